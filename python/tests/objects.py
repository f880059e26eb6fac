"""Odd objects, drawn by a seeded generator: what programs hand over by mistake, and what only an attacker would."""

import array
import collections
import datetime
import decimal
import fractions
import pathlib
import types

import numpy as np

try:
    import pandas
    import polars
    import pyarrow
except ImportError:
    pandas = polars = pyarrow = None

DTYPES = "? i1 i2 >i4 i8 u1 <u2 u8 >u8 f2 f4 >f4 f8 >f8 c8 c16 S2 U3 >U2 O V4".split()
DTYPES += "M8[s] >M8[ns] M8[D] M8[M] m8[us] m8[Y] M8".split()
SHAPES = [(), (0,), (1,), (2,), (7,), (60,), (60,), (60,), (200,), (3, 4), (60, 1), (1, 60), (0, 3), (2, 2, 2)]
#: Names that columns may have.
NAMES = [
    "current_a",
    "velocity_rad_s",
    "load_torque_nm",
    "t_s",
    "time",
    "trace",
    "class_name",
    "",
    "x" * 300,
    "ä\0",
    "a-b",
]


class Text(str):
    """A text that is not a plain one."""


class Whole(int):
    """A number that is not a plain one."""


class Raising:
    """An object whose conversions fail."""

    def __array__(self, *_, **__):
        raise ValueError("no array")

    def __len__(self):
        raise TypeError("no length")

    def __iter__(self):
        raise TypeError("no values")


class Endless(collections.abc.Mapping):
    """A mapping whose values are missing."""

    def __getitem__(self, key):
        raise ValueError(f"no value for {key}")

    def __len__(self):
        return 3

    def __iter__(self):
        return iter(["current_a", "velocity_rad_s", "load_torque_nm"])


class Stream:
    """An object with an Arrow stream that is none."""

    def __init__(self, own):
        self.own = own

    def __arrow_c_stream__(self, requested_schema=None):
        return self.own


def pick(random, values):
    return values[random.integers(len(values))]


def text(random):
    return pick(
        random,
        [
            "",
            "healthy",
            "a",
            "none",
            "ls",
            "1,1,0,1,1",
            "current_a",
            "\0",
            "\ud800",
            "é" * 50,
            "-1",
            "nan",
            "1e999",
            "{}",
            "a=b",
            "a<=",
            "[",
            Text("y"),
            "../x",
            "*",
        ],
    )


def number(random):
    return pick(
        random,
        [
            0,
            1,
            2,
            3,
            5,
            -1,
            32,
            33,
            10**6,
            2**31,
            2**63,
            -(2**63) - 1,
            10**40,
            0.5,
            -0.0,
            1e-320,
            1e300,
            float("nan"),
            float("inf"),
            -float("inf"),
            True,
            Whole(3),
            np.float32(2.5),
            np.int8(-1),
            np.uint64(2**64 - 1),
            1j,
            decimal.Decimal("1.5"),
            decimal.Decimal("sNaN"),
            fractions.Fraction(1, 3),
        ],
    )


def moment(random):
    own = datetime.datetime(2026, 11, 26, 1, 2, 3, int(random.integers(10**6)))
    zone = datetime.timezone(datetime.timedelta(minutes=int(random.integers(-1439, 1439))))
    return pick(
        random,
        [
            own,
            own.replace(tzinfo=zone),
            own.date(),
            own.time(),
            own - own.replace(year=1),
            datetime.datetime.min.replace(tzinfo=zone),
            datetime.datetime.max.replace(tzinfo=zone),
            np.datetime64("NaT"),
            np.timedelta64(3, "Y"),
            None,
            datetime.timedelta.max,
        ],
    )


def an_array(random, shape=None):
    shape = pick(random, SHAPES) if shape is None else shape
    kind = np.dtype(pick(random, DTYPES))
    count = int(np.prod(shape))
    if kind.kind == "O":
        values = np.empty(count, dtype=object)
        for k in range(count):
            values[k] = (
                pick(random, [1, 2.5, None, "a", True, float("nan"), 10**30])
                if random.integers(8)
                else pick(random, [moment, number, text])(random)
            )
        own = values.reshape(shape)
    elif kind.kind in "fc" and random.integers(4):
        with np.errstate(all="ignore"):
            own = (random.normal(size=shape) * 10.0 ** random.integers(-40, 40)).astype(kind)
    else:
        own = (
            np.frombuffer(random.bytes(count * max(kind.itemsize, 1)), dtype="u1").view(kind).reshape(shape)
            if kind.kind not in "U"
            else np.full(shape, "ab", dtype=kind)
        )
    how = random.integers(8)
    if how == 0:
        return own[::-1] if own.ndim else own
    if how == 1 and own.ndim:
        return np.repeat(own, 2, axis=0)[::2]
    if how == 2 and own.ndim:
        return np.broadcast_to(own[:1], own.shape) if len(own) else own
    if how == 3:
        mask = random.integers(2, size=own.shape).astype(bool)
        return np.ma.MaskedArray(own, mask if random.integers(2) else np.ma.nomask)
    if how == 4:
        fields = np.zeros(own.shape, dtype=[("current_a", "f8"), ("t", "M8[ns]")])
        return pick(random, [fields, fields["current_a"], fields["t"]])
    if how == 6 and own.dtype.kind in "fMm":
        return np.frombuffer(b"\0" + own.tobytes(), dtype="u1")[1:].view(own.dtype).reshape(own.shape)
    if how == 5 and own.ndim == 1 and own.dtype.kind == "f":
        own = np.array(own)
        own.flags.writeable = False
    return own


def column(random):
    return pick(
        random, [an_array, lambda r: an_array(r, (60,)), lambda r: an_array(r, (60,)), a_list, frame_column, anything]
    )(random)


def a_list(random):
    length = int(random.integers(0, 61))
    own = pick(random, [number, text, moment, anything])
    return pick(random, [list, tuple, collections.deque, lambda values: array.array("d", [1.0] * len(values))])(
        [own(random) for _ in range(min(length, 12))] * 5
    )


def ragged(random):
    return [[1.0] * int(random.integers(0, 5)) for _ in range(int(random.integers(0, 6)))]


def frame_column(random):
    if pandas is None:
        return an_array(random)
    count = pick(random, [0, 1, 60, 60])
    makers = [
        lambda: pandas.Series(random.normal(size=count)),
        lambda: pandas.Series(pandas.array([1, None] * (count // 2), dtype="Int64")),
        lambda: pandas.Series(pandas.Categorical(["a", "b"] * (count // 2))),
        lambda: pandas.Series(pandas.date_range("2026-01-01", periods=count, freq="ms", tz="Asia/Kolkata")),
        lambda: pandas.Series(pandas.period_range("2026-01", periods=count, freq="D")),
        lambda: pandas.Series(pandas.interval_range(0, count)),
        lambda: pandas.Series([None] * count, dtype="string"),
        lambda: pandas.Series(pandas.arrays.SparseArray(np.zeros(count))),
        lambda: polars.Series([1.0, None] * (count // 2), dtype=polars.Float32),
        lambda: polars.Series([[1.0]] * count, dtype=polars.List(polars.Float64)),
        lambda: polars.Series([datetime.datetime(2026, 1, 1)] * count, dtype=polars.Datetime("ns", "UTC")),
        lambda: polars.Series([decimal.Decimal("1.1")] * count, dtype=polars.Decimal(10, 2)),
        lambda: polars.Series(["a"] * count, dtype=polars.Categorical),
        lambda: pyarrow.array([1, None] * (count // 2), pyarrow.int8()),
        lambda: pyarrow.chunked_array([[1.0], [2.0] * max(count - 1, 0)]),
        lambda: pyarrow.array([{"a": 1}] * count),
        lambda: pyarrow.array([0] * count, pyarrow.time32("ms")),
        lambda: pyarrow.nulls(count),
        lambda: pyarrow.array([1] * count, pyarrow.date32()),
        lambda: pyarrow.array(["a"] * count).dictionary_encode(),
    ]
    return pick(random, makers)()


def good(random):
    """A table that is mostly right."""
    u = random.normal(size=60)
    return {
        "current_a": np.cumsum(u) * 0.1,
        "velocity_rad_s": u,
        "load_torque_nm": random.normal(size=60),
        "t_s": np.arange(60) * 0.01,
    }


def table(random):
    own = dict(good(random)) if random.integers(3) else {}
    for _ in range(int(random.integers(0, 4))):
        name = pick(random, NAMES) if random.integers(6) else anything(random)
        try:
            own[name] = column(random)
        except TypeError:
            own["unhashable"] = name
    how = random.integers(12)
    if pandas is not None and how < 6:
        try:
            return [doubled, indexed, to_polars, to_arrow, batches, relation][how](random, own)
        except Exception:
            return own
    if how == 6:
        return types.MappingProxyType(own)
    if how == 7:
        return collections.defaultdict(list, own)
    return own


def doubled(random, own):
    frame = pandas.DataFrame(simple(random))
    return pandas.concat([frame, frame.iloc[:, :1]], axis=1)


def indexed(random, own):
    index = pick(
        random,
        [
            lambda: pandas.date_range("2026", periods=60, freq="ms"),
            lambda: pandas.DatetimeIndex([None] * 60),
            lambda: pandas.timedelta_range("1s", periods=60, freq="-1ms"),
            lambda: pandas.period_range("2026", periods=60, freq="s"),
            lambda: pandas.MultiIndex.from_product([["a", "b"], range(30)]),
            lambda: pandas.CategoricalIndex(["a"] * 60),
            lambda: pandas.Index([moment(random) for _ in range(60)]),
            lambda: pandas.Index(np.full(60, np.nan), name="time"),
            lambda: pandas.date_range("1700-01-01", periods=60, freq="YS", tz="UTC"),
        ],
    )()
    return pandas.DataFrame(good(random) if random.integers(2) else {"current_a": np.arange(60.0)}, index=index)


def to_polars(random, own):
    return pick(random, [lambda frame: frame, lambda frame: frame.lazy()])(
        polars.DataFrame(simple(random), strict=False)
    )


def simple(random):
    """Columns that pyarrow and polars take; they crash at lists that contain themselves."""
    time = np.datetime64("2026-01-01", pick(random, ["s", "ms", "ns"])) + np.arange(60)
    own = pick(random, [np.ones(60), time, time - time[0], ["a"] * 60, [None] * 60, np.arange(60, dtype="i2")])
    # Values at an odd address.
    odd = pyarrow.py_buffer(b"\0" + np.ones(60).tobytes()).slice(1)
    odd = pyarrow.Array.from_buffers(pyarrow.float64(), 60, [None, odd]) if random.integers(4) == 0 else own
    return {**good(random), pick(random, NAMES): odd}


def to_arrow(random, own):
    own = simple(random)
    return pick(random, [lambda own: own, lambda own: own.slice(3, 20), lambda own: own.to_reader(7)])(
        pyarrow.table(own)
    )


def batches(random, own):
    first = pyarrow.RecordBatch.from_pydict(simple(random))
    return pick(
        random,
        [
            first,
            pyarrow.Table.from_batches([], first.schema),
            pyarrow.Table.from_arrays(first.columns, ["a"] * first.num_columns),
        ],
    )


def relation(random, own):
    return Stream(pick(random, [None, 3, "x", pyarrow.array([1.0]).__arrow_c_array__()[0], Stream(None)]))


def tables(random):
    names = ["a", "b", "c", "", 3, None, Text("d"), b"e"]
    return {pick(random, names): table(random) for _ in range(int(random.integers(0, 5)))}


def labels(random):
    made = {
        pick(random, ["a", "b", "c", 3, "traces"]): pick(random, ["healthy", "spall", "", Text("x"), 5, None])
        for _ in range(int(random.integers(0, 5)))
    }
    return pick(
        random, [made, {"trace": list(made), "class_name": list(made.values())}, table(random), None, anything(random)]
    )


def order(random):
    return pick(
        random,
        [
            (1, 1, 0, 1, 1),
            (1, 1, 1, 1, 1),
            (2, 1, 0, 1, 1),
            "1,1,0,1,1",
            [33] * 5,
            (1,),
            (),
            ragged(random),
            np.array([1, 1, 0, 1, 1]),
            number(random),
            text(random),
            [number(random) for _ in range(5)],
        ],
    )


def circle():
    own = []
    own.append(own)
    return own


def anything(random):
    makers = [
        text,
        number,
        moment,
        an_array,
        ragged,
        lambda r: None,
        lambda r: r.bytes(int(r.integers(0, 40))),
        lambda r: bytearray(b"abc"),
        lambda r: memoryview(b"abcdefgh").cast("d") if r.integers(2) else memoryview(b"abc")[::2],
        lambda r: pathlib.Path("no_such_file.csv"),
        lambda r: {"a": ragged(r)},
        lambda r: {"a": [1.0] * 5, "b": [1.0] * 7},
        lambda r: {text(r): number(r)},
        lambda r: {1, 2},
        lambda r: range(60),
        lambda r: (own for own in [1.0, 2.0]),
        lambda r: Raising(),
        lambda r: Endless(),
        lambda r: object(),
        lambda r: int,
        lambda r: len,
        lambda r: Ellipsis,
        lambda r: circle(),
        lambda r: [[[[1.0]]]],
        lambda r: good(r),
        lambda r: np.dtype("f8"),
        lambda r: Exception("x"),
        frame_column,
    ]
    return pick(random, makers)(random)
