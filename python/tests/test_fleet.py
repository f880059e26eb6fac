"""Training of a fleet from Python, and on a cluster of two processes of which one is killed."""

import json
import os
import signal
import threading
import time

import bearing_watch as bw
import pytest
from bearing_watch import fleet

from conftest import quietly

OPTIONS = {
    "y": "current_a",
    "u1": "velocity_ref_rad_s - velocity_rad_s",
    "u2": "load_torque_nm",
    "order": "2,1,2,1,1",
    "segment": 250,
    "unit": "drive",
}


def trained(parts, model):
    """Trains from parts; so few drives support no rate, which a warning says."""
    return quietly(lambda: fleet.train_features(parts, model=model, features=["a", "b"], unit="drive"))


@pytest.fixture(scope="module")
def labels(folder, tmp_path_factory):
    """The labels of the bench with four drives, each of which has a recording of each class."""
    head, *rows = (folder / "labels.csv").read_text().splitlines()
    file = tmp_path_factory.mktemp("labels") / "labels.csv"
    file.write_text("\n".join([f"{head},drive", *(f"{row},d{k % 4}" for k, row in enumerate(rows))]))
    return file


@pytest.fixture(scope="module")
def whole(folder, labels, tmp_path_factory):
    """The part of all drives, and the report of the training from it."""
    place = tmp_path_factory.mktemp("whole")
    quietly(lambda: fleet.features(folder, labels, out=place / "whole.parquet", **OPTIONS))
    found = trained(place / "whole.parquet", place / "m.bwm")
    return place / "whole.parquet", found


def test_features_of_traces_are_those_of_the_command(command, folder, labels, whole, tmp_path):
    words = [f"--{key}={value}" for key, value in OPTIONS.items()]
    words += [f"--labels={labels}", f"--out={tmp_path / 'c.parquet'}", "--json"]
    told = json.loads(command("features", folder, *words))
    assert whole[1]["rows"] == told["rows"] > 0
    assert whole[0].read_bytes() == (tmp_path / "c.parquet").read_bytes()


def test_a_cluster_that_loses_a_worker_gives_the_same_model(folder, labels, whole, tmp_path):
    distributed = pytest.importorskip("distributed")
    parts = [tmp_path / f"d{k}.parquet" for k in range(4)]
    cluster = distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
    with cluster, distributed.Client(cluster) as client:
        processes = client.run(os.getpid)
        killed = []

        def kill_midway():
            """Kills a worker once a part is written and others are not."""
            while not any(part.exists() for part in parts):
                time.sleep(0.002)
            killed.append(sum(part.exists() for part in parts))
            os.kill(next(iter(processes.values())), signal.SIGKILL)

        killer = threading.Thread(target=kill_midway, daemon=True)
        killer.start()
        tasks = [
            client.submit(
                fleet.features,
                folder,
                labels,
                out=part,
                plan=whole[0],
                where=f"drive=d{k}",
                **OPTIONS,
                pure=False,
                retries=2,
            )
            for k, part in enumerate(parts)
        ]
        assert sum(report["rows"] for report in client.gather(tasks)) == whole[1]["rows"]
        killer.join(timeout=60)
    assert killed and killed[0] < len(parts), killed
    found = trained(parts, tmp_path / "m.bwm")
    assert found["fingerprint"] == whole[1]["fingerprint"]
    assert (tmp_path / "m.bwm").read_bytes() == (whole[0].parent / "m.bwm").read_bytes()
    with pytest.raises(bw.BearingWatchError, match="no part in this folder"):
        (tmp_path / "empty").mkdir()
        trained(tmp_path / "empty", tmp_path / "n.bwm")
