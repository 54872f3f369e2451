"""Rovers from YAML files: the presets that ship with the package, and the user's own."""

from __future__ import annotations

import functools
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

from ..core import SettingError, build, read_yaml, suggest
from ._chassis import Chassis, End, Suspension
from ._mobility import Mobility
from ._model import DEGREE, JOINT, STATIC_TILT, Drive, Rover
from ._steering import Kind, Steering

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
        return _rover(_trusted(read_yaml(path, what="rover file")), source=f"preset {text}")


def _folder() -> Traversable:
    return resources.files("rovernav.rover") / "presets"


def _from_yaml(path: Path, *, source: str) -> Rover:
    data = read_yaml(path, what="rover file")
    return _rover(build(_model(), data, source=source).model_dump(), source=source)


def _trusted(data: dict[str, Any]) -> dict[str, Any]:
    """The settings of a file that ships with the package, whose keys tests have checked.

    Making the model that checks any file takes a tenth of a second.
    """
    sections = {name: data.get(name) for name in ("chassis", "mobility", "steering")}
    for name, section in sections.items():
        if section is not None:
            sections[name] = {**_USUAL[name], **section}
    return {**_USUAL["rover"], **data, **sections}


def _rover(settings: dict[str, Any], *, source: str) -> Rover:
    try:
        parts: dict[str, Any] = {
            "chassis": _part(settings.pop("chassis"), _chassis, settings),
            "mobility": _part(settings.pop("mobility"), Mobility),
            "steering": _part(settings.pop("steering"), Steering),
        }
        return Rover(**parts, **dict(_in_si(key, item) for key, item in settings.items()))
    except SettingError as error:
        raise SettingError(f"{source}: {error}") from None


def _part(section: dict[str, Any] | None, make: Any, *more: Any) -> Any:
    """A part of the rover from its section of the file, or None without one."""
    if section is None:
        return None
    return make(*more, **dict(_in_si(key, item) for key, item in section.items()))


def _chassis(rover: dict[str, Any], /, **section: Any) -> Chassis:
    """A chassis; limits that the file leaves out are the rover's slope limit, or usual ones."""
    section["belly_length"], section["belly_width"] = section.pop("belly")
    slope = rover["max_slope_deg"] * DEGREE
    usual = {"max_tilt": slope, "max_pitch": slope, "max_roll": slope}
    usual |= {"static_tilt": max(slope, STATIC_TILT), "max_rocker": JOINT, "max_bogie": JOINT}
    for name, limit in usual.items():
        section[name] = limit if section[name] is None else section[name]
    return Chassis(**section)


def _in_si(key: str, item: Any) -> tuple[str, Any]:
    """A key without the unit that ends it, and its number in SI units."""
    for suffix, factor in _UNITS:
        if key.endswith(suffix):
            name = key.removesuffix(suffix)
            if isinstance(item, list):
                return name, tuple(part * factor for part in item)
            return name, None if item is None else item * factor
    return key, item


_UNITS = (
    *(
        ("_deg_s2", DEGREE),
        ("_deg_s", DEGREE),
        ("_m_s2", 1.0),
        ("_m_s", 1.0),
        ("_deg", DEGREE),
        ("_m", 1.0),
    ),
    *(("_kg", 1.0), ("_w", 1.0), ("_s", 1.0)),
)
"""How keys end, and what turns that unit into SI; longer ends first."""


_USUAL: dict[str, dict[str, Any]] = {
    "rover": {"turn_rate_deg_s": 0.0, "track_m": 0.0, "step_m": 0.0, "footing_m": 0.0},
    "chassis": {
        **{"rocker_m": [0.0, 0.0], "bogie_m": [0.0, 0.0], "bogie_wheels": "rear"},
        **{"belly_x_m": 0.0, "mass_x_m": 0.0},
        **{"max_tilt_deg": None, "max_pitch_deg": None, "max_roll_deg": None},
        **{"static_tilt_deg": None, "max_rocker_deg": None, "max_bogie_deg": None},
    },
    "mobility": {"drive_power_w": 0.0, "max_slip": 0.6, "soil": "compacted"},
    "steering": {
        **{"max_steer_deg": 90.0, "wheel_speed_m_s": 0.0, "acceleration_m_s2": 0.0},
        **{"turn_acceleration_deg_s2": 0.0, "lag_s": 0.0},
    },
}
"""What a rover file may leave out, section by section."""


@functools.cache
def _model() -> Any:
    from pydantic import BaseModel, ConfigDict, Field

    rover, chassis, mobility, steering = _USUAL.values()
    strict = ConfigDict(extra="forbid", allow_inf_nan=False, strict=True)

    class ChassisSection(BaseModel):
        model_config = strict
        suspension: Suspension
        wheel_x_m: list[float] = Field(min_length=2, max_length=3)
        wheel_width_m: float
        rocker_m: list[float] = Field(chassis["rocker_m"], min_length=2, max_length=2)
        bogie_m: list[float] = Field(chassis["bogie_m"], min_length=2, max_length=2)
        bogie_wheels: End = chassis["bogie_wheels"]
        belly_m: list[float] = Field(min_length=2, max_length=2)
        belly_x_m: float = chassis["belly_x_m"]
        mass_x_m: float = chassis["mass_x_m"]
        max_tilt_deg: float | None = chassis["max_tilt_deg"]
        max_pitch_deg: float | None = chassis["max_pitch_deg"]
        max_roll_deg: float | None = chassis["max_roll_deg"]
        static_tilt_deg: float | None = chassis["static_tilt_deg"]
        max_rocker_deg: float | None = chassis["max_rocker_deg"]
        max_bogie_deg: float | None = chassis["max_bogie_deg"]

    class MobilitySection(BaseModel):
        model_config = strict
        mass_kg: float
        gravity_m_s2: float
        efficiency: float
        idle_power_w: float
        drive_power_w: float = mobility["drive_power_w"]
        max_slip: float = mobility["max_slip"]
        soil: str = mobility["soil"]

    class SteeringSection(BaseModel):
        model_config = strict
        kind: Kind
        max_steer_deg: float = steering["max_steer_deg"]
        wheel_speed_m_s: float = steering["wheel_speed_m_s"]
        acceleration_m_s2: float = steering["acceleration_m_s2"]
        turn_acceleration_deg_s2: float = steering["turn_acceleration_deg_s2"]
        lag_s: float = steering["lag_s"]

    class RoverFile(BaseModel):
        """The keys of a rover file; units stand in their names. Ranges are the Rover's own."""

        model_config = strict
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
        turn_rate_deg_s: float = rover["turn_rate_deg_s"]
        track_m: float = rover["track_m"]
        step_m: float = rover["step_m"]
        footing_m: float = rover["footing_m"]
        chassis: ChassisSection | None = None
        mobility: MobilitySection | None = None
        steering: SteeringSection | None = None

    names = {"Drive": Drive, "Suspension": Suspension, "End": End, "Kind": Kind, "Field": Field}
    made = (ChassisSection, MobilitySection, SteeringSection)
    for model in made:
        model.model_rebuild(_types_namespace=names)
    sections = {model.__name__: model for model in made}
    RoverFile.model_rebuild(_types_namespace=names | sections)
    return RoverFile
