"""Training and evaluation: the functions of the command line, on files, arrays and tables."""

from __future__ import annotations

import json
import os
import tempfile
from dataclasses import dataclass
from os import PathLike, fspath
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np
import numpy.typing as npt

from bearing_watch import _core, _html
from bearing_watch._options import Evaluate as EvaluateOptions
from bearing_watch._options import Train as TrainOptions
from bearing_watch._tables import Labels, Path, Traces, drive_and_options, warn

if TYPE_CHECKING:
    from bearing_watch._options import Unpack


class Model:
    """A trained model of a detector.

    :func:`train` makes it, :meth:`load` reads it from a file. The file is that of the command line.

    Attributes
    ----------
    classes : list of str
        Names of the classes.
    healthy : str or None
        The healthy class, if the model has one.
    features : list of str
        Names of the features in use.
    orders : list of str
        Names of the tracked bearing orders.
    columns : list of str
        Columns, or formulas of columns, that the detector reads.
    trained_on : list of str
        Ids of the training traces.
    segment_samples : int
        Samples of a segment.
    interval_s : float
        Sampling interval of the detector's input, s; 0 if it is not known.
    """

    def __init__(self, core: _core.Model) -> None:
        self._core = core
        self.classes = core.classes
        self.healthy = core.healthy
        self.features = core.features
        self.orders = core.orders
        self.columns = core.columns
        self.trained_on = core.trained_on
        self.segment_samples = core.segment_samples
        self.interval_s = core.interval_s

    @classmethod
    def load(cls, path: Path) -> Model:
        """Read a model file (``.bwm``).

        Parameters
        ----------
        path : path_like
            The file.
        """
        # A number would be an open file of this process.
        with open(fspath(path), "rb") as file:
            return cls(_core.Model.from_bytes(path, file.read()))

    @classmethod
    def from_bytes(cls, data: bytes) -> Model:
        """Read the bytes of a model file."""
        return cls(_core.Model.from_bytes("model", data))

    def to_bytes(self) -> bytes:
        """Return the bytes of the model file."""
        return self._core.to_bytes()

    def save(self, path: Path) -> None:
        """Write the model file, completely or not at all."""
        _write(path, self.to_bytes())

    def to_rust(self, path: Optional[Path] = None) -> str:
        """Return the model as constants in Rust, and write them to a file if one is given."""
        return _written(path, self._core.to_rust())

    def to_c(self, path: Optional[Path] = None) -> str:
        """Return the model as a C header, and write it to a file if one is given."""
        return _written(path, self._core.to_c())

    def report(self, *, rank: bool = False) -> dict[str, Any]:
        """Return what ``bearing-watch train --json`` reports: held-out or cross-validated error, gate, alarm.

        Parameters
        ----------
        rank : bool
            Also rank the features, which takes longer.
        """
        _, value, _ = self._core.report(rank)
        report: dict[str, Any] = json.loads(value)
        return report

    def summary(self, *, rank: bool = False) -> str:
        """Return the report of the training as text; of a model without the data of its training, what it is."""
        if not self._core.is_trained:
            if rank:
                raise _core.BearingWatchError(
                    "a model that was loaded from a file does not have the data of its training, by which features are "
                    "ranked; use the model that train returned"
                )
            return "\n".join(f"{name}: {text}" for name, text in self._about())
        lines, _, _ = self._core.report(rank)
        return "\n".join(lines)

    def _about(self) -> list[tuple[str, str]]:
        interval = f"{self.interval_s:.6g} s" if self.interval_s > 0 else "not known"
        return [
            ("classes", ", ".join(self.classes)),
            ("healthy class", self.healthy or "none"),
            ("features", ", ".join(self.features)),
            ("bearing orders", ", ".join(self.orders) or "none"),
            ("columns", ", ".join(self.columns)),
            ("segment", f"{self.segment_samples} samples, one every {interval}"),
            ("training", f"{len(self.trained_on)} traces"),
            ("size", f"{len(self.to_bytes())} bytes"),
        ]

    def _repr_html_(self) -> str:
        return _html.table(["model", ""], self._about())

    def __repr__(self) -> str:
        return f"Model(classes={self.classes}, features={self.features})"

    def __eq__(self, other: object) -> bool:
        """Whether it is the same model file; a pickle has the file alone, and not the data of the training."""
        return self.to_bytes() == other.to_bytes() if isinstance(other, Model) else NotImplemented

    def __hash__(self) -> int:
        return hash(self.to_bytes())

    def __reduce__(self) -> tuple[Any, tuple[bytes]]:
        return Model.from_bytes, (self.to_bytes(),)


@dataclass(frozen=True)
class Evaluation:
    """The verdicts of a model on labelled traces.

    Attributes
    ----------
    classes : list of str
        The c classes of the model.
    confusion : ndarray of int, shape (c, c)
        Number of decisions by true class (rows) and decided class.
    undetermined, novel, ambiguous : ndarray of int, shape (c,)
        Number of decisions without a class, by true class.
    error_rate, balanced_accuracy : tuple of float
        Value and ends of the 95 % interval.
    report : dict
        All that ``bearing-watch evaluate --json`` reports.
    text : str
        What it prints.
    """

    classes: list[str]
    confusion: npt.NDArray[np.int64]
    undetermined: npt.NDArray[np.int64]
    novel: npt.NDArray[np.int64]
    ambiguous: npt.NDArray[np.int64]
    error_rate: tuple[float, float, float]
    balanced_accuracy: tuple[float, float, float]
    report: dict[str, Any]
    text: str

    def __str__(self) -> str:
        return self.text

    def _repr_html_(self) -> str:
        rows = [
            (name, *(int(n) for n in self.confusion[k]), int(self.novel[k]), int(self.ambiguous[k]),
             int(self.undetermined[k]))
            for k, name in enumerate(self.classes[: len(self.confusion)])
        ]
        value, low, high = self.error_rate
        head = ["true class", *self.classes[: self.confusion.shape[-1]], "novel", "ambiguous", "undetermined"]
        return _html.table(head, rows, f"error rate {100 * value:.1f} % [{100 * low:.1f}, {100 * high:.1f}]")


def train(
    traces: Optional[Traces] = None, labels: Optional[Labels] = None, **options: Unpack[TrainOptions]
) -> Model:
    """Train a model from labelled traces; the result is that of ``bearing-watch train``, byte for byte.

    Parameters
    ----------
    traces : path_like, list of path_like, mapping, or table
        A drive file (``.toml``); files and folders in any format that the command line reads; a mapping of trace ids to
        tables; or one table with a column ``trace``. A table is a mapping of arrays of shape (n,), or a table of
        pandas, polars or pyarrow.
    labels : path_like, mapping, or table
        A CSV file; a mapping of trace ids to class names; or a table with the columns ``trace``, ``class_name`` and any
        others for ``train_where``, ``test_where`` and ``group``. May be in the drive file.
    **options
        The options of ``bearing-watch train`` with underscores, which are the keys of a drive file: ``y``, ``u1``,
        ``u2`` (columns or formulas of columns), ``order=(2, 1, 2, 1, 1)``, ``healthy="healthy"``,
        ``features=["a", "b"]``, ``priors={"healthy": 0.98, "spall": 0.02}`` and so on. They go before those in the
        drive file.

    Returns
    -------
    Model

    Raises
    ------
    BearingWatchError, OSError
        With the text of the command line.

    Examples
    --------
    >>> import warnings
    >>> import bearing_watch as bw
    >>> warnings.simplefilter("ignore", bw.BearingWatchWarning)
    >>> bench = bw.simulate(["healthy", "spall"], count=8, seed=1)
    >>> channels = {"y": "current_a", "u1": "velocity_ref_rad_s", "u2": "load_torque_nm"}
    >>> model = bw.train(bench.traces, bench.labels, order=(2, 1, 2, 1, 1), **channels)
    >>> model
    Model(classes=['healthy', 'spall'], features=['a1', 'a2', 'b1', 'c1', 'c2'])
    >>> others = bw.simulate(["healthy", "spall"], count=4, seed=2)
    >>> bw.evaluate(model, others.traces, others.labels).confusion.tolist()
    [[4, 0], [0, 4]]
    """
    model, messages = _core.train(*drive_and_options(traces, labels, dict(options)))
    warn(messages)
    return Model(model)


def evaluate(
    model: Union[Model, Path],
    traces: Optional[Traces] = None,
    labels: Optional[Labels] = None,
    **options: Unpack[EvaluateOptions],
) -> Evaluation:
    """Classify labelled traces by the detector of the firmware, and count.

    Parameters
    ----------
    model : Model or path_like
        The model, or its file.
    traces, labels
        As of :func:`train`.
    **options
        The options of ``bearing-watch evaluate``: ``test_where``, ``where``, ``classes``, ``per_segment=True``,
        ``group``.

    Returns
    -------
    Evaluation
    """
    own = model if isinstance(model, Model) else Model.load(model)
    lines, value, messages = own._core.evaluate(*drive_and_options(traces, labels, dict(options)))
    warn(messages)
    report: dict[str, Any] = json.loads(value)

    def rate(name: str) -> tuple[float, float, float]:
        value, low, high = (report[name][key] for key in ("value", "low", "high"))
        return tuple(float("nan") if x is None else x for x in (value, low, high))  # type: ignore[return-value]

    counts = {name: np.asarray(report[name], dtype=np.int64) for name in ("undetermined", "novel", "ambiguous")}
    return Evaluation(
        classes=report["classes"],
        confusion=np.asarray(report["confusion"], dtype=np.int64),
        error_rate=rate("error_rate"),
        balanced_accuracy=rate("balanced_accuracy"),
        report=report,
        text="\n".join(lines),
        **counts,
    )


def _written(path: Optional[Union[str, PathLike[str]]], text: str) -> str:
    if path is not None:
        _write(path, text.encode())
    return text


def _write(path: Path, data: bytes) -> None:
    """Write a file completely or not at all."""
    folder = os.path.dirname(fspath(path)) or "."
    descriptor, temporary = tempfile.mkstemp(dir=folder, prefix=".bearing-watch")
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(data)
        os.chmod(temporary, 0o644)
        os.replace(temporary, path)
    except BaseException:
        os.unlink(temporary)
        raise
