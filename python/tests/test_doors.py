"""What comes in another way than usual: forked processes, indices, masks, names that occur twice, pickles."""

import multiprocessing
import pickle

import bearing_watch as bw
import numpy as np
import pytest

from conftest import PLAIN, quietly

NAMES = ["current_a", "velocity_ref_rad_s", "velocity_rad_s", "load_torque_nm"]


@pytest.fixture(scope="module")
def plain(bench):
    return quietly(lambda: bw.train(bench.traces, bench.labels, **PLAIN))


def trace(bench, rows=4000):
    return {name: bench.traces["spall_3_002"][name][:rows] for name in NAMES}


def _verdicts(given):
    data, columns = given
    return bw.Detector(bw.Model.from_bytes(data)).run(columns).verdict.tolist()


def _trained(given):
    traces, labels = given
    return quietly(lambda: bw.train(traces, labels, **PLAIN)).to_bytes()


@pytest.mark.skipif("fork" not in multiprocessing.get_all_start_methods(), reason="no fork on this system")
def test_forked_processes_work_after_their_parent_has(bench, plain):
    # The fixture has trained in this process: its threads are not in the children.
    here = _verdicts((plain.to_bytes(), trace(bench)))
    with multiprocessing.get_context("fork").Pool(2) as pool:
        found = pool.map_async(_verdicts, [(plain.to_bytes(), trace(bench))] * 4).get(timeout=120)
        assert found == [here] * 4
        again = pool.map_async(_trained, [(bench.traces, bench.labels)] * 2).get(timeout=300)
        assert again == [plain.to_bytes()] * 2
    assert _verdicts((plain.to_bytes(), trace(bench))) == here


@pytest.mark.parametrize("kind", ["dates", "zoned", "durations", "numbers", "named"])
def test_an_index_of_times_has_the_rate_of_the_model(bench, plain, kind):
    pandas = pytest.importorskip("pandas")
    columns = trace(bench)
    count = len(columns["current_a"])

    def frame(step):
        seconds = np.arange(count) * step
        indices = {
            "dates": pandas.to_datetime(seconds, unit="s"),
            "zoned": pandas.to_datetime(seconds, unit="s", utc=True).tz_convert("Europe/Berlin"),
            "durations": pandas.to_timedelta(seconds, unit="s"),
            "numbers": pandas.Index(seconds),
            "named": pandas.Index(seconds, name="time_s"),
        }
        return pandas.DataFrame(columns, index=indices[kind])

    expected = bw.Detector(plain).run(columns).verdict.tolist()
    assert bw.Detector(plain).run(frame(0.002)).verdict.tolist() == expected
    for method in ("run", "step"):
        with pytest.raises(bw.BearingWatchError, match="sampled every 0.02 s, but the model wants 0.002 s"):
            getattr(bw.Detector(plain), method)(frame(0.02))
    with pytest.raises(bw.BearingWatchError, match="sampled every 0.02 s"):
        bw.replay(plain, {"x": frame(0.02)})
    pieces = bw.Detector(plain)
    found = [pieces.step(frame(0.002)[k : k + 1]) for k in range(2)] + [pieces.step(frame(0.002)[2:]), pieces.finish()]
    assert [one for own in found for one in own.verdict] == expected


def test_an_index_that_is_no_time_is_none(bench, plain):
    pandas = pytest.importorskip("pandas")
    columns = trace(bench)
    count = len(columns["current_a"])
    expected = bw.Detector(plain).run(columns).verdict.tolist()
    for index in (pandas.RangeIndex(count), pandas.Index(np.arange(count) * 1.0, name="position_mm")):
        assert bw.Detector(plain).run(pandas.DataFrame(columns, index=index)).verdict.tolist() == expected
    # A column of times goes before the index.
    timed = pandas.DataFrame({"t_s": np.arange(count) * 0.002, **columns}, index=pandas.Index(np.arange(count) * 1.0))
    assert bw.Detector(plain).run(timed).verdict.tolist() == expected


def test_columns_of_one_name_are_refused(bench, plain):
    pandas, pyarrow = pytest.importorskip("pandas"), pytest.importorskip("pyarrow")
    columns = trace(bench)
    arrays = list(columns.values())
    twice = pandas.DataFrame(np.stack([*arrays, arrays[0]], axis=1), columns=[*NAMES, "current_a"])
    arrow = pyarrow.table([*arrays, arrays[0]], names=[*NAMES, "current_a"])
    for given in (twice, arrow, {**columns, 1: arrays[0], "1": arrays[0]}):
        with pytest.raises(ValueError, match="two columns are named (current_a|1)"):
            bw.Detector(plain).run(given)


def test_masked_values_are_missing(bench, plain):
    pandas = pytest.importorskip("pandas")
    columns = trace(bench)
    lacking = {name: values.copy() for name, values in columns.items()}
    lacking["current_a"][100:110] = np.nan
    masked = dict(columns)
    masked["current_a"] = np.ma.masked_array(columns["current_a"], mask=np.isnan(lacking["current_a"]))
    nullable = pandas.DataFrame(columns)
    nullable["current_a"] = pandas.array(lacking["current_a"], dtype="Float64")

    def outcome(given):
        try:
            found = bw.Detector(plain).run(given)
        except ValueError as error:
            return str(error)
        return found.verdict.tolist(), found.rejected.tolist()

    # As NaN in a plain array: refused, or counted as rejected.
    assert outcome(masked) == outcome(nullable) == outcome(lacking) != outcome(columns)
    whole = np.ma.masked_array(columns["current_a"])
    assert outcome({**columns, "current_a": whole}) == outcome(columns)
    integers = np.ma.masked_array(np.arange(3), mask=[False, True, False])
    with pytest.raises(ValueError):
        bw.identify(integers, np.ones(3), np.ones(3), order=(1, 1, 0, 1, 1))
    texts = np.ma.masked_array(["a", "b"], mask=[False, True])
    with pytest.raises(TypeError, match="only one of numbers"):
        bw.Detector(plain).run({**columns, "note": texts})


def test_models_and_detectors_are_equal_to_their_pickles(bench, plain):
    other = pickle.loads(pickle.dumps(plain))
    assert other == plain and hash(other) == hash(plain) and plain != "model"
    assert other != quietly(lambda: bw.train(bench.traces, bench.labels, **{**PLAIN, "segment": 900}))
    assert "trained on 4 healthy" in plain.summary()
    assert "classes: healthy, spall, roughness" in other.summary() or "classes: " in other.summary()
    with pytest.raises(bw.BearingWatchError, match="does not have the data"):
        other.summary(rank=True)


@pytest.mark.parametrize("options", [{"run_a_trace": True}, {"run_a_trace": False}])
def test_a_detector_goes_on_from_its_pickle(bench, model, plain, options):
    detector = bw.Detector(model, **options)
    columns = bench.traces["spall_3_000"]
    first = detector.run(columns)
    copy = pickle.loads(pickle.dumps(detector))
    found, other = copy.run(columns).columns(), detector.run(columns).columns()
    for name, values in other.items():
        np.testing.assert_array_equal(found[name], values, err_msg=name)
    assert found["score"].tolist() != first.score.tolist(), "evidence goes on"
    detector.step(columns)
    with pytest.raises(bw.BearingWatchError, match="a trace is open"):
        pickle.dumps(detector)
    detector.finish()
    state = pickle.loads(pickle.dumps(detector))
    assert state.run(columns).score.tolist() == detector.run(columns).score.tolist()
    with pytest.raises(bw.BearingWatchError, match="no state of this detector"):
        bw.Detector(plain, run_a_trace=True)._core.restore(detector._core.save())
