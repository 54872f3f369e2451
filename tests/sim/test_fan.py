from __future__ import annotations

import math

import numpy as np
import pytest

from rovernav.core import Command, Frame, Mission, RoverState, SettingError
from rovernav.sim import DifferentialDrive, Grid, RangeFan, Worlds


def at(x: float, y: float, heading: float, n: int = 1) -> RoverState:
    return RoverState.at_start(
        Mission(
            start=np.tile([x, y, heading], (n, 1)),
            goal=np.full((n, 2), 99.0),
            goal_radius=0.1,
            time_limit=9.0,
        )
    )


def test_a_beam_is_as_long_as_the_way_to_the_wall() -> None:
    fan = RangeFan(reach=10.0, beams=5, view=math.pi)
    wall = Worlds.single([(3.0, -50.0, 4.0, 50.0)])
    beams, _ = fan.read(wall, at(0.0, 0.0, 0.0), None)
    slanted = 3.0 / math.cos(math.pi / 4)
    np.testing.assert_allclose(beams[0], [10.0, slanted, 3.0, slanted, 10.0], rtol=1e-12)


def test_beams_run_from_right_to_left_of_the_heading() -> None:
    fan = RangeFan(reach=10.0, beams=3, view=math.pi)
    on_the_left = Worlds.single([(-1.0, 2.0, 1.0, 3.0)])
    np.testing.assert_allclose(fan.read(on_the_left, at(0, 0, 0), None)[0][0], [10, 10, 2])
    turned = fan.read(on_the_left, at(0, 0, math.pi / 2), None)[0][0]
    np.testing.assert_allclose(turned, [10, 2, 10], rtol=1e-12)


def test_a_beam_never_ends_before_or_behind_the_first_blocked_cell(
    rng: np.random.Generator,
) -> None:
    blocked = (rng.random((40, 40)) < 0.1).astype(np.uint8)
    grid = Grid(frame=Frame(cell=0.5, shape=(40, 40)), blocked=blocked)
    fan = RangeFan(reach=8.0, beams=37, view=2 * math.pi)
    for _ in range(20):
        x, y, heading = *rng.uniform(1, 19, 2).tolist(), rng.uniform(-3, 3)
        beams = fan.read(Worlds.single(grid=grid), at(x, y, heading), None)[0][0]
        for angle, length in zip(fan.angles + heading, beams, strict=True):
            along = np.arange(0.0, length - 1e-6, 0.01)
            rows = np.floor((y + along * math.sin(angle)) / 0.5).astype(int)
            columns = np.floor((x + along * math.cos(angle)) / 0.5).astype(int)
            inside = (rows >= 0) & (rows < 40) & (columns >= 0) & (columns < 40)
            assert not blocked[rows[inside], columns[inside]].any()
            if length < 8.0:
                row = math.floor((y + (length + 1e-6) * math.sin(angle)) / 0.5)
                column = math.floor((x + (length + 1e-6) * math.cos(angle)) / 0.5)
                near = blocked[max(row - 1, 0) : row + 2, max(column - 1, 0) : column + 2]
                assert near.any()


@pytest.mark.parametrize(
    ("what", "message"),
    [
        ({"reach": 0.0}, "reach farther than 0 m"),
        ({"reach": math.nan}, "reach farther than 0 m"),
        ({"reach": 1.0, "beams": 2}, "3 to 4096 beams"),
        ({"reach": 1.0, "view": 7.0}, "at most 360 deg"),
    ],
)
def test_absurd_fans_are_refused(what: dict[str, float], message: str) -> None:
    with pytest.raises(SettingError, match=message):
        RangeFan(**what)  # pyright: ignore[reportArgumentType]


def drive(v: float, w: float, *, period: float = 0.5, steps: int = 1) -> RoverState:
    motion = DifferentialDrive(speed=1.0, turn_rate=2.0, period=period)
    state = at(1.0, 2.0, 0.3)
    for _ in range(steps):
        state = motion.step(state, Command(twist=np.array([[v, 5.0, w]])))
    return state


def test_an_arc_is_exact_however_it_is_cut() -> None:
    whole, parts = drive(0.8, 1.1, period=1.0), drive(0.8, 1.1, period=0.001, steps=1000)
    np.testing.assert_allclose(whole.pose, parts.pose, atol=1e-9)
    radius, turned = 0.8 / 1.1, 1.1
    x = 1.0 + radius * (math.sin(0.3 + turned) - math.sin(0.3))
    y = 2.0 - radius * (math.cos(0.3 + turned) - math.cos(0.3))
    np.testing.assert_allclose(whole.pose[0], [x, y, 0.3 + turned], rtol=1e-12)


def test_commands_beyond_the_motors_are_limited_and_sideways_is_ignored() -> None:
    np.testing.assert_allclose(drive(9.0, -9.0).twist, [[1.0, 0.0, -2.0]])
    np.testing.assert_allclose(drive(0.5, 0.0).pose, [[1 + 0.25 * math.cos(0.3), 2 + 0.25 * math.sin(0.3), 0.3]])  # fmt: skip # noqa: E501


def test_headings_stay_within_half_a_turn() -> None:
    assert abs(drive(0.0, 2.0, steps=40).pose[0, 2]) <= math.pi


def test_time_and_odometry_count() -> None:
    state = drive(0.5, 0.0, steps=4)
    assert state.time[0] == pytest.approx(2.0)
    assert state.odometry[0] == pytest.approx(1.0)


@pytest.mark.parametrize("what", ["speed", "turn_rate", "period"])
def test_absurd_motors_are_refused(what: str) -> None:
    numbers = {"speed": 1.0, "turn_rate": 1.0, "period": 1.0, what: 0.0}
    with pytest.raises(SettingError, match=f"needs a {what.replace('_', ' ')} above 0"):
        DifferentialDrive(**numbers)
