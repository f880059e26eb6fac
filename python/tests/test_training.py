import pickle

import bearing_watch as bw
import numpy as np
import pytest

from conftest import MODEL, PLAIN, from_json, quietly, read_csv, words


@pytest.fixture(scope="session")
def file(command, folder, tmp_path_factory):
    """The model of the command line, with its exports."""
    file = tmp_path_factory.mktemp("model") / "m.bwm"
    exports = ["--rust", file.with_suffix(".rs"), "--c", file.with_suffix(".h"), "--json"]
    report = command("train", "--labels", folder / "labels.csv", *words(MODEL), "--model", file, *exports)
    file.with_suffix(".json").write_text(report)
    return file


def tidy(bench):
    """All traces as the columns of one table."""
    columns = {
        name: np.concatenate([own[name] for own in bench.traces.values()]) for name in bench.traces["spall_3_000"]
    }
    ids = [trace for trace, own in bench.traces.items() for _ in own["t_s"]]
    return {"trace": ids, **columns}


def label_table(bench):
    return {"trace": list(bench.labels), "class_name": list(bench.labels.values())}


@pytest.mark.parametrize("rate", [-1.0, 0.0, 0.6, 1.5, float("nan"), 1e-320])
def test_a_rate_that_is_none_is_refused(bench, rate):
    with pytest.raises(bw.BearingWatchError, match="give a rate from 1e-9 to 0.5 a segment"):
        quietly(lambda: bw.train(bench.traces, bench.labels, **{**PLAIN, "false_alarm": rate}))


def test_simulated_arrays_are_those_of_the_files(folder, bench):
    for name in ("healthy_3_000", "roughness_3_003"):
        for column, values in read_csv(folder / f"{name}.csv").items():
            assert np.array_equal(values, bench.traces[name][column]), (name, column)


@pytest.fixture(scope="session")
def plain(command, folder, tmp_path_factory):
    """A model of the regression alone, by the command line."""
    file = tmp_path_factory.mktemp("plain") / "m.bwm"
    command("train", "--labels", folder / "labels.csv", *words(PLAIN), "--model", file)
    return file


def test_files_give_the_bytes_of_the_command_line(plain, folder):
    paths = quietly(lambda: bw.train(folder, folder / "labels.csv", **PLAIN))
    assert paths.to_bytes() == plain.read_bytes()
    alone = quietly(lambda: bw.train(None, str(folder / "labels.csv"), **PLAIN))
    assert alone.to_bytes() == plain.read_bytes()
    listed = quietly(lambda: bw.train(sorted(folder.glob("*_3_*.csv")), folder / "labels.csv", **PLAIN))
    assert listed.to_bytes() == plain.read_bytes()


def test_arrays_and_tables_give_the_bytes_of_the_command_line(file, plain, bench, model):
    pandas, polars, pyarrow = (pytest.importorskip(name) for name in ("pandas", "polars", "pyarrow"))
    assert model.to_bytes() == file.read_bytes()
    for kind in (pandas.DataFrame, polars.DataFrame, pyarrow.table, dict):
        tables = {name: kind(columns) for name, columns in bench.traces.items()}
        labels = kind(label_table(bench))
        assert quietly(lambda: bw.train(tables, labels, **PLAIN)).to_bytes() == plain.read_bytes(), kind
        one = kind(tidy(bench))
        assert quietly(lambda: bw.train(one, bench.labels, **PLAIN)).to_bytes() == plain.read_bytes(), kind
    ids = pandas.DataFrame(tidy(bench)).astype({"trace": "category"})
    by_arrow = pyarrow.Table.from_pandas(ids)
    assert quietly(lambda: bw.train(by_arrow, bench.labels, **PLAIN)).to_bytes() == plain.read_bytes()


def test_dropped_and_empty_rows_are_missing_samples(bench):
    pandas = pytest.importorskip("pandas")
    lost = np.random.default_rng(5).random(5000) < 0.01

    def without(columns):
        own = lost[: len(columns["t_s"])]
        empty = {name: np.where(own & (name != "t_s"), np.nan, values) for name, values in columns.items()}
        return {name: values[~own] for name, values in columns.items()}, empty

    pairs = {name: without(columns) for name, columns in bench.traces.items()}
    dropped, empty = ({name: pair[k] for name, pair in pairs.items()} for k in (0, 1))
    nullable = {name: pandas.DataFrame(columns).convert_dtypes() for name, columns in empty.items()}
    models = [quietly(lambda own=own: bw.train(own, bench.labels, **MODEL)) for own in (dropped, empty, nullable)]
    first = models[0].to_bytes()
    assert all(model.to_bytes() == first for model in models)
    named = {name: np.full(5, np.nan) for name in next(iter(bench.traces.values()))}
    with pytest.raises(bw.BearingWatchError, match="has no number in any row"):
        bw.train({**empty, "healthy_3_000": {**named, "t_s": np.arange(5.0)}}, bench.labels, **MODEL)


def test_a_drive_file_gives_the_bytes_of_the_command_line(command, folder, tmp_path):
    drive, file = folder / "drive.toml", tmp_path / "m.bwm"
    options = {**PLAIN, "folds": 5}
    command(
        "train", "--labels", folder / "labels.csv", *words(options), "--model", tmp_path / "first.bwm", "--save", drive
    )
    command("train", drive, "--model", file)
    assert quietly(lambda: bw.train(drive)).to_bytes() == file.read_bytes()
    command("train", drive, "--features=b,log_variance", "--model", file)
    other = quietly(lambda: bw.train(str(drive), features=["b", "log_variance"]))
    assert other.to_bytes() == file.read_bytes() and other.features == ["b1", "log_variance"]
    # The drive file of one call is not that of the next.
    assert b"[channels]" in other.to_bytes()
    assert b"[channels]" not in quietly(lambda: bw.train(folder, folder / "labels.csv", **PLAIN)).to_bytes()
    drive.unlink()


def test_exports_and_reports_are_those_of_the_command_line(file, model, tmp_path):
    def without_path(text):
        return [line for line in text.splitlines() if "Generated" not in line]

    assert without_path(model.to_rust(tmp_path / "m.rs")) == without_path(file.with_suffix(".rs").read_text())
    assert (tmp_path / "m.rs").read_text() == model.to_rust()
    assert model.to_c() == file.with_suffix(".h").read_text()
    report = from_json(file.with_suffix(".json").read_text())
    del report["model"]
    assert model.report() == report
    assert "trained on 4 healthy, 4 spall, 4 roughness traces" in model.summary()


def test_a_model_survives_files_and_pickles(model, tmp_path):
    path = tmp_path / "m.bwm"
    model.save(path)
    loaded = bw.Model.load(path)
    assert loaded.to_bytes() == model.to_bytes() == pickle.loads(pickle.dumps(model)).to_bytes()
    assert (loaded.classes, loaded.healthy) == (["healthy", "spall", "roughness"], "healthy")
    assert loaded.features == model.features == ["a1", "a2", "drag", "order_outer"]
    assert loaded.segment_samples == 1000 and loaded.interval_s == pytest.approx(2e-3)
    assert "BW_MODEL" in loaded.to_c().upper()
    with pytest.raises(bw.BearingWatchError, match="does not have the data of its training"):
        loaded.to_rust()
    damaged = bytearray(path.read_bytes())
    damaged[100] ^= 1
    path.write_bytes(damaged)
    with pytest.raises(bw.BearingWatchError, match=r"m\.bwm, model: .*train it again"):
        bw.Model.load(path)
    assert [own.name for own in tmp_path.iterdir()] == ["m.bwm"]


def test_evaluation_is_that_of_the_command_line(command, file, folder, bench, model):
    text = command(
        "evaluate", "--model", file, "--labels", folder / "labels.csv", "--per-segment", "--group=trace", "--json"
    )
    with pytest.warns(bw.BearingWatchWarning, match="12 of 12 traces were trained on"):
        found = bw.evaluate(model, bench.traces, folder / "labels.csv", per_segment=True, group="trace")
    assert found.report == from_json(text)
    others = bw.simulate(["healthy", "spall"], count=3, seed=9)
    fresh = bw.evaluate(file, others.traces, others.labels)
    assert fresh.confusion.shape == (3, 3) and fresh.confusion.sum() + fresh.novel.sum() == 6
    value, low, high = fresh.error_rate
    assert 0 <= low <= value <= high <= 1 and "error rate" in str(fresh)


def test_held_out_runs_are_reported(bench):
    labels = {**label_table(bench), "run": np.arange(12) % 4}
    options = {"train_where": ["run<3"], "test_where": "run>=3"}
    model = quietly(lambda: bw.train(bench.traces, labels, **{**PLAIN, **options}))
    held_out = model.report()["held_out"]
    assert sum(map(sum, held_out["confusion"])) + sum(held_out["novel"]) == 3
    assert len(model.trained_on) == 9


def test_bad_input_is_an_exception_with_the_text_of_the_command_line(command, folder, bench, tmp_path):
    def text(error, *arguments, **options):
        with pytest.raises(error) as caught:
            bw.train(*arguments, **{**PLAIN, **options})
        return str(caught.value)

    refused = bw.BearingWatchError
    assert text(refused, bench.traces, bench.labels, ordr=3) == "train has no option ordr; did you mean order?"
    assert "offset is true or false" in text(refused, bench.traces, bench.labels, offset=3)
    assert "features takes a text, a number or a list" in text(
        TypeError, bench.traces, bench.labels, features=[object()]
    )
    assert "unknown class x" in text(refused, bench.traces, bench.labels, healthy="x")
    assert "invalid value '1,2' for order" in text(refused, bench.traces, bench.labels, order=(1, 2))
    assert "no trace with the columns of current_a" in text(refused, {}, bench.labels)
    assert "no column" in text(refused, bench.traces, bench.labels, y="nothing")
    assert "no column class_name" in text(refused, bench.traces, {"trace": ["a"], "run": [1]})
    few = {name: bench.labels[name] for name in ("healthy_3_000", "spall_3_000")}
    assert "class healthy has 1 training trace(s)" in text(refused, bench.traces, few, segment=None)
    assert "ghost is labelled, but there is no such trace" in text(
        refused, bench.traces, {**bench.labels, "ghost": "spall"}
    )
    assert "a table is a mapping of columns or an Arrow table, not int" in text(TypeError, 3, bench.labels)
    gone = tmp_path / "none.csv"
    message = text(FileNotFoundError, gone, folder / "labels.csv")
    printed = command(
        "train", gone, "--labels", folder / "labels.csv", *words(PLAIN), "--model", tmp_path / "m.bwm", fails=True
    )
    assert printed == f"error: {message}\n"
    broken = {name: dict(own) for name, own in bench.traces.items()}
    broken["spall_3_000"]["current_a"] = broken["spall_3_000"]["current_a"].copy()
    broken["spall_3_000"]["current_a"][41] = -1e16
    message = text(refused, broken, bench.labels)
    assert "spall_3_000, row 42, column current_a: -10000000000000000 is no measured value" in message
    broken["spall_3_000"]["current_a"] = broken["spall_3_000"]["current_a"][:-1]
    assert "give columns of one length" in text(refused, broken, bench.labels)
    broken["spall_3_000"]["current_a"] = np.zeros((5000, 2))
    assert "no numbers but float64 in 2 dimensions" in text(refused, broken, bench.labels)
    broken["spall_3_000"]["current_a"] = ["x"] * 5000
    assert "no numbers but text" in text(refused, broken, bench.labels)
