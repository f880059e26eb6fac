"""Training for a fleet: features as tables, their sums, and the model, on one machine or on a cluster of Dask.

Each step goes from files to files, as the commands of the same names do::

    traces ─► features ─► part.parquet ─► features_sum ─► .sums ─► train_features ─► model.bwm

Sums are exact: any order and any tree of merges gives the same model, so that a cluster may repeat the work of a worker
that is lost. :func:`sum_on` does that on a `dask.distributed` client whose workers see the same files.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from os import PathLike, fspath
from pathlib import Path as _File
from typing import TYPE_CHECKING, Any, Optional, Union

from bearing_watch import _core
from bearing_watch._tables import Labels, Path, drive_and_options, warn, whole

if TYPE_CHECKING:
    from bearing_watch._options import Features as FeaturesOptions
    from bearing_watch._options import FeaturesSum as FeaturesSumOptions
    from bearing_watch._options import TrainFeatures as TrainFeaturesOptions
    from bearing_watch._options import Unpack

__all__ = ["features", "features_sum", "sum_on", "train_features"]

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


def features_sum(parts: Parts, *, out: Path, **options: Unpack[FeaturesSumOptions]) -> dict[str, Any]:
    """Sum parts and sums of other parts, and write the sums.

    Parameters
    ----------
    parts : path_like or sequence of path_like
        Parts and sums, and folders of them.
    out : path_like
        The sums.
    **options
        The options of the command: ``features=["a", "b"]``, ``train_where=["run<=4"]``, ``keep_units=True``.

    Returns
    -------
    dict
        What ``bearing-watch features-sum --json`` reports.
    """
    return _step("features-sum", None, {**options, "parts": _files(parts), "out": fspath(out)})


def train_features(parts: Parts, *, model: Path, **options: Unpack[TrainFeaturesOptions]) -> dict[str, Any]:
    """Train a model from parts or sums, and write it.

    Parameters
    ----------
    parts : path_like or sequence of path_like
        Parts or sums, or folders of them; keys in the names of folders (``year=2026``) are columns.
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


def sum_on(
    client: Any, parts: Sequence[Path], folder: Path, *, branch: int = 8, **options: Unpack[FeaturesSumOptions]
) -> _File:
    """Sum parts on a cluster, as a tree.

    Each task sums one part, or merges the sums of ``branch`` tasks, and writes its file completely or not at all. The
    task of a lost worker is done again by another one.

    Parameters
    ----------
    client : dask.distributed.Client
        The cluster; its workers see the files under the same names.
    parts : sequence of path_like
        Parts.
    folder : path_like
        Where the sums are written.
    branch : int
        Sums that one task merges, at least 2.
    **options
        The options of :func:`features_sum`.

    Returns
    -------
    pathlib.Path
        The sums of all parts.
    """
    if not hasattr(client, "submit"):
        raise TypeError(f"client is a Client of dask.distributed, not {type(client).__name__}")
    if whole("branch", branch) < 2:
        raise ValueError(f"branch is {branch}; give at least 2")
    if not parts:
        raise ValueError("no part is given")
    folder = _File(folder)
    folder.mkdir(parents=True, exist_ok=True)
    level = [
        client.submit(_leaf, fspath(part), fspath(folder / f"part{k}.sums"), options, pure=False, retries=2)
        for k, part in enumerate(parts)
    ]
    height = 0
    while len(level) > 1:
        height += 1
        groups = [level[k : k + branch] for k in range(0, len(level), branch)]
        keep: FeaturesSumOptions = {"keep_units": True} if options.get("keep_units") else {}
        level = [
            client.submit(_merge, group, fspath(folder / f"merge{height}-{k}.sums"), keep, pure=False, retries=2)
            for k, group in enumerate(groups)
        ]
    return _File(level[0].result())


def _leaf(part: str, out: str, options: FeaturesSumOptions) -> str:
    features_sum(part, out=out, **options)
    return out


def _merge(sums: list[str], out: str, options: FeaturesSumOptions) -> str:
    features_sum(sums, out=out, **options)
    return out


def _step(name: str, drive: Optional[str], options: dict[str, Any]) -> dict[str, Any]:
    report, warnings = _core.fleet(name, drive, options)
    warn(warnings)
    found: dict[str, Any] = json.loads(report)
    return found


def _files(parts: Parts) -> list[str]:
    return [fspath(parts)] if isinstance(parts, (str, PathLike)) else [fspath(part) for part in parts]
