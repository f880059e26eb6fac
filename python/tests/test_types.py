"""What a checker of types says of calls: names and kinds of options are known."""

import importlib.util
import json
import subprocess
import sys

import pytest
from bearing_watch import _core, _options

CALLS = """
import bearing_watch as bw
from bearing_watch import fleet

model = bw.train("drive.toml", order=(2, 1, 2, 1, 1), false_alarm=0.01, priors={"healthy": 0.9, "spall": 0.1})
bw.evaluate(model, "drive.toml", per_segment=True, by=["load_kgf"])
bw.audit("runs", current="iq_A")
bw.simulate("spall", count=2, rig="dc")
fleet.features("drive.toml", out="p.parquet", order=(2, 1, 2, 1, 1), plan="a.parquet")
fleet.train_features(["p.parquet"], model="m.bwm", unit="drive", false_alarm=0.01, one_pass=True, rust="m.rs")
bw.train("drive.toml", ordr=3)  # Unexpected keyword argument "ordr"
bw.train("drive.toml", segment="long")  # Argument "segment"
bw.train("drive.toml", method="lsq")  # Argument "method"
bw.evaluate(model, "drive.toml", per_segmnt=True)  # Unexpected keyword argument "per_segmnt"
bw.simulate("spall", sevrity=2.0)  # Unexpected keyword argument "sevrity"
fleet.features("drive.toml", out="p.parquet", plan_trace=3)  # Unexpected keyword argument "plan_trace"
fleet.train_features("p.parquet", model="m.bwm", units="drive")  # Unexpected keyword argument "units"
"""


def test_wrong_options_are_found(tmp_path):
    if importlib.util.find_spec("mypy") is None:
        pytest.skip("mypy is not installed")
    file = tmp_path / "calls.py"
    file.write_text(CALLS)
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--cache-dir", tmp_path / "cache", file],
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
    )
    errors = [line for line in done.stdout.splitlines() if ": error:" in line]
    wanted = [(k, line.split("# ")[1]) for k, line in enumerate(CALLS.splitlines(), 1) if "# " in line]
    assert len(errors) == len(wanted), done.stdout + done.stderr
    for error, (line, words) in zip(errors, wanted):
        assert f"calls.py:{line}: error: {words}" in error


#: The options of each job, and those among them that are no settings.
OPTIONS = {
    "train": (_options.Train, set()),
    "evaluate": (_options.Evaluate, {"per_segment"}),
    "features": (_options.Features, {"plan", "plan_traces"}),
    "train-features": (_options.TrainFeatures, {"one_pass", "rust", "c"}),
}


@pytest.mark.parametrize("job", OPTIONS)
def test_the_options_are_those_of_the_settings(command, job):
    options, further = OPTIONS[job]
    named = set(options.__annotations__)
    schema = json.loads(command("schema"))
    keys = {key for fields in schema["properties"].values() for key in fields["properties"]} - {"traces", "labels"}

    def is_taken(key):
        try:
            _core.settings(job, {key: "x"})
        except ValueError as refused:
            return "has no option" not in str(refused)
        return True

    assert further <= named and named - further == {key for key in keys if is_taken(key)}
