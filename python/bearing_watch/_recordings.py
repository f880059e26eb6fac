"""Recordings of files: their columns, an audit, and the description of a drive."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from os import PathLike, fspath
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np
import numpy.typing as npt

from bearing_watch import _core
from bearing_watch._options import Audit as AuditOptions
from bearing_watch._tables import Path, drive_and_options, warn

if TYPE_CHECKING:
    from bearing_watch._options import Unpack

_Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Trace:
    """A recording: columns of one length, with their units and the time.

    Attributes
    ----------
    name : str
        Name of the trace, without folder.
    columns : dict of str to ndarray, shape (n,)
        The columns, or formulas of columns.
    units : dict of str to str
        Units of columns, by their names (``speed_rpm``) or by the end of a formula; unknown ones are not there.
    time_s : ndarray, shape (n,), or None
        Time of each row, s.
    """

    name: str
    columns: dict[str, _Array]
    units: dict[str, str]
    time_s: Optional[_Array]

    def __len__(self) -> int:
        return len(next(iter(self.columns.values()), np.empty(0)))

    def __getitem__(self, column: str) -> _Array:
        return self.columns[column]

    @property
    def interval_s(self) -> Optional[float]:
        """Median step of the time, s; None without a time."""
        if self.time_s is None or len(self.time_s) < 2:
            return None
        # A row may lack its time.
        steps = np.diff(self.time_s[np.isfinite(self.time_s)])
        return float(np.median(steps)) if len(steps) else None

    def to_pandas(self) -> Any:
        """Return a pandas.DataFrame; its index is the time, if there is one."""
        return frame(self.columns, self.time_s)


def read(
    path: Path,
    channels: Optional[Sequence[str]] = None,
    *,
    time: Optional[str] = None,
    rate_hz: Optional[float] = None,
    skip: Optional[int] = None,
    units_row: bool = False,
    separator: Optional[str] = None,
    decimal: Optional[str] = None,
) -> Union[Trace, list[Trace]]:
    """Read a trace file of any format that the command line reads.

    Parameters
    ----------
    path : path_like
        The file: .csv, .tsv, .txt (also packed), .mat, .h5, .parquet, .arrow, .npz or .npy.
    channels : sequence of str, optional
        Columns, or formulas of columns such as ``"speed_rpm rad/s"``; all columns of numbers if not given.
    time : str, optional
        Name of the time column, if it has no usual name; ``"none"`` for none.
    rate_hz : float, optional
        Rows a second of a file without time.
    skip, units_row, separator, decimal : optional
        The layout of a text file that is not guessed rightly: lines before its header; whether its first line has names
        and the next one units; the separator (a character, or tab, blank, comma, semicolon, bar); the decimal mark
        ("point" or "comma"; the other one then separates thousands).

    Returns
    -------
    Trace, or list of Trace
        A list if the table has a column ``trace``.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import bearing_watch as bw
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "run.csv"
    >>> _ = file.write_text("t_s,speed_rpm\\n0,60\\n0.1,120\\n0.2,60\\n")
    >>> trace = bw.read(file)
    >>> trace["speed_rpm"].tolist(), trace.units, trace.interval_s
    ([60.0, 120.0, 60.0], {'speed_rpm': 'rpm'}, 0.1)
    >>> bw.read(file, ["speed_rpm rad/s"])["speed_rpm rad/s"].round(3).tolist()
    [6.283, 12.566, 6.283]
    """
    if isinstance(channels, str):
        raise TypeError("channels is a list of names")
    names = None if channels is None else list(channels)
    layout = {"skip": skip, "units_row": units_row or None, "separator": separator, "decimal": decimal}
    found, units, notes = _core.read(path, names, {"time": time, "rate_hz": rate_hz, **layout})
    warn(notes)
    traces = [Trace(name, columns, dict(units), times) for name, times, columns in found]
    return traces[0] if len(traces) == 1 and traces[0].name == os.path.basename(path) else traces


@dataclass(frozen=True)
class Audit:
    """What recordings are worth.

    Attributes
    ----------
    findings : list of tuple
        What was found, and the traces that have it.
    report : dict
        All that ``bearing-watch audit --json`` reports.
    text : str
        What it prints.
    """

    findings: list[tuple[str, list[str]]]
    report: dict[str, Any]
    text: str

    def __str__(self) -> str:
        return self.text

    def _repr_html_(self) -> str:
        return f"<pre>{escape(self.text)}</pre>"


def audit(
    traces: Union[Path, Sequence[Path], None] = None,
    labels: Optional[Path] = None,
    **options: Unpack[AuditOptions],
) -> Audit:
    """Look for what is wrong with recordings: gaps, held and saturated samples, lags, equal traces, and more.

    Parameters
    ----------
    traces : path_like or list of path_like
        A drive file (``.toml``), or files and folders.
    labels : path_like, optional
        A CSV file with the classes of the traces.
    **options
        The options of ``bearing-watch audit``.

    Returns
    -------
    Audit

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import bearing_watch as bw
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "run.csv"
    >>> rows = [f"{0.1 * k},{k % 3}" for k in range(20)] + [f"{9 + 0.1 * k},{k % 3}" for k in range(20)]
    >>> _ = file.write_text("t_s,current_a\\n" + "\\n".join(rows))
    >>> [what for what, _ in bw.audit(file).findings if "gap" in what]
    ['gaps in time, up to 71 steps']
    """
    drive, plain, tables, table = drive_and_options(traces, labels, dict(options))
    if tables is not None or table is not None:
        raise TypeError("audit takes files and folders")
    lines, value, messages = _core.audit(drive, plain)
    warn(messages)
    report: dict[str, Any] = json.loads(value)
    findings = [(own["finding"], own["traces"]) for own in report["findings"]]
    return Audit(findings, report, "\n".join(lines))


def init(
    traces: Union[Path, Sequence[Path]],
    *,
    out: Optional[Path] = None,
    labels: Optional[Path] = None,
    labels_from_names: Optional[Path] = None,
    front_end: Optional[Path] = None,
    force: bool = False,
    time: Optional[str] = None,
    rate_hz: Optional[float] = None,
) -> str:
    """Write a drive file by looking at recordings, as ``bearing-watch init``; return its path.

    Parameters
    ----------
    traces : path_like or list of path_like
        Files and folders.
    out : path_like, optional
        The file; by default ``drive.toml`` in the folder of the first trace.
    labels : path_like, optional
        Labels, if they are not the ``labels.csv`` beside the traces.
    labels_from_names : path_like, optional
        Where labels are written, by the names of the files.
    front_end : path_like, optional
        For counts at the control rate: also write the file of the front end that makes current, velocity and angle of
        them; relative to the folder of the drive file.
    force : bool
        Replace the files if they exist.
    time, rate_hz
        As of :func:`read`.
    """
    if labels is not None and labels_from_names is not None:
        raise TypeError("labels goes without labels_from_names")
    own = {"out": out, "labels": labels, "labels_from_names": labels_from_names, "front_end": front_end}
    plain: dict[str, Any] = {key: fspath(path) for key, path in own.items() if path is not None}
    plain["traces"] = [fspath(path) for path in ([traces] if isinstance(traces, (str, PathLike)) else traces)]
    plain.update(force=force, time=time, rate_hz=rate_hz)
    file, messages = _core.init(plain)
    warn(messages)
    return fspath(file)


def frame(columns: dict[str, Any], index: Optional[_Array] = None) -> Any:
    """Return a DataFrame of columns."""
    try:
        import pandas
    except ImportError as error:
        raise ImportError("to_pandas needs pandas: pip install pandas; to_numpy and Arrow do without it") from error
    return pandas.DataFrame(columns, index=None if index is None else pandas.Index(index, name="time_s"))
