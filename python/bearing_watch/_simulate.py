"""Recordings of the simulated rigs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple, Union

import numpy as np
import numpy.typing as npt

from bearing_watch import _core
from bearing_watch._options import Simulate as SimulateOptions

if TYPE_CHECKING:
    from bearing_watch._options import Unpack


class Recording(NamedTuple):
    """Simulated recordings: ``traces`` are columns by trace id, ``labels`` are class names by trace id."""

    traces: dict[str, dict[str, npt.NDArray[np.float64]]]
    labels: dict[str, str]


def simulate(
    classes: Union[str, Sequence[str]] = ("healthy", "spall", "roughness"),
    *,
    count: int = 20,
    seed: int = 1,
    **options: Unpack[SimulateOptions],
) -> Recording:
    """Simulate traces of a rig; they are those of ``bearing-watch simulate``, number for number.

    Parameters
    ----------
    classes : str or sequence of str
        Class of each trace: the defect, or ``healthy``.
    count : int
        Traces of each class.
    seed : int
        Sets of different seeds never share a trace.
    **options
        The options of the command: ``rig="ema"``, ``severity=0.5``, ``condition="mix"``, ``condition=["gravity", "cycle"]``, ``waveform="square"`` …

    Returns
    -------
    Recording
        Columns of the DC rig: ``t_s``, ``velocity_ref_rad_s``, ``velocity_rad_s``, ``current_a``, ``load_torque_nm``,
        ``angle_rad``, ``voltage_v``, each of shape (n,).

    Examples
    --------
    >>> import bearing_watch as bw
    >>> bench = bw.simulate("spall", count=1, seed=1, severity=0.5)
    >>> {name: own["current_a"].shape for name, own in bench.traces.items()}
    {'spall_0.5_1_000': (5000,)}
    """
    names = [classes] if isinstance(classes, str) else list(classes)
    found = _core.simulate({"class": names, "count": count, "seed": seed, **options})
    return Recording({name: own for name, _, own in found}, {name: label for name, label, _ in found})
