"""Training of a fleet from Python, and on a cluster of two processes of which one is killed."""

import json
import os
import signal
import threading
import time

import bearing_watch as bw
import pytest
from bearing_watch import fleet

FEATURES = ["a", "b", "c"]


@pytest.fixture(scope="module")
def parts(command, tmp_path_factory):
    """Twelve parts of a simulated fleet of 2400 drives."""
    folder = tmp_path_factory.mktemp("fleet")
    command("simulate-features", "--drives", 2400, "--segments", 40, "--parts", 12, "--seed", 3, "--out", folder)
    return sorted(folder.glob("*.parquet"))


@pytest.fixture(scope="module")
def folded(command, parts, tmp_path_factory):
    """The report of the command line's fold over all parts."""
    model = tmp_path_factory.mktemp("folded") / "m.bwm"
    options = ["--features", ",".join(FEATURES), "--unit", "drive", "--one-pass", "--model", model, "--json"]
    return json.loads(command("train-features", *parts, *options)), model


def test_sums_of_any_tree_give_the_model_of_the_fold(parts, folded, tmp_path):
    halves = [parts[:5], parts[5:]]
    for k, half in enumerate(halves):
        report = fleet.features_sum(half, out=tmp_path / f"{k}.sums", features=FEATURES)
        assert report["rows"] == len(half) * 200 * 40
    found = fleet.train_features([tmp_path / "1.sums", tmp_path / "0.sums"], model=tmp_path / "m.bwm", unit="drive")
    assert found["fingerprint"] == folded[0]["fingerprint"]
    assert bw.Model.load(tmp_path / "m.bwm").classes == bw.Model.load(folded[1]).classes
    with pytest.raises(bw.BearingWatchError, match="share|complete|both"):
        fleet.train_features([tmp_path / "0.sums", tmp_path / "0.sums"], model=tmp_path / "n.bwm", unit="drive")
    assert not (tmp_path / "n.bwm").exists()


def test_features_of_traces_are_those_of_the_command(command, folder, tmp_path):
    options = {"y": "current_a", "u1": "velocity_ref_rad_s - velocity_rad_s", "u2": "load_torque_nm"}
    labels = folder / "labels.csv"
    report = fleet.features(folder, labels, out=tmp_path / "p.parquet", order="2,1,2,1,1", segment=1000, **options)
    words = [f"--{key}={value}" for key, value in options.items()]
    words += ["--order=2,1,2,1,1", "--segment=1000", f"--labels={labels}", f"--out={tmp_path / 'c.parquet'}"]
    told = json.loads(command("features", *words, "--json"))
    assert report["rows"] == told["rows"] > 0
    assert (tmp_path / "p.parquet").read_bytes() == (tmp_path / "c.parquet").read_bytes()


def test_a_cluster_that_loses_a_worker_gives_the_same_model(parts, folded, tmp_path):
    distributed = pytest.importorskip("distributed")
    cluster = distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
    with cluster, distributed.Client(cluster) as client:
        processes = client.run(os.getpid)
        killed = []

        def kill_midway():
            """Kills a worker once some parts are summed and others are not."""
            while len(list(tmp_path.glob("part*.sums"))) < 3:
                time.sleep(0.002)
            killed.append(len(list(tmp_path.glob("part*.sums"))))
            os.kill(next(iter(processes.values())), signal.SIGKILL)

        killer = threading.Thread(target=kill_midway, daemon=True)
        killer.start()
        sums = fleet.sum_on(client, parts, tmp_path, branch=4, features=FEATURES)
        killer.join(timeout=60)
    assert killed and killed[0] < len(parts), killed
    found = fleet.train_features(sums, model=tmp_path / "m.bwm", unit="drive")
    assert found["fingerprint"] == folded[0]["fingerprint"]
    assert found["rows"] == folded[0]["rows"] == 2400 * 40
