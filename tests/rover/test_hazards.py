from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy import ndimage

from rovernav.core import SettingError
from rovernav.kernels import distance, relief
from rovernav.rover import Reason, drive_cost, drive_table, hazards, read_rover, standing
from rovernav.terrain import planes_over
from tests.rover.rough_ground import rough_ground
from tests.rover.test_rovers import POINT, made
from tests.terrain.ground import ground, plane, rough

edt: Any = ndimage.distance_transform_edt
ALWAYS = {"slope", "east", "north", "roughness", "step", "distance"}


def test_layers_of_a_plane() -> None:
    rover = read_rover("perseverance")
    found = hazards(plane(0.2, -0.1, shape=(40, 50), cell=0.5), rover, soil="crust", heading=0.3)
    layers = found.layers
    assert set(layers) == ALWAYS | {"slip", "energy", "pitch", "roll"}
    assert (found.rover, found.soil, found.heading) == ("perseverance", "crust", 0.3)
    assert_allclose(layers["east"].values, 0.2, atol=1e-5)
    assert_allclose(layers["north"].values, -0.1, atol=1e-5)
    assert_allclose(layers["roughness"].values, 0.0, atol=2e-5)
    assert np.isinf(layers["distance"].values).all()
    told = drive_cost(0.2, -0.1, 0.3, drive_table(rover, "crust"))
    for name in ("slip", "energy", "pitch", "roll"):
        assert_allclose(layers[name].values, float(getattr(told, name)), rtol=2e-4, atol=2e-5)


def test_without_a_heading_slip_and_energy_are_uphills() -> None:
    rover = read_rover("research")
    found = hazards(plane(0.1, 0.2, shape=(30, 30), cell=0.1), rover)
    told = drive_cost(math.hypot(0.1, 0.2), 0.0, 0.0, drive_table(rover))
    assert_allclose(found.layers["energy"].values, float(told.energy), rtol=1e-4)
    assert "straight uphill" in found.layers["energy"].words


def test_hazards_stand_where_standing_stands() -> None:
    terrain, rover = rough_ground(2, slope=0.2, cover=0.1), read_rover("perseverance")
    found, alone = hazards(terrain, rover), standing(terrain, rover)
    assert_array_equal(found.blocked, alone.blocked)
    assert_array_equal(found.reason, alone.reason)
    assert_array_equal(found.layers["slope"].values, alone.slope)
    bad = (alone.reason != Reason.FREE) & (alone.reason != Reason.NEAR)
    expected = edt(~bad) * terrain.frame.cell
    assert_allclose(found.layers["distance"].values, expected, rtol=1e-6)


def test_every_layer_explains_itself() -> None:
    terrain = rough_ground(1, slope=0.05, cells=30)
    found = hazards(terrain, read_rover("perseverance"), heading=0.0, turns=2)
    assert len(found.layers) == 13
    for name, layer in found.layers.items():
        assert layer.name == name
        assert layer.unit in {"rad", "1", "m", "J/m"}
        assert len(layer.words) > 20
        assert layer.formula
        assert layer.source
        assert "{" not in layer.words
        assert layer.values.dtype == np.float32
        assert not layer.values.flags.writeable
        assert layer.values.shape == terrain.frame.shape
        summary = layer.summary()
        assert 0.0 <= summary["known"] <= 1.0
        if summary["known"]:
            assert summary["lowest"] <= summary["median"] <= summary["highest"]


def test_proven_headings_fall_with_rocks() -> None:
    rover = read_rover("perseverance")
    flat = ground(np.zeros((56, 56)), 0.1)
    smooth = hazards(flat, rover, turns=8).layers["proven"].values
    rocky = hazards(rough_ground(1, cover=0.2, cells=56), rover, turns=8).layers["proven"].values
    assert smooth[28, 28] == 1.0
    assert rocky.mean() < smooth.mean()
    assert smooth[0, 0] == 0.0  # off the map nothing is proven


def test_a_point_rover_has_no_slip_and_says_so_when_asked() -> None:
    found = hazards(plane(0.1, 0.0), made(POINT))
    assert set(found.layers) == ALWAYS
    assert found.soil is None
    with pytest.raises(SettingError, match="rover robot says nothing of its mass and motors"):
        hazards(plane(0.1, 0.0), made(POINT), soil="crust")
    with pytest.raises(SettingError, match="rover robot has no wheels"):
        hazards(plane(0.1, 0.0), made(POINT), turns=1)


def test_too_many_poses_to_prove_are_refused() -> None:
    terrain = ground(np.zeros((600, 600)))
    with pytest.raises(
        SettingError, match="16 headings for 600 x 600 cells are more than 4,000,000"
    ):
        hazards(terrain, read_rover("research"), turns=16)


@pytest.mark.kernels
@pytest.mark.parametrize("missing", [0.0, 0.05])
@pytest.mark.parametrize("reach", [1, 3, 6])
def test_planes_and_what_they_leave(reach: int, missing: float) -> None:
    terrain = ground(rough(np.random.default_rng(reach), (17, 19), missing) + 1000.0, 0.7)
    planes = planes_over(terrain, 2 * reach * 0.7)
    assert planes.posts == 2 * reach + 1
    steps = range(-reach, reach + 1)
    design = np.array([[1.0, u * 0.7, v * 0.7] for v in steps for u in steps])
    for i in range(reach, 17 - reach):
        for j in range(reach, 19 - reach):
            square = terrain.height[i - reach : i + reach + 1, j - reach : j + reach + 1]
            z = square.ravel().astype(np.float64)
            if np.isnan(z).any():
                assert np.isnan(planes.rms[i, j])
                continue
            fit = np.linalg.lstsq(design, z, rcond=None)[0]
            left = z - design @ fit
            assert planes.east[i, j] == pytest.approx(fit[1], abs=1e-5)
            assert planes.north[i, j] == pytest.approx(fit[2], abs=1e-5)
            assert planes.rms[i, j] == pytest.approx(math.sqrt((left**2).mean()), abs=1e-5)


def test_planes_are_the_same_across_tiles() -> None:
    rng = np.random.default_rng(3)
    heights = rng.normal(0.0, 1.0, (300, 290)).cumsum(axis=0)
    whole = planes_over(ground(heights), 4.0)
    part = planes_over(ground(heights[240:, 230:]), 4.0)
    for name in ("east", "north", "rms"):
        got, expected = getattr(part, name)[2:-2, 2:-2], getattr(whole, name)[242:-2, 232:-2]
        assert_allclose(got, expected, rtol=0, atol=1e-5)


def test_arc_tangents_are_good_to_the_last_bits() -> None:
    x = np.concatenate([np.linspace(0.0, 10.0, 20001), np.logspace(-8, 8, 2001)])
    got = np.array([relief.arctan(float(value)) for value in x])
    assert_allclose(got, np.arctan(x), rtol=5e-16)
    assert math.isnan(relief.arctan(math.nan))


@pytest.mark.kernels
@pytest.mark.parametrize("share", [0.0, 0.002, 0.3, 1.0])
@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (12, 1), (23, 31)])
def test_distances_equal_scipys(shape: tuple[int, int], share: float) -> None:
    marked = (np.random.default_rng(7).random(shape) < share).astype(np.uint8)
    squared = np.empty(shape, np.int32)
    distance.columns(marked, squared)
    distance.squares(squared)
    if not marked.any():
        assert (squared >= distance.FAR**2).all()
        return
    expected = np.rint(edt(marked == 0) ** 2)
    assert_array_equal(squared, expected)


@pytest.mark.data
def test_perseverances_stops_are_no_hazards(data_dir: Path) -> None:
    from tests.rover.real import jezero

    found = jezero(data_dir)
    assert found.stops == 114
    assert found.blocked <= 0.01 * found.stops
    assert found.tilt_rmse < 2.5
    assert found.tilt_correlation > 0.75
    assert found.pitch_correlation > 0.8
    assert found.roll_correlation > 0.7
