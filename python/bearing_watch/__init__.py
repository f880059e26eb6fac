"""Bearing-fault detection from the signals that a motor drive already has.

The functions run the Rust library of bearing-watch on arrays and tables:

* :func:`identify`, :func:`structure`, :func:`validate`: linear difference models of recorded signals;
* :class:`RecursiveEstimator`: the parameters of such a model while samples come, with their variances;
* :func:`train`, :func:`evaluate`, :class:`Model`: the models of detectors, equal to those of the command line to the
  last byte;
* :func:`read`, :func:`audit`, :func:`init`: trace files as arrays, what is wrong with them, and a drive file for them;
* :class:`Detector`, :func:`replay`: the detector of the firmware, in single precision with the same bits;
* :func:`simulate`: recordings of the simulated rigs;
* :mod:`bearing_watch.fleet`: features as tables, their sums and the model of a fleet, also on a cluster of Dask;
* :mod:`bearing_watch.sklearn`: the classifier and the novelty gate on matrices of features, as estimators of
  scikit-learn.
"""

from bearing_watch._core import BearingWatchError, __version__
from bearing_watch._detector import Detector, Verdicts, replay
from bearing_watch._model import Evaluation, Model, evaluate, train
from bearing_watch._recordings import Audit, Trace, audit, init, read
from bearing_watch._recursive import Estimates, RecursiveEstimator
from bearing_watch._simulate import Recording, simulate
from bearing_watch._signals import (
    Correlation,
    Estimate,
    ResidualTest,
    Roots,
    StructureSearch,
    Validation,
    identify,
    structure,
    validate,
)
from bearing_watch._tables import BearingWatchWarning

__all__ = [
    "Audit",
    "BearingWatchError",
    "BearingWatchWarning",
    "Correlation",
    "Detector",
    "Estimate",
    "Estimates",
    "Evaluation",
    "Model",
    "Recording",
    "RecursiveEstimator",
    "ResidualTest",
    "Roots",
    "StructureSearch",
    "Trace",
    "Validation",
    "Verdicts",
    "__version__",
    "audit",
    "evaluate",
    "identify",
    "init",
    "read",
    "replay",
    "simulate",
    "structure",
    "train",
    "validate",
]
