"""How drives end, and where."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from rovernav.core import Frame, Outcome
from rovernav.sim import DifferentialDrive, Grid, Worlds, begin, simulate, tick
from tests.sim.drives import Always, drive, mission

FORWARD = Always(1.0, 0.0, 0.0)
WALL = (2.25, -1.0, 3.0, 1.0)


def test_a_collision_ends_at_the_contact_point() -> None:
    trace = simulate(drive(FORWARD, WALL))
    assert trace.ended() is Outcome.COLLIDED
    assert_array_equal(trace.path(), [[0, 0], [1, 0], [2, 0], [2.25, 0]])
    assert trace.steps[0] == 3
    assert trace.time[-1, 0] == 3.0
    assert trace.length[0] == 2.25


def test_a_slanted_step_ends_where_it_meets_a_corner() -> None:
    trace = simulate(drive(Always(4.0, 3.0, 0.0), (2.0, -1.0, 9.0, 1.5)))
    assert_allclose(trace.path(), [[0, 0], [2, 1.5]], rtol=0, atol=1e-15)
    assert trace.ended() is Outcome.COLLIDED


def test_a_step_does_not_jump_over_a_thin_wall() -> None:
    trace = simulate(drive(Always(9.0, 0.0, 0.0), (4.0, -5.0, 4.0, 5.0)))
    assert_array_equal(trace.path()[-1], [4, 0])


def test_a_blocked_cell_stops_like_a_box() -> None:
    blocked = np.zeros((8, 12), np.uint8)
    blocked[3, 5] = 1
    worlds = Worlds.single(grid=Grid(frame=Frame(cell=0.5, shape=(8, 12)), blocked=blocked))
    start = mission([[0.2, 1.75, 0.0]], (5.5, 1.75), limit=50.0)
    trace = simulate(drive(FORWARD, worlds=worlds, mission=start))
    assert trace.ended() is Outcome.COLLIDED
    assert_allclose(trace.path()[-1], (2.5, 1.75), rtol=0, atol=1e-15)


@pytest.mark.parametrize(
    ("start", "goal", "outcome"),
    [
        ((2.5, 0.0), (9.0, 9.0), Outcome.COLLIDED),  # in the wall
        ((2.25, 1.0), (9.0, 9.0), Outcome.COLLIDED),  # on its corner
        ((2.5, 0.0), (2.5, 0.0), Outcome.COLLIDED),  # the goal is in the wall too
        ((5.0, 5.0), (5.0, 5.0), Outcome.REACHED),
        ((5.0, 5.0), (5.0, 5.1), Outcome.REACHED),  # as far as the goal's radius
        ((-20.1, 0.0), (9.0, 9.0), Outcome.LEFT_MAP),
        ((-20.1, 0.0), (-20.1, 0.0), Outcome.LEFT_MAP),
    ],
)
def test_a_drive_can_end_before_it_begins(
    start: tuple[float, float], goal: tuple[float, float], outcome: Outcome
) -> None:
    trace = simulate(drive(FORWARD, WALL, starts=[(*start, 0.3)], goal=goal))
    assert trace.ended() is outcome
    assert trace.steps[0] == trace.length[0] == 0
    assert_array_equal(trace.path(), [start])
    assert trace.commands.shape == (0, 1, 3)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("axis", [0, 1])
def test_a_command_to_nowhere_loses_the_rover_where_it_stands(bad: float, axis: int) -> None:
    twist = np.zeros((2, 3))
    twist[1, axis] = bad
    starts = [(0.0, 0.0, 0.5), (1.0, 1.0, 0.5)]
    trace = simulate(drive(Always(*twist), WALL, starts=starts, limit=3.0))
    assert [trace.ended(0), trace.ended(1)] == [Outcome.TIMED_OUT, Outcome.LEFT_MAP]
    assert trace.steps.tolist() == [3, 1]
    assert_array_equal(trace.pose[-1], starts)
    assert_array_equal(trace.length, [0.0, 0.0])


@pytest.mark.parametrize("twist", [(math.nan, 0.0, 0.0), (0.1, 0.0, math.nan)])
def test_a_differential_drive_goes_nowhere_either(twist: tuple[float, float, float]) -> None:
    motion = DifferentialDrive(speed=1.0, turn_rate=1.0)
    trace = simulate(drive(Always(*twist), motion=motion))
    assert trace.ended() is Outcome.LEFT_MAP
    assert np.isfinite(trace.pose).all()


def test_the_edge_belongs_to_the_map() -> None:
    trace = simulate(drive(FORWARD, starts=[(18.0, 0.0, 0.0)], goal=(0.0, 9.0)))
    assert trace.ended() is Outcome.LEFT_MAP
    assert trace.path()[:, 0].tolist() == [18, 19, 20, 21]


def test_a_goal_off_the_map_is_not_reached() -> None:
    trace = simulate(drive(FORWARD, starts=[(18.0, 0.0, 0.0)], goal=(21.0, 0.0)))
    assert trace.ended() is Outcome.LEFT_MAP


def test_the_goals_radius_includes_its_edge() -> None:
    trace = simulate(drive(FORWARD, goal=(3.0, 0.1)))
    assert trace.ended() is Outcome.REACHED
    assert trace.steps[0] == 3


@pytest.mark.parametrize(("period", "limit", "steps"), [(1.0, 7.0, 7), (0.1, 6.0, 60), (2.0, 3, 2)])
def test_time_runs_out(period: float, limit: float, steps: int) -> None:
    trace = simulate(drive(Always(0.0, 0.0, 0.0), limit=limit, period=period))
    assert trace.ended() is Outcome.TIMED_OUT
    assert trace.steps[0] == steps
    assert trace.time[-1, 0] == pytest.approx(steps * period, abs=1e-9)


def test_a_goal_reached_at_the_last_moment_is_reached() -> None:
    assert simulate(drive(FORWARD, goal=(3.0, 0.0), limit=3.0)).ended() is Outcome.REACHED


def test_a_collision_comes_before_everything() -> None:
    behind = (3.0, -1.0, 30.0, 1.0)
    trace = simulate(drive(Always(25.0, 0.0, 0.0), behind, goal=(3.0, 0.0), limit=1.0))
    assert trace.ended() is Outcome.COLLIDED


def test_a_step_that_meets_something_beyond_the_edge_meets_it() -> None:
    trace = simulate(drive(Always(9.0, 0.0, 0.0), (21.0, -1.0, 22.0, 1.0), starts=[(18.0, 0, 0)]))
    assert trace.ended() is Outcome.COLLIDED
    assert_array_equal(trace.path()[-1], [21, 0])


def test_a_period_is_as_long_as_it_says() -> None:
    trace = simulate(drive(Always(1.0, 0.5, 9.0), goal=(2.0, 1.0), period=0.25))
    assert_array_equal(trace.path(), np.arange(9)[:, None] * [0.25, 0.125])
    assert_array_equal(trace.time[:, 0], np.arange(9) * 0.25)
    assert_array_equal(trace.pose[:, 0, 2], np.zeros(9))


def test_those_that_ended_stay_as_they_are_while_others_drive() -> None:
    starts = [(0.0, 0.0, 0.0), (0.0, 5.0, 0.0), (8.0, 0.0, 0.0), (-19.0, 0.0, math.pi)]
    set_up = drive(FORWARD, WALL, starts=starts, limit=12.0)
    trace = simulate(set_up)
    assert [trace.ended(k).label for k in range(4)] == [
        "collided", "timed_out", "reached", "left_map",
    ]  # fmt: skip
    assert trace.steps.tolist() == [3, 12, 2, 2]
    for k, steps in enumerate(trace.steps):
        assert_array_equal(trace.pose[steps:, k], np.tile(trace.pose[steps, k], (13 - steps, 1)))
        assert_array_equal(trace.time[steps:, k], np.full(13 - steps, float(steps)))
    assert_allclose(trace.length, [2.25, 12.0, 2.0, 2.0], rtol=0, atol=1e-12)


def test_further_ticks_change_nothing_once_all_have_ended() -> None:
    set_up = drive(FORWARD, WALL)
    state = begin(set_up, np.random.default_rng(0))
    for _ in range(3):
        state = tick(set_up, state)
    assert state.rovers.outcome.tolist() == [Outcome.COLLIDED]
    later = tick(set_up, tick(set_up, state))
    for name in ("time", "pose", "twist", "odometry", "outcome"):
        assert_array_equal(getattr(later.rovers, name), getattr(state.rovers, name))
    assert_array_equal(state.rovers.twist, np.zeros((1, 3)))
