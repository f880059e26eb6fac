"""What the tests share: the command line, and one simulated bench as files and as arrays."""

import csv
import json
import os
import re
import subprocess
from pathlib import Path

import bearing_watch as bw
import numpy as np
import pytest

#: Options of a model of the regression alone, as keywords.
PLAIN = {
    "y": "current_a",
    "u1": "velocity_ref_rad_s - velocity_rad_s",
    "u2": "load_torque_nm",
    "order": (2, 1, 2, 1, 1),
    "segment": 1000,
    "healthy": "healthy",
}

#: Those of a model that watches the shaft too.
MODEL = {
    **PLAIN,
    "angle": "angle_rad",
    "velocity": "velocity_rad_s",
    "load": "load_torque_nm",
    "bearing": (9, 3, 17, 10),
    "features": ["a", "drag", "order_outer"],
    "false_alarm": 0.05,
}


def words(options):
    """The options as words of the command line."""

    def text(value):
        return ",".join(map(str, value)) if isinstance(value, (list, tuple)) else str(value)

    return [f"--{key.replace('_', '-')}={text(value)}" for key, value in options.items()]


@pytest.fixture(scope="session")
def program():
    """Runs the command line."""
    name = os.environ.get("BEARING_WATCH_PROGRAM")
    if name is None:
        pytest.skip("the variable BEARING_WATCH_PROGRAM does not name the command line")

    def run(*arguments):
        return subprocess.run([name, *map(str, arguments)], capture_output=True, text=True, check=False)

    return run


@pytest.fixture(scope="session")
def command(program):
    """Runs the command line; returns what it prints."""

    def run(*arguments, fails=False):
        done = program(*arguments)
        assert (done.returncode != 0) == fails, done.stderr
        return done.stderr if fails else done.stdout

    return run


@pytest.fixture(scope="session")
def bench():
    """Simulated recordings of three classes."""
    return bw.simulate(count=4, seed=3)


@pytest.fixture(scope="session")
def folder(command, tmp_path_factory):
    """The same recordings, written by the command line."""
    folder = tmp_path_factory.mktemp("bench")
    command("simulate", "--class", "healthy,spall,roughness", "--count", 4, "--seed", 3, "--out", folder)
    return folder


@pytest.fixture(scope="session")
def model(bench):
    """A model of the bench."""
    return quietly(lambda: bw.train(bench.traces, bench.labels, **MODEL))


def quietly(work):
    """Runs work whose warnings are not of interest."""
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", bw.BearingWatchWarning)
        return work()


def told(work):
    """What work returns, and its warnings as one text."""
    import warnings

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", bw.BearingWatchWarning)
        found = work()
    return found, "\n".join(str(one.message) for one in caught)


def document(name, language):
    """The examples of a document of the package in a language."""
    text = (Path(__file__).parents[1] / name).read_text(encoding="utf-8")
    return re.findall(rf"```{language}\n(.*?)```", text, flags=re.DOTALL)


def read_csv(path: Path):
    """The columns of a file of numbers."""
    with path.open() as file:
        rows = list(csv.reader(file))
    return {name: np.array([float(row[k]) for row in rows[1:]]) for k, name in enumerate(rows[0])}


def from_json(text):
    """The report of a command, without the name and the version of its form."""
    return {key: value for key, value in json.loads(text).items() if key not in ("format", "version")}
