"""Drives that go on and on hold no more memory than at their beginning."""

from __future__ import annotations

import gc
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rovernav.adapters import register_envs
from rovernav.control import GoalSeeker, RouteFollower
from rovernav.core import Command, Frame, Mission, Observation
from rovernav.mapping import ElevationMapper
from rovernav.rover import read_rover
from rovernav.sim import (
    LIDAR,
    Body,
    Drive,
    Ground,
    NoisyFan,
    Odometry,
    Patch,
    RangeFan,
    Worlds,
    begin,
    simulate,
    tick,
)
from tests.control.test_routed import FRAME, GOAL, START, costs
from tests.control.test_routed import drive as routed_drive

pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="no /proc to ask"),
]
MOST = 4.0
"""Megabytes by which memory may have grown when all has long been warm."""


def held() -> float:
    """Megabytes of memory that this process holds."""
    gc.collect()
    found = re.search(r"VmRSS:\s+(\d+)", Path("/proc/self/status").read_text(encoding="ascii"))
    assert found
    return int(found[1]) / 1024.0


def assert_flat(step: Callable[[int], Any], *, warm: int, then: int) -> None:
    """Memory after `warm` steps and after `then` more is about the same."""
    for k in range(warm):
        step(k)
    before = held()
    for k in range(warm, warm + then):
        step(k)
    grown = held() - before
    assert grown < MOST, f"{grown:.1f} MB more than the {before:.0f} MB after {warm} steps"


class Circles:
    """Goes round, to the left or to the right."""

    def start(self, mission: Mission, rng: np.random.Generator) -> Any:
        return np.where(mission.number % 2 == 0, 0.3, -0.3)

    def act(self, observation: Observation, memory: Any) -> tuple[Command, Any]:
        twist = np.zeros((len(memory), 3))
        twist[:, 0], twist[:, 2] = 0.25, memory
        return Command(twist=twist), memory


def test_bodies_with_sensors_and_maps() -> None:
    """A hundred thousand steps of rovers that see, map and drift; nobody ever ends."""
    n, rover = 25, read_rover("research")
    at = (np.arange(120) + 0.5) * 0.1
    hills = 0.05 * np.sin(at[None, :]) + 0.04 * np.cos(0.8 * at[:, None])
    ground = Ground(frame=Frame(cell=0.1, shape=(120, 120)), height=hills.astype(np.float32))
    rng, eyes = np.random.default_rng(0), Patch(near=0.4, far=2.0, cell=0.25)
    fan = NoisyFan(RangeFan(reach=3.0, beams=25), LIDAR)
    start = np.column_stack([rng.uniform(3.5, 8.5, (n, 2)), rng.uniform(-3, 3, n)])
    drive = Drive(
        worlds=Worlds.single([(0.5, 0.5, 1.0, 1.0)], ground=ground, rovers=n),
        mission=Mission(start=start, goal=np.full((n, 2), 99.0), goal_radius=0.1, time_limit=1e9),
        sensors=(fan, eyes, Odometry()),
        mapper=ElevationMapper(rover, eyes, fan=fan, side=32),
        controller=Circles(),
        motion=Body(rover, period=0.5, soil="bedrock"),
    )
    states = [begin(drive, np.random.default_rng(0))]

    def step(_: int) -> None:
        states[0] = tick(drive, states[0])

    assert_flat(step, warm=500, then=4000)
    assert states[0].rovers.driving.mean() > 0.9


def test_drives_begun_again_and_again() -> None:
    """Each with worlds of its own: what is kept for a world goes with it."""
    rover = read_rover("research")

    def step(k: int) -> None:
        at = (np.arange(200) + 0.5) * 0.1
        hills = 0.05 * np.sin(at[None, :] + k) + 0.04 * np.cos(0.8 * at[:, None])
        ground = Ground(frame=Frame(cell=0.1, shape=(200, 200)), height=hills.astype(np.float32))
        drive = Drive(
            worlds=Worlds.single(ground=ground),
            mission=Mission.between((3.0, 3.0), (9.0, 9.0), goal_radius=0.1, time_limit=3.0),
            sensors=(RangeFan(reach=3.0, beams=25), Patch(near=0.4, far=2.0, cell=0.25)),
            controller=Circles(),
            motion=Body(rover, period=0.5),
        )
        simulate(drive, seed=k)

    assert_flat(step, warm=40, then=300)


def test_environments_with_many_episodes() -> None:
    gymnasium = pytest.importorskip("gymnasium", reason="needs the extra gym")
    register_envs()
    env = gymnasium.make_vec(
        "RovernavRover-v1", num_envs=16, side=24.0, cell=0.5, nearest=3.0, farthest=8.0, beams=9,
        time_limit=12.0,
    )  # fmt: skip
    env.reset(seed=1)
    rng, ended = np.random.default_rng(0), [0]

    def step(_: int) -> None:
        action = rng.uniform((0.2, -1.0), (1.0, 1.0), (16, 2)).astype(np.float32)
        _, _, terminated, truncated, _ = env.step(action)
        ended[0] += int((terminated | truncated).sum())

    assert_flat(step, warm=500, then=4000)
    assert ended[0] > 2000
    env.close()


def test_routes_planned_anew() -> None:
    """A wall that nobody mapped, met again and again."""
    blocked = np.zeros(FRAME.shape, np.uint8)
    blocked[80:120, 100:104] = 1
    ground, plans = costs(np.zeros_like(blocked)), [0]

    def step(k: int) -> None:
        follower = RouteFollower(GoalSeeker(), np.array([START, GOAL]), ground=ground)
        whole = routed_drive(follower, blocked)
        state = begin(whole, np.random.default_rng(k))
        while state.rovers.driving.any():
            state = tick(whole, state)
        plans[0] += int(state.controller.plans[0])

    assert_flat(step, warm=8, then=60)
    assert plans[0] >= 68
