"""Recordings and parts in stores, data bases and lakes: the examples of `STORES.md`, each run as it stands there."""

import json
import shutil
import sqlite3

import bearing_watch as bw
import numpy as np
import pytest
from bearing_watch import fleet

from conftest import document, quietly, told

pandas = pytest.importorskip("pandas")
polars = pytest.importorskip("polars")
pyarrow = pytest.importorskip("pyarrow")
parquet = pytest.importorskip("pyarrow.parquet")

OPTIONS = {"y": "current_a", "u1": "velocity_ref_rad_s", "u2": "load_torque_nm", "order": (2, 1, 2, 1, 1)}
CHANNELS = {"y": "current_a", "u1": "velocity_rad_s", "order": (2, 1, 0, 1, 1)}


def example(word, language="python"):
    """The only example of the chapter with this word."""
    (found,) = [own for own in document("STORES.md", language) if word in own]
    return found


def run(text, folder, monkeypatch, **given):
    """Runs an example in a folder; its variables."""
    monkeypatch.chdir(folder)
    names = dict(given)
    quietly(lambda: exec(text, names))
    return names


@pytest.fixture(scope="module")
def store(bench, tmp_path_factory):
    """A folder as of a store, with recordings of two classes as Parquet files."""
    folder = tmp_path_factory.mktemp("store")
    for name, columns in bench.traces.items():
        if not name.startswith("roughness"):
            parquet.write_table(pyarrow.table(columns), folder / f"{name}.parquet")
    return folder


def model_of_files(folder, tmp_path):
    rows = [f"{own.stem},{own.stem.split('_')[0]}" for own in sorted(folder.glob("*.parquet"))]
    labels = tmp_path / "labels.csv"
    labels.write_text("trace,class_name\n" + "\n".join(rows))
    return quietly(lambda: bw.train(folder, labels, **OPTIONS))


def test_a_folder_of_a_store_is_copied_or_read(store, tmp_path, monkeypatch):
    address = '"s3://plant-7/press?region=eu-central-1"'
    run(example("copy_files").replace(address, repr(store.as_uri())), tmp_path, monkeypatch)
    assert len(list((tmp_path / "press").iterdir())) == len(list(store.iterdir())) == 8
    names = run(example("FileSelector").replace(address, repr(store.as_uri())), tmp_path, monkeypatch)
    expected = model_of_files(store, tmp_path)
    assert sorted(names["model"].classes) == sorted(expected.classes)
    # A store lists files in any order, and the order of the traces is that of the classes.
    sorted_labels = dict(sorted(names["labels"].items()))
    model = quietly(lambda: bw.train(names["traces"], sorted_labels, **OPTIONS))
    assert model.to_bytes() == expected.to_bytes()
    # A file system that begins in a folder.
    fs = pytest.importorskip("pyarrow.fs")
    inner = fs.SubTreeFileSystem(str(store), fs.LocalFileSystem())
    tables = {name: parquet.read_table(f"{name}.parquet", filesystem=inner) for name in names["traces"]}
    assert quietly(lambda: bw.train(tables, sorted_labels, **OPTIONS)).to_bytes() == expected.to_bytes()


def test_a_store_of_fsspec_is_read(store, tmp_path, monkeypatch):
    fsspec = pytest.importorskip("fsspec")
    memory = fsspec.filesystem("memory")
    for file in store.iterdir():
        memory.pipe(f"/plant-7/press/{file.name}", file.read_bytes())
    names = run(example("fsspec").replace('"s3"', '"memory"'), tmp_path, monkeypatch)
    tables = {path.split("/")[-1].removesuffix(".parquet"): own for path, own in names["traces"].items()}
    labels = {name: name.split("_")[0] for name in tables}
    assert quietly(lambda: bw.train(tables, labels, **OPTIONS)).to_bytes() == model_of_files(store, tmp_path).to_bytes()


def test_a_selection_of_a_lake_is_a_tidy_table(bench, tmp_path, monkeypatch):
    dataset = pytest.importorskip("pyarrow.dataset")
    times = np.datetime64("2026-11-26T10:00:00", "us") + np.arange(5000) * np.timedelta64(2000, "us")
    tables = [
        pyarrow.table({"trace": [name] * 5000, "time": times, "year": [2025 + k % 2] * 5000, **columns})
        for k, (name, columns) in enumerate(bench.traces.items())
    ]
    parts = dataset.partitioning(pyarrow.schema([("year", pyarrow.int64())]), flavor="hive")
    dataset.write_dataset(pyarrow.concat_tables(tables), tmp_path / "lake", format="parquet", partitioning=parts)
    address = '"s3://plant-7/lake?region=eu-central-1"'
    names = run(example("to_table").replace(address, '"lake"'), tmp_path, monkeypatch)
    chosen = list(bench.traces)[1::2]
    labels = {name: bench.labels[name] for name in chosen}
    model = quietly(lambda: bw.train(names["table"], labels, **CHANNELS))
    assert model.trained_on == chosen and model.interval_s == pytest.approx(0.002, rel=2e-5)
    with pytest.raises(bw.BearingWatchError, match="there is no such trace"):
        quietly(lambda: bw.train(names["table"], bench.labels, **CHANNELS))


@pytest.fixture(scope="module")
def samples(bench):
    """A table of a data base with a row for each value, and the signals themselves."""
    own = bench.traces["spall_3_000"]
    steps = np.datetime64("2026-11-26T10:00:00", "us") + np.arange(3000) * np.timedelta64(2000, "us")
    times = [f"{step}Z" for step in steps]
    rows = [
        (time, 7, channel, float(own[channel][k]))
        for k, time in enumerate(times)
        for channel in ("current_a", "velocity_rad_s")
    ]
    random = np.random.default_rng(4)
    return [rows[k] for k in random.permutation(len(rows))], own


def check(file, own):
    trace = bw.read(file)
    assert trace.interval_s == pytest.approx(0.002, rel=2e-5) and len(trace) == 3000
    for name in ("current_a", "velocity_rad_s"):
        assert np.array_equal(trace[name], own[name][:3000])


def test_the_query_of_the_book_gives_a_column_for_each_signal(samples, tmp_path, monkeypatch):
    rows, own = samples
    connection = sqlite3.connect(":memory:")
    connection.execute("CREATE TABLE samples (time TEXT, run INTEGER, channel TEXT, value REAL)")
    connection.executemany("INSERT INTO samples VALUES (?, ?, ?, ?)", rows)
    (tmp_path / "runs").mkdir()
    query = example("FILTER", "sql")
    run(example("read_sql"), tmp_path, monkeypatch, query=query, connection=connection)
    schema = parquet.read_schema(tmp_path / "runs" / "run_7.parquet")
    assert schema.field("time").type.tz == "UTC"
    check(tmp_path / "runs" / "run_7.parquet", own)


def test_a_row_for_each_value_is_refused_with_the_remedy_that_works(samples, command, tmp_path, monkeypatch):
    rows, own = samples
    times, _, channels, values = zip(*sorted(rows))
    utc = pyarrow.timestamp("us", "UTC")
    long = {
        "_time": pyarrow.array(pandas.to_datetime(times, utc=True), utc),
        "_field": pyarrow.array(channels).dictionary_encode(),
        "_value": pyarrow.array(values, pyarrow.float64()),
    }
    parquet.write_table(pyarrow.table(long), tmp_path / "export.parquet")
    refusal = r"named by column _field, with their values in column _value; write a column for each signal"
    with pytest.raises(bw.BearingWatchError, match=refusal):
        bw.read(tmp_path / "export.parquet")
    assert "write a column for each signal" in command("init", tmp_path / "export.parquet", fails=True)
    with pytest.raises(bw.BearingWatchError, match=refusal):
        bw.train({"a": pyarrow.table(long)}, {"a": "x"}, y="_value", u1="_value", order=(2, 1, 0, 1, 1))
    (tmp_path / "runs").mkdir()
    run(example("long.pivot"), tmp_path, monkeypatch)
    check(tmp_path / "runs" / "run_7.parquet", own)


def test_types_of_exports_are_read(tmp_path):
    count = 400
    steps = [None if k == 7 else 1_795_651_200_000_000 + 500 * k for k in range(count)]
    decimals = pyarrow.array([str(k / 8) for k in range(count)]).cast(pyarrow.decimal128(12, 3))
    nullable = pyarrow.array([None if k in (3, 9) else k % 11 for k in range(count)], pyarrow.float64())
    zone = pyarrow.timestamp("us", "Europe/Berlin")
    columns = {"time": pyarrow.array(steps, zone), "current_a": nullable, "load_nm": decimals}
    parquet.write_table(pyarrow.table({**columns, "state": ["run"] * count}), tmp_path / "e.parquet")
    with pytest.warns(bw.BearingWatchWarning, match="column state"):
        trace = bw.read(tmp_path / "e.parquet")
    assert trace.interval_s == pytest.approx(500e-6, rel=2e-5)
    assert np.flatnonzero(np.isnan(trace["current_a"])).tolist() == [3, 9] and trace["load_nm"][5] == 0.625
    assert np.flatnonzero(np.isnan(trace.time_s)).tolist() == [7]


@pytest.fixture(scope="module")
def part(folder, tmp_path_factory):
    """A part of twelve drives in two years, and the model of it."""
    place = tmp_path_factory.mktemp("parts")
    rows = (folder / "labels.csv").read_text().splitlines()[1:]
    rows = [f"{row.split(',')[0]},{row.split(',')[1]},d{k:02},{2025 + k % 2}" for k, row in enumerate(rows)]
    (place / "labels.csv").write_text("trace,class_name,drive,year\n" + "\n".join(rows))
    fleet.features(folder, place / "labels.csv", out=place / "a.parquet", unit="drive", segment=500, **OPTIONS)
    return place


def trained(parts, folder, **options):
    found = quietly(
        lambda: fleet.train_features(parts, model=folder / "m.bwm", features=["a", "b"], unit="drive", **options)
    )
    return found["fingerprint"], found["rows"]


def plain_texts(schema, kind):
    """The schema with texts of this type in place of dictionaries."""
    is_text = pyarrow.types.is_dictionary
    return pyarrow.schema([(field.name, kind if is_text(field.type) else field.type) for field in schema])


def without_metadata(part, file, change=lambda table: table):
    parquet.write_table(change(parquet.read_table(part / "a.parquet")).replace_schema_metadata(None), file)


def test_a_part_that_is_written_again_needs_the_plan_beside_it(part, tmp_path):
    expected = trained(part / "a.parquet", tmp_path)
    assert json.loads((part / "a.plan.json").read_text())["features"][:2] == ["a1", "a2"]
    copy = tmp_path / "b.parquet"
    without_metadata(part, copy)
    with pytest.raises(bw.BearingWatchError, match="its metadata with the plan is lost: put the file NAME.plan.json"):
        trained(copy, tmp_path)
    shutil.copy(part / "a.plan.json", tmp_path / "b.plan.json")
    assert trained(copy, tmp_path) == expected
    # Rows in another order: the sums are exact, and only the second pass is left out.
    without_metadata(part, copy, lambda table: table.sort_by("segment"))
    options = {"model": tmp_path / "m.bwm", "features": ["a", "b"], "unit": "drive"}
    assert "units do not ascend" in told(lambda: fleet.train_features(copy, **options))[1]
    whole = parquet.read_table(part / "a.parquet")
    metadata = parquet.read_metadata(part / "a.parquet").metadata
    assert json.loads(metadata[b"bearing_watch_plan"]) == json.loads((part / "a.plan.json").read_text())
    own = {name: metadata[name] for name in (b"bearing_watch_plan", b"bearing_watch_sorted")}
    parquet.write_table(whole.sort_by("segment").replace_schema_metadata(own), copy)
    with pytest.raises(bw.BearingWatchError, match="but the file says that units ascend"):
        trained(copy, tmp_path)
    # Texts without a dictionary, and other types of texts.
    without_metadata(part, copy, lambda own: own.cast(plain_texts(own.schema, pyarrow.large_string())))
    assert trained(copy, tmp_path) == expected
    without_metadata(part, copy, lambda own: own.drop(["unit"]).append_column("unit", pyarrow.nulls(len(own), "str")))
    with pytest.raises(bw.BearingWatchError, match="column unit lacks cells; fill them in"):
        trained(copy, tmp_path)
    (tmp_path / "b.plan.json").write_text("{}")
    with pytest.raises(bw.BearingWatchError, match="b.plan.json, content: the plan has version none"):
        trained(copy, tmp_path)


def test_polars_writes_parts_again(part, tmp_path, monkeypatch):
    expected = trained(part / "a.parquet", tmp_path)
    for file in ("a.parquet", "a.plan.json"):
        shutil.copy(part / file, tmp_path)
    text = example("polars")
    run(text.replace('pl.col("usable") > 0.9', 'pl.col("usable") >= 0'), tmp_path, monkeypatch)
    assert trained(tmp_path / "b.parquet", tmp_path) == expected


def test_a_folder_of_parts_has_the_keys_of_its_names(part, command, tmp_path):
    dataset = pytest.importorskip("pyarrow.dataset")
    expected = trained(part / "a.parquet", tmp_path)
    table = parquet.read_table(part / "a.parquet").replace_schema_metadata(None)
    keys = dataset.partitioning(pyarrow.schema([(name, pyarrow.string()) for name in ("year", "unit")]), flavor="hive")
    lake = tmp_path / "lake"
    texts = table.cast(plain_texts(table.schema, pyarrow.string()))
    dataset.write_dataset(texts, lake, format="parquet", partitioning=keys)
    with pytest.raises(bw.BearingWatchError, match="or as plan.json into its folder"):
        trained(lake, tmp_path)
    shutil.copy(part / "a.plan.json", lake / "plan.json")
    assert trained(lake, tmp_path) == expected
    assert trained(lake, tmp_path, train_where=["year=2026"])[1] == expected[1] // 2
    words = ["--features=a,b", "--unit=drive", f"--model={tmp_path / 'n.bwm'}", "--json"]
    assert json.loads(command("train-features", lake, *words))["fingerprint"] == expected[0]
    with pytest.raises(bw.BearingWatchError, match="no part in this folder"):
        (tmp_path / "empty").mkdir()
        trained(tmp_path / "empty", tmp_path)


def test_another_machine_takes_the_plan_beside_a_part(part, folder, tmp_path):
    options = {"unit": "drive", "segment": 500, **OPTIONS}
    labels = part / "labels.csv"
    for plan, out in ((part / "a.parquet", "b.parquet"), (part / "a.plan.json", "c.parquet")):
        quietly(lambda: fleet.features(folder, labels, out=tmp_path / out, plan=plan, **options))
    assert (tmp_path / "b.parquet").read_bytes() == (tmp_path / "c.parquet").read_bytes()
    assert (tmp_path / "b.plan.json").read_text() == (part / "a.plan.json").read_text()
