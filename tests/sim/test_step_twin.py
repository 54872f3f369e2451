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
from rovernav.rover import drive_table
from rovernav.sim import Body, Ground, Worlds
from rovernav.sim._footing import footing
from tests.naive import step as naive
from tests.sim.bodies import CARS, CELL, LOWER, SOILS, worlds_of

STEPS, ROVERS = 5, 8


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
    for step in range(round(mission.time_limit / body.period)):
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
    rng, worlds = np.random.default_rng([seed, len(name)]), worlds_of(seed, ROVERS)
    start = np.column_stack([rng.uniform(1.7, 4.7, (ROVERS, 2)), rng.uniform(-3, 3, ROVERS)])
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
    shape, lanes = (36, 66), (0.9, 1.8, 2.7)  # each course thrice, a little apart
    east, north = np.meshgrid(*((np.arange(n) + 0.5) * CELL for n in reversed(shape)))
    level, off = np.zeros(shape), np.abs(np.mod(north + 0.45, 0.9) - 0.45)
    grounds = {
        "tipped": (north - 1.8) * np.maximum(east - 1.0, 0.0),
        "high_centred": 0.16 * np.clip(east - 1.7, 0, 1) * np.maximum(0.0, 1.0 - off / 0.12),
        "stuck": 0.49 * east,
        "left_map": level,
        "reached": level,
        "collided": level,
        "ledge": np.where(east > 2.25, 0.24, 0.0),
        "timed_out": 0.1 * np.sin(3.0 * east) * np.cos(2.0 * north),
    }
    n = len(grounds)
    start = np.column_stack(
        [np.tile([1.3, 1.45, 1.6], n), np.tile(lanes, n), np.tile([-0.05, 0.0, 0.1], n)]
    )
    start[9:12, 0] += 4.1
    goal = np.tile([6.0, 3.4], (3 * n, 1))
    goal[12:15] = start[12:15, :2] + (0.8, 0.0)
    worlds = Worlds(
        boxes=np.array([[2.4, 0.0, 2.5, 3.6]]), offsets=np.repeat([0, 1], [6, n - 5]),
        bounds=np.tile([0.3, 0.3, 6.3, 3.3], (n, 1)), of=np.repeat(np.arange(n), 3),
        ground=Ground(
            frame=Frame(cell=CELL, shape=shape),
            height=np.stack(list(grounds.values())).astype(np.float32),
        ),
    )  # fmt: skip
    return worlds, start, goal


@pytest.mark.kernels
def test_every_way_to_end_is_decided_as_by_the_twin() -> None:
    worlds, start, goal = courses()
    mission = Mission(start=start, goal=goal, goal_radius=0.12, time_limit=3.0)
    told = np.tile([0.6, 0.0, 0.0], (len(start), 1))
    rover = dataclasses.replace(LOWER, max_step=0.2)
    counts = drive(Body(rover, period=0.5, soil="loose-sand", parts=2), worlds, mission,
                   lambda _: told, 0)  # fmt: skip
    body_decides = set(Outcome) - {Outcome.ASTRAY}  # what a rover believes is no matter of a body
    assert set(counts) >= {outcome.label for outcome in body_decides}, counts
    assert counts["unsure"] <= 3, counts
