from __future__ import annotations

import math
from dataclasses import fields
from importlib import resources
from pathlib import Path
from typing import Any

import pytest

from rovernav.core import FileError, SettingError
from rovernav.rover import Rover, presets, read_rover

ROBOT: dict[str, Any] = {
    "name": "robot",
    "source": "test",
    "drive": "differential",
    "length": 0.5,
    "width": 0.4,
    "wheel_radius": 0.1,
    "clearance": 0.1,
    "max_slope": 0.3,
    "max_step": 0.1,
    "speed": 1.0,
    "turn_rate": 1.0,
    "track": 0.3,
}
WHEELED = ("curiosity", "jackal", "mer", "perseverance", "research", "sojourner")
POINT: dict[str, Any] = {
    **ROBOT,
    "drive": "two-axis",
    **dict.fromkeys(("length", "width", "wheel_radius", "turn_rate", "track"), 0.0),
    "step": 0.8287,
}


def test_presets_are_listed_and_readable() -> None:
    assert presets() == sorted([*WHEELED, "paper-point"])
    for name in presets():
        rover = read_rover(name)
        assert rover.name == name
        assert len(rover.source) > 60
        assert 0.0 < rover.max_slope < math.pi / 4


def test_the_papers_rover() -> None:
    rover = read_rover("paper-point")
    assert rover.is_point
    assert rover.radius == 0.0
    assert rover.drive == "two-axis"
    assert rover.step == 0.8287
    assert rover.max_slope == pytest.approx(math.radians(20.0), abs=1e-15)
    assert rover.max_step == 0.2
    assert rover.footing == 0.3
    assert "assumptions" in rover.source


def test_units_become_si() -> None:
    rover = read_rover("perseverance")
    assert (rover.length, rover.width, rover.wheel_radius) == (3.0, 2.7, 0.2625)
    assert rover.turn_rate == pytest.approx(math.radians(2.0), abs=1e-15)
    assert rover.speed == 0.042
    assert rover.footing == 3.0
    assert rover.radius == pytest.approx(math.hypot(3.0, 2.7) / 2, abs=1e-15)


def test_unchecked_numbers_say_so() -> None:
    for name in ("curiosity", "jackal", "mer", "sojourner", "perseverance"):
        assert "memory)" in read_rover(name).source


def made(base: dict[str, Any], **changes: Any) -> Rover:
    settings: dict[str, Any] = {**base, **changes}
    return Rover(**settings)


def lines(**changes: Any) -> str:
    keys: dict[str, Any] = {
        "name": "mine",
        "source": "measured",
        "drive": "differential",
        "length_m": 0.5,
        "width_m": 0.4,
        "wheel_radius_m": 0.1,
        "clearance_m": 0.1,
        "max_slope_deg": 15,
        "max_step_m": 0.05,
        "speed_m_s": 0.5,
        "turn_rate_deg_s": 90,
        "track_m": 0.3,
        **changes,
    }
    return "".join(f"{key}: {item}\n" for key, item in keys.items() if item is not None)


@pytest.mark.parametrize("as_text", [True, False])
def test_a_users_own_rover(tmp_path: Path, as_text: bool) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(lines(footing_m=0.8))
    rover = read_rover(str(path) if as_text else path)
    assert rover.max_slope == pytest.approx(math.radians(15), abs=1e-15)
    assert rover.turn_rate == pytest.approx(math.pi / 2, abs=1e-15)
    assert rover.footing == 0.8


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"max_slop_deg": 3}, r"mine.yaml: unknown key 'max_slop_deg'; did you mean 'max_slope_de"),
        ({"max_slope": 3}, "unknown key 'max_slope'; did you mean 'max_slope_deg'"),
        ({"width_m": None}, "the key 'width_m' is missing; add it"),
        ({"width_m": "wide"}, "width_m = 'wide': input should be a valid number"),
        ({"width_m": "true"}, "width_m = True: input should be a valid number"),
        ({"width_m": ".nan"}, "width_m = nan: input should be a finite number"),
        ({"drive": "legs"}, "drive = 'legs': input should be 'differential' or 'two-axis'"),
        ({"max_slope_deg": 91}, "mine.yaml: rover mine: max_slope must lie in 0 to 89 deg, got 91"),
        ({"wheel_radius_m": 4}, "a wheel of 8 m does not fit into a length of 0.5 m"),
    ],
)
def test_a_rover_file_with_a_mistake(tmp_path: Path, changes: dict[str, Any], message: str) -> None:
    (tmp_path / "mine.yaml").write_text(lines(**changes))
    with pytest.raises(SettingError, match=message) as caught:
        read_rover(tmp_path / "mine.yaml")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", presets())
def test_a_preset_is_what_its_file_says_when_checked(name: str) -> None:
    with resources.as_file(resources.files("rovernav.rover") / "presets" / f"{name}.yaml") as path:
        checked = read_rover(path)
    assert repr(read_rover(name)) == repr(checked)


def test_an_unknown_preset_names_the_nearest() -> None:
    with pytest.raises(SettingError, match=r"no rover preset 'perseverence'; did you mean 'persev"):
        read_rover("perseverence")
    with pytest.raises(SettingError, match=r"A path that ends in .yaml reads your own rover"):
        read_rover("../presets/jackal")


def test_a_missing_rover_file() -> None:
    with pytest.raises(FileError, match=r"there is no rover file at none.yaml; check the path"):
        read_rover("none.yaml")


@pytest.mark.parametrize(
    ("base", "changes", "message"),
    [
        (ROBOT, {"length": -1.0}, "length must lie in 0 to 20 m, got -1"),
        (ROBOT, {"length": math.nan}, "length must lie in 0 to 20 m, got nan"),
        (ROBOT, {"max_slope": 1.6}, "max_slope must lie in 0 to 89 deg, got 91.67"),
        (ROBOT, {"speed": 0.0}, "speed must lie in 1e-06 to 100 m/s, got 0"),
        (ROBOT, {"clearance": math.inf}, "clearance must lie in 0 to 10 m, got inf"),
        (ROBOT, {"width": 0.0}, "length 0.5 m and width 0 m must both be 0 .a point. or both"),
        (ROBOT, {"wheel_radius": 0.3}, "a wheel of 0.6 m does not fit into a length of 0.5 m"),
        (ROBOT, {"track": 0.5}, "track 0.5 m must not exceed width 0.4 m"),
        (ROBOT, {"track": 0.0}, "a differential rover needs a positive track and turn rate"),
        (ROBOT, {"turn_rate": 0.0}, "a differential rover needs a positive track and turn rate"),
        (POINT, {"step": 0.0}, "a two-axis rover needs a positive step; set it"),
        (POINT, {"drive": "two-axes"}, "unknown drive 'two-axes'; did you mean 'two-axis'"),
    ],
)
def test_absurd_rovers(base: dict[str, Any], changes: dict[str, Any], message: str) -> None:
    made(base)
    with pytest.raises(SettingError, match=f"rover robot: {message}"):
        made(base, **changes)


def test_every_number_is_checked() -> None:
    numbers = [f.name for f in fields(Rover) if f.type == "float"]
    assert len(numbers) == 11
    for name in numbers:
        with pytest.raises(SettingError, match=f"{name} must lie in"):
            made(ROBOT, **{name: math.nan})


CHASSIS = """chassis:
  suspension: rocker-bogie
  wheel_x_m: [0.15, 0.0, -0.15]
  wheel_width_m: 0.05
  rocker_m: [0.03, 0.1]
  bogie_m: [-0.07, 0.05]
  belly_m: [0.3, 0.2]
mobility:
  mass_kg: 12
  gravity_m_s2: 3.71
  efficiency: 0.4
  idle_power_w: 8
"""


def test_a_rover_file_with_wheels_and_motors(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(lines(track_m=0.3) + CHASSIS)
    rover = read_rover(path)
    assert rover.chassis is not None
    assert rover.mobility is not None
    assert (rover.chassis.wheels, rover.chassis.wheelbase) == (6, 0.3)
    assert rover.chassis.max_tilt == rover.max_slope
    assert rover.chassis.static_tilt == pytest.approx(math.radians(45), abs=1e-15)
    assert rover.mobility.mass == 12.0
    assert rover.mobility.soil == "compacted"


def test_an_old_rover_file_gets_four_wheels_at_its_corners(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(lines())
    rover = read_rover(path)
    assert rover.chassis is not None
    assert rover.chassis.suspension == "averaging"
    assert rover.chassis.wheel_x == pytest.approx((0.15, -0.15), abs=1e-12)
    assert rover.mobility is None
    assert read_rover("paper-point").chassis is None


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("wheel_x_m:", "wheels_x_m:", "unknown key 'chassis.wheels_x_m'; did you mean 'wheel_x_m'"),
        ("mass_kg: 12", "mass: 12", "unknown key 'mobility.mass'; did you mean 'mass_kg'"),
        ("rocker-bogie", "rocker-boogie", "input should be 'rigid', 'averaging' or 'rocker-bogie'"),
        ("[0.15, 0.0, -0.15]", "[0.15, -0.15]", "rocker-bogie needs 3 wheels a side"),
        ("[0.15, 0.0, -0.15]", "[0.15, 0.2, -0.15]", "wheel_x must fall from front to rear"),
        ("[0.15, 0.0, -0.15]", "[0.3, 0.0, -0.3]", "wheels reach over 0.8 m, more than the length"),
        ("[0.03, 0.1]", "[0.3, 0.1]", "the rocker's pivot must lie between the wheels"),
        ("[-0.07, 0.05]", "[0.07, 0.05]", "the bogie's pivot must lie between its wheels"),
        ("[-0.07, 0.05]", "[-0.07, -0.05]", "the bogie's pivot must not lie below the axles"),
        ("belly_m: [0.3, 0.2]", "belly_m: [0.3]", "chassis.belly_m"),
        ("belly_m: [0.3, 0.2]", "belly_m: [-1, 0.2]", "belly_length must lie in 0 to 20 m, got -1"),
        ("  belly_m", "  max_roll_deg: 95\n  belly_m", "max_roll must lie in 0 to 89 deg, got 95"),
        ("mass_kg: 12", "mass_kg: -12", "mass must lie in 0.001 to 1e.06 kg, got -12"),
    ],
)
def test_a_section_with_a_mistake(tmp_path: Path, old: str, new: str, message: str) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text((lines() + CHASSIS).replace(old, new, 1))
    with pytest.raises(SettingError, match=message) as caught:
        read_rover(path)
    assert "\n" not in str(caught.value)
