"""Every field of the settings as a keyword option."""

import json

import bearing_watch as bw
import pytest
from bearing_watch import _core

ONLY_OF = {
    "evaluate": {"by", "controls", "control_classes"},
    "replay": {"load_rating_n", "rollers", "bearing_load_n", "bearing_load_per_nm", "torque_constant_nm_a"},
}
#: What `replay` takes.
REPLAYED = ONLY_OF["replay"] | {"traces", "labels", "bearing"}


def example(field):
    """Return a value by the schema of a field, and the start of its text in a drive file."""
    if "oneOf" in field:
        return field["oneOf"][-1]["const"], '"'
    if "examples" in field:
        return field["examples"][0], f'"{field["examples"][0]}"'
    kinds = field["type"] if isinstance(field["type"], list) else [field["type"]]
    if kinds[0] == "array":
        items = field["items"]["type"]
        if items == "integer":
            return (2, 1, 2, 1, 1), '"2,1,2,1,1"'
        return ([0.25, 2.0], "[0.25, 2.0]") if items == "number" else (["one=1"], '["one=1"]')
    return {
        "boolean": (True, "true"),
        "number": (0.25, "0.25"),
        "integer": (3, "3"),
        "string": ("name", '"name"'),
    }[kinds[0]]


def test_each_field_is_an_option(command):
    schema = json.loads(command("schema"))
    count = 0
    for section, fields in schema["properties"].items():
        for key, field in fields["properties"].items():
            job = next((job for job, keys in ONLY_OF.items() if key in keys), "train")
            value, text = example(field)
            saved = _core.settings(job, {key: value})
            assert f"[{section}]\n{key} = {text}" in saved, (key, saved)
            # Every job takes the column of the runs.
            if key != "group":
                other = "train-features" if key in REPLAYED else "replay"
                with pytest.raises(bw.BearingWatchError, match=f"{other} has no option {key}"):
                    _core.settings(other, {key: value})
            count += 1
    assert count > 60


def test_values_are_taken_as_they_are_written():
    same = [{"order": "2,1,2,1,1"}, {"order": (2, 1, 2, 1, 1)}, {"order": [2, 1, 2, 1, 1]}]
    assert len({_core.settings("train", own) for own in same}) == 1
    same = [{"priors": {"a": 0.5, "b": 0.5}}, {"priors": "a=0.5,b=0.5"}, {"priors": ["a=0.5", "b=0.5"]}]
    assert len({_core.settings("train", own) for own in same}) == 1
    assert "reject_cost = inf" in _core.settings("train", {"reject_cost": float("inf")})


def test_a_bearing_is_four_numbers_or_a_designation():
    same = [(9, 3, 17, 10), [9.0, 3.0, 17.0, 10.0], "9,3,17,10"]
    texts = {_core.settings("train", {"bearing": own}) for own in same}
    assert len(texts) == 1 and "bearing = [9.0, 3.0, 17.0, 10.0]" in texts.pop()
    for own in (6205, "6205"):
        assert 'bearing = "6205"' in _core.settings("train", {"bearing": own})
    for own, problem in (
        ((9, 3, 17, 61), "from 0 to 60 degrees"),
        ((2, 3, 17, 10), "from 3 to 100"),
        ((9, 3, 17), "four numbers"),
        ("6214", "not in the table of published bearings"),
    ):
        with pytest.raises(bw.BearingWatchError, match=problem):
            _core.settings("train", {"bearing": own})
