"""A whole step of a body, of every kind of steering, against its slow twin in plain Python."""

from __future__ import annotations

import dataclasses
import math
from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rovernav.core import Command, Frame, Mission, Outcome, RoverState
from rovernav.kernels import traction
from rovernav.rover import Rover, Steering, drive_table, read_rover
from rovernav.sim import Body, Ground, Rocks, Worlds
from rovernav.sim._footing import footing
from tests.naive import step as naive
from tests.rover.rough_ground import rough_ground

CELL, CELLS, SIDE = 0.1, 90, 9.0
WAYS = {"speed": 0.6, "turn_rate": 0.8}
RESEARCH = dataclasses.replace(read_rover("research"), **WAYS)
MARS = dataclasses.replace(read_rover("perseverance"), **WAYS)
LOWER = dataclasses.replace(RESEARCH, clearance=0.06, max_step=0.3, max_slope=math.radians(60.0))


def steered(rover: Rover, kind: Any, **more: Any) -> Rover:
    drives = {"drive": "two-axis", "step": 0.6} if kind == "two-axis" else {}
    return dataclasses.replace(rover, steering=Steering(kind=kind, **more), **drives)


LAZY = {"lag": 0.3, "acceleration": 0.9, "turn_acceleration": 1.2}
CARS = {
    "two-axis": steered(LOWER, "two-axis", wheel_speed=0.5),
    "skid": steered(RESEARCH, "skid", **LAZY),
    "ackermann-four": steered(LOWER, "ackermann", max_steer=math.radians(35.0), lag=0.2),
    "ackermann-six": steered(MARS, "ackermann", max_steer=math.radians(60.0), acceleration=0.8),
    "crab": steered(MARS, "crab", max_steer=math.radians(50.0), wheel_speed=0.5, **LAZY),
}
SOILS = {"skid": "loose-sand", "ackermann-six": "loose-sand"}
STEPS, ROVERS = 6, 8


def worlds_of(seed: int) -> Worlds:
    """Rough ground with rocks, a steep slope, ridges, and a box beside ground that is missing."""
    rng, at = np.random.default_rng([7, seed]), (np.arange(CELLS) + 0.5) * CELL
    rough, steep, ridged, holed = (
        rough_ground(4 * seed + k, slope=slope, cell=CELL, cells=CELLS)
        for k, slope in enumerate((0.1, 0.72, 0.0, 0.1))
    )
    height = np.stack([g.height + np.float32(g.offset) for g in (rough, steep, ridged, holed)])
    height[2] += (0.28 * np.maximum(0.0, 1.0 - np.abs(np.mod(at, 1.4) - 0.7) / 0.25))[None]
    height[3, 20:26, 45:50] = np.nan
    rocks = np.column_stack(
        [rng.uniform(0, SIDE, (20, 2)), rng.uniform(0.15, 0.2, 20), rng.uniform(0.05, 0.4, 20)]
    )
    return Worlds(
        boxes=np.array([[2.0, 3.0, 2.3, 4.0], [4.0, 4.5, 4.1, 6.0]]),
        offsets=np.array([0, 0, 0, 0, 2]),
        bounds=np.tile([0.3, 0.3, SIDE - 0.3, SIDE - 0.3], (4, 1)),
        of=np.arange(ROVERS) % 4,
        ground=Ground(frame=rough.frame, height=height, offset=2.0),
        rocks=Rocks(place=rocks, offsets=np.array([0, 20, 20, 20, 20])),
    )


def places(worlds: Worlds, body: Body, mission: Mission) -> list[naive.Place]:
    """What the twin knows of each rover's world."""
    rover, out = body.rover, []
    on, row, first = footing(worlds, rover), drive_table(rover, body.soil)[0], traction.FIRST
    table = (row[traction.ROLLING], row[first : first + 129], row[first + 129 :])
    for k, i in enumerate(worlds.of.tolist()):
        high = np.empty((0, 4)) if worlds.rocks is None else worlds.rocks.of_world(i).place
        out.append(
            naive.Place(
                wheel=on.wheel[i], below=on.ground[i], step=on.step[i], cell=on.cell,
                offset=on.offset, boxes=worlds.boxes[worlds.offsets[i] : worlds.offsets[i + 1]],
                rocks=high[high[:, 3] > min(rover.max_step, rover.clearance)],
                bounds=worlds.bounds[i], goal=mission.goal[k], radius=mission.goal_radius,
                limit=mission.time_limit, table=table,
            )
        )  # fmt: skip
    return out


def row_of(state: RoverState, k: int) -> naive.Row:
    lists: dict[str, Any] = {
        name: getattr(state, name)[k].tolist()
        for name in ("pose", "twist", "attitude", "slip", "stall")
    }
    numbers: dict[str, Any] = {
        name: float(getattr(state, name)[k]) for name in ("time", "odometry", "energy")
    }
    return naive.Row(**lists, **numbers)


def assert_equal(row: naive.Row, state: RoverState, k: int, missed: float) -> None:
    """All that a step changes; a swept footprint may stop its `missed` [m] too early."""
    assert Outcome(int(state.outcome[k])).label == row.outcome
    assert state.time[k] == pytest.approx(row.time, abs=1e-12)
    assert_allclose(state.twist[k], row.twist, atol=1e-6)
    assert_allclose(state.slip[k], row.slip, atol=1e-5)
    assert_allclose(state.stall[k], row.stall, atol=1e-5)
    assert state.energy[k] == pytest.approx(row.energy, rel=1e-4)
    turned = math.remainder(state.pose[k, 2] - row.pose[2], 2 * math.pi)
    assert abs(turned) < 1e-5 + 4 * missed
    assert_allclose(state.pose[k, :2], row.pose[:2], atol=1e-5 + missed)
    assert state.odometry[k] == pytest.approx(row.odometry, abs=1e-5 + missed)
    if row.outcome not in ("left_map", "collided"):
        assert_allclose(state.attitude[k], row.attitude, atol=2e-5)


Told = Callable[[int], Any]


def drive(body: Body, worlds: Worlds, mission: Mission, told: Told, seed: int) -> Counter[str]:
    """Drive a batch; every step of every rover equals its twin. How steps ended, or too near."""
    rover, n, counts = body.rover, len(mission.start), Counter[str]()
    factor = np.random.default_rng(seed).uniform(0.7, 1.3, (n, 2))
    state, there = RoverState.at_start(mission), places(worlds, body, mission)
    state = body.place(worlds, mission, state)
    for step in range(STEPS):
        twist = told(step)
        after = body.move(worlds, mission, state, Command(twist=twist), factor)
        for k in np.flatnonzero(state.outcome == Outcome.DRIVING).tolist():
            twin = row_of(state, k)
            near = naive.step(rover, there[k], twin, twist[k], factor[k])
            met = after.outcome[k] == Outcome.COLLIDED
            if not near.clear(angle=1e-4, length=2e-3 if met else 1e-4, share=1e-5):
                counts["unsure"] += 1
                continue
            assert_equal(twin, after, k, 2e-3 if met else 0.0)
            counts[twin.outcome] += 1
        state = after
    return counts


@pytest.mark.kernels
@pytest.mark.parametrize("name", CARS)
@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(k, marks=pytest.mark.long) for k in range(1, 9))]
)
def test_a_whole_step_equals_its_twin(name: str, seed: int) -> None:
    rng, worlds = np.random.default_rng([seed, len(name)]), worlds_of(seed)
    start = np.column_stack([rng.uniform(2.0, 7.0, (ROVERS, 2)), rng.uniform(-3, 3, ROVERS)])
    mission = Mission(
        start=start, goal=start[:, :2] + rng.uniform(-1, 1, (ROVERS, 2)), goal_radius=0.12,
        time_limit=0.5 * STEPS,
    )  # fmt: skip
    body = Body(CARS[name], period=0.5, soil=SOILS.get(name), parts=2)
    counts = drive(
        body, worlds, mission,
        lambda _: rng.uniform((-0.2, -0.3, -0.5), (0.8, 0.3, 0.5), (ROVERS, 3)), seed,
    )  # fmt: skip
    assert counts["driving"] > 8, counts
    assert counts["unsure"] <= 0.1 * counts.total(), counts


def courses() -> tuple[Worlds, Any, Any]:
    """Worlds in which a rover that drives on ends in each of all ways; starts and goals."""
    at = (np.arange(CELLS) + 0.5) * CELL
    level, (east, north) = np.zeros((CELLS, CELLS)), np.meshgrid(at, at)
    grounds = {
        "tipped": (north - 4.5) * np.maximum(east - 3.0, 0.0),
        "high_centred": 0.16
        * np.clip(east - 3.7, 0.0, 1.0)
        * np.maximum(0.0, 1.0 - np.abs(np.mod(north + 0.45, 0.9) - 0.45) / 0.12),
        "stuck": 0.49 * east,
        "left_map": level,
        "reached": level,
        "collided": level,
        "ledge": np.where(east > 4.25, 0.24, 0.0),
        "timed_out": 0.1 * np.sin(3.0 * east) * np.cos(2.0 * north),
    }
    lanes = np.array([3.6, 4.5, 5.4])  # each course thrice, a little apart
    n = len(grounds)
    start = np.column_stack(
        [np.tile([3.3, 3.45, 3.6], n), np.tile(lanes, n), np.tile([-0.05, 0.0, 0.1], n)]
    )
    start[9:12, 0] += 4.6
    goal = np.tile([8.5, 8.5], (3 * n, 1))
    goal[12:15] = start[12:15, :2] + (0.8, 0.0)
    worlds = Worlds(
        boxes=np.array([[4.4, 0.0, 4.5, 8.0]]), offsets=np.repeat([0, 1], [6, n - 5]),
        bounds=np.tile([0.3, 0.3, SIDE - 0.3, SIDE - 0.3], (n, 1)),
        of=np.repeat(np.arange(n), 3),
        ground=Ground(
            frame=Frame(cell=CELL, shape=(CELLS, CELLS)),
            height=np.stack(list(grounds.values())).astype(np.float32),
        ),
    )  # fmt: skip
    return worlds, start, goal


@pytest.mark.kernels
def test_every_way_to_end_is_decided_as_by_the_twin() -> None:
    worlds, start, goal = courses()
    mission = Mission(start=start, goal=goal, goal_radius=0.12, time_limit=0.5 * STEPS)
    told = np.tile([0.6, 0.0, 0.0], (len(start), 1))
    rover = dataclasses.replace(LOWER, max_step=0.2)
    counts = drive(Body(rover, period=0.5, soil="loose-sand", parts=2), worlds, mission,
                   lambda _: told, 0)  # fmt: skip
    assert set(counts) >= {outcome.label for outcome in Outcome}, counts
    assert counts["unsure"] <= 3, counts
