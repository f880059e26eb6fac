"""Training for a fleet: features as tables, and the model, on one machine or on a cluster of Dask.

Each step goes from files to files, as the commands of the same names do::

    traces ─► features ─► part.parquet ─► train_features ─► model.bwm

The model is the same, however the traces are split into parts, and a part is written completely or not at all, so that
a cluster may repeat the work of a worker that is lost: :func:`features` is a task for a `dask.distributed` client whose
workers see the same files.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from os import PathLike, fspath
from typing import TYPE_CHECKING, Any, Optional, Union

from bearing_watch import _core
from bearing_watch._tables import Labels, Path, drive_and_options, warn

if TYPE_CHECKING:
    from bearing_watch._options import Features as FeaturesOptions
    from bearing_watch._options import TrainFeatures as TrainFeaturesOptions
    from bearing_watch._options import Unpack

__all__ = ["features", "train_features"]

#: One file, or several.
Parts = Union[Path, Sequence[Path]]


def features(
    traces: Path, labels: Optional[Labels] = None, *, out: Path, **options: Unpack[FeaturesOptions]
) -> dict[str, Any]:
    """Compute the features of traces and write them as a part, one row a segment.

    Parameters
    ----------
    traces : path_like
        A folder of traces, or a drive file (``.toml``).
    labels : path_like, optional
        The labels; by default those of the drive file.
    out : path_like
        The part, a Parquet file. Its plan is also written beside it, as ``NAME.plan.json``, by which the part stays one
        if another program writes it again without its metadata.
    **options
        The options of the command: ``unit="drive"``, ``plan="a.plan.json"`` …

    Returns
    -------
    dict
        What ``bearing-watch features --json`` reports.
    """
    drive, plain, _, _ = drive_and_options(traces, labels, dict(options))
    return _step("features", drive, {**plain, "out": fspath(out)})


def train_features(parts: Parts, *, model: Path, **options: Unpack[TrainFeaturesOptions]) -> dict[str, Any]:
    """Train a model from parts, and write it.

    Parameters
    ----------
    parts : path_like or sequence of path_like
        Parts, or folders of them; keys in the names of folders (``year=2026``) are columns.
    model : path_like
        The model file; :meth:`bearing_watch.Model.load` reads it.
    **options
        The options of the command: ``features=["a", "b"]``, ``unit="drive"``, ``false_alarm=0.01`` …

    Returns
    -------
    dict
        What ``bearing-watch train-features --json`` reports, with the ``fingerprint`` of the model.
    """
    return _step("train-features", None, {**options, "parts": _files(parts), "model": fspath(model)})


def _step(name: str, drive: Optional[str], options: dict[str, Any]) -> dict[str, Any]:
    report, warnings = _core.fleet(name, drive, options)
    warn(warnings)
    found: dict[str, Any] = json.loads(report)
    return found


def _files(parts: Parts) -> list[str]:
    return [fspath(parts)] if isinstance(parts, (str, PathLike)) else [fspath(part) for part in parts]
