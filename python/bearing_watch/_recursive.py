"""The streaming estimator of the firmware on arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Optional, Union

import numpy as np
import numpy.typing as npt

from bearing_watch import _core
from bearing_watch._tables import order_text, vector, whole

_Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Estimates:
    """The estimates that were due, k of them, with p parameters.

    Attributes
    ----------
    samples : ndarray of int, shape (k,)
        Number of samples so far.
    theta : ndarray, shape (k, p)
        Parameters; NaN without an estimate.
    covariance : ndarray, shape (k, p, p)
        Their covariances.
    variance : ndarray, shape (k,)
        Residual variance, in the unit of y squared.
    rows : ndarray of int, shape (k,)
        Equivalent number of rows in the memory.
    reason : list of str
        Why there is no estimate; empty if there is one.
    names : list of str
        Names of the parameters.
    """

    samples: npt.NDArray[np.int64]
    theta: _Array
    covariance: _Array
    variance: _Array
    rows: npt.NDArray[np.int64]
    reason: list[str]
    names: list[str]

    def __len__(self) -> int:
        return len(self.samples)

    @property
    def sd(self) -> _Array:
        """Standard deviations of the parameters, shape (k, p)."""
        return np.sqrt(np.diagonal(self.covariance, axis1=1, axis2=2))


class RecursiveEstimator:
    """Recursive least squares or instrumental variables with fading memory: the code of the firmware.

    Parameters
    ----------
    y, u1, u2 : array_like, shape (n,)
        A reference record, as of :func:`identify`: it gives the scales and the nominal model, and is not part of the
        estimates.
    order : sequence of int or str
        na, nb, nc, nkb, nkc.
    method : {"ls", "instruments"}
        Least squares, or streaming instruments, which noise of the output does not bias.
    forgetting : float
        Weight of a row relative to the next one; 1/(1 − forgetting) rows count.
    every : int
        Samples from one estimate to the next.
    offset : bool
        Also estimate a constant.

    Notes
    -----
    The arithmetic is of single precision. Missing samples are NaN.

    Examples
    --------
    >>> import numpy as np, bearing_watch as bw
    >>> random = np.random.default_rng(1)
    >>> u, e, y = random.normal(size=4000), 0.01 * random.normal(size=4000), np.zeros(4000)
    >>> for k in range(1, 4000):
    ...     y[k] = 0.8 * y[k - 1] + (1.0 if k < 2000 else 2.0) * u[k - 1] + e[k]
    >>> estimator = bw.RecursiveEstimator(y[:2000], u[:2000], order=(1, 1, 0, 1, 1), forgetting=0.99, every=1000)
    >>> found = estimator.step(y, u)
    >>> found.names, found.theta[[1, 3]].round(2).tolist()
    (['a1', 'b1'], [[-0.8, 1.0], [-0.8, 2.0]])
    >>> bool((found.sd < 0.003).all())
    True
    """

    def __init__(
        self,
        y: npt.ArrayLike,
        u1: npt.ArrayLike,
        u2: Optional[npt.ArrayLike] = None,
        *,
        order: Union[Sequence[int], str],
        method: str = "ls",
        forgetting: float = 0.999,
        every: int = 1000,
        offset: bool = False,
    ) -> None:
        reference = {"y": vector("y", y), "u1": vector("u1", u1)}
        if u2 is not None:
            reference["u2"] = vector("u2", u2)
        self._core = _core.RecursiveEstimator(
            reference,
            order_text(order),
            offset=offset,
            method=method,
            forgetting=forgetting,
            every=whole("every", every),
        )
        self.names = self._core.names
        self._has_second = u2 is not None

    def step(self, y: npt.ArrayLike, u1: npt.ArrayLike, u2: Optional[npt.ArrayLike] = None) -> Estimates:
        """Take the next samples, and return the estimates that are due."""
        if self._has_second != (u2 is not None):
            raise TypeError("u2 is given with all samples, or with none")
        first = vector("u1", u1)
        found = self._core.step(vector("y", y), first, first if u2 is None else vector("u2", u2))
        return Estimates(**found, names=self.names)

    def reset(self) -> None:
        """Forget all samples."""
        self._core.reset()
