"""Identification, structure search and validation on arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt

from bearing_watch import _core
from bearing_watch._tables import order_numbers, order_text, vector, warn, whole

_Array = npt.NDArray[np.float64]
_Order = tuple[int, int, int, int, int]
#: y, u1 and perhaps u2, each of shape (n,).
Signals = Sequence[npt.ArrayLike]


@dataclass(frozen=True)
class Estimate:
    r"""A difference model A(q) y = B(q) u1 + C(q) u2 [+ constant] + noise.

    Attributes
    ----------
    order : tuple of int
        na, nb, nc, nkb, nkc.
    offset : bool
        Whether a constant was estimated.
    names : list of str
        Names of the p parameters: a1…, b1…, c1…, offset.
    theta : ndarray, shape (p,)
        Parameters; those of A have the sign of the left side.
    sd : ndarray, shape (p,)
        Their standard deviations.
    covariance : ndarray, shape (p, p)
        Their covariance under the noise that the method assumes.
    variance : float
        Variance of the residuals, in the squared unit of y.
    rows : int
        Number of rows of the regression.
    fit_percent, prediction_fit_percent : float
        Fit of the simulation from the inputs alone, and of the one-step prediction, %.
    residuals : ndarray, shape (rows,)
        One-step prediction errors, in the unit of y.
    simulated : ndarray, shape (n,)
        Output simulated from the inputs alone, in the unit of y.
    white : bool
        Whether the residuals are white, as the standard deviations of most methods presume.
    noise : str
        ``equation``, ``output``, ``autoregressive`` or ``moving_average``.
    noise_polynomial : ndarray
        Its coefficients, including the leading 1; empty for white noise.
    converged, stable : bool
        Whether the iteration converged, and whether every pole is inside or on the unit circle.
    iterations : int
        Number of passes or steps.
    undetermined : list of str
        Names of parameters that the signals hardly determine.
    """

    order: _Order
    offset: bool
    names: list[str]
    theta: _Array
    sd: _Array
    covariance: _Array
    variance: float
    rows: int
    fit_percent: float
    prediction_fit_percent: float
    residuals: _Array
    simulated: _Array
    white: bool
    noise: str
    noise_polynomial: _Array
    converged: bool
    iterations: int
    stable: bool
    undetermined: list[str]

    @property
    def parameters(self) -> dict[str, float]:
        """Parameters by name."""
        return dict(zip(self.names, self.theta.tolist()))


@dataclass(frozen=True)
class StructureSearch:
    """Scores of k structures.

    Attributes
    ----------
    orders : ndarray of int, shape (k, 5)
        na, nb, nc, nkb, nkc.
    parameters : ndarray of int, shape (k,)
        Number of parameters.
    fit_percent : ndarray, shape (k,)
        Mean fit of the simulation over the validation signals, %.
    aic, mdl, variance : ndarray, shape (k,)
        Akaike's criterion, minimum description length, and variance of the residuals on the training signals.
    stable : ndarray of bool, shape (k,)
        Whether the model is stable; the fit of others is that of reflected poles.
    best_fit, best_aic, best_mdl : tuple of int
        The best structures.
    refused : list of tuple
        Structures without an estimate, with the reason.
    """

    orders: npt.NDArray[np.int64]
    parameters: npt.NDArray[np.int64]
    fit_percent: _Array
    aic: _Array
    mdl: _Array
    variance: _Array
    stable: npt.NDArray[np.bool_]
    best_fit: _Order
    best_aic: _Order
    best_mdl: _Order
    refused: list[tuple[_Order, str]]


@dataclass(frozen=True)
class ResidualTest:
    """A test of correlations: how many lags are outside their 99 % bound, and how many may be.

    ``largest`` is the largest correlation in standard deviations, and ``limit`` the largest that passes.
    """

    passed: bool
    tested: int
    outside: int
    allowed: int
    largest: float
    limit: float


@dataclass(frozen=True)
class Correlation:
    """A correlation of the residuals: lags in samples, values, and 99 % bounds, each of shape (lags,)."""

    lags: npt.NDArray[np.int64]
    value: _Array
    bound_99: _Array


@dataclass(frozen=True)
class Roots:
    """Poles or zeros.

    Attributes
    ----------
    at : ndarray of complex, shape (k,)
        Positions in the z-plane.
    covariance : ndarray, shape (k, 2, 2)
        Covariances of real and imaginary part.
    separated : ndarray of bool, shape (k,)
        Whether the 3σ region is clear of those of other roots.
    """

    at: npt.NDArray[np.complex128]
    covariance: _Array
    separated: npt.NDArray[np.bool_]


@dataclass(frozen=True)
class Validation:
    """Residual tests, poles and zeros of an estimate on its own signals.

    A valid model passes ``independence``; ``whiteness`` must hold for least squares too. If ``feedback`` does not
    pass, the output acts on the input, which is no fault of the model. ``removable`` are the indices of poles that a
    zero may cancel for every input.
    """

    estimate: Estimate
    independence: ResidualTest
    whiteness: ResidualTest
    feedback: ResidualTest
    autocorrelation: Correlation
    cross_correlation_u1: Correlation
    cross_correlation_u2: Correlation
    poles: Roots
    zeros_u1: Roots
    zeros_u2: Roots
    removable: list[int]


def _signals(y: npt.ArrayLike, u1: npt.ArrayLike, u2: Optional[npt.ArrayLike]) -> dict[str, _Array]:
    columns = {"y": vector("y", y), "u1": vector("u1", u1)}
    if u2 is not None:
        columns["u2"] = vector("u2", u2)
    return columns


def identify(
    y: npt.ArrayLike,
    u1: npt.ArrayLike,
    u2: Optional[npt.ArrayLike] = None,
    *,
    order: Union[Sequence[int], str],
    method: str = "ls",
    offset: bool = False,
    passes: int = 3,
    noise_order: Optional[int] = None,
    instruments: Optional[npt.ArrayLike] = None,
    robust: bool = False,
) -> Estimate:
    """Estimate a difference model.

    Parameters
    ----------
    y : array_like, shape (n,)
        Output, as a rule the quadrature current, A.
    u1 : array_like, shape (n,)
        First input, as a rule the reference of the velocity, or reference − measured, rad/s.
    u2 : array_like, shape (n,), optional
        Second input, as a rule the load, N·m; without it, an order with nc = 0.
    order : sequence of int or str
        na, nb, nc, nkb, nkc: terms of A, B and C, and the delays of B and C in samples.
    method : {"ls", "iv", "iv-command", "iv4", "sriv", "sm", "oe", "armax"}
        Least squares, instrumental variables (basic, from the command, four-stage, refined), Steiglitz–McBride, output
        error, or ARMAX.
    offset : bool
        Also estimate a constant; recorded signals have operating points.
    passes : int
        Passes of ``iv``, 1 to 3.
    noise_order : int, optional
        Terms of the noise polynomial of ``armax``; na, at least one, if not given.
    instruments : array_like, shape (n,), optional
        The command of the loop, for ``iv-command``.
    robust : bool
        Standard deviations of ``ls`` that allow for coloured residuals.

    Returns
    -------
    Estimate

    Raises
    ------
    BearingWatchError
        If the signals have no finite values of one length, or do not excite the parameters.

    Examples
    --------
    >>> import numpy as np, bearing_watch as bw
    >>> u = np.sign(np.sin(0.3 * np.arange(500)) + 0.2)
    >>> y = np.zeros(500)
    >>> e = 0.01 * np.random.default_rng(1).normal(size=500)
    >>> for k in range(1, 500):
    ...     y[k] = 0.9 * y[k - 1] + 0.5 * u[k - 1] + e[k]
    >>> bw.identify(y, u, order=(1, 1, 0, 1, 1)).theta.round(2).tolist()
    [-0.9, 0.5]
    """
    signals = _signals(y, u1, u2)
    if (instruments is None) == (method == "iv-command"):
        raise ValueError("instruments, the command of the loop, go with method iv-command")
    if instruments is not None:
        signals["instruments"] = vector("instruments", instruments)
    text = order_text(order)
    raw = _core.identify(
        "signals",
        signals,
        text,
        offset=offset,
        method=method,
        passes=whole("passes", passes),
        noise_order=None if noise_order is None else whole("noise_order", noise_order),
        robust=robust,
    )
    found = _estimate(raw)
    warn(_doubts(found, allows_colour=robust or method in ("iv", "iv-command")))
    return found


def _estimate(found: dict[str, Any]) -> Estimate:
    return Estimate(**{**found, "order": tuple(found["order"])})


def _doubts(found: Estimate, allows_colour: bool) -> list[str]:
    messages = []
    if found.undetermined:
        names = ", ".join(found.undetermined)
        messages.append(f"the signals hardly determine {names}; use a richer command than a sine, or fewer terms")
    if not found.stable:
        messages.append("the model is unstable; its fit is that of a simulation with the poles reflected")
    if not found.converged:
        messages.append(
            "the estimate did not converge; it is the last good iterate: try a lower order or another method"
        )
    if not (found.white or allows_colour):
        messages.append(
            "the residuals are coloured: the standard deviations are wrong; use method iv, or a higher order"
        )
    return messages


def _is_several(given: Any) -> bool:
    is_list = isinstance(given, (Sequence, np.ndarray)) and not isinstance(given, (str, bytes))
    return is_list and getattr(given, "ndim", 1) > 0


def _sets(what: str, given: Union[Signals, Sequence[Signals]]) -> list[tuple[str, Any]]:
    every: Any = given
    if not _is_several(every):
        raise TypeError(f"{what} is a tuple of signals y, u1 and perhaps u2, or a list of such tuples")
    sets = [every] if len(every) > 0 and np.ndim(every[0]) == 1 else every
    tables: list[tuple[str, Any]] = []
    for k, own in enumerate(sets):
        if not _is_several(own) or len(own) not in (2, 3):
            raise ValueError(f"{what} {k}: give y, u1 and perhaps u2")
        tables.append((f"{what}_{k}", _signals(own[0], own[1], own[2] if len(own) == 3 else None)))
    return tables


def structure(
    training: Union[Signals, Sequence[Signals]],
    validation: Union[Signals, Sequence[Signals]],
    *,
    max_order: Sequence[int],
    min_order: Sequence[int] = (1, 1, 1, 1, 1),
    method: str = "ls",
    offset: bool = False,
) -> StructureSearch:
    """Try every order between two limits: estimate on one set of signals, and simulate another.

    Parameters
    ----------
    training, validation : tuple of array_like, or list of such tuples
        y, u1 and perhaps u2, each of shape (n,); or several such records.
    max_order, min_order : sequence of int
        Greatest and least na, nb, nc, nkb, nkc; nc = 0 without a second input.
    method : {"ls", "iv4"}
        Estimator.
    offset : bool
        Also estimate a constant.

    Returns
    -------
    StructureSearch
    """
    limits = [order_numbers(order) for order in (max_order, min_order)]
    if limits[0][2] == 0:
        limits[1][2] = 0
    sets = _sets("training", training), _sets("validation", validation)
    found = _core.structure(*sets, *limits, offset=offset, method=method)
    for name in ("best_fit", "best_aic", "best_mdl"):
        found[name] = tuple(found[name])
    found["refused"] = [(tuple(order), reason) for order, reason in found["refused"]]
    return StructureSearch(**found)


def validate(
    y: npt.ArrayLike,
    u1: npt.ArrayLike,
    u2: Optional[npt.ArrayLike] = None,
    *,
    order: Union[Sequence[int], str],
    method: str = "ls",
    offset: bool = False,
    lags: int = 25,
) -> Validation:
    """Estimate a model as :func:`identify`, and test its residuals, poles and zeros.

    Parameters
    ----------
    y, u1, u2, order, method, offset
        As of :func:`identify`.
    lags : int
        Largest lag of the correlations on either side, samples.

    Returns
    -------
    Validation
    """
    signals = _signals(y, u1, u2)
    lags = whole("lags", lags)
    found = _core.validate("signals", signals, order_text(order), offset=offset, method=method, lags=lags)
    return Validation(
        estimate=_estimate(found["estimate"]),
        independence=ResidualTest(**found["independence"]),
        whiteness=ResidualTest(**found["whiteness"]),
        feedback=ResidualTest(**found["feedback"]),
        autocorrelation=Correlation(*found["autocorrelation"]),
        cross_correlation_u1=Correlation(*found["cross_correlation_u1"]),
        cross_correlation_u2=Correlation(*found["cross_correlation_u2"]),
        poles=_roots(*found["poles"]),
        zeros_u1=_roots(*found["zeros_u1"]),
        zeros_u2=_roots(*found["zeros_u2"]),
        removable=found["removable"],
    )


def _roots(at: list[list[float]], covariance: list[Any], separated: list[bool]) -> Roots:
    parts = np.asarray(at, dtype=np.float64).reshape(-1, 2)
    return Roots(
        at=parts[:, 0] + 1j * parts[:, 1],
        covariance=np.asarray(covariance, dtype=np.float64).reshape(-1, 2, 2),
        separated=np.asarray(separated, dtype=np.bool_),
    )
