from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from rovernav.terrain import hillshade, ledge_height, slope, slope_over, step_height
from tests.naive import relief as naive
from tests.terrain.ground import ground, plane, rough

tilt = st.floats(-2.0, 2.0)
SHAPES = [(3, 3), (3, 8), (7, 4), (6, 6)]


@settings(max_examples=40)
@given(p=tilt, q=tilt)
def test_slope_is_exact_on_planes_to_the_edge(p: float, q: float) -> None:
    exact = math.atan(math.hypot(p, q))
    assert_allclose(slope(plane(p, q)), exact, rtol=0, atol=2e-5)
    assert_allclose(slope_over(plane(p, q), 2.4), exact, rtol=0, atol=2e-5)


@pytest.mark.kernels
@pytest.mark.parametrize("missing", [0.0, 0.1])
@pytest.mark.parametrize("shape", SHAPES)
def test_slope_equals_its_twin(shape: tuple[int, int], missing: float) -> None:
    heights = rough(np.random.default_rng(shape[1]), shape, missing)
    terrain = ground(heights, cell=0.7)
    assert_allclose(slope(terrain), naive.horn(terrain.height, 0.7), rtol=0, atol=1e-6)


@pytest.mark.kernels
@pytest.mark.parametrize("reach", [1, 2])
@pytest.mark.parametrize("missing", [0.0, 0.05])
@pytest.mark.parametrize("shape", SHAPES)
def test_fitted_slope_equals_least_squares(
    shape: tuple[int, int], missing: float, reach: int
) -> None:
    terrain = ground(rough(np.random.default_rng(shape[0]), shape, missing), cell=0.7)
    fits = min(reach, (min(shape) - 1) // 2)
    fitted = slope_over(terrain, 2 * reach * 0.7)
    assert_allclose(fitted, naive.fitted(terrain.height, 0.7, fits), rtol=0, atol=1e-6)


@pytest.mark.kernels
@pytest.mark.parametrize("reach", [1, 3])
@pytest.mark.parametrize("steeper", [0.0, 0.8])
@pytest.mark.parametrize("missing", [0.0, 0.1])
@pytest.mark.parametrize("shape", SHAPES)
def test_ledge_equals_its_twin(
    shape: tuple[int, int], missing: float, steeper: float, reach: int
) -> None:
    terrain = ground(rough(np.random.default_rng(shape[1]), shape, missing), cell=0.7)
    got = ledge_height(terrain, within=reach * 0.7, steeper=steeper)
    assert_allclose(got, naive.ledge(terrain.height, 0.7, reach, steeper), rtol=0, atol=1e-6)


def test_slope_is_missing_beside_missing_heights_only() -> None:
    heights = np.zeros((6, 7))
    heights[1, 2] = np.nan
    expected = np.zeros((6, 7), bool)
    expected[0:3, 0:4] = True  # row 0 and column 0 through the nearest windows, around 1
    assert_array_equal(np.isnan(slope(ground(heights))), expected)
    assert_array_equal(np.isnan(slope_over(ground(heights), 1.0)), expected)


def test_a_step_is_exact_on_both_sides() -> None:
    heights = np.zeros((4, 6))
    heights[:, 3:] = 0.35
    steps = step_height(ground(heights, cell=0.1))
    assert_allclose(steps, [[0, 0, 0.35, 0.35, 0, 0]] * 4, rtol=0, atol=1e-6)


def test_a_spike_is_a_step_for_its_eight_neighbours() -> None:
    heights = np.zeros((5, 5))
    heights[2, 2] = 0.5
    steps = step_height(ground(heights))
    assert_array_equal(steps[1:4, 1:4], np.full((3, 3), np.float32(0.5)))
    assert steps[0].max() == steps[:, 4].max() == 0.0


def test_a_slope_is_no_ledge_however_far_apart_the_posts() -> None:
    terrain = plane(0.3, 0.1, shape=(6, 6), cell=20.0)
    assert step_height(terrain).max() > 5.0
    assert ledge_height(terrain, steeper=math.atan(0.35)).max() == 0.0


def test_a_ledge_smeared_over_posts_is_seen_within_a_wheel() -> None:
    heights = np.repeat([[0, 0, 0, 0.15, 0.3, 0.3, 0.3]], 3, axis=0)
    steep = math.radians(30)
    near = ledge_height(ground(heights, cell=0.1), steeper=steep)
    wide = ledge_height(ground(heights, cell=0.1), within=0.2, steeper=steep)
    assert near.max() == pytest.approx(0.15, abs=1e-6)
    assert wide.max() == pytest.approx(0.3, abs=1e-6)


def test_light_comes_from_the_north_west() -> None:
    flat = hillshade(plane(0.0, 0.0))
    assert_allclose(flat, math.sin(math.radians(45)), rtol=0, atol=1e-6)
    facing, turned_away = hillshade(plane(0.5, -0.5)), hillshade(plane(-2.0, 2.0))
    assert facing.min() > flat.max()
    assert turned_away.max() == 0.0
    at_the_sun = plane(-math.sin(math.pi * 1.75), -math.cos(math.pi * 1.75))
    assert_allclose(hillshade(at_the_sun), 1.0, rtol=0, atol=1e-6)


def test_shade_is_missing_where_slope_is() -> None:
    heights = rough(np.random.default_rng(5), (8, 9), 0.05)
    terrain = ground(heights)
    assert_array_equal(np.isnan(hillshade(terrain)), np.isnan(slope(terrain)))
    assert slope(terrain).dtype == hillshade(terrain).dtype == np.float32
