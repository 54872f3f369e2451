from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

from rovernav.rover import Reason, Rover, read_rover, standing
from tests.rover.test_rovers import POINT, ROBOT, made
from tests.terrain.ground import ground, plane, rough

FREE, NO_DATA, SLOPE, STEP, NEAR = Reason
DEGREES = math.pi / 180.0


def point(**changes: Any) -> Rover:
    return made(POINT, **{"max_slope": 20 * DEGREES, "max_step": 0.2, **changes})


def robot(**changes: Any) -> Rover:
    return made(ROBOT, **{"max_slope": 20 * DEGREES, "max_step": 0.1, **changes})


def test_flat_ground_is_free_to_its_edge() -> None:
    result = standing(plane(0.0, 0.0), robot())
    assert result.share == 0.0
    assert result.blocked.dtype == result.reason.dtype == np.uint8
    assert result.blocked.flags.c_contiguous
    assert not result.blocked.flags.writeable


@settings(max_examples=30)
@given(angle=st.floats(0.0, 40.0), heading=st.floats(-math.pi, math.pi))
@pytest.mark.parametrize("cell", [0.094, 3.69])
def test_a_plane_is_free_up_to_the_slope_limit(cell: float, angle: float, heading: float) -> None:
    rise = math.tan(angle * DEGREES)
    result = standing(plane(rise * math.cos(heading), rise * math.sin(heading), cell=cell), point())
    if abs(angle - 20.0) > 0.01:
        assert result.share == (1.0 if angle > 20.0 else 0.0)


def test_a_low_step_is_climbed_and_a_high_one_is_not() -> None:
    heights = np.zeros((40, 60))
    heights[:, 30:] = 0.19
    wide = {"footing": 3.0}
    low = standing(ground(heights, cell=0.1), point(**wide))
    high = standing(ground(heights / 0.19 * 0.21, cell=0.1), point(**wide))
    assert low.share == 0.0
    expected = np.zeros((40, 60), np.uint8)
    expected[:, 29:31] = STEP
    assert_array_equal(high.reason, expected)
    assert high.step.max() == pytest.approx(0.21, abs=1e-6)


def test_a_spike_is_a_step() -> None:
    heights = np.zeros((9, 9))
    heights[4, 4] = 0.3
    result = standing(ground(heights, cell=0.1), point(footing=5.0))
    expected = np.zeros((9, 9), np.uint8)
    expected[3:6, 3:6] = STEP
    assert_array_equal(result.reason, expected)


def test_noise_of_single_posts_is_no_slope() -> None:
    heights = np.random.default_rng(1).normal(0.0, 0.025, (60, 60))
    terrain = ground(heights, cell=0.05)
    assert standing(terrain, point(footing=0.1)).share > 0.1
    assert standing(terrain, point(footing=0.5)).share == 0.0


def test_gentle_ground_on_far_posts_has_no_steps() -> None:
    terrain = plane(0.2, 0.1, cell=20.0)
    assert standing(terrain, read_rover("paper-point")).share == 0.0


def test_missing_ground_is_blocked_with_its_surroundings() -> None:
    heights = np.zeros((7, 7))
    heights[3, 3] = np.nan
    result = standing(ground(heights, cell=1.0), point())
    expected = np.zeros((7, 7), np.uint8)
    expected[2:5, 2:5] = NO_DATA
    assert_array_equal(result.reason, expected)
    assert np.isnan(result.slope[3, 3])
    assert np.isnan(result.step[3, 3])


def test_reasons_have_their_order() -> None:
    heights = np.zeros((6, 9))
    heights[:, 4:] = 5.0
    heights[0, 4] = np.nan
    reason = standing(ground(heights, cell=1.0), robot()).reason
    assert reason[0, 4] == NO_DATA
    assert reason[4, 4] == SLOPE
    assert standing(ground(heights, cell=1.0), robot(max_slope=1.3)).reason[4, 4] == STEP


def test_blocked_ground_grows_by_the_rovers_radius_exactly() -> None:
    heights = np.zeros((21, 25))
    heights[10, 12] = 1.0  # the radius of 0.5 m is five cells
    wide = robot(length=0.8, width=0.6, wheel_radius=0.0, footing=9.0)
    reason = standing(ground(heights, cell=0.1), wide).reason
    i, j = np.indices(heights.shape)
    spike = (abs(i - 10) <= 1) & (abs(j - 12) <= 1)
    away = np.hypot(np.maximum(abs(i - 10) - 1, 0), np.maximum(abs(j - 12) - 1, 0))
    expected = np.where(spike, STEP, np.where(away <= 5, NEAR, FREE))
    assert_array_equal(reason, expected)


@pytest.mark.kernels
@pytest.mark.parametrize("seed", range(4))
def test_growth_equals_all_pairs(seed: int) -> None:
    rng = np.random.default_rng(seed)
    terrain = ground(rough(rng, (9, 13), 0.02) * 0.1, cell=0.3)
    bare = standing(terrain, point(footing=0.5, max_step=0.25)).reason
    grown = standing(terrain, robot(footing=0.5, max_step=0.25, wheel_radius=0.0)).reason
    radius = math.hypot(0.5, 0.4) / 2
    bad = np.argwhere(bare != FREE)
    for i, j in np.ndindex(bare.shape):
        gap = 0.3 * min((math.hypot(i - a, j - b) for a, b in bad), default=math.inf)
        expected = bare[i, j] or (NEAR if gap <= radius else FREE)
        assert grown[i, j] == expected


def test_shares_add_up() -> None:
    terrain = ground(rough(np.random.default_rng(3), (30, 30), 0.01) * 0.05, cell=0.1)
    result = standing(terrain, robot())
    shares = result.share_by_reason()
    assert list(shares) == ["free", "no_data", "slope", "step", "near"]
    assert sum(shares.values()) == pytest.approx(1.0, abs=1e-12)
    assert 1.0 - shares["free"] == pytest.approx(result.share, abs=1e-12)


def test_a_careful_rover_stands_nowhere_that_a_bold_one_cannot() -> None:
    terrain = ground(rough(np.random.default_rng(8), (40, 40)) * 0.05, cell=0.1)
    bold = standing(terrain, robot()).blocked
    for careful in (robot(max_slope=0.1), robot(max_step=0.02), robot(length=1.5, footing=0.5)):
        assert (standing(terrain, careful).blocked >= bold).all()
