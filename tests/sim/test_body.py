"""A rover with a body: what it can do, what it costs, and how its drives end."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from rovernav.core import Command, Frame, Mission, Outcome, RoverState, SettingError
from rovernav.rover import Rover, Steering, drive_cost, drive_table, read_rover
from rovernav.sim import (
    Body,
    DifferentialDrive,
    Drive,
    Grid,
    Ground,
    Rocks,
    Shape,
    Trace,
    TwoAxis,
    Worlds,
    replay,
    simulate,
)
from tests.bits import assert_same_bits
from tests.rover.rough_ground import rough_ground
from tests.sim.drives import Always, mission

RESEARCH, MARS = read_rover("research"), read_rover("perseverance")
BARE = dataclasses.replace(RESEARCH, mobility=None)
FIELDS = ("time", "pose", "attitude", "slip", "energy", "outcome", "steps", "length")


def plane(along: float, across: float = 0.0, *, side: float = 12.0, cell: float = 0.1) -> Ground:
    """Ground that rises by so much for each metre to the east and the north."""
    n = round(side / cell)
    at = (np.arange(n) + 0.5) * cell
    height = (along * at[None, :] + across * at[:, None]).astype(np.float32)
    return Ground(frame=Frame(cell=cell, shape=(n, n)), height=height)


def on(  # noqa: PLR0913
    ground: Ground | None,
    rover: Rover = RESEARCH,
    *,
    twist: Any = (0.3, 0.0, 0.0),
    start: Any = ((3.0, 6.0, 0.0),),
    limit: float = 10.0,
    goal: Any = (50.0, 50.0),
    worlds: Worlds | None = None,
    **body: Any,
) -> Drive:
    n = len(start)
    settings: dict[str, Any] = {"period": 0.5, **body}
    return Drive(
        worlds=worlds or Worlds.single(ground=ground, rovers=n),
        mission=mission(start, goal, limit=limit),
        sensors=(),
        controller=Always(*twist),
        motion=Body(rover, **settings),
    )


def assert_same(a: Trace, b: Trace) -> None:
    for name in FIELDS:
        assert_same_bits(getattr(a, name), getattr(b, name))


# What a body does without anything that makes it a body


def test_without_soil_and_ground_it_moves_as_a_differential_drive_to_the_bit() -> None:
    rng = np.random.default_rng(0)
    state = RoverState.at_start(mission(rng.uniform(-3, 3, (200, 3)), (0, 0), limit=9.0))
    body = Body(BARE, parts=1, period=0.7)
    plain = DifferentialDrive(speed=BARE.speed, turn_rate=BARE.turn_rate, period=0.7)
    other = state
    for _ in range(5):
        command = Command(twist=rng.normal(size=(200, 3)))
        state, other = body.step(state, command), plain.step(other, command)
        for name in ("time", "pose", "twist", "odometry"):
            assert_same_bits(getattr(state, name), getattr(other, name))
    for name in ("attitude", "energy", "slip"):
        assert not getattr(state, name).any()


def test_the_papers_rover_moves_as_on_two_axes_to_the_bit() -> None:
    rng = np.random.default_rng(1)
    state = RoverState.at_start(mission(rng.uniform(-3, 3, (50, 3)), (0, 0), limit=9.0))
    command = Command(twist=0.8 * rng.uniform(-1, 1, (50, 3)))
    body, plain = Body(read_rover("paper-point"), period=1.0), TwoAxis(1.0)
    moved, other = body.step(state, command), plain.step(state, command)
    assert_same_bits(moved.pose, other.pose)
    assert_same_bits(moved.odometry, other.odometry)


# Steering and motors


def steered(kind: str, rover: Rover = MARS, **more: Any) -> Rover:
    steering = Steering(kind=kind, **more)  # type: ignore[arg-type]
    return dataclasses.replace(rover, steering=steering, mobility=None, speed=1.0, turn_rate=1.0)


def driven(rover: Rover, *twists: Any, period: float = 0.5) -> RoverState:
    state = RoverState.at_start(mission([(0.0, 0.0, 0.0)], (9, 9), limit=1e6))
    body = Body(rover, period=period, parts=1)
    for twist in twists:
        state = body.step(state, Command(twist=np.array([twist])))
    return state


def test_six_wheels_turn_about_their_middle_axle() -> None:
    twist = driven(steered("ackermann"), (0.5, 0.3, 0.1)).twist[0]
    assert_allclose(twist, (0.5, 0.1 * 0.055, 0.1), rtol=1e-15)


def test_four_wheels_turn_about_their_rear_axle() -> None:
    twist = driven(steered("ackermann", RESEARCH), (0.5, 0.0, 0.2)).twist[0]
    assert_allclose(twist, (0.5, 0.2 * 0.175, 0.2), rtol=1e-15)


def test_a_turn_too_tight_for_the_steering_becomes_the_tightest() -> None:
    rover = steered("ackermann", RESEARCH, max_steer=math.radians(30.0))
    u, _, w = driven(rover, (0.2, 0.0, 1.0)).twist[0]
    inner = math.atan(0.35 / (u / w - 0.17))
    assert u == 0.2
    assert inner == pytest.approx(math.radians(30.0), abs=1e-12)
    assert driven(rover, (0.0, 0.0, 1.0)).twist[0].tolist() == [0, 0, 0]


def test_corner_wheels_that_turn_far_enough_turn_on_the_spot() -> None:
    spot = driven(steered("ackermann", max_steer=math.radians(60.0)), (0.0, 0.0, 0.3))
    assert spot.twist[0, 2] == 0.3
    assert driven(steered("ackermann", max_steer=math.radians(40.0)), (0, 0, 0.3)).twist[0, 2] == 0


def test_a_crab_moves_sideways_within_its_speed_and_steering() -> None:
    side = driven(steered("crab"), (0.0, 0.5, 0.0))
    assert_allclose(side.pose[0], (0.0, 0.25, 0.0), atol=1e-15)
    fast = driven(steered("crab"), (3.0, 4.0, 0.0)).twist[0]
    assert_allclose(fast, (0.6, 0.8, 0.0), atol=1e-15)
    u, v, _ = driven(steered("crab", max_steer=math.radians(20.0)), (0.5, 0.5, 0.0)).twist[0]
    assert math.atan2(v, u) == pytest.approx(math.radians(20.0))


@pytest.mark.parametrize("kind", ["skid", "ackermann", "crab"])
def test_no_wheel_turns_faster_than_its_motor(kind: str) -> None:
    rover = steered(kind, wheel_speed=0.4)
    wheels = [(x, y) for x in (1.129, -0.055, -1.129) for y in (1.063, -1.063)]
    for twist in [(0.9, 0.2, 0.5), (0.3, 0.0, -0.4), (-1.0, 0.0, 0.1)]:
        u, v, w = driven(rover, twist).twist[0]
        speeds = [
            abs(u - w * y) if kind == "skid" else math.hypot(u - w * y, v + w * x)
            for x, y in wheels
        ]
        assert max(speeds) == pytest.approx(0.4)
        free = driven(steered(kind), twist).twist[0]
        assert_allclose(np.cross(free, (u, v, w)), 0.0, atol=1e-12)  # the same arc, slower


def test_speeds_follow_with_a_lag() -> None:
    rover = dataclasses.replace(BARE, steering=Steering(kind="skid", lag=0.8))
    one = driven(rover, *[(0.3, 0.0, 0.0)] * 4)
    assert one.twist[0, 0] == pytest.approx(0.3 * (1 - math.exp(-2.0 / 0.8)))
    assert one.pose[0, 0] == pytest.approx(0.3 * (2.0 - 0.8 * (1 - math.exp(-2.0 / 0.8))))
    whole = driven(rover, (0.3, 0.0, 0.0), period=2.0)  # exact, however long a step
    assert_allclose(whole.pose, one.pose, rtol=1e-12)


def test_speeds_change_no_faster_than_the_motors_can() -> None:
    steering = Steering(kind="skid", acceleration=0.1, turn_acceleration=0.05)
    state = driven(dataclasses.replace(BARE, steering=steering), *[(0.3, 0.0, 0.5)] * 4)
    assert_allclose(state.twist[0], (0.2, 0.0, 0.1), rtol=1e-12)
    assert state.odometry[0] == pytest.approx(0.5 * 0.1 * 4.0, rel=1e-3)


# Slip and energy


@pytest.mark.parametrize("degrees", [-12.0, -3.0, 0.0, 4.0, 11.0])
@pytest.mark.parametrize("rover", [RESEARCH, MARS])
def test_a_straight_drive_costs_what_drive_cost_says(rover: Rover, degrees: float) -> None:
    rise = math.tan(math.radians(degrees))
    set_up = on(plane(rise), rover, twist=(rover.speed, 0, 0), period=2.0, limit=26.0)
    trace = simulate(set_up)
    cost = drive_cost(rise, 0.0, 0.0, drive_table(rover))
    assert trace.ended() is Outcome.TIMED_OUT
    assert trace.energy is not None
    assert trace.slip is not None
    assert trace.attitude is not None
    assert trace.energy[-1, 0] / trace.length[0] == pytest.approx(float(cost.energy), rel=1e-5)
    assert 26.0 / trace.length[0] == pytest.approx(float(cost.time), rel=1e-5)
    assert trace.slip[-1, 0, 0] == pytest.approx(float(cost.slip), abs=1e-5)
    assert trace.attitude[-1, 0, 1] == pytest.approx(math.radians(degrees), abs=1e-5)


def test_a_side_slope_carries_the_rover_downhill() -> None:
    rise = math.tan(math.radians(8.0))
    trace = simulate(on(plane(0.0, rise), limit=10.0))
    cost = drive_cost(0.0, rise, 0.0, drive_table(RESEARCH))
    dx, dy = trace.pose[-1, 0, :2] - trace.pose[0, 0, :2]
    assert float(cost.side_slip) > 0.0
    assert dy / dx == pytest.approx(
        -float(cost.side_slip) * math.cos(math.radians(8.0)) / (1.0 - float(cost.slip)), rel=1e-4
    )


def test_soils_differ_and_wheels_may_be_told_not_to_slip() -> None:
    def way(**body: Any) -> float:
        return float(simulate(on(plane(0.15), **body)).length[0])

    assert way(soil="loose-sand") < 0.9 * way() < way(slip="none")
    assert way(slip="none") == pytest.approx(3.0 / math.hypot(1.0, 0.15), rel=1e-5)
    assert way(slip="high") < way() < way(slip="low")


def test_motors_without_power_climb_slowly() -> None:
    assert MARS.mobility is not None
    weak = dataclasses.replace(MARS, mobility=dataclasses.replace(MARS.mobility, drive_power=60.0))
    trace = simulate(on(plane(0.2), weak, twist=(0.042, 0, 0), period=2.0, limit=30.0))
    cost = drive_cost(0.2, 0.0, 0.0, drive_table(weak))
    assert trace.energy is not None
    assert trace.energy[-1, 0] == pytest.approx(30.0 * (60.0 + 150.0), rel=1e-9)
    assert trace.energy[-1, 0] / trace.length[0] == pytest.approx(float(cost.energy), rel=1e-5)


def test_energy_is_never_won_back() -> None:
    terrain = rough_ground(3, slope=0.15)
    ground = Ground(frame=terrain.frame, height=terrain.height)
    starts = [(8.0, 8.0, a) for a in np.linspace(-3, 3, 16)]
    trace = simulate(on(ground, start=starts, twist=(0.3, 0.0, 0.1), limit=30.0))
    assert trace.energy is not None
    spent = np.diff(trace.energy, axis=0)
    assert (spent >= 0.0).all()
    assert (spent[0] >= 0.5 * 15.0 * 0.99).all()  # the idle power at least


def test_each_rovers_luck_is_its_own() -> None:
    starts = [(3.0, 1.0 + k, 0.0) for k in range(10)]
    traces = {
        (seed, spread): simulate(on(plane(0.15), start=starts, spread=spread), seed=seed)
        for seed, spread in [(0, 0.3), (1, 0.3), (0, 0.0)]
    }
    one, other, none = traces.values()
    assert one.slip is not None
    assert other.slip is not None
    assert none.slip is not None
    share = one.slip[-1, :, 0] / none.slip[-1, :, 0]
    assert 0.7 <= share.min() < 0.9 < 1.1 < share.max() <= 1.3
    assert (one.slip[-1] != other.slip[-1]).any()


# Ends


def wall(**more: Any) -> Worlds:
    return Worlds.single([(5.0, 0.0, 5.1, 12.0)], bounds=(0, 0, 12, 12), **more)


def test_the_footprint_stops_at_a_wall_not_the_middle() -> None:
    trace = simulate(on(None, worlds=wall()))
    assert trace.ended() is Outcome.COLLIDED
    assert trace.pose[-1, 0, 0] == pytest.approx(5.0 - 0.25, abs=1e-6)


def test_a_thin_wall_is_not_jumped_over() -> None:
    fast = dataclasses.replace(BARE, speed=9.0)
    trace = simulate(on(None, fast, worlds=wall(), twist=(9.0, 0, 0), period=1.0, parts=1))
    assert trace.ended() is Outcome.COLLIDED
    assert trace.pose[-1, 0, 0] == pytest.approx(4.75, abs=1e-6)


def test_a_corner_is_hit_by_turning_on_the_spot() -> None:
    worlds = Worlds.single([(3.2, 6.21, 3.3, 6.3)], bounds=(0, 0, 12, 12))
    free = simulate(on(None, worlds=worlds, twist=(0.3, 0, 0), limit=3.0))
    assert free.ended() is Outcome.TIMED_OUT
    turning = simulate(on(None, worlds=worlds, twist=(0, 0, 0.5)))
    assert turning.ended() is Outcome.COLLIDED
    assert turning.length[0] == 0.0


def test_shapes_and_grids_stop_the_footprint_too() -> None:
    blocked = np.zeros((24, 24), np.uint8)
    blocked[12, 10] = 1
    for worlds in (
        Worlds.single(shapes=[Shape.disc(5.5, 6.0, 0.5)]),
        Worlds.single(grid=Grid(frame=Frame(cell=0.5, shape=(24, 24)), blocked=blocked)),
    ):
        trace = simulate(on(None, worlds=worlds))
        assert trace.ended() is Outcome.COLLIDED
        assert trace.pose[-1, 0, 0] == pytest.approx(4.75, abs=2e-2)
    seen = simulate(on(None, worlds=worlds, grid=False))
    assert seen.ended() is Outcome.TIMED_OUT


def test_a_rock_blocks_under_a_wheel_or_under_the_belly() -> None:
    """Wheels climb 0.1 m and run at y = 0.17 m, 0.06 m wide; the belly is 0.1 m high."""
    tall = dataclasses.replace(BARE, max_step=0.15)  # climbs more than fits under its belly

    def end(rover: Rover, y: float, high: float) -> Outcome:
        rocks = [(4.5, 6.0 + y, 0.02, high)]
        if high <= rover.max_step:
            rocks = [(4.5, 6.0 + y, 0.1, high)]
        worlds = Worlds.single(ground=plane(0.0), rocks=rocks)
        return simulate(on(None, rover, worlds=worlds)).ended()

    assert end(BARE, 0.17, 0.12) is Outcome.COLLIDED
    assert end(BARE, 0.0, 0.12) is Outcome.COLLIDED
    low = dataclasses.replace(BARE, max_step=0.05)
    assert end(low, 0.17, 0.08) is Outcome.COLLIDED
    assert end(low, 0.0, 0.08) is Outcome.TIMED_OUT  # passes under the belly
    assert end(tall, 0.0, 0.12) is Outcome.COLLIDED
    assert end(tall, 1.0, 0.12) is Outcome.TIMED_OUT


def test_a_low_rock_tilts_the_rover() -> None:
    worlds = Worlds.single(ground=plane(0.0, cell=0.05), rocks=[(4.5, 6.17, 0.2, 0.08)])
    trace = simulate(on(None, BARE, worlds=worlds))
    assert trace.ended() is Outcome.TIMED_OUT
    assert trace.attitude is not None
    assert np.abs(trace.attitude[:, 0, 2]).max() > math.radians(3.0)


def test_rocks_finer_than_the_ground_are_refused_and_finer_ground_takes_them() -> None:
    coarse = plane(0.0, cell=0.5)
    rocks = [(4.5, 6.17, 0.2, 0.08)]
    message = r"rocks of 0.4 m are too small for ground with cells of 0.5 m: .*Ground.finer"
    with pytest.raises(SettingError, match=message):
        simulate(on(None, BARE, worlds=Worlds.single(ground=coarse, rocks=rocks)))
    fine = Worlds.single(ground=coarse.finer(5), rocks=rocks)
    trace = simulate(on(None, BARE, worlds=fine))
    assert trace.attitude is not None
    assert np.abs(trace.attitude[:, 0, 2]).max() > math.radians(2.0)
    with pytest.raises(SettingError, match="need ground to stand on"):
        simulate(on(None, BARE, worlds=Worlds.single(rocks=rocks)))


def test_finer_ground_is_the_same_ground() -> None:
    ground = plane(0.3, -0.2, cell=0.5)
    fine = ground.finer(4)
    assert fine.frame.extent == ground.frame.extent
    inner = plane(0.3, -0.2, cell=0.125).height[2:-2, 2:-2]
    assert_allclose(fine.height[2:-2, 2:-2], inner, atol=1e-6)
    with pytest.raises(SettingError, match="1 to 100 times finer, got 0"):
        ground.finer(0)


def test_too_steep_a_slope_tips_it() -> None:
    n = 120
    at = (np.arange(n) + 0.5) * 0.1
    height = (at[:, None] - 6.0) * np.maximum(at - 4.0, 0.0) * 0.3  # ever steeper to the side
    ground = Ground(frame=Frame(cell=0.1, shape=(n, n)), height=height.astype(np.float32))
    trace = simulate(on(ground, BARE, limit=60.0))
    assert trace.ended() is Outcome.TIPPED
    assert trace.attitude is not None
    before, after = trace.attitude[-2:, 0, 2]
    assert before < math.radians(45.0) < after


def ridge(high: float, wide: float) -> Ground:
    ground = plane(0.0, cell=0.02, side=8.0)
    at = (np.arange(400) + 0.5) * 0.02
    bump = high * np.maximum(0.0, 1.0 - np.abs(at - 4.0) / wide)
    return dataclasses.replace(ground, height=np.tile(bump, (400, 1)).astype(np.float32))


def test_a_ridge_higher_than_the_belly_high_centres_it() -> None:
    climbs = dataclasses.replace(BARE, max_slope=math.radians(60.0), max_step=0.3)
    trace = simulate(on(ridge(0.16, 0.15), climbs, start=((3.0, 4.0, 0.0),)))
    assert trace.ended() is Outcome.HIGH_CENTRED
    passed = simulate(on(ridge(0.06, 0.15), climbs, start=((3.0, 4.0, 0.0),)))
    assert passed.ended() is Outcome.TIMED_OUT


def cliff(drop: float) -> Ground:
    ground = plane(0.0, cell=0.05)
    height = ground.height.copy()
    height[:, 120:] -= drop
    return dataclasses.replace(ground, height=height)


def test_cliffs_are_not_climbed_and_holes_are_fallen_into() -> None:
    up = simulate(on(cliff(-0.5), BARE, limit=30.0))
    assert up.ended() is Outcome.COLLIDED
    assert 5.7 < up.pose[-1, 0, 0] + 0.25 < 6.15
    down = simulate(on(cliff(0.5), BARE, limit=30.0))
    assert down.ended() in (Outcome.TIPPED, Outcome.HIGH_CENTRED)
    assert down.pose[-1, 0, 0] + 0.25 > 5.9
    small = simulate(on(cliff(0.05), BARE, limit=15.0))
    assert small.ended() is Outcome.TIMED_OUT


def test_slip_of_all_its_way_leaves_it_stuck() -> None:
    trace = simulate(on(plane(math.tan(math.radians(26.0))), soil="loose-sand", limit=60.0))
    assert trace.ended() is Outcome.STUCK
    assert trace.time[-1, 0] == pytest.approx(2 * 0.35 / 0.3, abs=0.5)
    assert trace.length[0] < 0.05 * 2 * 0.35


@pytest.mark.parametrize(("share", "outcome"), [(0.049, Outcome.STUCK), (0.051, Outcome.DRIVING)])
def test_stuck_is_less_than_a_twentieth_of_two_wheel_bases(share: float, outcome: Outcome) -> None:
    """Commanded 0.69 m so far, and 0.15 m more on sand that holds all of it."""
    sand = on(plane(math.tan(math.radians(26.0))), soil="loose-sand", parts=1)
    body = sand.motion
    assert isinstance(body, Body)
    state = body.place(sand.worlds, sand.mission, RoverState.at_start(sand.mission))
    state = dataclasses.replace(state, stall=np.array([[0.69, 0.84 * share]]))
    told, whole = Command(twist=np.array([[0.3, 0.0, 0.0]])), np.full((1, 2), 9.0)
    after = body.move(sand.worlds, sand.mission, state, told, whole)
    assert after.outcome[0] == outcome
    early = dataclasses.replace(state, stall=np.array([[0.5, 0.0]]))
    assert body.move(sand.worlds, sand.mission, early, told, whole).outcome[0] == Outcome.DRIVING


def test_the_goal_is_reached_within_its_radius() -> None:
    for far, outcome in ((0.0999, Outcome.REACHED), (0.1001, Outcome.TIMED_OUT)):
        trace = simulate(on(plane(0.0), twist=(0, 0, 0), goal=(3.0, 6.0 + far), limit=1.0))
        assert trace.ended() is outcome


def test_it_tips_at_its_static_tilt() -> None:
    def stands(degrees: float) -> Outcome:
        rise = math.tan(math.radians(degrees) + RESEARCH.chassis.static_tilt)  # type: ignore[union-attr]
        return simulate(on(plane(0.6 * rise, 0.8 * rise), limit=0.4)).ended()

    assert stands(0.1) is Outcome.TIPPED
    assert stands(-0.1) is not Outcome.TIPPED


def test_circles_and_waiting_are_not_being_stuck() -> None:
    circling = simulate(on(plane(0.0), start=((6.0, 6.0, 0.0),), twist=(0.1, 0, 0.6), limit=60.0))
    waiting = simulate(on(plane(0.0), twist=(0.0, 0, 0.0), limit=60.0))
    assert circling.ended() is waiting.ended() is Outcome.TIMED_OUT


def test_the_edge_of_the_ground_is_the_edge_of_the_map() -> None:
    trace = simulate(on(plane(0.0), start=((11.0, 6.0, 0.0),)))
    assert trace.ended() is Outcome.LEFT_MAP


def test_ground_that_is_not_known_cannot_be_stood_on() -> None:
    ground = plane(0.0)
    height = ground.height.copy()
    height[:, 60:70] = np.nan
    trace = simulate(on(dataclasses.replace(ground, height=height), limit=30.0))
    assert trace.ended() is Outcome.COLLIDED


def test_ends_come_at_the_start_too() -> None:
    steep = plane(1.5)
    starts = ((6.0, 6.0, 0.0), (11.99, 6.0, 0.0))
    trace = simulate(on(steep, start=starts))
    assert [trace.ended(k) for k in (0, 1)] == [Outcome.TIPPED, Outcome.LEFT_MAP]
    assert simulate(on(None, worlds=wall(), start=((4.8, 6, 0),))).ended() is Outcome.COLLIDED
    here = simulate(on(plane(0.0), goal=(3.0, 6.0)))
    assert here.ended() is Outcome.REACHED
    assert here.steps[0] == 0


def test_a_command_to_nowhere_loses_it_where_it_stands() -> None:
    trace = simulate(on(plane(0.0), twist=(math.nan, 0.0, 0.0)))
    assert trace.ended() is Outcome.LEFT_MAP
    assert_array_equal(trace.pose[-1], trace.pose[0])


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"period": 0.0}, "the period must be above 0 s"),
        ({"spread": 1.5}, "the spread of slip must lie in 0 to 1"),
        ({"parts": 0}, "a step has 1 to 1000 parts"),
        ({"soil": "loose-sandd"}, "did you mean 'loose-sand'"),
        ({"slip": "medium"}, "unknown slip 'medium'"),
    ],
)
def test_wrong_settings_are_refused(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(SettingError, match=message):
        Body(RESEARCH, **settings)


def test_a_rover_without_wheels_cannot_stand_on_ground() -> None:
    with pytest.raises(SettingError, match="has no wheels to set onto the ground"):
        simulate(on(plane(0.0), read_rover("paper-point")))


# Batches, replays, symmetry, convergence


def many(rovers: int = 24) -> Drive:
    """Rovers in three worlds with rocks, walls and ground of their own; all sorts of ends."""
    rng = np.random.default_rng(5)
    grounds = [rough_ground(k, slope=0.3 * k, cell=0.1, cells=80) for k in range(3)]
    height = np.stack([g.height + np.float32(g.offset) for g in grounds])
    rocks = np.column_stack(
        [rng.uniform(0, 8, (30, 2)), np.full(30, 0.15), rng.uniform(0.03, 0.3, 30)]
    )
    worlds = Worlds(
        boxes=np.array([[6.5, 0.0, 6.6, 8.0]]),
        offsets=np.array([0, 1, 1, 1]),
        bounds=np.tile([0.0, 0.0, 8.0, 8.0], (3, 1)),
        of=rng.integers(0, 3, rovers),
        ground=Ground(frame=grounds[0].frame, height=height),
        rocks=Rocks(place=rocks, offsets=np.array([0, 8, 20, 30])),
        shapes=None,
    )
    starts = np.column_stack([rng.uniform(1, 7, (rovers, 2)), rng.uniform(-3, 3, rovers)])
    twist = np.column_stack(
        [np.full(rovers, 0.3), np.zeros(rovers), rng.uniform(-0.2, 0.2, rovers)]
    )
    return Drive(
        worlds=worlds,
        mission=Mission(
            start=starts, goal=rng.uniform(1, 7, (rovers, 2)), goal_radius=0.5, time_limit=25.0
        ),
        sensors=(),
        controller=Always(*twist),
        motion=Body(RESEARCH, period=0.5, spread=0.3, soil="loose-sand"),
    )


def test_a_rover_alone_is_its_row_of_the_batch_to_the_bit() -> None:
    whole = many()
    trace = simulate(whole, seed=3)
    assert len({trace.ended(k) for k in range(24)}) >= 4
    for k in range(24):
        m = whole.mission
        alone = dataclasses.replace(
            whole,
            worlds=whole.worlds.row(k),
            mission=dataclasses.replace(
                m, start=m.start[k : k + 1], goal=m.goal[k : k + 1], number=m.number[k : k + 1]
            ),
            controller=Always(*whole.controller.twist[k : k + 1]),  # type: ignore[attr-defined]
        )
        one = simulate(alone, seed=3)
        steps = int(one.steps[0]) + 1
        for name in ("time", "pose", "attitude", "slip", "energy"):
            assert_same_bits(getattr(one, name)[:steps, 0], getattr(trace, name)[:steps, k])
        assert one.outcome[0] == trace.outcome[k]


def test_a_trace_replays_to_the_bit() -> None:
    trace = simulate(many(), seed=3)
    again = replay(trace, many())
    assert_same(again, trace)
    assert_same_bits(again.commands, trace.commands)
    other = dataclasses.replace(many(), mission=mission([(1, 1, 0)] * 24, (3, 3), limit=9.0))
    with pytest.raises(Exception, match="the trace is of other missions"):
        replay(trace, other)
    with pytest.raises(Exception, match='record the drive with record="all"'):
        replay(simulate(many(), record="path"), many())


def turned(ground: Ground, quarters: int) -> Ground:
    return dataclasses.replace(
        ground, height=np.ascontiguousarray(np.rot90(ground.height, -quarters))
    )


@pytest.mark.parametrize("quarters", [1, 2, 3])
@pytest.mark.parametrize("rover", [RESEARCH, MARS])
def test_a_turned_world_gives_the_turned_drive(rover: Rover, quarters: int) -> None:
    terrain = rough_ground(7, slope=0.1)
    ground = Ground(frame=terrain.frame, height=terrain.height)
    speed = 0.3
    rover = dataclasses.replace(rover, speed=speed, turn_rate=0.7)
    start, side = np.array([6.0, 7.0, 0.4]), ground.frame.extent[0]
    x, y = start[:2] - side / 2
    for _ in range(quarters):
        x, y = -y, x
    there = (x + side / 2, y + side / 2, start[2] + quarters * math.pi / 2)
    a = simulate(on(ground, rover, start=(start,), twist=(speed, 0, 0.1)))
    b = simulate(on(turned(ground, quarters), rover, start=(there,), twist=(speed, 0, 0.1)))
    path = a.path() - side / 2
    for _ in range(quarters):
        path = np.stack([-path[:, 1], path[:, 0]], axis=1)
    assert b.ended() is a.ended()
    assert_allclose(b.path(), path + side / 2, atol=1e-6)
    assert_allclose(b.attitude, a.attitude, atol=1e-5)  # type: ignore[arg-type]
    assert_allclose(b.energy, a.energy, rtol=1e-5)  # type: ignore[arg-type]


@pytest.mark.parametrize("rover", [RESEARCH, MARS])
def test_a_mirrored_world_gives_the_mirrored_drive(rover: Rover) -> None:
    terrain = rough_ground(8, slope=0.1)
    ground = Ground(frame=terrain.frame, height=terrain.height)
    mirrored = dataclasses.replace(ground, height=np.ascontiguousarray(ground.height[::-1]))
    rover = dataclasses.replace(rover, speed=0.3, turn_rate=0.7)
    side = ground.frame.extent[1]
    a = simulate(on(ground, rover, start=((6.0, 7.0, 0.4),), twist=(0.3, 0, 0.1)))
    b = simulate(on(mirrored, rover, start=((6.0, side - 7.0, -0.4),), twist=(0.3, 0, -0.1)))
    assert_allclose(b.path(), a.path() * (1, -1) + np.array([0.0, side]), atol=1e-6)
    assert_allclose(b.attitude, a.attitude * (1, 1, -1), atol=1e-5)  # type: ignore[operator]
    assert_allclose(b.energy, a.energy, rtol=1e-5)  # type: ignore[arg-type]


def test_a_shifted_world_gives_the_shifted_drive() -> None:
    terrain = rough_ground(9, slope=0.1)
    wide = np.pad(terrain.height, ((30, 0), (0, 0)), mode="edge")
    ground = Ground(frame=terrain.frame, height=terrain.height)
    lower = Ground(frame=Frame(cell=0.1, shape=wide.shape), height=wide)
    a = simulate(on(ground, start=((6.0, 7.0, 0.4),), twist=(0.3, 0, 0.1)))
    b = simulate(on(lower, start=((6.0, 10.0, 0.4),), twist=(0.3, 0, 0.1)))
    assert_allclose(b.path(), a.path() + np.array([0.0, 3.0]), atol=1e-9)
    assert_allclose(b.attitude, a.attitude, atol=1e-9)  # type: ignore[arg-type]


def test_finer_steps_converge() -> None:
    n = 120
    at = (np.arange(n) + 0.5) * 0.1
    hills = 0.25 * np.sin(at[None, :]) + 0.2 * np.cos(0.8 * at[:, None])
    ground = Ground(frame=Frame(cell=0.1, shape=(n, n)), height=hills.astype(np.float32))
    lazy = dataclasses.replace(RESEARCH, steering=Steering(kind="skid", lag=0.7))

    def end(parts: int) -> Any:
        trace = simulate(on(ground, lazy, twist=(0.3, 0, 0.15), period=1.0, parts=parts))
        assert trace.energy is not None
        return np.append(trace.pose[-1, 0], trace.energy[-1, 0] / 100.0)

    exact = end(256)
    errors = [np.abs(end(parts) - exact).max() for parts in (1, 4, 16)]
    assert errors[0] > 3.0 * errors[1] > 9.0 * errors[2]
    assert errors[0] < 0.1
