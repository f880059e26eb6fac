"""The detector of the firmware on arrays."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt

from bearing_watch import _core, _html
from bearing_watch._model import Model
from bearing_watch._recordings import frame
from bearing_watch._tables import Path, Table, Traces, table, traces

#: Rows of verdicts that a notebook shows.
_SHOWN = 20

_Single = npt.NDArray[np.float32]
_Count = npt.NDArray[np.int64]
_Text = npt.NDArray[np.str_]


@dataclass(frozen=True)
class Verdicts:
    """What the detector reports on s segments: the numbers of ``bearing-watch replay``, to the last bit.

    Attributes
    ----------
    start, length : ndarray of int, shape (s,)
        First sample of the segment in its trace, and number of samples.
    verdict : ndarray of str, shape (s,)
        Name of the class, ``novel``, ``ambiguous`` or ``undetermined``.
    undetermined : ndarray of str, shape (s,)
        Why there is no verdict; empty if there is one.
    posterior, log_likelihood : ndarray of float32, shape (s, classes)
        Of each class; NaN without a verdict.
    distance : ndarray of float32, shape (s,)
        Distance from the healthy class in its standard deviations; NaN without a verdict.
    surprise : ndarray of float32, shape (s,)
        −ln of the probability that a healthy segment is as distant, nats; NaN without a verdict.
    score : ndarray of float32, shape (s,)
        Evidence so far, nats.
    alarm : ndarray of bool, shape (s,)
        Whether the alarm was raised by then.
    cause : ndarray of str, shape (s,)
        The class that it names, or ``unknown``.
    direction : ndarray of str, shape (s,)
        The feature that raised the alarm, or has risen most, in a model whose alarm watches runs.
    size, growth : ndarray of float32, shape (s, 3)
        By how many standard deviations of usual runs this feature exceeds what is usual for the drive, and its change
        in an hour of segments, each with the ends of its 90 % interval; NaN in other models.
    hours_left : ndarray of float32, shape (s, 3)
        Hours of segments until a single segment shows the defect, if the growth goes on so, with the ends of its 90 %
        interval; NaN where nothing grows.
    features : ndarray of float64, shape (s, features)
        The features of the model; NaN for missing ones.
    parameters : ndarray of float32, shape (s, p)
        Parameters of the difference model; NaN without an estimate.
    variance : ndarray of float32, shape (s,)
        Variance of its residuals.
    prominence, amplitude, slip : ndarray of float32, shape (s, orders)
        Of each bearing order: strength relative to the noise, amplitude in A, relative slip of the cage.
    friction : ndarray of float32, shape (s, 8) or (s, 0)
        J/Kt (A·s²/rad), B/Kt (A·s/rad), Tc/Kt (A), 1/Kt (A/(N·m)), offset (A), load friction (A/(N·m)), Stribeck
        friction (A), drag (A); NaN for what was not estimated.
    rows, rejected, saturated : ndarray of int, shape (s,)
        Rows of the regression, and samples that were not used.
    lacking : ndarray of str, shape (s,)
        Names of missing features, and of covariates out of range.
    class_names, feature_names, parameter_names, order_names : list of str
        Names of the columns of the arrays.
    """

    start: _Count
    length: _Count
    verdict: _Text
    undetermined: _Text
    posterior: _Single
    log_likelihood: _Single
    distance: _Single
    surprise: _Single
    score: _Single
    alarm: npt.NDArray[np.bool_]
    cause: _Text
    direction: _Text
    size: _Single
    growth: _Single
    hours_left: _Single
    features: npt.NDArray[np.float64]
    parameters: _Single
    variance: _Single
    prominence: _Single
    amplitude: _Single
    slip: _Single
    friction: _Single
    rows: _Count
    rejected: _Count
    saturated: _Count
    lacking: _Text
    class_names: list[str]
    feature_names: list[str]
    parameter_names: list[str]
    order_names: list[str]

    def __len__(self) -> int:
        return len(self.start)

    def to_numpy(self) -> npt.NDArray[np.void]:
        """Return a structured array of shape (s,); a field is one of the arrays above."""
        arrays = {own.name: getattr(self, own.name) for own in fields(self) if not own.name.endswith("_names")}
        kinds = [(name, array.dtype, array.shape[1:]) for name, array in arrays.items()]
        structured = np.empty(len(self), dtype=kinds)
        for name, array in arrays.items():
            structured[name] = array
        return structured

    def __array__(self, dtype: Any = None, copy: Optional[bool] = None) -> npt.NDArray[Any]:
        array = self.to_numpy()
        return array if dtype is None else array.astype(dtype)

    def columns(self) -> dict[str, npt.NDArray[Any]]:
        """Return columns of shape (s,), one for each class, feature, parameter and order."""
        names = {
            "posterior": ("p", self.class_names),
            "features": ("feature", self.feature_names),
            "parameters": ("parameter", self.parameter_names),
            "prominence": ("prominence", self.order_names),
            "amplitude": ("amplitude", self.order_names),
            "slip": ("slip", self.order_names),
        }
        columns = {}
        for own in fields(self):
            array = getattr(self, own.name)
            if own.name in names:
                prefix, each = names[own.name]
                columns.update({f"{prefix}_{name}": array[:, k] for k, name in enumerate(each)})
            elif isinstance(array, np.ndarray) and array.ndim == 1:
                columns[own.name] = array
        return columns

    def to_pandas(self) -> Any:
        """Return :meth:`columns` as a pandas.DataFrame, one row a segment; needs pandas."""
        return frame(self.columns())

    def _repr_html_(self) -> str:
        head = ["segment", "start", "length", "verdict", *(f"p {name}" for name in self.class_names), "score", "alarm"]
        probabilities = self.posterior.astype(float).tolist()
        rows = [
            (k, int(self.start[k]), int(self.length[k]), self.verdict[k], *probabilities[k], float(self.score[k]),
             self.cause[k] if self.alarm[k] else "")
            for k in range(min(len(self), _SHOWN))
        ]
        alarms = int(self.alarm.sum())
        return _html.table(head, rows, f"{len(self)} segments, {len(rows)} shown; alarm after {alarms} of them")

    def __arrow_c_stream__(self, requested_schema: object = None) -> object:
        """Return :meth:`columns` as an Arrow stream, for pyarrow, polars and others."""
        columns = {
            name: array.tolist() if array.dtype.kind == "U" else np.ascontiguousarray(array)
            for name, array in self.columns().items()
        }
        return _core.arrow_stream(columns)


class Detector:
    """The detector of a model: the code and the bits of the firmware, in single precision.

    Parameters
    ----------
    model : Model or path_like
        The model, or its file.
    run_a_trace : bool
        Each trace is a run, from power-up to power-up: its segments depend on each other, and the alarm averages their
        evidence.

    Notes
    -----
    The samples go in by the names of the recorded columns that the model reads (``Model.columns`` has them, or formulas
    of them). Evidence for the alarm goes on from trace to trace, until :meth:`reset`. Times, as a column or as the index
    of a frame, are compared with the rate of the model. A pickle of a detector has its evidence and alarm, but no
    samples: of an open trace, it is refused.

    Examples
    --------
    >>> import warnings
    >>> import bearing_watch as bw
    >>> warnings.simplefilter("ignore", bw.BearingWatchWarning)
    >>> bench = bw.simulate(["healthy", "spall"], count=8, seed=1)
    >>> channels = {"y": "current_a", "u1": "velocity_ref_rad_s", "u2": "load_torque_nm"}
    >>> model = bw.train(bench.traces, bench.labels, order=(2, 1, 2, 1, 1), segment=2500, **channels)
    >>> detector = bw.Detector(model)
    >>> fresh = bw.simulate("spall", count=1, seed=2).traces["spall_2_000"]
    >>> detector.run(fresh).verdict.tolist()
    ['spall', 'spall']
    >>> pieces = {name: fresh[name][:3000] for name in model.columns}
    >>> len(detector.step(pieces)), len(detector.finish())
    (1, 0)
    """

    def __init__(
        self,
        model: Union[Model, Path],
        *,
        run_a_trace: bool = False,
    ) -> None:
        self.model = model if isinstance(model, Model) else Model.load(model)
        self._options = {"run_a_trace": run_a_trace}
        self._core = _core.Detector(self.model._core, run_a_trace)

    def __getstate__(self) -> dict[str, Any]:
        return {"model": self.model, "options": self._options, "evidence": self._core.save()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        Detector.__init__(self, state["model"], **state["options"])
        self._core.restore(state["evidence"])

    def run(self, trace: Optional[Table] = None, /, **columns: npt.ArrayLike) -> Verdicts:
        """Run a whole trace.

        Parameters
        ----------
        trace : table, optional
            The recorded columns: a mapping of arrays of shape (n,), or a table of pandas, polars or pyarrow.
        **columns : array_like, shape (n,)
            The recorded columns by name instead.

        Returns
        -------
        Verdicts
            Of every segment; a last one of no more than half a segment is left out.
        """
        return self._verdicts(self._core.run(_columns(trace, columns)))

    def step(self, samples: Optional[Table] = None, /, **columns: npt.ArrayLike) -> Verdicts:
        """Take the next samples of a trace, and return the verdicts on the segments that end with them.

        Pieces of any length give the verdicts of :meth:`run` on the whole trace; :meth:`finish` ends the trace.
        """
        return self._verdicts(self._core.step(_columns(samples, columns)))

    def finish(self) -> Verdicts:
        """End a trace whose samples came by :meth:`step`, and return the verdict on its last segment."""
        return self._verdicts(self._core.finish())

    def end_run(self) -> dict[str, tuple[float, float]]:
        """End a run, from power-up to power-up.

        Returns
        -------
        dict of str to tuple of float
            Of each direction that the alarm watches: how far the mean of the run lies above what is usual for this
            drive, in standard deviations of runs, and the score, nats. Empty if the alarm watches none.
        """
        return {name: (deviations, score) for name, deviations, score in self._core.end_run()}

    def deny(self) -> bool:
        """Deny the alarm, because the bearing was inspected and is sound; return whether there was one.

        The evidence starts afresh, and what raised the alarm must be half as large again to raise the next one, for at
        most three alarms.
        """
        return self._core.deny()

    def reset(self) -> None:
        """Forget all samples and all evidence."""
        self._core.reset()

    def _verdicts(self, found: dict[str, Any]) -> Verdicts:
        for name in ("verdict", "undetermined", "cause", "direction", "lacking"):
            found[name] = np.asarray(found[name], dtype=np.str_)
        model = self.model
        return Verdicts(**found, class_names=model.classes, feature_names=model.features, order_names=model.orders)


def replay(
    model: Union[Model, Path],
    recordings: Traces,
    *,
    run_a_trace: bool = False,
) -> dict[str, Verdicts]:
    """Run recordings through the detector one after the other, as a drive would see them.

    Parameters
    ----------
    model : Model or path_like
        The model, or its file.
    recordings : path_like, list of path_like, mapping, or table
        Files and folders; tables by trace id; or one table.
    run_a_trace
        As of :class:`Detector`.

    Returns
    -------
    dict of str to Verdicts
        By the names of the traces, in their order; the evidence goes on from trace to trace. The numbers are those of
        ``bearing-watch replay``.

    Examples
    --------
    >>> import warnings
    >>> import bearing_watch as bw
    >>> warnings.simplefilter("ignore", bw.BearingWatchWarning)
    >>> bench = bw.simulate(["healthy", "spall"], count=8, seed=1)
    >>> channels = {"y": "current_a", "u1": "velocity_ref_rad_s", "u2": "load_torque_nm"}
    >>> model = bw.train(bench.traces, bench.labels, order=(2, 1, 2, 1, 1), **channels)
    >>> found = bw.replay(model, bw.simulate(["healthy", "spall"], count=1, seed=2).traces)
    >>> {name: own.verdict.tolist() for name, own in found.items()}
    {'healthy_2_000': ['healthy'], 'spall_2_000': ['spall']}
    """
    detector = Detector(model, run_a_trace=run_a_trace)
    files, tables = traces(recordings)
    return {name: detector._verdicts(own) for name, own in detector._core.replay(files or [], tables)}


def _columns(given: Optional[Table], columns: dict[str, Any]) -> Any:
    if given is not None and columns:
        raise TypeError("give one table, or columns by name")
    return table(columns if given is None else given)
