"""Arguments of the package as the extension module takes them: arrays, tables, traces, labels."""

from __future__ import annotations

import operator
import warnings
from collections.abc import Iterable, Mapping, Sequence
from os import PathLike, fspath
from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt

from bearing_watch import _core, _times

#: A file or folder.
Path = Union[str, "PathLike[str]"]
#: Columns by name: a mapping of arrays, or a table of pandas, polars or pyarrow.
Table = Any
#: Files or folders, tables by trace id, or one table with a column ``trace``.
Traces = Union[Path, Sequence[Path], Mapping[str, Table], Table]
#: A CSV file, class names by trace id, or a table with the columns ``trace`` and ``class_name``.
Labels = Union[Path, Mapping[str, str], Table]

NUMBERS = "fiub"


class BearingWatchWarning(UserWarning):
    """What the command line prints as a warning."""


def warn(messages: Iterable[str]) -> None:
    """Warn with each message, at the line that called the function which calls this one."""
    for message in messages:
        warnings.warn(message, BearingWatchWarning, stacklevel=3)


def array(values: Any) -> npt.NDArray[Any]:
    """Return values as an array; what is masked, or missing in a column of pandas, is NaN."""
    if isinstance(values, np.ma.MaskedArray):
        if values.dtype.kind not in NUMBERS:
            if np.ma.getmaskarray(values).any():
                raise TypeError(f"a masked array of {values.dtype}: only one of numbers can have missing values")
            return np.asarray(values.data)
        return np.asarray(np.ma.filled(values.astype(np.float64), np.nan))
    own = np.asarray(values)
    if own.dtype.kind == "O" and own.ndim == 1:
        missing = [_is_missing(cell) for cell in own]
        numbers = [isinstance(cell, (int, float, np.number)) for cell in own]
        # Cells that are all missing are numbers if their column says so, as one of pandas does.
        of_numbers = getattr(getattr(values, "dtype", None), "kind", "O") in NUMBERS or not all(missing)
        if of_numbers and all(one or other for one, other in zip(missing, numbers)):
            return np.array([np.nan if gone else cell for gone, cell in zip(missing, own)], dtype=np.float64)
    return own


def vector(name: str, values: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Return values as an array of float64 in one piece of memory."""
    own = array(values)
    if own.ndim != 1:
        raise ValueError(f"{name} has {own.ndim} dimensions; give one value a sample, shape (n,)")
    if own.dtype.kind not in NUMBERS:
        raise TypeError(f"{name} holds {own.dtype}; give numbers")
    return aligned(own)


def aligned(values: npt.NDArray[Any]) -> npt.NDArray[np.float64]:
    """Return an array as one of float64 in one piece of memory, each at an address that processors take."""
    found: npt.NDArray[np.float64] = np.require(values, np.float64, ["C", "A"])
    # NumPy calls an array without values aligned wherever it is.
    return found if len(found) else np.empty(found.shape)


def _cells(values: Any) -> Any:
    """Return a column as an array of float64, a list of texts, times, or the name of the type of other cells."""
    own = array(_times.of_pandas(values))
    if own.ndim == 1 and own.dtype.kind in NUMBERS:
        return aligned(own)
    if own.ndim == 1 and own.dtype.kind in "Mm":
        return _times.of_array(own)
    if own.ndim == 1 and own.dtype.kind in "UTO":
        cells = [None if _is_missing(cell) else cell for cell in own.tolist()]
        if all(cell is None or isinstance(cell, str) for cell in cells):
            return ["" if cell is None else str(cell) for cell in cells]
        times = _times.of_objects(own, [cell is None for cell in cells])
        if times is not None:
            return times
    return f"{own.dtype} in {own.ndim} dimensions"


def _is_missing(cell: Any) -> bool:
    # The missing value of pandas is neither equal to itself nor different.
    return cell is None or type(cell).__name__ in ("NAType", "NaTType") or (isinstance(cell, float) and cell != cell)


def _is_mapping(table: Any) -> bool:
    # pandas offers Arrow only where pyarrow is installed; its columns are arrays anyway.
    is_of_pandas = type(table).__module__.split(".")[0] == "pandas"
    return isinstance(table, Mapping) or (is_of_pandas and hasattr(table, "columns"))


def _is_table(given: Any) -> bool:
    # Single columns of pandas, polars and pyarrow have Arrow streams too.
    is_column = hasattr(given, "dtype") or (hasattr(given, "type") and not hasattr(given, "schema"))
    return _is_mapping(given) or (hasattr(given, "__arrow_c_stream__") and not is_column)


def _timed(given: Any, columns: dict[str, Any]) -> dict[str, Any]:
    """Return the columns with the times of the index of a frame, unless they have times."""
    index: Any = getattr(given, "index", None)
    if isinstance(given, Mapping) or any(map(_core.is_time, columns)):
        return columns
    # Periods are points of time, their beginnings.
    index = index.to_timestamp() if hasattr(index, "to_timestamp") else index
    kind = getattr(getattr(index, "dtype", None), "kind", "")
    own = index.name if isinstance(getattr(index, "name", None), str) else "t_s"
    if kind in ("M", "m"):
        return {"t_s": _cells(index), **columns}
    return {own: _cells(index), **columns} if kind == "f" and _core.is_time(own) else columns


def table(given: Table) -> Any:
    """Return a table as a dictionary of columns, or as the object with an Arrow stream that it is."""
    if _is_mapping(given):
        columns: dict[str, Any] = {}
        for name, values in given.items():
            if str(name) in columns:
                raise ValueError(f"two columns are named {name}; rename or drop one")
            columns[str(name)] = _cells(values)
        return _timed(given, columns)
    if _is_table(given):
        for name in getattr(given, "columns", ()):
            # At such a name the stream of polars ends the process.
            if isinstance(name, str) and "\0" in name:
                raise ValueError(f"the name of column {name!r} has a null character; rename it")
        return given
    raise TypeError(f"a table is a mapping of columns or an Arrow table, not {type(given).__name__}")


def _path(given: Any) -> Optional[str]:
    return fspath(given) if isinstance(given, (str, PathLike)) else None


def traces(given: Optional[Traces]) -> tuple[Optional[list[str]], Optional[list[tuple[str, Any]]]]:
    """Return files or folders, or tables in memory with their names."""
    if given is None:
        return None, None
    path = _path(given)
    if path is not None:
        return [path], None
    if isinstance(given, Mapping):
        tables = [(str(name), own) for name, own in given.items()]
        if not all(_is_table(own) for _, own in tables):
            return None, [("traces", table(given))]
        return None, [(name, table(own)) for name, own in tables]
    if isinstance(given, Sequence) and not _is_table(given):
        paths = [path for path in map(_path, given) if path is not None]
        if len(paths) == len(given):
            return paths, None
        raise TypeError("traces are files and folders, tables by trace id, or one table with a column trace")
    return None, [("traces", table(given))]


def labels(given: Optional[Labels]) -> tuple[Optional[str], Optional[Any]]:
    """Return a file, or a table in memory."""
    if given is None:
        return None, None
    path = _path(given)
    if path is not None:
        return path, None
    if isinstance(given, Mapping) and all(isinstance(name, str) for name in given.values()):
        return None, {"trace": [str(trace) for trace in given], "class_name": list(given.values())}
    return None, table(given)


def drive_and_options(
    given: Optional[Traces], given_labels: Optional[Labels], options: dict[str, Any]
) -> tuple[Optional[str], dict[str, Any], Optional[list[tuple[str, Any]]], Optional[Any]]:
    """Return drive file, options, traces and labels of a command that takes labelled traces."""
    drive = _path(given)
    if drive is not None and drive.lower().endswith(".toml"):
        given = None
    else:
        drive = None
    files, tables_in_memory = traces(given)
    label_file, label_table = labels(given_labels)
    plain = {key: _plain(value) for key, value in options.items()}
    for key, value in (("traces", files), ("labels", label_file)):
        if value is not None:
            plain[key] = value
    return drive, plain, tables_in_memory, label_table


def _plain(value: Any) -> Any:
    """Return numbers and arrays of numpy as those of Python."""
    return value.tolist() if isinstance(value, (np.generic, np.ndarray)) else value


def real(name: str, value: Any) -> float:
    """Return a number."""
    try:
        return float(value)
    except (TypeError, ValueError, ArithmeticError):
        raise TypeError(f"{name} is a number, not {value!r:.60}") from None


def whole(name: str, value: Any) -> int:
    """Return a whole number from 0 on, of at most 31 bits."""
    try:
        number = operator.index(value)
    except TypeError:
        raise TypeError(f"{name} is a whole number, not {value!r:.60}") from None
    if not 0 <= number < 2**31:
        text = str(number) if abs(number) < 10**20 else "a number of more than 20 digits"
        raise ValueError(f"{name} is {text}: no such number is possible")
    return number


def order_text(order: Any) -> str:
    """Return na, nb, nc, nkb, nkc as text."""
    if isinstance(order, str):
        return order
    return ",".join(str(_plain(number)) for number in order)


def order_numbers(order: Any) -> list[int]:
    """Return na, nb, nc, nkb, nkc."""
    try:
        numbers = [whole("a number of an order", number) for number in order]
    except TypeError:
        numbers = []
    if len(numbers) != 5 or not all(0 <= number <= 32 for number in numbers):
        raise ValueError(f"{order!r:.80}: an order is na, nb, nc, nkb, nkc, whole numbers from 0 to 32")
    return numbers
