"""Rovers from YAML files: the presets that ship with the package, and the user's own."""

from __future__ import annotations

import functools
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

from ..core import SettingError, build, read_yaml, suggest
from ._model import DEGREE, Drive, Rover

_SUFFIXES = (".yaml", ".yml")


def presets() -> list[str]:
    """Names of the rovers that ship with the package, sorted."""
    names = [file.name for file in _folder().iterdir()]
    return sorted(name.removesuffix(".yaml") for name in names if name.endswith(".yaml"))


def read_rover(name_or_path: str | Path) -> Rover:
    """The rover of a preset, or of a YAML file.

    Args:
        name_or_path: A name out of `presets`, or a path that ends in .yaml or .yml.

    Raises:
        FileError: The file cannot be read.
        SettingError: An unknown preset or key (the nearest valid one is named), or a number that
            no rover can have.
    """
    text = str(name_or_path)
    if isinstance(name_or_path, Path) or text.endswith(_SUFFIXES):
        return _from_yaml(Path(name_or_path), source=text)
    if text not in presets():
        raise SettingError(
            f"there is no rover preset {text!r}; {suggest(text, presets())} "
            "A path that ends in .yaml reads your own rover."
        )
    with resources.as_file(_folder() / f"{text}.yaml") as path:
        return _from_yaml(path, source=f"preset {text}")


def _folder() -> Traversable:
    return resources.files("rovernav.rover") / "presets"


def _from_yaml(path: Path, *, source: str) -> Rover:
    settings = build(_model(), read_yaml(path, what="rover file"), source=source).model_dump()
    try:
        return Rover(**dict(_in_si(key, item) for key, item in settings.items()))
    except SettingError as error:
        raise SettingError(f"{source}: {error}") from None


def _in_si(key: str, item: Any) -> tuple[str, Any]:
    """A key without the unit that ends it, and its number in SI units."""
    for suffix, factor in _UNITS:
        if key.endswith(suffix):
            return key.removesuffix(suffix), item * factor
    return key, item


_UNITS = (("_deg_s", DEGREE), ("_m_s", 1.0), ("_deg", DEGREE), ("_m", 1.0))
"""How keys end, and what turns that unit into SI; longer ends first."""


@functools.cache
def _model() -> Any:
    from pydantic import BaseModel, ConfigDict

    class RoverFile(BaseModel):
        """The keys of a rover file; units stand in their names. Ranges are the Rover's own."""

        model_config = ConfigDict(extra="forbid", allow_inf_nan=False, strict=True)
        name: str
        source: str
        drive: Drive
        length_m: float
        width_m: float
        wheel_radius_m: float
        clearance_m: float
        max_slope_deg: float
        max_step_m: float
        speed_m_s: float
        turn_rate_deg_s: float = 0.0
        track_m: float = 0.0
        step_m: float = 0.0
        footing_m: float = 0.0

    RoverFile.model_rebuild(_types_namespace={"Drive": Drive})
    return RoverFile
