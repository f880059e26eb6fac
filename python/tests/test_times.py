"""Times of tables in memory: each form has the rate, and the model the bytes, of the same table read from a file."""

import datetime

import bearing_watch as bw
import numpy as np
import pytest

from conftest import PLAIN, quietly

pandas = pytest.importorskip("pandas")
polars = pytest.importorskip("polars")
pyarrow = pytest.importorskip("pyarrow")
parquet = pytest.importorskip("pyarrow.parquet")

COLUMNS = ("current_a", "velocity_ref_rad_s", "velocity_rad_s", "load_torque_nm")
#: The step of the rows at 16 kHz, which is no whole number of microseconds.
STEP_NS = 62_500
START = datetime.datetime(2026, 11, 26, 23, 59, 59)
OPTIONS = {**PLAIN, "segment": 1000, "order": (1, 1, 1, 1, 1)}


@pytest.fixture(scope="module")
def signals(bench):
    return {name: {column: own[column][:2000] for column in COLUMNS} for name, own in bench.traces.items()}


def times(unit):
    """Points of time in a unit, of rows with some jitter of a nanosecond."""
    random = np.random.default_rng(5)
    nanoseconds = np.arange(2000, dtype=np.int64) * STEP_NS + random.integers(-20, 20, 2000)
    return np.datetime64(START, "ns") + nanoseconds.astype("m8[ns]").astype(f"m8[{unit}]")


def pythons(values):
    return values.astype("M8[us]").astype(object).tolist()


def in_pandas(index):
    return lambda columns: pandas.DataFrame(columns, index=index)


def with_column(name, values):
    return lambda columns: {name: values, **columns}


ZONE = datetime.timezone(datetime.timedelta(hours=-5))
FORMS = {
    "index_ns": (in_pandas(pandas.DatetimeIndex(times("ns"))), "ns"),
    "index_us": (in_pandas(pandas.DatetimeIndex(times("us").astype("M8[us]"))), "us"),
    "index_ms": (in_pandas(pandas.date_range(START, periods=2000, freq="ms", unit="ms")), None),
    "index_periods": (in_pandas(pandas.period_range(START, periods=2000, freq="ms")), None),
    "index_zoned": (in_pandas(pandas.DatetimeIndex(times("ns"), tz="UTC").tz_convert("America/New_York")), "ns"),
    "index_timedelta": (in_pandas(pandas.TimedeltaIndex(times("ns") - times("ns")[0])), "ns"),
    "index_named": (in_pandas(pandas.DatetimeIndex(times("ns"), name="current_a")), "ns"),
    "column_pandas": (lambda own: pandas.DataFrame({"time": times("us").astype("M8[us]"), **own}), "us"),
    "column_zoned": (
        lambda own: pandas.DataFrame({"time": pandas.DatetimeIndex(times("ns"), tz="UTC"), **own}),
        "ns",
    ),
    "column_arrow_in_pandas": (
        lambda own: pandas.DataFrame(
            {"when": pandas.Series(times("us").astype("M8[us]"), dtype="timestamp[us, tz=UTC][pyarrow]"), **own}
        ),
        "us",
    ),
    "array": (with_column("time", times("ns")), "ns"),
    "array_big_endian": (with_column("time", times("ns").astype(">M8[ns]")), "ns"),
    "array_of_spans": (with_column("elapsed", times("ns") - times("ns")[0]), "ns"),
    "array_unnamed": (with_column("when", times("us").astype("M8[us]")), "us"),
    "list_of_datetimes": (with_column("time", pythons(times("us"))), "us"),
    "list_of_zoned": (with_column("time", [own.replace(tzinfo=ZONE) for own in pythons(times("us"))]), "us"),
    "list_of_timestamps": (with_column("time", list(pandas.DatetimeIndex(times("ns")))), "ns"),
    "texts": (with_column("when", [str(own) for own in times("ns")]), "ns"),
    "polars_us": (lambda own: polars.DataFrame({"time": times("us").astype("M8[us]"), **own}), "us"),
    "polars_ns": (lambda own: polars.DataFrame({"when": times("ns"), **own}), "ns"),
    "polars_series": (with_column("time", polars.Series(times("ns"))), "ns"),
    "pyarrow_ns": (lambda own: pyarrow.table({"time": times("ns"), **own}), "ns"),
    "pyarrow_zoned": (
        lambda own: pyarrow.table(
            {"when": pyarrow.array(times("us").astype("M8[us]"), pyarrow.timestamp("us", "Europe/Berlin")), **own}
        ),
        "us",
    ),
    "pyarrow_array": (with_column("time", pyarrow.chunked_array([times("ns")[:7], times("ns")[7:]])), "ns"),
    "pyarrow_of_day": (
        lambda own: pyarrow.table(
            {"clock": pyarrow.array([k * 1000 for k in range(2000)], pyarrow.time64("us")), **own}
        ),
        None,
    ),
}


def to_file(table, path):
    """Writes the same table with a tool of its own kind."""
    if isinstance(table, pandas.DataFrame):
        is_of_periods = isinstance(table.index, pandas.PeriodIndex)
        (table.set_index(table.index.to_timestamp()) if is_of_periods else table).to_parquet(path)
    elif isinstance(table, polars.DataFrame):
        table.write_parquet(path)
    else:
        if isinstance(table, dict):
            # pyarrow takes no bytes in the other order.
            table = pyarrow.table({name: native(own) for name, own in table.items()})
        parquet.write_table(table, path)


def native(values):
    """The values as pyarrow takes them: in the order of bytes of this machine, and with their nanoseconds."""
    if isinstance(values, np.ndarray) and values.dtype.byteorder == ">":
        return values.astype("M8[ns]")
    if isinstance(values, polars.Series):
        return values.to_arrow()
    return pandas.DatetimeIndex(values) if isinstance(values[0], pandas.Timestamp) else values


def labels_of(bench, folder):
    labels = folder / "labels.csv"
    labels.write_text("trace,class_name\n" + "".join(f"{name},{own}\n" for name, own in bench.labels.items()))
    return labels


@pytest.mark.parametrize("form", FORMS)
def test_each_form_of_time_gives_the_model_of_the_file(bench, signals, tmp_path, form):
    make, unit = FORMS[form]
    tables = {name: make(columns) for name, columns in signals.items()}
    model = quietly(lambda: bw.train(tables, bench.labels, **OPTIONS))
    expected = 1e-3 if unit is None else STEP_NS * 1e-9
    # The core has the interval in single precision; steps in microseconds are 62 or 63 of them.
    assert model.interval_s == pytest.approx(expected, rel=2e-5 if unit != "us" else 0.01)
    for name, table in tables.items():
        to_file(table, tmp_path / f"{name}.parquet")
    labels = labels_of(bench, tmp_path)
    assert quietly(lambda: bw.train(tmp_path, labels, **OPTIONS)).to_bytes() == model.to_bytes()


def test_days_are_a_time_only_by_their_name(bench, signals):
    days = np.datetime64("2020-01-01") + np.arange(2000)
    for own in (days, days.astype(object), pyarrow.array(days)):
        tables = {name: {"day": own, **columns} for name, columns in signals.items()}
        assert quietly(lambda: bw.train(tables, bench.labels, **OPTIONS)).interval_s == 0
        tables = {name: {"time": own, **columns} for name, columns in signals.items()}
        with pytest.raises(bw.BearingWatchError, match="sampling interval is out of range"):
            quietly(lambda: bw.train(tables, bench.labels, **OPTIONS))


def test_a_row_without_a_time_is_a_missing_sample_as_in_a_file(bench, signals, tmp_path):
    gone = times("ns").copy()
    gone[[5, 900]] = np.datetime64("NaT")
    tables = {name: pandas.DataFrame({"time": gone, **columns}) for name, columns in signals.items()}
    model = quietly(lambda: bw.train(tables, bench.labels, **OPTIONS))
    for name, table in tables.items():
        table.to_parquet(tmp_path / f"{name}.parquet")
    labels = labels_of(bench, tmp_path)
    assert quietly(lambda: bw.train(tmp_path, labels, **OPTIONS)).to_bytes() == model.to_bytes()


def test_times_that_cannot_be_are_refused_with_their_row(bench, signals):
    def refused(values, match, error=bw.BearingWatchError):
        tables = {name: {"time": values, **columns} for name, columns in signals.items()}
        with pytest.raises(error, match=match):
            quietly(lambda: bw.train(tables, bench.labels, **OPTIONS))

    falling = times("ns").copy()
    falling[7] = falling[5]
    refused(falling, "row 8, column time: time runs backwards")
    refused(np.full(2000, np.datetime64("NaT", "ns")), "column time of healthy_3_000: no row has a time")
    mixed = pythons(times("us"))
    refused([*mixed[:9], 5, *mixed[10:]], "column time: no numbers but points and in row 10 5")
    refused([*mixed[:9], mixed[9].date(), *mixed[10:]], "points and in row 10 datetime.date")
    refused([*mixed[:9], mixed[9].replace(tzinfo=ZONE), *mixed[10:]], r"with and without a time zone \(row 10\)")
    words = [str(own) for own in times("ns")]
    refused([*words[:99], "noon", *words[100:]], 'row 100, column time: "noon" is no date with a time')
    refused((times("ns") - times("ns")[0]).astype(np.int64).view("m8"), "times without a unit", ValueError)


def test_columns_of_series_are_a_table(bench, signals):
    model = quietly(lambda: bw.train(signals, bench.labels, **OPTIONS))
    for make in (pandas.Series, polars.Series, lambda own: pyarrow.chunked_array([own])):
        columns = {name: make(own) for name, own in signals["spall_3_000"].items()}
        found = bw.Detector(model).run(columns)
        assert found.verdict.tolist() == bw.Detector(model).run(signals["spall_3_000"]).verdict.tolist()
        assert list(bw.replay(model, columns)) == ["traces"]
        with pytest.raises(TypeError, match="a table is a mapping of columns"):
            bw.Detector(model).run(columns["current_a"])


def test_an_index_stays_a_time_beside_columns_whose_names_only_begin_like_one(bench, signals):
    tables = {
        name: pandas.DataFrame({**own, "t_motor_degc": 40.0}, index=pandas.DatetimeIndex(times("ns")))
        for name, own in signals.items()
    }
    model = quietly(lambda: bw.train(tables, bench.labels, **OPTIONS))
    assert model.interval_s == pytest.approx(STEP_NS * 1e-9, rel=2e-5)
