"""Points and spans of time in columns, as whole numbers of a unit that the extension module takes."""

from __future__ import annotations

import datetime
from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt

#: Kind, units a second, and the times in these units; the smallest integer is a missing one.
Times = tuple[str, float, npt.NDArray[np.int64]]

#: Units a second of the units of NumPy that are parts of one.
_PARTS = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9, "ps": 1e12, "fs": 1e15, "as": 1e18}
_MISSING = np.iinfo(np.int64).min
_MICROSECOND = datetime.timedelta(microseconds=1)
_EPOCH = datetime.datetime(1970, 1, 1)
_KINDS = {
    datetime.datetime: "points",
    datetime.date: "days",
    datetime.time: "times of the day",
    datetime.timedelta: "spans",
}


def of_pandas(values: Any) -> Any:
    """Return a column or an index of pandas with times as an array of NumPy, in UTC if it has a time zone."""
    kind: Any = getattr(values, "dtype", None)
    if getattr(kind, "kind", "") in ("M", "m") and not isinstance(kind, np.dtype):
        unit = getattr(kind, "unit", None) or kind.pyarrow_dtype.unit
        return values.to_numpy(dtype=f"{kind.kind}8[{unit}]", na_value=np.array("NaT", f"{kind.kind}8[{unit}]")[()])
    return values


def of_array(values: npt.NDArray[Any]) -> Times:
    """Return the times of an array of ``datetime64`` or ``timedelta64``."""
    unit, count = np.datetime_data(values.dtype)
    kind = "points" if values.dtype.kind == "M" else "spans"
    if unit == "generic":
        raise ValueError("times without a unit; give the array one, such as timedelta64[us]")
    # Multiples of units, and days and longer ones, are whole numbers of the unit or of seconds.
    target = unit if unit in _PARTS else "s"
    if kind == "points" and unit in ("D", "W", "M", "Y"):
        kind = "days"
    if kind == "spans" and unit in ("M", "Y"):
        raise ValueError(f"spans in {unit} have no fixed length; give seconds")
    units = values.astype(f"{values.dtype.kind}8[{target}]")
    if (count, target) != (1, unit) and not np.array_equal(units.astype(values.dtype), values, equal_nan=True):
        raise ValueError(f"times in {values.dtype} are outside of what 64 bits hold in {target}")
    return kind, _PARTS[target], _aligned(units)


def _aligned(units: npt.NDArray[Any]) -> npt.NDArray[np.int64]:
    found = np.require(units, requirements=["C", "A"]).view(np.int64)
    return found if len(found) else np.empty(0, dtype=np.int64)


def of_objects(cells: npt.NDArray[Any], missing: list[bool]) -> Union[Times, str, None]:
    """Return the times of dates, times and spans of Python; why they are none if only some are; None if none is.

    Points with a time zone are those of UTC.
    """
    first: Optional[type] = None
    zoned: Optional[bool] = None
    units = np.full(len(cells), _MISSING, dtype=np.int64)
    nanoseconds = np.zeros(len(cells), dtype=np.int64)
    for row, (cell, gone) in enumerate(zip(cells, missing)):
        if gone:
            continue
        own = next((kind for kind in _KINDS if isinstance(cell, kind)), None)
        if first is None and own is None:
            return None
        if first is None:
            first = own
        if own is not first:
            return f"{_KINDS[first or datetime.date]} and in row {row + 1} {cell!r:.40}"
        has_zone = getattr(cell, "tzinfo", None) is not None
        if zoned is not None and has_zone != zoned:
            return f"times with and without a time zone (row {row + 1})"
        zoned = has_zone
        try:
            units[row] = _microseconds(cell)
        except OverflowError:
            return f"times that 64 bits do not hold (row {row + 1})"
        nanoseconds[row] = getattr(cell, "nanosecond", 0) or getattr(cell, "nanoseconds", 0)
    if first is None:
        return None
    kind = _KINDS[first]
    if kind == "days":
        return kind, 1.0, np.where(units == _MISSING, _MISSING, units // 1_000_000)
    if not nanoseconds.any():
        return kind, 1e6, units
    return kind, 1e9, np.where(units == _MISSING, _MISSING, units * 1000 + nanoseconds)


def _microseconds(cell: Any) -> int:
    """Return microseconds since 1970, since midnight, or of a span."""
    if isinstance(cell, datetime.timedelta):
        return int(cell // _MICROSECOND)
    if isinstance(cell, datetime.time):
        return ((cell.hour * 60 + cell.minute) * 60 + cell.second) * 1_000_000 + cell.microsecond
    if not isinstance(cell, datetime.datetime):
        return int((cell - _EPOCH.date()) // _MICROSECOND)
    if cell.tzinfo is not None:
        cell = cell.astimezone(datetime.timezone.utc).replace(tzinfo=None)
    return int((cell - _EPOCH) // _MICROSECOND)
