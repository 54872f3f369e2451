from __future__ import annotations

import itertools
import math
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from rovernav.core import FileError, InputError, SettingError
from rovernav.kernels import traction as k
from rovernav.rover import (
    Mobility,
    Soil,
    cheapest,
    drive_cost,
    drive_table,
    read_rover,
    read_soil,
    soils,
)
from tests.naive import traction as naive
from tests.rover.test_rovers import POINT, ROBOT, WHEELED, made

rise = st.floats(-0.9, 0.9)


def with_power(limit: float) -> Any:
    mobility = Mobility(
        mass=20.0, gravity=9.81, efficiency=0.5, idle_power=10.0, drive_power=limit, max_slip=0.6,
        soil="bedrock",
    )  # fmt: skip
    return made(ROBOT, mobility=mobility)


def kinky(soil: Soil) -> Soil:
    """A soil whose kinks lie on the nodes of the table, so that the table says it all."""
    nodes = np.linspace(-1.0, 1.0, k.NODES)
    nodes = nodes[nodes >= 0.0]
    curves = ("slip", "slip_low", "slip_high", "side_slip")
    slope = np.arctan(nodes)
    made: dict[str, Any] = {n: np.interp(slope, soil.slope, getattr(soil, n)) for n in curves}
    others = [f.name for f in fields(Soil) if f.name not in {*curves, "slope"}]
    rest: dict[str, Any] = {name: getattr(soil, name) for name in others}
    return Soil(slope=slope, **made, **rest)


@pytest.mark.kernels
@settings(max_examples=60)
@given(p=rise, q=rise, heading=st.floats(-3.1, 3.1), limit=st.sampled_from([0.0, 60.0]))
@pytest.mark.parametrize("name", ["bedrock", "loose-sand"])
def test_cost_equals_its_twin(name: str, p: float, q: float, heading: float, limit: float) -> None:
    rover, soil = with_power(limit), kinky(read_soil(name))
    got = drive_cost(p, q, heading, drive_table(rover, soil))
    slip, side, speed, power, energy, time, pitch, roll = naive.cost(p, q, heading, rover, soil)
    assert_allclose(got.pitch, pitch, atol=1e-12)
    # Nose up first, then roll: sin(left side up against level) = cos(pitch) sin(roll).
    assert_allclose(math.cos(pitch) * math.sin(got.roll), math.sin(roll), atol=1e-12)
    assert_allclose(got.slip, slip, atol=2e-4)  # between nodes: straight in tangents, not angles
    assert_allclose(got.side_slip, side, atol=2e-4)
    if (1 - slip) ** 2 - side**2 > 1e-3:
        assert_allclose(got.speed, speed, rtol=0.02, atol=1e-4)
        assert_allclose(got.power, power, rtol=1e-9)
        assert_allclose(got.energy, energy, rtol=0.02)
        assert_allclose(got.time, time, rtol=0.02)


@settings(max_examples=60)
@given(p=rise, q=rise, turn=st.floats(-3.1, 3.1), heading=st.floats(-3.1, 3.1))
def test_turning_the_world_changes_nothing(p: float, q: float, turn: float, heading: float) -> None:
    table = drive_table(read_rover("research"), "crust")
    here = drive_cost(p, q, heading, table)
    cos, sin = math.cos(turn), math.sin(turn)
    there = drive_cost(p * cos - q * sin, p * sin + q * cos, heading + turn, table)
    for name in ("pitch", "roll", "slip", "side_slip"):
        assert_allclose(getattr(there, name), getattr(here, name), atol=1e-9)
    mirrored = drive_cost(p, -q, -heading, table)
    assert_allclose(mirrored.energy, here.energy, rtol=1e-12)
    assert_allclose(mirrored.side_slip, -here.side_slip, atol=1e-15)


def test_uphill_costs_more_and_sand_more_than_rock() -> None:
    rover = read_rover("perseverance")
    up = np.tan(np.radians(np.arange(0.0, 20.0)))
    table = drive_table(rover, soils())
    costs = {name: drive_cost(up, 0.0, 0.0, table, n) for n, name in enumerate(soils())}
    for cost in costs.values():
        assert (np.diff(cost.energy) > 0.0).all()
        assert (np.diff(cost.speed) <= 1e-15).all()
    order = ("bedrock", "compacted", "crust", "loose-sand")
    for easy, hard in itertools.pairwise(order):
        assert (costs[easy].energy < costs[hard].energy).all()
    down = drive_cost(-up[1:], 0.0, 0.0, table, 0)
    assert (down.energy > 0.0).all()
    assert (down.energy < costs["bedrock"].energy[0]).all()


def test_the_band_holds_the_expected() -> None:
    rover = read_rover("mer")
    up = np.linspace(0.0, 0.4, 50)
    low, middle, high = (
        drive_cost(up, 0.05, 0.0, drive_table(rover, "crust", slip=s))
        for s in ("low", "expected", "high")
    )
    assert (low.slip <= middle.slip).all()
    assert (middle.slip <= high.slip).all()
    assert (low.energy <= middle.energy).all()


@pytest.mark.parametrize(("deg", "slip"), [(5, 0.10), (10, 0.225), (15, 0.52), (20, 0.92)])
def test_sand_slips_as_the_chassis_tests_say(deg: float, slip: float) -> None:
    got = drive_cost(math.tan(math.radians(deg)), 0.0, 0.0,
                     drive_table(read_rover("mer"), "loose-sand"))  # fmt: skip
    assert got.slip == pytest.approx(slip, abs=0.02)


def code(rover: Any, soil: str, pitch: float, roll: float = 0.0) -> int:
    p, q = math.tan(math.radians(pitch)), math.tan(math.radians(roll))
    return int(drive_cost(p, q, 0.0, drive_table(rover, soil)).code)


def test_codes_say_which_limit_and_what_was_measured() -> None:
    rover = read_rover("perseverance")
    assert code(rover, "bedrock", 3) == k.ALLOWED
    assert code(rover, "bedrock", 24) == k.ALLOWED
    assert code(rover, "bedrock", 28) == k.ALLOWED + k.UNMEASURED
    assert code(rover, "bedrock", -8) == k.ALLOWED + k.UNMEASURED
    assert code(rover, "bedrock", 0, 8) == k.ALLOWED + k.SIDE_UNMEASURED
    assert code(rover, "loose-sand", 17) == k.SLIP
    assert code(rover, "bedrock", 32) & 7 == k.PITCH
    assert code(rover, "bedrock", 0, -32) & 7 == k.ROLL
    assert code(rover, "bedrock", 25, 25) & 7 == k.TILT
    stuck = drive_cost(math.tan(0.5), 0.0, 0.0, drive_table(rover, "loose-sand"))
    assert stuck.energy == stuck.time == math.inf
    assert stuck.speed == 0.0
    assert not stuck.allowed
    assert not stuck.measured
    assert math.isnan(stuck.power)


def test_nothing_is_cheaper_than_the_cheapest() -> None:
    for name in WHEELED:
        table = drive_table(read_rover(name), soils())
        energy, time = cheapest(table)
        rng = np.random.default_rng(1)
        p, q = rng.uniform(-0.8, 0.8, (2, 2000))
        cost = drive_cost(p, q, rng.uniform(-3, 3, 2000), table, rng.integers(0, len(table), 2000))
        assert 0.0 < energy <= cost.energy.min()
        assert 0.0 < time <= cost.time.min()


def test_wheels_dig_in_as_they_slip() -> None:
    soil = read_soil("loose-sand")
    assert soil.depth(0.77, 0.25) == pytest.approx(0.30 * 0.5, abs=1e-3)
    assert soil.depth(0.0, 0.25) == 0.0
    assert read_soil("bedrock").depth(1.0, 0.25) == 0.0


def test_every_soil_names_its_sources_and_assumptions() -> None:
    assert soils() == ["bedrock", "compacted", "crust", "loose-sand"]
    for name in soils():
        assert read_soil(name).name == name
        assert "assumption" in read_soil(name).source


def test_unknown_words_name_the_nearest() -> None:
    rover = read_rover("mer")
    with pytest.raises(SettingError, match=r"there is no soil 'sand'; .*loose-sand"):
        drive_table(rover, "sand")
    with pytest.raises(SettingError, match="unknown slip 'hig'; did you mean 'high'"):
        drive_table(rover, slip="hig")
    with pytest.raises(SettingError, match="give at least one soil"):
        drive_table(rover, [])
    with pytest.raises(SettingError, match="rover robot says nothing of its mass and motors"):
        drive_table(made(ROBOT))
    with pytest.raises(SettingError, match="rover robot says nothing of its mass"):
        drive_table(made(POINT))
    with pytest.raises(InputError, match="soil must be 0 to 0, a row of the table"):
        drive_cost(0.0, 0.0, 0.0, drive_table(rover), 1)


SAND = """name: mine
source: guessed
rolling_resistance: 0.2
slope_deg: [0, 10]
slip: [0.1, 0.3]
slip_low: [0.0, 0.2]
slip_high: [0.2, 0.5]
side_slip: [0.0, 0.1]
measured_up_to_deg: 10
measured_down_to_deg: 5
measured_side_deg: 5
"""


def test_a_users_own_soil(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(SAND)
    soil = read_soil(path)
    assert soil.measured_up == pytest.approx(math.radians(10), abs=1e-15)
    table = drive_table(read_rover("mer"), str(path))
    assert drive_cost(0.0, 0.0, 0.0, table).slip == pytest.approx(0.1, abs=1e-12)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("sinkag", "sinkag", "there is no soil file"),
        ("slip: [0.1, 0.3]", "slip: [0.1, 0.3]\nslp: 1", "unknown key 'slp'; did you mean 'slip'"),
        ("[0, 10]", "[0, 10, 20]", "soil mine: all curves need as many points as slope_deg"),
        ("[0, 10]", "[5, 10]", "slope_deg must begin with 0 and rise"),
        ("[0, 10]", "[0, 90]", "slope_deg must stay below 90"),
        ("slip: [0.1, 0.3]", "slip: [0.3, 0.1]", "slip must rise with the slope, from 0 to 1"),
        ("slip: [0.1, 0.3]", "slip: [0.1, 0.6]", "slip must lie between slip_low and slip_high"),
        ("rolling_resistance: 0.2", "rolling_resistance: 3", "rolling_resistance must lie in 0 to"),
    ],
)
def test_a_soil_file_with_a_mistake(tmp_path: Path, old: str, new: str, message: str) -> None:
    path = tmp_path / "mine.yaml"
    if old != new:
        path.write_text(SAND.replace(old, new, 1))
    with pytest.raises((SettingError, FileError), match=message):
        read_soil(path)


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("mass", 0.0, "mass must lie in 0.001 to 1e.06 kg, got 0"),
        ("efficiency", 1.5, "efficiency must lie in 0.01 to 1, got 1.5"),
        ("gravity", math.nan, "gravity must lie in 0.001 to 30 m/s.2, got nan"),
        ("max_slip", 1.0, "max_slip must lie in 0.01 to 0.99, got 1"),
    ],
)
def test_absurd_mobility(field: str, value: float, message: str) -> None:
    numbers: dict[str, Any] = {
        "mass": 1.0, "gravity": 1.0, "efficiency": 0.5, "idle_power": 1.0, "drive_power": 0.0,
        "max_slip": 0.6, "soil": "crust",
    }  # fmt: skip
    Mobility(**numbers)
    with pytest.raises(SettingError, match=message):
        Mobility(**dict(numbers, **{field: value}))
