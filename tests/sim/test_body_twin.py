"""A body's step against a plain one: other formulas, small steps, Newton's method, shapely."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
import shapely
from numpy.testing import assert_allclose
from shapely.geometry import Polygon

from rovernav.core import Command, Mission, Outcome, RoverState
from rovernav.kernels.footprint import along_arc
from rovernav.rover import Rover, Steering, read_rover, read_soil, surface
from rovernav.sim import Body, Ground, Shape, Worlds
from tests.naive import body as naive
from tests.rover.rough_ground import poses, rough_ground

RESEARCH = dataclasses.replace(read_rover("research"), speed=0.6, turn_rate=0.8)
MARS = dataclasses.replace(read_rover("perseverance"), speed=0.6, turn_rate=0.8)


def with_steering(rover: Rover, kind: Any, **more: Any) -> Rover:
    return dataclasses.replace(rover, steering=Steering(kind=kind, **more))


CARS = {
    "skid": RESEARCH,
    "skid-limited": with_steering(RESEARCH, "skid", wheel_speed=0.4),
    "four": with_steering(RESEARCH, "ackermann", max_steer=math.radians(35.0)),
    "six": with_steering(MARS, "ackermann", max_steer=math.radians(60.0)),
    "crab": with_steering(MARS, "crab", max_steer=math.radians(50.0), wheel_speed=0.5),
}


def at(start: Any, twist: Any) -> tuple[Mission, RoverState]:
    mission = Mission(
        start=np.array(start), goal=np.full((len(start), 2), 1e6), goal_radius=0.1, time_limit=1e6
    )
    return mission, dataclasses.replace(RoverState.at_start(mission), twist=np.array(twist))


@pytest.mark.kernels
@pytest.mark.parametrize("name", CARS)
def test_wheels_can_do_what_they_are_told(name: str) -> None:
    """What steering and motors leave of a command is possible, and all of it where that is."""
    rover, rng = dataclasses.replace(CARS[name], mobility=None), np.random.default_rng(0)
    commands = rng.uniform(-0.7, 0.7, (300, 3))
    _, state = at(np.zeros((300, 3)), np.zeros((300, 3)))
    twists = Body(rover, parts=1).step(state, Command(twist=commands)).twist
    fastest = rover.steering.wheel_speed or math.inf
    whole = 0
    for told, twist in zip(commands, twists, strict=True):
        assert naive.can(rover, twist), (told, twist)
        assert max(naive.rolling(rover, twist)) <= fastest + 1e-9
        assert abs(twist[2]) <= rover.turn_rate + 1e-12
        assert math.hypot(*twist[:2]) <= rover.speed + abs(twist[2]) * 1.2 + 1e-9
        possible = naive.can(rover, told) and max(naive.rolling(rover, told)) <= fastest
        if possible and math.hypot(*told[:2]) <= rover.speed and abs(told[2]) <= rover.turn_rate:
            assert_allclose(twist, told, atol=1e-12)
            whole += 1
    assert whole or name != "crab"


@pytest.mark.kernels
@pytest.mark.parametrize("name", ["skid", "six", "crab"])
def test_a_step_on_rough_ground_equals_its_twin(name: str) -> None:
    rover, rng = CARS[name], np.random.default_rng(1)
    soil = read_soil("loose-sand")
    terrain = rough_ground(2, slope=0.12, cell=0.1, cells=120)
    worlds = Worlds.single(
        ground=Ground(frame=terrain.frame, height=terrain.height, offset=3.0), rovers=6
    )
    wheel = surface(terrain, rover).wheel
    twist = {"skid": (0.3, 0, 0.2), "six": (0.3, 0.011, 0.2), "crab": (0.3, 0.1, 0.1)}[name]
    mission, state = at(poses(rng, terrain, 6, 3.0), np.zeros((6, 3)))
    body = Body(rover, period=0.5, soil=soil, parts=1)
    factor = rng.uniform(0.7, 1.3, (6, 2))
    before = body.place(worlds, mission, state)
    told = Command(twist=np.tile(np.array(twist, dtype=float), (6, 1)))
    after = body.move(worlds, mission, before, told, factor)
    for k in range(6):
        stands = naive.stand(wheel, 0.1, rover, before.pose[k])
        assert_allclose(before.attitude[k] - (3, 0, 0), stands, atol=2e-6)
        drives = after.twist[k]
        slip, side, power = naive.costs(rover, soil, stands, drives, factor[k])
        assert_allclose(after.slip[k], (slip, -side), atol=2e-3)  # nodes of the table
        ground = naive.over_the_map(before.attitude[k], drives, after.slip[k, 0], -after.slip[k, 1])
        there = naive.moved(before.pose[k], drives, after.slip[k, 0], ground, 0.5)
        assert_allclose(after.pose[k], there, atol=1e-7)
        assert after.energy[k] == pytest.approx(0.5 * power, rel=1e-5)
        assert after.odometry[k] == pytest.approx(math.dist(there[:2], before.pose[k, :2]))
        if after.outcome[k] == Outcome.DRIVING:
            stands = naive.stand(wheel, 0.1, rover, after.pose[k])
            assert_allclose(after.attitude[k] - (3, 0, 0), stands, atol=2e-6)


@pytest.mark.parametrize(("limit", "lag"), [(0.0, 0.6), (0.25, 0.05)])
def test_lag_and_limits_equal_their_twin(limit: float, lag: float) -> None:
    rover = dataclasses.replace(
        with_steering(RESEARCH, "skid", lag=lag, acceleration=limit), mobility=None
    )
    _, state = at([(0.0, 0.0, 0.0)], [(-0.1, 0.0, 0.0)])
    after = Body(rover, period=0.4, parts=1).step(state, Command(twist=np.array([[0.5, 0.0, 0.0]])))
    speed, mean = naive.follow(-0.1, 0.5, limit, lag, 0.4)
    assert after.twist[0, 0] == pytest.approx(speed, abs=1e-4)
    assert after.pose[0, 0] == pytest.approx(0.4 * mean, abs=1e-4)


def test_what_is_met_on_an_arc_is_met_where_shapely_says() -> None:
    """The first place on the arc at which the footprint touches, of a thousand drives."""
    rng = np.random.default_rng(7)
    n, rover = 1000, dataclasses.replace(RESEARCH, mobility=None, turn_rate=3.0)
    corners = [
        rng.uniform(-0.55, 0.55, 2) + rng.uniform(0.05, 0.3, (5, 1)) * np.stack(
            [np.cos(turn), np.sin(turn)], axis=1)
        for turn in np.sort(rng.uniform(0, 2 * math.pi, (n, 5)), axis=1)
    ]  # fmt: skip
    worlds = Worlds(
        boxes=np.empty((0, 4)), offsets=np.zeros(n + 1, np.int64), of=np.arange(n),
        bounds=np.tile([-9.0, -9.0, 9.0, 9.0], (n, 1)), shapes=_each(corners),
    )  # fmt: skip
    starts = np.column_stack([rng.uniform(-0.9, 0.9, (n, 2)), rng.uniform(-3, 3, n)])
    mission, state = at(starts, np.zeros((n, 3)))
    body = Body(rover, period=1.0, parts=1)
    placed = body.place(worlds, mission, state)
    twist = np.column_stack([rng.uniform(-0.6, 0.6, n), np.zeros(n), rng.uniform(-2, 2, n)])
    moved = body.move(worlds, mission, placed, Command(twist=twist), np.ones((n, 2)))
    counts = {"start": 0, "way": 0, "free": 0}
    for k in range(n):
        obstacle = shapely.make_valid(Polygon(corners[k]))
        if placed.outcome[k] == Outcome.COLLIDED:
            assert naive.footprint(rover, starts[k]).distance(obstacle) < 1e-9
            counts["start"] += 1
            continue
        assert naive.footprint(rover, starts[k]).distance(obstacle) > 0.0
        end = naive.footprint(rover, moved.pose[k])
        if moved.outcome[k] == Outcome.COLLIDED:
            assert end.distance(obstacle) <= 1.1e-3  # the bulge at most before it touches
            counts["way"] += 1
        assert end.intersection(obstacle).area < 1e-9
        share = np.linalg.norm(moved.pose[k, :2] - starts[k, :2])
        for t in np.linspace(0, 1, 50):
            x, y, a = along_arc(starts[k], twist[k], t)
            if math.dist((x, y), starts[k, :2]) > share:
                break
            assert naive.footprint(rover, (x, y, a)).intersection(obstacle).area < 1e-9
        counts["free"] += moved.outcome[k] == Outcome.DRIVING
    assert min(counts.values()) > 60, counts


def _each(corners: list[Any]) -> Any:
    from rovernav.sim import Shapes

    return Shapes.packed([[Shape.polygon(c)] for c in corners])
