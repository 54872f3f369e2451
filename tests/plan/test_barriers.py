"""Why there is no way: the layer, the number, the place."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from rovernav import plan
from rovernav.plan._barriers import _joined
from rovernav.rover import Rover, hazards
from tests.plan.slopes import rover, terrain_of

ENDS = ((3.0, 20.0), (56.0, 20.0))


def over(heights: np.ndarray, who: Rover | None = None) -> plan.Going:
    who = who or rover()
    ground = terrain_of(heights)
    return plan.going(hazards(ground, who, soil="bedrock"), who)


def ridge(height: float, *, gap: float | None = None) -> np.ndarray:
    """A ridge from south to north across the middle, lower in a gap."""
    x, y = np.meshgrid(np.arange(60.0), np.arange(40.0))
    top = np.full(y.shape, height)
    if gap is not None:
        top[10:20] = gap
    return top * np.exp(-((x - 30.0) ** 2) / 3.0**2)


def test_a_steep_ridge_names_slope_and_the_number_opens_a_way() -> None:
    ground = over(ridge(6.0))
    trip = plan.travel(ground, ENDS)
    assert trip.status == "unreachable"
    barrier = next(b for b in trip.barriers if b.limit == "slope")
    assert barrier.now == rover().max_slope < barrier.needed
    assert barrier.at is not None
    assert abs(barrier.at[0] - 30.0) < 6.0
    assert f"to {math.degrees(barrier.needed):.2f} deg, hardest at" in trip.reason
    for factor, opens in ((1.001, True), (0.99, False)):
        slack = dataclasses.replace(rover(), max_slope=barrier.needed * factor)
        free = hazards(terrain_of(ridge(6.0)), slack, soil="bedrock").blocked == 0
        assert _joined(free, (20, 3), (20, 56)) is opens


def test_the_way_that_would_open_leads_through_the_gap() -> None:
    trip = plan.travel(over(ridge(7.0, gap=4.5)), ENDS)
    barrier = next(b for b in trip.barriers if b.limit == "slope")
    assert barrier.at is not None
    assert 9.0 <= barrier.at[1] <= 21.0


def test_a_river_of_no_data_is_named() -> None:
    heights = ridge(0.01)
    heights[:, 28:32] = np.nan
    trip = plan.travel(over(heights), ENDS)
    assert [b.limit for b in trip.barriers] == ["no data"]
    assert "ground without data" in trip.reason
    assert trip.nearest is not None
    assert 20.0 < trip.nearest[0] < 28.0


def test_slope_and_no_data_together_have_no_single_remedy() -> None:
    heights = ridge(9.0)
    heights[:, 10:13] = np.nan
    trip = plan.travel(over(heights), ENDS)
    assert not trip.found
    assert trip.barriers == ()


@pytest.mark.parametrize(
    ("start", "words"),
    [((-2.0, 3.0), "lies beyond the map"), ((30.0, 20.0), "touches forbidden ground")],
)
def test_bad_starts_are_answers(start: tuple[float, float], words: str) -> None:
    heights = ridge(0.01)
    heights[18:23, 28:33] = np.nan
    trip = plan.travel(over(heights), [start, ENDS[1]])
    assert trip.status == "unreachable"
    assert words in trip.reason


@pytest.mark.parametrize(
    ("spoilt", "words"),
    [
        (np.nan, "; a height is missing there"),
        (9.0, " deg steep there, and "),
    ],
)
def test_what_forbids_an_end_is_said(spoilt: float, words: str) -> None:
    heights = np.zeros((40, 60))
    heights[18:23, 28:33] = spoilt
    for stops in ([(30.5, 18.5), ENDS[1]], [ENDS[1], (30.5, 18.5)]):
        trip = plan.travel(over(heights), stops)
        assert words in trip.legs[0].reason


def test_a_zone_that_forbids_an_end_is_said() -> None:
    import shapely

    zones = plan.Zones(avoid=shapely.box(28.0, 18.0, 32.0, 22.0))
    ground = plan.within_zones(over(np.zeros((40, 60))), zones)
    trip = plan.travel(ground, [(28.0, 20.0), ENDS[1]])
    assert trip.legs[0].reason.endswith(" away; a zone forbids it")


def test_later_legs_are_told_by_number() -> None:
    trip = plan.travel(over(ridge(6.0)), [(3.0, 3.0), *ENDS])
    assert trip.failed == 1
    assert trip.reason.startswith("leg 2: ")
    assert len(trip.account()) == 1
    assert trip.points.shape == (0, 2)
