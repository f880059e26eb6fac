"""Arguments of the package as the extension module takes them: arrays, tables, traces, labels."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping, Sequence
from os import PathLike, fspath
from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt

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


def _is_missing(cell: Any) -> bool:
    """Return whether a cell is missing: None, NaN, or NA of pandas, which compares as neither true nor false."""
    return cell is None or type(cell).__name__ in ("NAType", "NaTType") or (isinstance(cell, float) and cell != cell)


def _array(values: Any) -> npt.NDArray[Any]:
    """Return values as an array; numbers of which some are missing or masked are float64, NaN where they are."""
    array = np.asarray(values)
    if isinstance(values, np.ma.MaskedArray) and array.dtype.kind in NUMBERS:
        return np.where(np.ma.getmaskarray(values), np.nan, array.astype(np.float64))
    if array.dtype.kind == "O" and array.ndim == 1:
        missing = [_is_missing(cell) for cell in array]
        numbers = [isinstance(cell, (int, float, np.number)) for cell in array]
        if not all(missing) and all(one or other for one, other in zip(missing, numbers)):
            return np.array([np.nan if gone else cell for gone, cell in zip(missing, array)], dtype=np.float64)
    return array


def vector(name: str, values: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Return values as an array of float64 in one piece of memory; what is missing is NaN."""
    array = _array(values)
    if array.ndim != 1:
        raise ValueError(f"{name} has {array.ndim} dimensions; give one value a sample, shape (n,)")
    if array.dtype.kind not in NUMBERS:
        raise TypeError(f"{name} holds {array.dtype}; give numbers")
    return np.ascontiguousarray(array, dtype=np.float64)


def _cells(values: Any) -> Any:
    """Return a column as an array of float64, a list of texts, or the name of the type of other cells."""
    array = _array(values)
    if array.ndim == 1 and array.dtype.kind in NUMBERS:
        return np.ascontiguousarray(array, dtype=np.float64)
    if array.ndim == 1 and array.dtype.kind in "UTO":
        cells = [None if _is_missing(cell) else cell for cell in array.tolist()]
        if all(cell is None or isinstance(cell, str) for cell in cells):
            return ["" if cell is None else cell for cell in cells]
    return f"{array.dtype} in {array.ndim} dimensions"


def _is_mapping(table: Any) -> bool:
    # pandas offers Arrow only where pyarrow is installed; its columns are arrays anyway.
    return isinstance(table, Mapping) or type(table).__module__.split(".")[0] == "pandas"


def table(given: Table) -> Any:
    """Return a table as a dictionary of columns, or as the object with an Arrow stream that it is."""
    if _is_mapping(given):
        return {str(name): _cells(values) for name, values in given.items()}
    if hasattr(given, "__arrow_c_stream__"):
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
        if any(not (_is_mapping(own) or hasattr(own, "__arrow_c_stream__")) for _, own in tables):
            return None, [("traces", table(given))]
        return None, [(name, table(own)) for name, own in tables]
    if isinstance(given, Sequence) and not hasattr(given, "__arrow_c_stream__"):
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


def order_text(order: Any) -> str:
    """Return na, nb, nc, nkb, nkc as text."""
    if isinstance(order, str):
        return order
    return ",".join(str(_plain(number)) for number in order)
