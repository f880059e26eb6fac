import doctest
import inspect
import pathlib
import re
import warnings

import bearing_watch as bw
import pytest
from bearing_watch import _detector, _model, _recordings, _recursive, _signals, _simulate


@pytest.mark.parametrize(
    ("module", "least"), [(_signals, 5), (_recordings, 12), (_detector, 12), (_model, 6), (_simulate, 3), (_recursive, 6)]
)
def test_examples_of_the_docstrings_run(module, least):
    with warnings.catch_warnings():
        failed, attempted = doctest.testmod(module)
    assert failed == 0 and attempted >= least


def test_the_version_is_that_of_the_crates():
    manifest = pathlib.Path(__file__).parents[2] / "Cargo.toml"
    versions = re.findall(r'^version = "(.+)"$', manifest.read_text(), flags=re.MULTILINE)
    assert [bw.__version__] == versions


def test_every_public_name_is_documented():
    for name in bw.__all__:
        own = getattr(bw, name)
        assert inspect.getdoc(own), name
        for method, body in inspect.getmembers(own, inspect.isfunction):
            if not method.startswith("_") and own.__module__.startswith("bearing_watch"):
                assert inspect.getdoc(body), f"{name}.{method}"
