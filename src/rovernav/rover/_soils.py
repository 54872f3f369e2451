"""Soils from YAML files: how much wheels slip on them, and how well that is known."""

from __future__ import annotations

import functools
import math
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

import numpy as np

from ..core import F64, SettingError, build, read_yaml, suggest, value

_SUFFIXES = (".yaml", ".yml")


@value
class Soil:
    """A soil: curves over the slope angle, straight between their points.

    Attributes:
        name: Short name.
        source: Where each number comes from; what is not published is called an assumption.
        rolling_resistance: Force to roll on level ground as a share of the weight.
        slope: Angles (k,), rising from 0 [rad].
        slip: Share of the wheels' way that is lost driving straight uphill (k,), 0 to 1.
        slip_low: The least that is likely (k,).
        slip_high: The most that is likely (k,).
        side_slip: Way downhill for each metre of the wheels' way, driving across the slope (k,).
        measured_up: Steepest climb that slip was measured on [rad].
        measured_down: Steepest descent [rad].
        measured_side: Steepest side slope [rad].
        sinkage: Depth to which wheels dig in for each unit of slip, in wheel diameters.
    """

    name: str
    source: str
    rolling_resistance: float
    slope: F64
    slip: F64
    slip_low: F64
    slip_high: F64
    side_slip: F64
    measured_up: float
    measured_down: float
    measured_side: float
    sinkage: float

    def _check(self) -> None:
        curves = (self.slip, self.slip_low, self.slip_high, self.side_slip)
        if self.slope.ndim != 1 or {c.shape for c in curves} != {self.slope.shape}:
            raise SettingError(f"soil {self.name}: all curves need as many points as slope_deg")
        if len(self.slope) < 2 or self.slope[0] != 0.0 or (np.diff(self.slope) <= 0.0).any():
            raise SettingError(f"soil {self.name}: slope_deg must begin with 0 and rise")
        if self.slope[-1] >= math.pi / 2.0:
            raise SettingError(f"soil {self.name}: slope_deg must stay below 90")
        for curve in curves:
            if not ((curve >= 0.0) & (curve <= 1.0)).all() or (np.diff(curve) < 0.0).any():
                raise SettingError(f"soil {self.name}: slip must rise with the slope, from 0 to 1")
        if (self.slip_low > self.slip).any() or (self.slip_high < self.slip).any():
            raise SettingError(f"soil {self.name}: slip must lie between slip_low and slip_high")
        if not 0.0 <= self.rolling_resistance <= 2.0 or not 0.0 <= self.sinkage <= 1.0:
            raise SettingError(
                f"soil {self.name}: rolling_resistance must lie in 0 to 2, sinkage in 0 to 1"
            )

    def depth(self, slip: Any, wheel_radius: float) -> Any:
        """How deep wheels dig in at a slip [m]; one measured point and a straight line to it."""
        return self.sinkage * np.clip(slip, 0.0, 1.0) * 2.0 * wheel_radius


def soils() -> list[str]:
    """Names of the soils that ship with the package, sorted."""
    names = [file.name for file in _folder().iterdir()]
    return sorted(name.removesuffix(".yaml") for name in names if name.endswith(".yaml"))


def read_soil(name_or_path: str | Path) -> Soil:
    """The soil of a name out of `soils`, or of a YAML file.

    Raises:
        FileError: The file cannot be read.
        SettingError: An unknown soil or key (the nearest valid one is named), or numbers that no
            soil can have.
    """
    text = str(name_or_path)
    if isinstance(name_or_path, Path) or text.endswith(_SUFFIXES):
        return _from_yaml(Path(name_or_path), source=text)
    if text not in soils():
        raise SettingError(
            f"there is no soil {text!r}; {suggest(text, soils())} "
            "A path that ends in .yaml reads your own soil."
        )
    with resources.as_file(_folder() / f"{text}.yaml") as path:
        # Tests have checked its keys; the model that checks any file takes a tenth of a second.
        return _soil({"sinkage": 0.0, **read_yaml(path, what="soil file")}, f"soil {text}")


def _folder() -> Traversable:
    return resources.files("rovernav.rover") / "soils"


def _from_yaml(path: Path, *, source: str) -> Soil:
    read = build(_model(), read_yaml(path, what="soil file"), source=source)
    return _soil(read.model_dump(), source)


def _soil(data: dict[str, Any], source: str) -> Soil:
    settings: dict[str, Any] = {}
    for key, item in data.items():
        angle = key.endswith("_deg")
        name = key.removesuffix("_deg").removesuffix("_to")
        plain = np.array(item, dtype=np.float64) if isinstance(item, list) else item
        settings[name] = np.radians(plain) if angle else plain
    try:
        return Soil(**settings)
    except SettingError as error:
        raise SettingError(f"{source}: {error}") from None


@functools.cache
def _model() -> Any:
    from pydantic import BaseModel, ConfigDict

    class SoilFile(BaseModel):
        """The keys of a soil file; units stand in their names."""

        model_config = ConfigDict(extra="forbid", allow_inf_nan=False, strict=True)
        name: str
        source: str
        rolling_resistance: float
        slope_deg: list[float]
        slip: list[float]
        slip_low: list[float]
        slip_high: list[float]
        side_slip: list[float]
        measured_up_to_deg: float
        measured_down_to_deg: float
        measured_side_deg: float
        sinkage: float = 0.0

    return SoilFile
