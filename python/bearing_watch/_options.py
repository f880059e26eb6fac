"""The options of the functions as keywords: the settings of a drive file that each takes.

They are those of the command line, which explains them (``bearing-watch train --help``).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike
from typing import TYPE_CHECKING, Literal, TypedDict, Union

if TYPE_CHECKING:
    from typing_extensions import Unpack as Unpack


class _Choice(TypedDict, total=False):
    """Records and features that are chosen."""

    classes: Union[str, Sequence[str]]
    features: Union[str, Sequence[str]]
    covariates: Union[str, Sequence[str]]
    train_where: Union[str, Sequence[str]]
    group: str
    unit: str
    healthy: str


class _Recordings(TypedDict, total=False):
    """Channels of recordings, and how their features are computed."""

    where: Union[str, Sequence[str]]
    time: str
    rate_hz: float
    skip: int
    units_row: bool
    separator: str
    decimal: str
    front_end: Union[str, PathLike[str]]
    y: str
    u1: str
    u2: str
    current: str
    velocity: str
    velocity_ref: str
    angle: str
    load: str
    park: Literal["standard", "thesis"]
    bearing: Union[str, Sequence[float], float]
    orders: Union[str, Sequence[str], Mapping[str, float]]
    harmonics: Union[str, Sequence[float], float]
    slip: float
    order: Union[str, Sequence[int]]
    offset: bool
    method: Literal["ls", "instruments"]
    nominal: str
    segment: int
    block_mean: int
    decimate: int
    memory: float
    handover: int
    saturation: Union[str, Sequence[float], float]
    stuck: int
    velocity_from: Literal["best", "channel", "angle"]
    current_delay: float
    balance_cutoff_hz: float
    gear_ratio: float


class _Classifier(_Choice, total=False):
    """What decides, and how it is trained."""

    rising: Union[str, Sequence[str]]
    identify: bool
    projection: Literal["none", "pca", "pca-raw", "fisher"]
    components: int
    variance: float
    discriminant: Literal["linear", "quadratic", "shrunk"]
    shrinkage: Union[str, Sequence[float], float]
    size_spread: float
    novelty: Literal["gate", "none"]
    false_alarm: float
    reject_cost: float
    alarm_interval_h: float
    alarm_interval_segments: float
    segments_a_run: int
    other_drive: bool
    acceptable: float
    priors: Union[str, Sequence[str], Mapping[str, float]]
    cost: Union[str, Sequence[str], Mapping[str, float]]


class Train(_Recordings, _Classifier, total=False):
    """Options of :func:`bearing_watch.train`."""

    test_where: Union[str, Sequence[str]]
    folds: int
    fold_seed: int


class Evaluate(TypedDict, total=False):
    """Options of :func:`bearing_watch.evaluate`."""

    where: Union[str, Sequence[str]]
    classes: Union[str, Sequence[str]]
    test_where: Union[str, Sequence[str]]
    group: str
    unit: str
    by: Union[str, Sequence[str]]
    controls: Union[str, Sequence[str]]
    control_classes: Union[str, Sequence[str]]
    per_segment: bool


class Features(_Recordings, _Choice, total=False):
    """Options of :func:`bearing_watch.fleet.features`."""

    plan: Union[str, PathLike[str]]
    plan_traces: int


class TrainFeatures(_Classifier, total=False):
    """Options of :func:`bearing_watch.fleet.train_features`."""

    one_pass: bool
    rust: Union[str, PathLike[str]]
    c: Union[str, PathLike[str]]


class Audit(TypedDict, total=False):
    """Options of :func:`bearing_watch.audit`."""

    where: Union[str, Sequence[str]]
    time: str
    rate_hz: float
    skip: int
    units_row: bool
    separator: str
    decimal: str
    current: str
    velocity: str
    velocity_ref: str
    angle: str
    load: str
    healthy: str
    false_alarm: float


class Simulate(TypedDict, total=False):
    """Options of :func:`bearing_watch.simulate`."""

    rig: Literal["dc", "ema"]
    severity: float
    condition: Union[str, Sequence[str]]
    ratio: float
    weight: float
    waveform: str
    angle_bits: int
    race: str
    log_every: int
    mix: bool
