import json
import threading

import bearing_watch as bw
import numpy as np
import pytest

from conftest import quietly


def replayed(command, model, folder, tmp_path, names, *options):
    """The segments that the command line reports."""
    file = tmp_path / "m.bwm"
    model.save(file)
    return json.loads(
        command("replay", "--model", file, *(folder / f"{name}.csv" for name in names), *options, "--json")
    )


def joined(*parts):
    return {name: np.concatenate([part.columns()[name] for part in parts]) for name in parts[0].columns()}


def same(one, other):
    assert one.keys() == other.keys()
    for name, values in one.items():
        np.testing.assert_array_equal(values, other[name], err_msg=name)


@pytest.mark.parametrize("run_a_trace", [False, True])
def test_the_bits_are_those_of_replay(command, folder, bench, model, tmp_path, run_a_trace):
    names = ["healthy_3_001", "spall_3_002"]
    flags = ["--run-a-trace"] if run_a_trace else []
    expected = replayed(command, model, folder, tmp_path, names, *flags)
    detector = bw.Detector(model, run_a_trace=run_a_trace)
    found = [detector.run(bench.traces[name]) for name in names]
    assert [len(own) for own in found] == [5, 5]

    def row(own, k):
        named = dict(zip(own.class_names, own.posterior[k].tolist()))
        return {
            "start": own.start[k],
            "length": own.length[k],
            "verdict": own.verdict[k],
            "posteriors": named,
            "distance": float(own.distance[k]),
            "surprise": float(own.surprise[k]),
            "score": float(own.score[k]),
            "parameters": dict(zip(own.parameter_names, own.parameters[k].tolist())),
            "variance": float(own.variance[k]),
            "rows": own.rows[k],
            "alarm": bool(own.alarm[k]),
        }

    rows = [row(own, k) for own in found for k in range(len(own))]

    def single(x):
        """JSON has the shortest digits of the single, and null for what is not there."""
        return np.nan if x is None else float(np.float32(x))

    for ours, theirs in zip(rows, expected):
        for name in ("start", "length", "verdict", "rows"):
            assert ours[name] == theirs[name], name
        for name in ("distance", "surprise", "score", "variance"):
            np.testing.assert_array_equal(ours[name], single(theirs[name]), err_msg=name)
        for name in ("posteriors", "parameters"):
            # Without a verdict there are no posteriors, without an estimate no parameters.
            numbers = [single((theirs[name] or {}).get(key)) for key in ours[name]]
            np.testing.assert_array_equal(list(ours[name].values()), numbers, err_msg=name)
            assert not theirs[name] or theirs[name].keys() == ours[name].keys(), name
        assert ours["alarm"] == (theirs["alarm"] is not None)
    values = [own["friction"]["values"] if own["friction"] else [None] * 8 for own in expected]
    friction = np.array(values, dtype=np.float32)
    np.testing.assert_array_equal(np.concatenate([own.friction for own in found]), friction)
    prominence = np.array([[order["prominence"] for order in own["orders"]] for own in expected], dtype=np.float32)
    np.testing.assert_array_equal(np.concatenate([own.prominence for own in found]), prominence)


@pytest.mark.parametrize("size", [1, 137, 1000, 4999])
def test_pieces_of_any_size_give_the_bits_of_the_whole(bench, model, size):
    trace = bench.traces["roughness_3_000"]
    whole = bw.Detector(model).run(trace)
    detector = bw.Detector(model)
    limit = 1200 if size == 1 else 5000
    parts = [
        detector.step({name: own[k : min(k + size, limit)] for name, own in trace.items()})
        for k in range(0, limit, size)
    ]
    with pytest.raises(bw.BearingWatchError, match="a trace is open"):
        detector.run(trace)
    parts.append(detector.finish())
    if size > 1:
        same(joined(*parts), whole.columns())
    else:
        np.testing.assert_array_equal(joined(*parts)["distance"], whole.distance[:1])
    assert len(detector.finish()) == 0


@pytest.mark.parametrize("size", [100, 999])
def test_missing_samples_in_pieces_are_those_of_the_whole(bench, model, size):
    lost = np.zeros(5000, dtype=bool)
    lost[[777, 1100, 1101, *range(2000, 2130)]] = True
    trace = {name: np.where(lost & (name != "t_s"), np.nan, own) for name, own in bench.traces["healthy_3_000"].items()}
    whole = bw.Detector(model).run(trace)
    detector = bw.Detector(model)
    parts = [
        detector.step({name: own[k : k + size] for name, own in trace.items()}) for k in range(0, 5000, size)
    ]
    same(joined(*parts, detector.finish()), whole.columns())
    assert whole.rejected.sum() == lost.sum()


def test_state_goes_on_until_reset(bench, model):
    detector, trace = bw.Detector(model), bench.traces["spall_3_000"]
    first, second = detector.run(trace), detector.run(trace)
    assert first.score.tolist() != second.score.tolist()
    np.testing.assert_array_equal(first.posterior, second.posterior)
    detector.step(trace)
    detector.reset()
    same(detector.run(trace).columns(), first.columns())


def test_columns_by_name_and_other_tables(bench, model):
    trace = bench.traces["healthy_3_002"]
    expected = bw.Detector(model).run(trace)
    needed = ("velocity_ref_rad_s", "velocity_rad_s", "current_a", "load_torque_nm", "angle_rad")
    named = bw.Detector(model).run(**{name: trace[name] for name in needed})
    same(named.columns(), expected.columns())
    pyarrow = pytest.importorskip("pyarrow")
    same(bw.Detector(model).run(pyarrow.table(trace)).columns(), expected.columns())


def test_verdicts_are_arrays_and_arrow(bench, model):
    found = bw.Detector(model).run(bench.traces["spall_3_000"])
    structured = np.asarray(found)
    assert structured.shape == (5,) and structured["posterior"].shape == (5, 3)
    assert structured["features"].shape == (5, 4) and structured["slip"].shape == (5, 1)
    np.testing.assert_array_equal(structured["distance"], found.distance)
    np.testing.assert_allclose(found.posterior.sum(axis=1), 1.0, rtol=1e-5)
    pyarrow, polars = pytest.importorskip("pyarrow"), pytest.importorskip("polars")
    arrow = pyarrow.table(found)
    assert arrow.column("verdict").to_pylist() == found.verdict.tolist()
    assert arrow.column("p_spall").to_numpy().tolist() == found.posterior[:, 1].tolist()
    frame = polars.DataFrame(found)
    np.testing.assert_array_equal(frame["feature_order_outer"].to_numpy(), found.features[:, 3])


def test_a_short_trace_has_no_verdict(bench, model):
    found = bw.Detector(model).run({name: own[:400] for name, own in bench.traces["healthy_3_000"].items()})
    assert found.verdict.tolist() == ["undetermined"] and "no more than half a segment of 1000" in found.undetermined[0]
    assert np.isnan(found.posterior).all()


def test_bad_input_is_an_exception(bench, model):
    detector, trace = bw.Detector(model), bench.traces["healthy_3_000"]
    with pytest.raises(bw.BearingWatchError, match="no column .*angle_rad"):
        detector.run({name: own for name, own in trace.items() if name != "angle_rad"})
    with pytest.raises(bw.BearingWatchError, match="the model wants"):
        detector.run({**trace, "t_s": 2 * trace["t_s"]})
    with pytest.raises(bw.BearingWatchError, match="row 1, column angle_rad: 1000000.* is no measured value"):
        detector.step({**trace, "angle_rad": np.full(5000, 1e300)})
    with pytest.raises(bw.BearingWatchError, match="channel angle_rad has no number in any row"):
        detector.run({**trace, "angle_rad": np.full(5000, np.nan)})
    with pytest.raises(TypeError, match="give one table, or columns by name"):
        detector.run(trace, y=[1.0])
    with pytest.raises(TypeError, match="not int"):
        detector.run(3)
    with pytest.raises(bw.BearingWatchError, match="the file is empty"):
        detector.run({})
    with pytest.raises(FileNotFoundError):
        bw.Detector("nothing.bwm")
    # A refused call leaves the detector as it was.
    assert len(detector.run(trace)) == 5
    averaged = quietly(lambda: bw.train(
        bench.traces, bench.labels, y="current_a", u1="velocity_ref_rad_s", order=(2, 1, 0, 1, 1), decimate=2
    ))  # fmt: skip
    with pytest.raises(bw.BearingWatchError, match="takes whole traces"):
        bw.Detector(averaged).step(trace)
    assert len(bw.Detector(averaged).run(trace)) == 1


def test_detectors_run_in_threads(bench, model):
    trace, found = bench.traces["spall_3_001"], []
    expected = bw.Detector(model).run(trace).distance
    threads = [threading.Thread(target=lambda: found.append(bw.Detector(model).run(trace))) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    np.testing.assert_array_equal([own.distance for own in found], [expected] * 4)


def test_an_alarm_is_denied(bench, model):
    detector = bw.Detector(model)
    assert not detector.deny()
    raised = any(bool(detector.run(bench.traces["spall_3_002"]).alarm[-1]) for _ in range(20))
    assert raised and detector.deny() and not detector.deny()
    assert detector.end_run() == {}, "this model watches no directions"
