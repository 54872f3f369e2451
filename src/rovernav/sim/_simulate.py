"""The one loop: `tick` is a step, `simulate` folds it and keeps the trace."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ..core import (
    Command,
    Controller,
    Memory,
    Mission,
    Motion,
    Observation,
    Outcome,
    RoverState,
    Sensor,
    ShapeError,
    value,
)
from ..kernels import drive as kernels
from ._trace import Trace, TraceBuilder
from ._world import Worlds

SLACK = 1e-9
"""Seconds by which a time limit may be missed through rounding [s]."""


@value
class Drive:
    """A drive set up: who drives, where, with which sensors.

    Attributes:
        worlds: The true worlds; only sensors and contact see them.
        mission: Starts and goals (n rovers).
        sensors: Read in this order at every step.
        controller: Sees observations alone.
        motion: Moves the rovers.
    """

    worlds: Worlds
    mission: Mission
    sensors: Sequence[Sensor]
    controller: Controller
    motion: Motion

    def _check(self) -> None:
        if len(self.worlds.of) != len(self.mission.start):
            raise ShapeError(
                f"{len(self.mission.start)} missions need as many rovers in worlds, "
                f"got {len(self.worlds.of)}"
            )


@value
class DriveState:
    """A drive between two steps: all that is needed to go on.

    Attributes:
        rovers: What the rovers do.
        sensors: Memory of each sensor.
        controller: Memory of the controller.
        observation: What was last sensed; None before the first step.
        command: What was last commanded; None before the first step.
    """

    rovers: RoverState
    sensors: tuple[Memory, ...]
    controller: Memory
    observation: Observation | None = None
    command: Command | None = None


Watcher = Callable[[DriveState], bool | None]
"""Called after every step; a watcher that returns False ends the drive early."""


def begin(drive: Drive, rng: np.random.Generator) -> DriveState:
    """All rovers at their starts; those already in an obstacle or at the goal have ended."""
    mission = drive.mission
    rovers = RoverState.at_start(mission)
    outcome = _ends(drive, rovers, rovers.pose, np.zeros(len(rovers.pose), bool))
    return DriveState(
        rovers=_with(rovers, outcome=outcome),
        sensors=tuple(sensor.start(mission, rng) for sensor in drive.sensors),
        controller=drive.controller.start(mission, rng),
    )


def tick(drive: Drive, state: DriveState) -> DriveState:
    """One step of every rover that still drives: sense, decide, move, meet. Others stay frozen."""
    rovers = state.rovers
    observation, sensors = _observe(drive, state)
    command, memory = drive.controller.act(observation, state.controller)
    moved = drive.motion.step(rovers, command)
    contact = np.empty(len(rovers.pose))
    kernels.contacts(rovers.pose, moved.pose, drive.worlds.arrays(), contact)
    hit = contact <= 1.0
    pose = np.where(hit[:, None], _at_contact(rovers.pose, moved.pose, contact), moved.pose)
    driving = rovers.driving
    after = RoverState(
        time=np.where(driving, moved.time, rovers.time),
        pose=np.where(driving[:, None], pose, rovers.pose),
        twist=np.where(driving[:, None], moved.twist, 0.0),
        odometry=np.where(driving, rovers.odometry + _length(rovers.pose, pose), rovers.odometry),
        outcome=rovers.outcome,
    )
    ended = _ends(drive, after, pose, hit)
    return DriveState(
        rovers=_with(after, outcome=np.where(driving, ended, rovers.outcome).astype(np.int8)),
        sensors=sensors,
        controller=memory,
        observation=observation,
        command=command,
    )


def simulate(
    drive: Drive,
    *,
    seed: int = 0,
    on_event: Watcher | None = None,
    settings: Mapping[str, Any] | None = None,
    record: str = "all",
) -> Trace:
    """Drive until every rover has ended.

    Args:
        drive: Who drives where.
        seed: Seed of everything random; the same seed gives the same trace.
        on_event: Watches every step.
        settings: Plain data kept in the trace: what is needed to run it again.
        record: ``all`` keeps poses, commands and readings, ``path`` poses alone, ``none`` only
            the ends.

    Returns:
        The trace; its `outcome` says how each rover ended.
    """
    state = begin(drive, np.random.default_rng(seed))
    builder = TraceBuilder(record)
    builder.add(state.rovers, None, None)
    while state.rovers.driving.any():
        state = tick(drive, state)
        builder.add(state.rovers, state.observation, state.command)
        if on_event is not None and on_event(state) is False:
            break
    return builder.finish(drive.mission, state.rovers, seed=seed, settings=dict(settings or {}))


def _observe(drive: Drive, state: DriveState) -> tuple[Observation, tuple[Memory, ...]]:
    channels: dict[str, Any] = {}
    memories: list[Memory] = []
    for sensor, memory in zip(drive.sensors, state.sensors, strict=True):
        channels[sensor.name], after = sensor.read(drive.worlds, state.rovers, memory)
        memories.append(after)
    goal = np.empty((len(state.rovers.pose), 2))
    kernels.goal_in_body(state.rovers.pose, drive.mission.goal, goal)
    seen = Observation(goal=goal, twist=state.rovers.twist, channels=channels)
    return seen, tuple(memories)


def _ends(drive: Drive, rovers: RoverState, pose: np.ndarray, hit: np.ndarray) -> np.ndarray:
    """How each rover ends at this pose, first reason first; DRIVING where it goes on."""
    goal, bounds = drive.mission.goal, drive.worlds.bounds[drive.worlds.of]
    here = pose[:, :2]
    reached = _length(pose, goal) <= drive.mission.goal_radius
    left = ((here < bounds[:, :2]) | (here > bounds[:, 2:])).any(axis=1) | ~np.isfinite(here).all(1)
    late = rovers.time >= drive.mission.time_limit - SLACK
    outcome = np.full(len(pose), Outcome.DRIVING, np.int8)
    for ends, how in (
        (late, Outcome.TIMED_OUT),
        (reached, Outcome.REACHED),
        (left, Outcome.LEFT_MAP),
        (hit, Outcome.COLLIDED),
    ):
        outcome[ends] = how
    return outcome


def _at_contact(before: np.ndarray, after: np.ndarray, t: np.ndarray) -> np.ndarray:
    share = np.minimum(t, 1.0)[:, None]
    return np.concatenate([before[:, :2] + share * (after - before)[:, :2], after[:, 2:]], axis=1)


def _length(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.hypot(b[:, 0] - a[:, 0], b[:, 1] - a[:, 1])


def _with(rovers: RoverState, *, outcome: np.ndarray) -> RoverState:
    return RoverState(
        time=rovers.time,
        pose=rovers.pose,
        twist=rovers.twist,
        odometry=rovers.odometry,
        outcome=outcome,
    )
