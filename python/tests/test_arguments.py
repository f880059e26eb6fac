"""Arguments of any kind: every answer is a result or an ordinary exception, never a panic of the extension module."""

import warnings

import bearing_watch as bw
import numpy as np
from bearing_watch import _core
from bearing_watch.sklearn import GaussianClassifier, NoveltyDetector
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

SETTINGS = settings(
    max_examples=150,
    deadline=None,
    derandomize=True,
    database=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)

#: What the package raises for bad arguments, and what its extension module raises besides; a panic is not among them.
REFUSALS = (ValueError, TypeError, OSError)
BELOW = (*REFUSALS, OverflowError, LookupError)

DTYPES = ["f8", "f4", "i8", "u1", "?", "c16", "U3", "S2", "M8[s]", "O"]
SHAPES = [(), (0,), (1,), (7,), (64,), (300,), (3, 4), (64, 1), (2, 0), (2, 2, 2)]


@st.composite
def arrays(draw):
    """Arrays of any type and shape, with NaN and infinite values where there are such."""
    shape, dtype = draw(st.sampled_from(SHAPES)), draw(st.sampled_from(DTYPES))
    random = np.random.default_rng(draw(st.integers(0, 99)))
    values = np.asarray(random.normal(size=shape) * 10.0 ** draw(st.integers(-30, 30)))
    if draw(st.booleans()) and values.size:
        values.flat[draw(st.integers(0, values.size - 1))] = draw(st.sampled_from([np.nan, np.inf, -np.inf]))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        array = values.astype("f8" if dtype == "M8[s]" else dtype)
        array = array.astype("i8").astype(dtype) if dtype == "M8[s]" else array
    return array[::-1] if draw(st.booleans()) and array.ndim else array


scalars = st.one_of(st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=8), st.binary(max_size=8))
small = st.one_of(scalars, st.integers(-3, 40), st.lists(st.integers(-2, 6), max_size=7))
anything = st.one_of(scalars, arrays(), st.lists(scalars, max_size=5), st.dictionaries(st.text(max_size=4), scalars))
signals = st.one_of(arrays(), anything)
names = st.sampled_from(["velocity_ref_rad_s", "velocity_rad_s", "current_a", "load_torque_nm", "angle_rad", "x"])
tables = st.one_of(anything, st.dictionaries(names, signals, max_size=6))


def below(work):
    attempt(work, BELOW)


def attempt(work, refusals=REFUSALS):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            work()
        except refusals:
            pass


@SETTINGS
@given(signals, signals, signals, small, small, st.one_of(st.sampled_from(["ls", "iv", "armax"]), scalars), small)
def test_identification(y, u1, u2, order, lags, method, passes):
    attempt(lambda: bw.identify(y, u1, u2, order=order, method=method, passes=passes, noise_order=lags))
    attempt(lambda: bw.identify(y, u1, u2, order=(1, 1, 1, 1, 1), method="iv-command", instruments=u2))
    attempt(lambda: bw.validate(y, u1, u2, order=(1, 1, 0, 1, 1), lags=lags))
    attempt(lambda: bw.structure((y, u1), (u2, u1), max_order=order, min_order=passes, method=method))


@SETTINGS
@given(tables, tables, anything, anything, st.integers(0, 3))
def test_detector(model, first, second, run_a_trace, values, how):
    detectors = [bw.Detector(model)]
    attempt(lambda: detectors.append(bw.Detector(model, run_a_trace=run_a_trace)))
    for detector in detectors:
        for columns in (first, second):
            attempt(lambda: detector.step(columns))
            attempt(lambda: detector.run(columns))
        attempt([detector.finish, detector.reset, lambda: detector.step(x=values), lambda: bw.Detector(first)][how])


@SETTINGS
@given(st.one_of(st.binary(max_size=300), anything), st.integers(0, 2**16), st.integers(0, 255))
def test_model_bytes(model, data, place, value):
    attempt(lambda: bw.Model.from_bytes(data))
    changed = bytearray(model.to_bytes())
    changed[place % len(changed)] = value
    attempt(lambda: bw.Model.from_bytes(bytes(changed)))


@SETTINGS
@given(st.dictionaries(st.text(max_size=4), tables, max_size=3), tables, anything, small, st.dictionaries(names, small))
def test_training(traces, labels, text, order, options):
    channels = {"y": "current_a", "u1": "velocity_rad_s", "u2": "load_torque_nm"}
    attempt(lambda: bw.train(traces, labels, **channels, order=order))
    attempt(lambda: bw.train(traces, dict.fromkeys(traces, "healthy"), y=text, u1=text, u2=text, order=(1, 1, 1, 1, 1)))
    attempt(lambda: bw.train(text, labels, **channels, order=order, **options))
    attempt(lambda: bw.evaluate(text, traces, labels))


@SETTINGS
@given(arrays(), anything, small, anything)
def test_rows(x, y, parameter, other):
    attempt(lambda: GaussianClassifier(priors=parameter, cost=other).fit(x, y).predict(x))
    attempt(lambda: NoveltyDetector(false_alarm=parameter).fit(x, runs=y).predict(x))


@SETTINGS
@given(anything, anything, anything, small, st.lists(small, max_size=5))
def test_extension_module(one, two, three, number, several):
    """The functions below the package, whose arguments it checks."""
    below(lambda: _core.Model.from_bytes(one, two))
    below(lambda: _core.identify("s", one, two, offset=three, method=two, passes=number, noise_order=3, robust=False))
    below(lambda: _core.validate("s", {"y": one, "u1": two}, "1,1,0,1,1", offset=False, method="ls", lags=number))
    below(lambda: _core.structure([("a", one)], [("b", two)], several, number, offset=False, method=three))
    below(lambda: _core.train(one, {"y": two}, [("a", three)], one))
    below(lambda: _core.RowClassifier(one, several, ["a", "b"], ["f"], two, None, three, number, [0.5], [[0, 1]]))
    below(lambda: _core.RowGate(one, several, ["f"], number))
    below(lambda: _core.arrow_stream({"a": one}))
