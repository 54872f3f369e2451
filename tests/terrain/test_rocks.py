from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from rovernav.core import Frame, SettingError, ShapeError
from rovernav.terrain import Rocks, rock_cover, scatter_rocks, with_rocks
from tests.naive.rocks import raised
from tests.terrain.ground import ground

FRAME = Frame(cell=1.0, shape=(200, 300))


def strewn(seed: int = 1, abundance: float = 0.1, **settings: Any) -> Rocks:
    rng = np.random.default_rng(seed)
    given: dict[str, Any] = {"smallest": 0.1, "largest": 3.0, **settings}
    return scatter_rocks(FRAME, abundance, rng=rng, **given)


def expected_count(abundance: float, a: float, b: float) -> float:
    """The density integral by the midpoint rule."""
    q = 1.79 + 0.152 / abundance
    edges = np.geomspace(a, b, 20_001)
    d = np.sqrt(edges[1:] * edges[:-1])
    density = abundance * q * np.exp(-q * d) / (math.pi * d**2 / 4.0)
    return float((density * np.diff(edges)).sum()) * FRAME.extent[0] * FRAME.extent[1]


@pytest.mark.parametrize("abundance", [0.005, 0.05, 0.19, 0.4])
def test_counts_follow_the_law_in_every_size_class(abundance: float) -> None:
    rocks = strewn(11, abundance)
    edges = np.array([0.1, 0.12, 0.15, 0.2, 0.3, 0.5, 3.0])
    counts = np.histogram(rocks.diameter, edges)[0]
    mean = np.array([expected_count(abundance, a, b) for a, b in itertools.pairwise(edges)])
    chi_square = float((((counts - mean) ** 2) / mean).sum())
    assert chi_square < 22.5  # 6 classes: exceeded by chance once in a thousand
    assert counts.sum() == len(rocks)


@pytest.mark.parametrize("diameter", [0.1, 0.25, 0.5, 1.0])
def test_covered_area_follows_the_law(diameter: float) -> None:
    rocks = strewn(5, 0.1, largest=20.0)
    areas = np.pi / 4.0 * rocks.diameter[rocks.diameter >= diameter] ** 2
    ground_area = FRAME.extent[0] * FRAME.extent[1]
    four_sigma = 4.0 * math.sqrt(float((areas**2).sum())) / ground_area
    expected = 0.1 * math.exp(-(1.79 + 1.52) * diameter)
    assert rock_cover(diameter, 0.1) == pytest.approx(expected, rel=1e-12)
    assert float(areas.sum()) / ground_area == pytest.approx(expected, abs=four_sigma)


def test_rocks_lie_evenly_over_the_ground() -> None:
    rocks = strewn(2)
    for along, side in ((rocks.x, 300.0), (rocks.y, 200.0)):
        counts = np.histogram(along, 10, (0.0, side))[0]
        assert counts.sum() == len(rocks)
        mean = len(rocks) / 10
        assert float(((counts - mean) ** 2 / mean).sum()) < 27.9  # 9 degrees: once in a thousand
    assert_array_equal(rocks.height, rocks.diameter / 2)


def test_a_seed_gives_its_rocks() -> None:
    assert_array_equal(strewn(4).x, strewn(4).x)
    assert len(strewn(4)) != len(strewn(5))


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"abundance": 0.001}, "a share of the ground from 0.005 to 0.4, got 0.001$"),
        ({"abundance": 5.0}, "from 0.005 to 0.4, got 5; write 5 % as 0.05"),
        ({"abundance": math.nan}, "from 0.005 to 0.4, got nan"),
        ({"smallest": 0.0}, "positive diameter, got 0 m: towards 0 their number grows without"),
        ({"smallest": math.nan}, "positive diameter, got nan m"),
        ({"smallest": 4.0}, r"largest rock \(3 m\) must be finite and larger than the smallest"),
        ({"largest": math.inf}, "must be finite"),
        ({"smallest": 1e-5}, "rocks of 1e-05 m and more would lie on 300 x 200 m, more than 20,0"),
    ],
)
def test_settings_out_of_range(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(SettingError, match=message):
        strewn(**settings)


def rocks_of(*rows: tuple[float, float, float]) -> Rocks:
    x, y, diameter = np.array(rows).T
    return Rocks(x=x, y=y, diameter=diameter, height=diameter / 2)


def test_one_rock_is_half_an_ellipsoid_on_the_slope_below_it() -> None:
    i, j = np.indices((40, 40))
    below = ground(0.02 * j + 0.0 * i, cell=0.1)
    rock = with_rocks(below, rocks_of((2.05, 1.95, 1.0)))
    rise = rock.height - below.height
    d = np.hypot((j + 0.5) * 0.1 - 2.05, (i + 0.5) * 0.1 - 1.95)
    expected = np.where(d < 0.5, 0.5 * np.sqrt(np.maximum(0.0, 1.0 - (d / 0.5) ** 2)), 0.0)
    assert_allclose(rise, expected, rtol=0, atol=1e-6)
    assert rock.name == "test-rocks"


def test_a_rock_smaller_than_a_cell_raises_its_cell_whole() -> None:
    rise = with_rocks(ground(np.zeros((4, 4))), rocks_of((1.1, 2.9, 0.3))).height
    assert rise[2, 1] == np.float32(0.15)
    assert np.count_nonzero(rise) == 1


def test_the_highest_of_overlapping_rocks_counts_in_any_order() -> None:
    few = [(2.2, 2.2, 1.9), (3.0, 2.5, 2.5), (2.2, 2.3, 0.4)]
    flat = ground(np.zeros((6, 7)), cell=0.5)
    one, other = (with_rocks(flat, rocks_of(*r)).height for r in (few, few[::-1]))
    assert_array_equal(one, other)
    alone = [with_rocks(flat, rocks_of(r)).height for r in few]
    assert_array_equal(one, np.max(alone, axis=0))


def test_missing_ground_stays_missing_and_far_rocks_do_nothing() -> None:
    heights = np.zeros((4, 4))
    heights[1, 1] = np.nan
    rise = with_rocks(ground(heights), rocks_of((1.5, 1.5, 1.0), (-9.0, 2.0, 3.0), (9.0, 9.0, 1.0)))
    assert np.isnan(rise.height[1, 1])
    assert np.nansum(rise.height) == 0.0


@pytest.mark.kernels
@pytest.mark.parametrize("shape", [(3, 3), (5, 9)])
def test_rocks_equal_their_twin(shape: tuple[int, int]) -> None:
    rng = np.random.default_rng(shape[1])
    rows = np.stack([rng.uniform(-1, 6, 12), rng.uniform(-1, 4, 12), rng.uniform(0.2, 3, 12)], 1)
    rocks = rocks_of(*rows.tolist())
    got = with_rocks(ground(np.zeros(shape), cell=0.6), rocks).height
    columns = (rocks.x, rocks.y, rocks.diameter, rocks.height)
    assert_allclose(got, raised(columns, shape, 0.6), rtol=0, atol=1e-6)


@pytest.mark.parametrize(
    ("diameter", "x", "message"),
    [
        ([0.0], [1.0], "every rock needs a positive diameter"),
        ([1.0], [np.nan], "every rock needs finite coordinates"),
        ([1.0, 2.0], [1.0], r"four arrays of one shape \(n,\)"),
    ],
)
def test_rocks_that_cannot_be(diameter: list[float], x: list[float], message: str) -> None:
    size = np.array(diameter)
    with pytest.raises(ShapeError, match=message):
        Rocks(x=np.array(x), y=np.zeros(1), diameter=size, height=np.ones(len(size)))
