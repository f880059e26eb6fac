"""The extension module; its functions take checked arguments. Use the package around it."""

from collections.abc import Mapping, Sequence
from os import PathLike
from typing import Any, Optional, Union, final

import numpy as np
import numpy.typing as npt

_Table = Union[Mapping[str, Any], Any]
_Tables = list[tuple[str, _Table]]
_Path = Union[str, PathLike[str]]
_Reported = tuple[list[str], str, list[str]]

__all__ = [
    "BearingWatchError",
    "Detector",
    "Model",
    "RecursiveEstimator",
    "RowClassifier",
    "RowGate",
    "__version__",
    "arrow_stream",
    "audit",
    "fleet",
    "identify",
    "init",
    "is_time",
    "read",
    "settings",
    "simulate",
    "structure",
    "train",
    "validate",
]

__version__: str

class BearingWatchError(ValueError): ...

def arrow_stream(columns: dict[str, Any]) -> object: ...
def fleet(step: str, drive: Optional[_Path], options: dict[str, Any]) -> tuple[str, list[str]]: ...
def identify(
    name: str,
    signals: _Table,
    order: str,
    *,
    offset: bool,
    method: str,
    passes: int,
    noise_order: Optional[int],
    robust: bool,
) -> dict[str, Any]: ...
def structure(
    training: _Tables,
    validation: _Tables,
    max_order: Sequence[int],
    min_order: Sequence[int],
    *,
    offset: bool,
    method: str,
) -> dict[str, Any]: ...
def validate(name: str, signals: _Table, order: str, *, offset: bool, method: str, lags: int) -> dict[str, Any]: ...
def train(
    drive: Optional[_Path], options: dict[str, Any], traces: Optional[_Tables], labels: Optional[_Table]
) -> tuple[Model, list[str]]: ...
def read(
    file: _Path, channels: Optional[Sequence[str]], options: dict[str, Any]
) -> tuple[
    list[tuple[str, Optional[npt.NDArray[np.float64]], dict[str, npt.NDArray[np.float64]]]],
    list[tuple[str, str]],
    list[str],
]: ...
def audit(drive: Optional[_Path], options: dict[str, Any]) -> _Reported: ...
def init(options: dict[str, Any]) -> tuple[PathLike[str], list[str]]: ...
def is_time(name: str) -> bool: ...
def settings(job: str, options: dict[str, Any]) -> str: ...
def simulate(options: dict[str, Any]) -> list[tuple[str, str, dict[str, npt.NDArray[np.float64]]]]: ...

@final
class Model:
    @staticmethod
    def from_bytes(name: _Path, bytes: bytes) -> Model: ...
    def to_bytes(self) -> bytes: ...
    @property
    def classes(self) -> list[str]: ...
    @property
    def healthy(self) -> Optional[str]: ...
    @property
    def features(self) -> list[str]: ...
    @property
    def orders(self) -> list[str]: ...
    @property
    def columns(self) -> list[str]: ...
    @property
    def trained_on(self) -> list[str]: ...
    @property
    def segment_samples(self) -> int: ...
    @property
    def interval_s(self) -> float: ...
    @property
    def is_trained(self) -> bool: ...
    def to_rust(self) -> str: ...
    def to_c(self) -> str: ...
    def report(self, rank: bool) -> _Reported: ...
    def evaluate(
        self,
        drive: Optional[_Path],
        options: dict[str, Any],
        traces: Optional[_Tables],
        labels: Optional[_Table],
    ) -> _Reported: ...

@final
class Detector:
    def __new__(cls, model: Model, run_a_trace: bool) -> Detector: ...
    def run(self, columns: _Table) -> dict[str, Any]: ...
    def replay(
        self, files: Sequence[_Path], tables_in_memory: Optional[_Tables]
    ) -> list[tuple[str, dict[str, Any]]]: ...
    def step(self, columns: _Table) -> dict[str, Any]: ...
    def finish(self) -> dict[str, Any]: ...
    def end_run(self) -> list[tuple[str, float, float]]: ...
    def deny(self) -> bool: ...
    def save(self) -> bytes: ...
    def restore(self, state: bytes) -> None: ...
    def reset(self) -> None: ...

@final
class RecursiveEstimator:
    def __new__(
        cls,
        reference: _Table,
        order: str,
        *,
        offset: bool,
        method: str,
        forgetting: float,
        every: int,
    ) -> RecursiveEstimator: ...
    @property
    def names(self) -> list[str]: ...
    def step(
        self, y: npt.NDArray[np.float64], u1: npt.NDArray[np.float64], u2: npt.NDArray[np.float64]
    ) -> dict[str, Any]: ...
    def reset(self) -> None: ...

@final
class RowClassifier:
    def __new__(
        cls,
        x: npt.NDArray[np.float64],
        classes: Sequence[int],
        class_names: Sequence[str],
        names: Sequence[str],
        discriminant: str,
        shrinkage: Optional[Sequence[float]],
        projection: str,
        components: Optional[int],
        priors: Sequence[float],
        cost: Sequence[Sequence[float]],
    ) -> RowClassifier: ...
    def predict(self, x: npt.NDArray[np.float64]) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]: ...

@final
class RowGate:
    def __new__(
        cls, x: npt.NDArray[np.float64], runs: Optional[Sequence[int]], names: Sequence[str], false_alarm: float
    ) -> RowGate: ...
    @property
    def limit(self) -> float: ...
    def surprise(self, x: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]: ...
