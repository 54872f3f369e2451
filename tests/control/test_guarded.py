"""The guard: no command leads onto ground that the rover's own map forbids."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from rovernav.control import GoalSeeker, Guarded, explain
from rovernav.core import Command, Mission, Observation, RoverState, SettingError
from rovernav.mapping import Elevation, ElevationMapper, LocalMap, Look
from rovernav.rover import Reason, read_rover
from rovernav.sim import DifferentialDrive
from tests.sim.drives import Always

ROVER = read_rover("research")
SIDE, CELL, PERIOD = 32, 0.1, 1.0
LOOK = Look(places=np.array([[0.5, 0.0]]), far=1.4, mast=0.6, noise=0.001)
MAPPER = ElevationMapper(ROVER, LOOK, side=SIDE, cell=CELL)
MOTION = DifferentialDrive(speed=0.3, turn_rate=0.7, period=PERIOD)


def map_of(poses: np.ndarray, reason: np.ndarray, blocked: np.ndarray) -> LocalMap:
    """Maps (n, s, s) whose rows and columns count from each rover's cell less half a side."""
    mission = Mission(start=poses, goal=poses[:, :2] + 5.0, goal_radius=0.1, time_limit=1.0)
    empty = MAPPER.start(mission)
    cells, verdicts = np.zeros_like(empty.cells), np.zeros_like(empty.cells)
    at = np.arange(SIDE)
    for k, centre in enumerate(empty.centre):
        rows, columns = ((centre[axis] - SIDE // 2 + at) & (SIDE - 1) for axis in range(2))
        cells[k][np.ix_(rows, columns)] = blocked[k]
        verdicts[k][np.ix_(rows, columns)] = reason[k]
    assert isinstance(empty.ground, Elevation)
    return dataclasses.replace(
        empty, cells=cells, ground=dataclasses.replace(empty.ground, reason=verdicts)
    )


def seen(local: LocalMap) -> Observation:
    n = len(local.pose)
    return Observation(
        goal=np.ones((n, 2)), twist=np.zeros((n, 3)), channels={}, map=local, pose=local.pose
    )


def at(local: LocalMap, k: int, x: float, y: float) -> tuple[bool, float]:
    """Whether a place is blocked, and how far it is from the nearest hazard, in plain Python."""
    i, j = math.floor(y / CELL), math.floor(x / CELL)
    low = local.centre[k] - SIDE // 2
    reason: Any = local.ground.reason[k]
    far = [
        math.hypot((b + 0.5) * CELL - x, (a + 0.5) * CELL - y)
        for a in range(i - 5, i + 6)
        for b in range(j - 5, j + 6)
        if 0 <= a - low[0] < SIDE and 0 <= b - low[1] < SIDE
        and reason[a & (SIDE - 1), b & (SIDE - 1)] in (Reason.STEP, Reason.SLOPE)
    ]  # fmt: skip
    return bool(local.cells[k, i & (SIDE - 1), j & (SIDE - 1)]), min(far, default=math.inf)


@pytest.mark.kernels
def test_no_command_leads_onto_forbidden_ground_or_nearer_to_what_forbids_it(
    rng: np.random.Generator,
) -> None:
    n = 600
    poses = np.column_stack([rng.normal(0, 2, (n, 2)), rng.uniform(-np.pi, np.pi, n)])
    reason = np.where(rng.random((n, SIDE, SIDE)) < 0.012, 3, 0).astype(np.uint8)
    blocked = np.zeros_like(reason)
    for i in range(-2, 3):
        for j in range(-2, 3):
            if i * i + j * j <= 5:
                blocked |= (np.roll(reason, (i, j), (1, 2)) > 0).astype(np.uint8)
    reason[(blocked > 0) & (reason == 0)] = 4
    local = map_of(poses, reason, blocked)
    wanted = np.column_stack([rng.uniform(-0.3, 0.3, n), np.zeros(n), rng.uniform(-0.7, 0.7, n)])
    guard = Guarded(Given(wanted), period=PERIOD, radius=3.0 * CELL)
    held = guard.act(seen(local), None)[0].twist
    state = RoverState.at_start(
        Mission(start=poses, goal=poses[:, :2], goal_radius=0.0, time_limit=1.0)
    )
    ends = MOTION.step(state, Command(twist=held)).pose
    cut = 0
    for k in range(n):
        stood, near = at(local, k, *poses[k, :2])
        stands, nearer = at(local, k, *ends[k, :2])
        assert not stands or (stood and nearer >= near - 1e-9)
        if np.array_equal(held[k], wanted[k]):
            continue
        cut += 1
        share = held[k, 0] / wanted[k, 0]
        assert 0.0 <= share < 1.0
        assert held[k, 2] == pytest.approx(wanted[k, 2] * (share or 1.0))
        step = share + 0.125 * CELL / abs(wanted[k, 0])  # a bit farther it would be forbidden
        onward = MOTION.step(state, Command(twist=wanted * min(step, 1.0))).pose[k]
        stands, nearer = at(local, k, *onward[:2])
        assert stands
        assert not stood or nearer < near + 0.3 * CELL or not _all_blocked(local, k, state, wanted)
    assert 50 < cut < n - 50


def _all_blocked(local: LocalMap, k: int, state: RoverState, wanted: np.ndarray) -> bool:
    shares = np.linspace(0.0, 1.0, 20)
    ends = [MOTION.step(state, Command(twist=wanted * s)).pose[k] for s in shares]
    return all(at(local, k, *end[:2])[0] for end in ends)


class Given:
    """Commands what it was given."""

    def __init__(self, twist: np.ndarray) -> None:
        self.twist = twist

    def start(self, mission: Mission, rng: np.random.Generator) -> None:
        return None

    def act(self, observation: Observation, memory: None) -> tuple[Command, None]:
        return Command(twist=self.twist), None


def test_the_guard_says_why_and_leaves_other_maps_alone() -> None:
    poses = np.array([[0.05, 0.05, 0.0]])
    reason = np.zeros((1, SIDE, SIDE), np.uint8)
    blocked = reason.copy()
    blocked[:, :, SIDE // 2 + 2 :] = 1  # from 0.2 m east on
    local = map_of(poses, reason, blocked)
    guard = Guarded(Always(0.3, 0.0, 0.0), period=PERIOD, radius=0.4)
    told = explain(guard, seen(local), None)
    assert told.command[0] == pytest.approx(0.1375, abs=0.01)
    assert "Its map forbids the rest of that way: 0.1" in told.words[-1]
    plain = dataclasses.replace(local, ground=None)
    assert_array_equal(guard.act(seen(plain), None)[0].twist, [[0.3, 0.0, 0.0]])
    free = map_of(poses, reason, np.zeros_like(blocked))
    assert_array_equal(guard.act(seen(free), None)[0].twist, [[0.3, 0.0, 0.0]])
    assert not any("forbids" in word for word in explain(guard, seen(free), None).words)


@pytest.mark.parametrize("name", ["period", "radius"])
def test_absurd_guards_are_refused(name: str) -> None:
    settings = {"period": 1.0, "radius": 0.4, name: 0.0}
    with pytest.raises(SettingError, match=f"a guarded driver needs a {name} above 0, got 0.0"):
        Guarded(GoalSeeker(), **settings)
