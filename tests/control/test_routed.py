"""Routes meet drivers: through where the straight line is a trap, and round what was not mapped."""

from __future__ import annotations

import dataclasses
import itertools
import math
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from rovernav.control import (
    GoalSeeker,
    NeuralController,
    RouteFollower,
    SensedPlanner,
    check_controller,
    explain,
    shy,
)
from rovernav.core import Controller, Frame, Mission, Observation, Outcome, SettingError
from rovernav.learn import find_controller
from rovernav.mapping import LocalMap, LocalMapper
from rovernav.plan import CostMap, any_angle
from rovernav.sim import (
    DifferentialDrive,
    Drift,
    Drive,
    Grid,
    Odometry,
    RangeFan,
    Worlds,
    begin,
    simulate,
    tick,
)
from tests.control.observations import scanned

FRAME = Frame(cell=0.25, shape=(200, 240))
START, GOAL = (8.0, 25.0), (52.0, 25.0)


def bay(deep: float = 26.0) -> np.ndarray:
    """A bay, open to the west, across the straight line: a trap for who has no map of it."""
    y, x = (np.indices(FRAME.shape) + 0.5) * 0.25
    wall = (np.abs(x - 44.0) < 0.5) & (np.abs(y - 25.0) < 12.0)
    arms = (np.abs(np.abs(y - 25.0) - 12.0) < 0.5) & (x > 44.0 - deep) & (x < 44.5)
    return (wall | arms).astype(np.uint8)


def costs(blocked: np.ndarray) -> CostMap:
    return CostMap.of(1.0, FRAME, forbidden=blocked)


def planned(blocked: np.ndarray) -> np.ndarray:
    """A route that keeps away where it can."""
    return any_angle(shy(costs(blocked)), START, GOAL).points


def drive(controller: Controller, blocked: np.ndarray, *, sensors: Any = (), n: int = 1) -> Drive:
    fan = RangeFan(reach=6.0)
    start = np.tile([*START, 0.0], (n, 1))
    start[:, 1] += 0.5 * np.arange(n)
    mission = Mission(
        start=start, goal=np.tile(np.array(GOAL), (n, 1)), goal_radius=0.5, time_limit=400.0
    )
    return Drive(
        worlds=Worlds.single(grid=Grid(frame=FRAME, blocked=blocked), rovers=n),
        mission=mission,
        sensors=(fan, *sensors),
        controller=controller,
        motion=DifferentialDrive(speed=0.3, turn_rate=0.698, period=1.0),
        mapper=LocalMapper(fan.angles, reach=fan.reach),
    )


@pytest.mark.parametrize("name", ["goal-seeker", "planner", "neural"])
def test_with_a_route_a_driver_arrives_where_without_one_it_is_trapped(name: str) -> None:
    driver, blocked = find_controller(name), bay()
    alone = simulate(drive(driver, blocked), record="none")
    assert alone.ended() is not Outcome.REACHED
    routed = RouteFollower(driver, planned(blocked), ground=costs(blocked))
    trace = simulate(drive(routed, blocked), record="path")
    assert trace.ended() is Outcome.REACHED
    assert trace.length[0] < 1.1 * any_angle(costs(blocked), START, GOAL).length


@pytest.mark.parametrize("known", [True, False])
def test_a_route_that_is_blocked_by_what_nobody_mapped_is_planned_anew(known: bool) -> None:
    """With a map at first, and with nothing but what was sensed."""
    blocked = np.zeros(FRAME.shape, np.uint8)
    blocked[80:120, 100:104] = 1  # 10 m of wall across the straight line
    ground = costs(np.zeros_like(blocked)) if known else None
    routed = RouteFollower(GoalSeeker(), np.array([START, GOAL]), ground=ground)
    assert simulate(drive(GoalSeeker(), blocked), record="none").ended() is not Outcome.REACHED
    whole = drive(routed, blocked)
    state = begin(whole, np.random.default_rng(0))
    while state.rovers.driving.any():
        state = tick(whole, state)
    assert state.rovers.outcome[0] == Outcome.REACHED
    assert 1 <= state.controller.plans[0] < 30
    assert state.rovers.odometry[0] < 55.0


def test_a_free_route_is_never_planned_anew_and_followed_closely() -> None:
    corner = np.array([START, (20.0, 25.0), (20.0, 40.0), (52.0, 40.0), GOAL])
    whole = drive(RouteFollower(GoalSeeker(), corner, ahead=2.0), np.zeros(FRAME.shape, np.uint8))
    state, off = begin(whole, np.random.default_rng(0)), []
    while state.rovers.driving.any():
        state = tick(whole, state)
        x, y = state.rovers.pose[0, :2]
        ends = itertools.pairwise(corner)
        off.append(min(_to_piece(np.array([x, y]), a, b) for a, b in ends))
    assert state.rovers.outcome[0] == Outcome.REACHED
    assert state.controller.plans[0] == 0
    assert max(off) < 1.5


def _to_piece(p: np.ndarray, a: np.ndarray, b: np.ndarray) -> float:
    share = float(np.clip((p - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1))
    return math.dist(p, a + share * (b - a))


def test_a_follower_goes_by_where_it_thinks_it_is() -> None:
    drift = Odometry(Drift(scale=0.0, walk=0.0, turn=0.0, curl=0.004))
    routed = RouteFollower(GoalSeeker(), np.array([START, (30.0, 40.0), GOAL]))
    whole = drive(routed, np.zeros(FRAME.shape, np.uint8), sensors=(drift,))
    trace = simulate(whole, seed=2)
    told = trace.channels["estimate"][: trace.steps[0], 0]
    assert min(math.dist(p[:2], (30.0, 40.0)) for p in told) < 3.0  # it cuts the corner
    assert max(np.hypot(*(told[:, :2] - trace.pose[: len(told), 0, :2]).T)) > 0.3


def test_a_row_does_not_depend_on_its_batch() -> None:
    blocked = bay(14.0)
    routed = RouteFollower(SensedPlanner(), np.array([START, GOAL]), ground=costs(0 * blocked))
    three = simulate(drive(routed, blocked, n=3), record="path")
    whole = drive(routed, blocked, n=3)
    for k in (0, 2):
        part = slice(k, k + 1)
        mission = dataclasses.replace(
            whole.mission,
            **{name: getattr(whole.mission, name)[part] for name in ("start", "goal", "number")},
        )
        one = dataclasses.replace(whole.worlds, of=whole.worlds.of[part])
        alone = simulate(dataclasses.replace(whole, worlds=one, mission=mission), record="path")
        assert_array_equal(alone.pose[:, 0], three.pose[: len(alone.pose), k])


def located(n: int, rng: np.random.Generator) -> Observation:
    seen = scanned(n, rng)
    return dataclasses.replace(seen, pose=seen.map.pose)


@pytest.mark.parametrize("driver", [GoalSeeker(), SensedPlanner()], ids=lambda d: type(d).__name__)
def test_followers_keep_the_contract_of_a_controller(driver: Controller) -> None:
    check_controller(RouteFollower(driver, np.array([[0.0, 0], [15, 10], [25, 25]])), located)


def test_each_rover_has_its_own_route_by_its_number(rng: np.random.Generator) -> None:
    routes = [np.array([[0.0, 0.0], [0.0, 9.0]]), np.array([[0.0, 0.0], [9.0, 0.0]])]
    follower = RouteFollower(GoalSeeker(), routes, ahead=3.0)
    mission = Mission(
        start=np.zeros((2, 3)), goal=np.array([[9.0, 0.0], [0.0, 9.0]]), goal_radius=0.1,
        time_limit=9.0, number=np.array([1, 0]),
    )  # fmt: skip
    memory = follower.start(mission, rng)
    seen = Observation(
        goal=np.zeros((2, 2)), twist=np.zeros((2, 3)), channels={"beams": np.full((2, 49), 6.0)},
        pose=np.zeros((2, 3)),
    )  # fmt: skip
    command, after = follower.act(seen, memory)
    assert command.twist[0, 0] > 0.0  # rover 1 goes east, straight ahead
    assert command.twist[1, 2] > 0.0  # rover 0 turns north
    assert_array_equal(after.plans, [0, 0])


def test_why_names_the_route_and_the_drivers_reasons(rng: np.random.Generator) -> None:
    seen = located(1, rng)
    network = find_controller("neural")
    assert isinstance(network, NeuralController)
    follower = RouteFollower(network, np.array([[0.0, 0.0], [30.0, 0.0]]))
    mission = Mission(
        start=seen.pose, goal=np.array([[30.0, 0.0]]), goal_radius=0.1, time_limit=9.0
    )
    why = explain(follower, seen, follower.start(mission, rng))
    assert why.words[0].startswith("It follows a route of which")
    assert why.network is not None
    assert_allclose(why.command, follower.act(seen, follower.start(mission, rng))[0].twist[0])


def test_the_map_is_asked_towards_the_point_ahead(rng: np.random.Generator) -> None:
    class Keeps:
        """Remembers what it was shown."""

        def start(self, mission: Mission, rng: np.random.Generator) -> None:
            return

        def act(self, observation: Observation, memory: None) -> tuple[Any, None]:
            self.seen = observation
            return GoalSeeker().act(observation, None)

    driver, seen = Keeps(), located(1, rng)
    empty = dataclasses.replace(seen.map, cells=np.zeros_like(seen.map.cells))
    seen = dataclasses.replace(seen, map=empty)
    x, y = seen.pose[0, :2]
    route = np.array([[x, y], [x, y + 9.0], [x + 50.0, y + 9.0]])
    follower = RouteFollower(driver, route, ahead=3.0)
    mission = Mission(start=seen.pose, goal=route[-1:], goal_radius=0.1, time_limit=9.0)
    follower.act(seen, follower.start(mission, rng))
    assert isinstance(driver.seen.map, LocalMap)
    assert_allclose(driver.seen.map.goal, [[x, y + 3.0]])
    assert_allclose(np.hypot(*driver.seen.goal[0]), 3.0)
    expected = driver.seen.map.asked(64)["around"]
    assert_array_equal(driver.seen.channel("around"), expected)


BAD: list[tuple[Any, str]] = [
    (lambda: RouteFollower(GoalSeeker(), np.zeros((3, 3))), r"needs points \(k, 2\), got shape"),
    (lambda: RouteFollower(GoalSeeker(), np.empty((0, 2))), "needs points"),
    (lambda: RouteFollower(GoalSeeker(), np.array([[0.0, math.nan]])), "is not finite"),
    (lambda: RouteFollower(GoalSeeker(), np.zeros((2, 2)), ahead=0.0), "more than 0 m ahead"),
]


@pytest.mark.parametrize(("make", "message"), BAD)
def test_absurd_routes_are_refused(make: Any, message: str) -> None:
    with pytest.raises(SettingError, match=message):
        make()


def test_too_few_routes_and_rovers_that_do_not_know_where_they_are_are_told(
    rng: np.random.Generator,
) -> None:
    two = [np.zeros((2, 2)), np.ones((2, 2))]
    mission = Mission(
        start=np.zeros((3, 3)), goal=np.zeros((3, 2)), goal_radius=0.1, time_limit=9.0
    )
    with pytest.raises(SettingError, match="2 routes are for rovers 0 to 1"):
        RouteFollower(GoalSeeker(), two).start(mission, rng)
    follower = RouteFollower(GoalSeeker(), two[0])
    with pytest.raises(SettingError, match="knows where it is"):
        follower.act(scanned(3, rng), follower.start(mission, rng))
