"""What holds for bodies of every kind of steering, wherever and with whomever they drive."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from rovernav.core import Command, Frame, Mission, Observation, Outcome
from rovernav.mapping import ElevationMapper
from rovernav.sim import (
    LIDAR,
    Body,
    Drive,
    Ground,
    NoisyFan,
    Odometry,
    Patch,
    RangeFan,
    Trace,
    Worlds,
    replay,
    simulate,
)
from tests.bits import assert_same_bits
from tests.sim.bodies import CARS, CELL, SIDE, SOILS, worlds_of

N = 70
BITS = ("time", "pose", "commands", "attitude", "slip", "energy")
EVERY = pytest.mark.parametrize("name", CARS)


class Plan:
    """Commands that hang on a rover's number and time alone; mirrored ones where wanted."""

    def __init__(self, side: float = 1.0) -> None:
        self.side = side

    def start(self, mission: Mission, rng: np.random.Generator) -> Any:
        return mission.number, 0

    def act(self, observation: Observation, memory: Any) -> tuple[Command, Any]:
        number, step = memory
        turn = np.sin(1.7 * number + 0.4 * step)
        twist = np.stack(
            [0.5 + 0.3 * np.cos(0.9 * number), 0.2 * turn * self.side, 0.4 * turn * self.side],
            axis=1,
        )
        return Command(twist=twist), (number, step + 1)


def drive(name: str, rovers: int = N, *, sensors: bool = False, controller: Any = None) -> Drive:
    """Rovers in four rough worlds."""
    rng, rover = np.random.default_rng(len(name)), CARS[name]
    start = np.column_stack([rng.uniform(1.7, 4.7, (rovers, 2)), rng.uniform(-3, 3, rovers)])
    eyes = Patch(near=0.4, far=2.0, cell=0.25)
    fan = NoisyFan(RangeFan(reach=3.0, beams=9), LIDAR)
    return Drive(
        worlds=worlds_of(0, rovers),
        mission=Mission(
            start=start, goal=start[:, :2] + rng.uniform(-1, 1, (rovers, 2)), goal_radius=0.15,
            time_limit=4.0,
        ),
        sensors=(fan, eyes, Odometry()) if sensors else (),
        mapper=ElevationMapper(rover, eyes, fan=fan, side=16) if sensors else None,
        controller=controller or Plan(),
        motion=Body(rover, period=0.5, soil=SOILS.get(name), spread=0.3),
    )  # fmt: skip


def row(whole: Drive, k: int) -> Drive:
    m = whole.mission
    one = {name: getattr(m, name)[k : k + 1] for name in ("start", "goal", "number")}
    return dataclasses.replace(
        whole, worlds=whole.worlds.row(k), mission=dataclasses.replace(m, **one)
    )


def assert_bits(a: Trace, b: Trace) -> None:
    for name in (*BITS, "outcome", "steps", "length"):
        assert_same_bits(getattr(a, name), getattr(b, name))
    assert a.channels.keys() == b.channels.keys()
    for name, reading in a.channels.items():
        assert_array_equal(b.channels[name], reading, err_msg=name)


@EVERY
def test_threads_rows_and_replays_have_the_same_bits(name: str) -> None:
    """Seventy rovers are parted among threads; each is what it is alone."""
    whole = drive(name, sensors=True)
    trace = simulate(whole, seed=4)
    assert len(set(trace.outcome.tolist())) >= 3
    for workers in (2, 3):
        assert_bits(simulate(whole, seed=4, workers=workers), trace)
    assert_bits(replay(trace, whole), trace)
    for k in (0, 33, N - 1):
        one = simulate(row(whole, k), seed=4)
        steps = int(one.steps[0])
        assert one.outcome[0] == trace.outcome[k]
        for field in BITS:
            count = steps if field == "commands" else steps + 1
            assert_same_bits(getattr(one, field)[:count, 0], getattr(trace, field)[:count, k])
        for channel, reading in one.channels.items():
            assert_array_equal(reading[:steps, 0], trace.channels[channel][:steps, k])


@EVERY
def test_energy_rises_by_the_idle_power_at_least(name: str) -> None:
    trace = simulate(drive(name), seed=1)
    assert trace.energy is not None
    mobility = CARS[name].mobility
    assert mobility is not None
    assert (trace.energy[0] == 0.0).all()
    spent = np.diff(trace.energy, axis=0)
    assert (spent >= 0.0).all()
    whole = np.arange(len(spent))[:, None] < trace.steps - 1  # periods that nothing cut short
    assert (spent[whole] >= 0.5 * mobility.idle_power * (1 - 1e-12)).all()


def turned(height: Any, quarters: int) -> Any:
    return np.ascontiguousarray(np.rot90(height, -quarters, axes=(-2, -1)))


def moved(worlds: Worlds, put: Any, height: Any) -> Worlds:
    """The worlds with each point where `put` says, and that ground."""
    corners = [put(worlds.boxes[:, k : k + 2]) for k in (0, 2)]
    assert worlds.rocks is not None
    assert worlds.ground is not None
    place = worlds.rocks.place.copy()
    place[:, :2] = put(place[:, :2])
    edges = [put(worlds.bounds[:, k : k + 2]) for k in (0, 2)]
    frame = Frame(cell=CELL, shape=height.shape[-2:])
    return dataclasses.replace(
        worlds,
        boxes=np.concatenate([np.minimum(*corners), np.maximum(*corners)], axis=1),
        bounds=np.concatenate([np.minimum(*edges), np.maximum(*edges)], axis=1),
        rocks=dataclasses.replace(worlds.rocks, place=place),
        ground=Ground(frame=frame, height=height, offset=worlds.ground.offset),
    )


def about(quarters: int, mirror: bool) -> Any:
    """A turn about the middle of the worlds, after a mirror that swaps north and south."""

    def put(points: Any) -> Any:
        x, y = points[:, 0] - SIDE / 2, points[:, 1] - SIDE / 2
        y = -y if mirror else y
        for _ in range(quarters):
            x, y = -y, x
        return np.stack([x, y], axis=1) + SIDE / 2

    return put


def by(columns: int, rows: int) -> Any:
    """A shift by whole cells."""
    return lambda points: points + np.array([columns * CELL, rows * CELL])


@EVERY
@pytest.mark.parametrize("change", ["turned", "mirrored", "shifted"])
def test_drives_follow_their_world(name: str, change: str) -> None:
    """To a micrometre and a microradian: places differ in their last bits."""
    here, side, quarters = drive(name, 24), 1.0, 0
    assert here.worlds.ground is not None
    height = here.worlds.ground.height
    if change == "turned":
        quarters = 1 + len(name) % 3
        height, put = turned(height, quarters), about(quarters, False)
    elif change == "mirrored":
        height, put, side = np.ascontiguousarray(height[:, ::-1]), about(0, True), -1.0
    else:  # ground reaches beyond the edge of the map, so that where it ends is nothing to them
        wide = np.pad(height, ((0, 0), (20, 20), (20, 20)), "edge")
        start = np.add(here.mission.start, (20 * CELL, 20 * CELL, 0.0))
        missions = dataclasses.replace(
            here.mission, start=start, goal=by(20, 20)(here.mission.goal)
        )
        here = dataclasses.replace(
            here, worlds=moved(here.worlds, by(20, 20), wide), mission=missions
        )
        height, put = np.pad(wide, ((0, 0), (7, 0), (12, 0)), "edge"), by(12, 7)
    start = np.column_stack(
        [
            put(here.mission.start[:, :2]),
            side * here.mission.start[:, 2] + quarters * math.pi / 2,
        ]
    )
    there = dataclasses.replace(
        here,
        worlds=moved(here.worlds, put, height),
        mission=dataclasses.replace(here.mission, start=start, goal=put(here.mission.goal)),
        controller=Plan(side),
        motion=Body(CARS[name], period=0.5, soil=SOILS.get(name)),
    )
    here = dataclasses.replace(here, motion=there.motion)
    a, b = simulate(here), simulate(there)
    assert len(set(a.outcome.tolist())) >= 3
    assert_array_equal(b.outcome, a.outcome)
    assert_array_equal(b.steps, a.steps)
    assert a.attitude is not None
    assert b.attitude is not None
    for k in range(24):
        assert_allclose(b.path(k), put(a.path(k)), atol=1e-6)
    lost = a.pose[..., 2] * side + quarters * math.pi / 2 - b.pose[..., 2]
    assert np.abs(np.mod(lost + math.pi, 2 * math.pi) - math.pi).max() < 1e-6
    assert_allclose(b.attitude, a.attitude * (1, 1, side), atol=1e-6)
    assert_allclose(b.energy, a.energy, rtol=1e-6)  # type: ignore[arg-type]
    assert_allclose(b.slip, a.slip * (1, side), atol=1e-6)  # type: ignore[operator]


@EVERY
def test_finer_steps_converge_to_the_first_order(name: str) -> None:
    """The attitude at a part's start holds for all of it: half the part, half the error."""
    n = 120
    at = (np.arange(n) + 0.5) * CELL
    hills = 0.25 * np.sin(at[None, :]) + 0.2 * np.cos(0.8 * at[:, None])
    ground = Ground(frame=Frame(cell=CELL, shape=(n, n)), height=hills.astype(np.float32))
    rng = np.random.default_rng(1)
    start = np.column_stack([rng.uniform(4.0, 8.0, (16, 2)), rng.uniform(-3, 3, 16)])
    mission = Mission(start=start, goal=np.full((16, 2), 99.0), goal_radius=0.1, time_limit=4.0)

    def end(parts: int) -> Any:
        body = Body(CARS[name], period=1.0, parts=parts)
        worlds = Worlds.single(ground=ground, rovers=16)
        trace = simulate(
            Drive(worlds=worlds, mission=mission, sensors=(), controller=Plan(), motion=body)
        )
        assert (trace.outcome == Outcome.TIMED_OUT).all()
        assert trace.energy is not None
        return np.column_stack([trace.pose[-1], trace.energy[-1] / trace.energy[-1].max()])

    exact = end(512)
    errors = [np.abs(end(parts) - exact).mean() for parts in (2, 8, 32)]
    orders = np.diff(-np.log(errors)) / math.log(4.0)
    assert (orders > 0.85).all(), (errors, orders)
    assert (orders < 1.3).all(), (errors, orders)
