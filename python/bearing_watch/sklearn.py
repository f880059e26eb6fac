"""Estimators in the style of scikit-learn over the training of the workbench.

They take a matrix of features, one row a segment: those of ``bearing-watch features``, of ``Verdicts.features``, or any
others. NaN is a missing value.

:class:`GaussianClassifier` is the discriminant of a model, :class:`NoveltyDetector` its gate. Both need the extra
``bearing-watch[sklearn]``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt
from sklearn.base import BaseEstimator, ClassifierMixin, OutlierMixin
from sklearn.utils.multiclass import check_classification_targets
from sklearn.utils.validation import check_array, check_is_fitted, validate_data

from bearing_watch import _core
from bearing_watch._tables import aligned, array, real

__all__ = ["GaussianClassifier", "NoveltyDetector"]

_Array = npt.NDArray[np.float64]


class _Refitted(BaseEstimator):  # type: ignore[misc]
    """An estimator that is pickled with its training rows: a fit depends on them alone, to the last bit."""

    _core_class: Any

    def _fit_core(self, *arguments: Any) -> None:
        self._arguments = arguments
        self._fitted = self._core_class(*arguments)

    def __getstate__(self) -> dict[str, Any]:
        state: dict[str, Any] = super().__getstate__()
        return {name: own for name, own in state.items() if name != "_fitted"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        super().__setstate__(state)
        if "_arguments" in state:
            self._fitted = self._core_class(*state["_arguments"])

    def __sklearn_tags__(self) -> Any:
        tags = super().__sklearn_tags__()
        tags.input_tags.allow_nan = True
        return tags


def _unmasked(X: Any) -> Any:
    """Return rows with NaN for what is masked; scikit-learn takes the values under the mask."""
    return array(X) if isinstance(X, np.ma.MaskedArray) else X


def _names(estimator: Any) -> list[str]:
    given = getattr(estimator, "feature_names_in_", None)
    return [f"x{k}" for k in range(estimator.n_features_in_)] if given is None else [str(name) for name in given]


class GaussianClassifier(ClassifierMixin, _Refitted):  # type: ignore[misc]
    """Linear or quadratic discriminant on projected features, with priors and costs.

    Parameters
    ----------
    discriminant : {"linear", "quadratic", "shrunk"}
        One covariance for all classes, one for each, or between the two by the best cross-validated log score.
    shrinkage : tuple of float, optional
        Fixed shrinkage instead: towards the shared covariance, and of the correlations, each 0 to 1.
    projection : {"none", "pca", "pca-raw", "fisher"}
        Projection of the features: none (each is scaled), principal components of standardised or of centred features,
        or Fisher's directions.
    components : int, optional
        Components to keep.
    priors : mapping of class to float, or sequence of float, optional
        Prior probability of each class; equal if not given.
    cost : array_like, shape (classes, classes), optional
        ``cost[i][k]`` is the cost of deciding class i if k is true; 1 off the diagonal if not given.

    Attributes
    ----------
    classes_ : ndarray, shape (classes,)
        The classes.
    n_features_in_ : int
        Number of features.
    feature_names_in_ : ndarray of str
        Their names, if the training data had names.
    """

    _core_class = _core.RowClassifier

    def __init__(
        self,
        *,
        discriminant: str = "linear",
        shrinkage: Optional[tuple[float, float]] = None,
        projection: str = "none",
        components: Optional[int] = None,
        priors: Optional[Union[Mapping[Any, float], Sequence[float]]] = None,
        cost: Optional[npt.ArrayLike] = None,
    ) -> None:
        self.discriminant = discriminant
        self.shrinkage = shrinkage
        self.projection = projection
        self.components = components
        self.priors = priors
        self.cost = cost

    def fit(self, X: npt.ArrayLike, y: npt.ArrayLike) -> GaussianClassifier:
        """Fit to features of shape (n, features) and classes of shape (n,)."""
        X = _unmasked(X)
        rows, y = validate_data(self, X, y, dtype=np.float64, ensure_all_finite="allow-nan", ensure_min_samples=2)
        check_classification_targets(y)
        self.classes_, places = np.unique(y, return_inverse=True)
        if len(self.classes_) < 2:
            raise ValueError(f"training needs at least two classes, but there is only 1 class: {self.classes_[0]}")
        count = len(self.classes_)
        priors: list[float] = []
        if isinstance(self.priors, Mapping):
            lacking = [own for own in self.classes_.tolist() if own not in self.priors]
            if lacking:
                raise ValueError(f"priors lack class {lacking[0]!r}; give one for each class")
            priors = [real("a prior", self.priors[own]) for own in self.classes_.tolist()]
        elif self.priors is not None:
            priors = [real("a prior", prior) for prior in self.priors]
        cost = [] if self.cost is None else np.asarray(self.cost, dtype=np.float64).reshape(count, count).tolist()
        shrinkage = None if self.shrinkage is None else [real("shrinkage", part) for part in self.shrinkage]
        self._fit_core(
            rows.copy(),
            places.tolist(),
            [str(own) for own in self.classes_.tolist()],
            _names(self),
            self.discriminant,
            shrinkage,
            self.projection,
            self.components,
            priors,
            cost,
        )
        return self

    def _predicted(self, X: npt.ArrayLike) -> tuple[_Array, npt.NDArray[np.int64]]:
        check_is_fitted(self)
        rows = validate_data(self, _unmasked(X), dtype=np.float64, ensure_all_finite="allow-nan", reset=False)
        found: tuple[_Array, npt.NDArray[np.int64]] = self._fitted.predict(aligned(rows))
        return found

    def predict(self, X: npt.ArrayLike) -> npt.NDArray[Any]:
        """Return the class of least expected cost of each row, shape (n,)."""
        _, decided = self._predicted(X)
        classes: npt.NDArray[Any] = self.classes_[decided]
        return classes

    def predict_log_proba(self, X: npt.ArrayLike) -> _Array:
        """Return the logarithms of the posteriors, shape (n, classes)."""
        return self._predicted(X)[0]

    def predict_proba(self, X: npt.ArrayLike) -> _Array:
        """Return the posteriors, shape (n, classes)."""
        return np.exp(self.predict_log_proba(X))


class NoveltyDetector(OutlierMixin, _Refitted):  # type: ignore[misc]
    """The novelty gate: trained on healthy rows alone, with a set false-alarm rate.

    Parameters
    ----------
    false_alarm : float
        Rate of further healthy rows that are called novel; few rows support no smaller one than the default. With
        ``runs`` in :meth:`fit` it is that of the next run.

    Attributes
    ----------
    limit_ : float
        The surprise from which on a row is novel: −ln of the rate, nats.
    offset_ : float
        Its negative: ``decision_function`` is ``score_samples`` less this.
    n_features_in_ : int
        Number of features.
    """

    _core_class = _core.RowGate

    def __init__(self, *, false_alarm: float = 0.05) -> None:
        self.false_alarm = false_alarm

    def fit(self, X: npt.ArrayLike, y: Any = None, *, runs: Optional[npt.ArrayLike] = None) -> NoveltyDetector:
        """Fit to healthy features.

        Parameters
        ----------
        X : array_like, shape (n, features)
            Healthy rows.
        y : None
            Not used.
        runs : array_like, shape (n,), optional
            Run of each row, in the order of time: rows of one run are more alike than those of different ones.
        """
        rows = validate_data(self, _unmasked(X), dtype=np.float64, ensure_all_finite="allow-nan", ensure_min_samples=2)
        numbers = None
        if runs is not None:
            try:
                own = check_array(runs, ensure_2d=False, dtype=None)
            except ArithmeticError:
                raise TypeError("runs hold numbers that cannot be compared") from None
            if len(own) != len(rows):
                raise ValueError(f"{len(own)} runs for {len(rows)} rows; give one a row")
            _, first, places = np.unique(own, return_index=True, return_inverse=True)
            numbers = first[places].tolist()
        false_alarm = real("false_alarm", self.false_alarm)
        if not 0.0 < false_alarm < 1.0:
            raise ValueError(f"false_alarm={self.false_alarm}: a rate is between 0 and 1")
        self._fit_core(rows.copy(), numbers, _names(self), false_alarm)
        self.limit_ = self._fitted.limit
        self.offset_ = -self.limit_
        return self

    def score_samples(self, X: npt.ArrayLike) -> _Array:
        """Return the negative surprise of each row, shape (n,): ln of the probability of a healthy row as distant."""
        check_is_fitted(self)
        rows = validate_data(self, _unmasked(X), dtype=np.float64, ensure_all_finite="allow-nan", reset=False)
        surprise: _Array = self._fitted.surprise(aligned(rows))
        return -surprise

    def decision_function(self, X: npt.ArrayLike) -> _Array:
        """Return the distance to the gate, shape (n,): negative for novel rows."""
        distance: _Array = self.score_samples(X) - self.offset_
        return distance

    def predict(self, X: npt.ArrayLike) -> npt.NDArray[np.int64]:
        """Return 1 for rows like the healthy ones, −1 for novel rows, shape (n,)."""
        return np.where(self.decision_function(X) <= 0.0, -1, 1)
