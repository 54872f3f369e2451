"""One step of a drive: sense, decide, move, meet."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..core import (
    Command,
    Controller,
    Mapper,
    Memory,
    Mission,
    Motion,
    Observation,
    Outcome,
    RoverState,
    Sensor,
    SettingError,
    ShapeError,
    value,
)
from ..kernels import drive as kernels
from ._body import Body
from ._odometry import Odometry
from ._world import Worlds

_ENDS = tuple(  # plain numbers: members take half a microsecond to find
    map(
        int,
        (
            Outcome.DRIVING,
            Outcome.TIMED_OUT,
            Outcome.REACHED,
            Outcome.LEFT_MAP,
            Outcome.COLLIDED,
        ),
    )
)
"""How rovers end, the last of them first."""
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
        mapper: Keeps what was sensed, if anything does.
    """

    worlds: Worlds
    mission: Mission
    sensors: Sequence[Sensor]
    controller: Controller
    motion: Motion
    mapper: Mapper | None = None

    def _check(self) -> None:
        if len(self.worlds.of) != len(self.mission.start):
            raise ShapeError(
                f"{len(self.mission.start)} missions need as many rovers in worlds, "
                f"got {len(self.worlds.of)}"
            )
        names = [sensor.name for sensor in self.sensors]
        if len(set(names)) < len(names):
            raise SettingError(f"each sensor needs a name of its own, got {', '.join(names)}")


@value
class DriveState:
    """A drive between two steps: all that is needed to go on.

    Attributes:
        rovers: What the rovers do.
        sensors: Memory of each sensor.
        controller: Memory of the controller.
        mapper: What was sensed so far; None without a mapper.
        motion: What a body remembers: its luck with slip; None for motion without a body.
        observation: What was last sensed; None before the first step.
        command: What was last commanded; None before the first step.
    """

    rovers: RoverState
    sensors: tuple[Memory, ...]
    controller: Memory
    mapper: Memory = None
    motion: Memory = None
    observation: Observation | None = None
    command: Command | None = None


def begin(drive: Drive, rng: np.random.Generator) -> DriveState:
    """All rovers at their starts; those already in an obstacle or at the goal have ended."""
    mission, motion = drive.mission, drive.motion
    rovers = RoverState.at_start(mission)
    if isinstance(motion, Body):
        rovers = motion.place(drive.worlds, mission, rovers)
    else:
        rovers = _met(drive, rovers, rovers)
    return DriveState(
        rovers=rovers,
        sensors=tuple(sensor.start(mission, rng) for sensor in drive.sensors),
        controller=drive.controller.start(mission, rng),
        mapper=None if drive.mapper is None else drive.mapper.start(mission),
        motion=motion.start(mission, rng) if isinstance(motion, Body) else None,
    )


def tick(drive: Drive, state: DriveState) -> DriveState:
    """One step of every rover that still drives: sense, decide, move, meet. Others stay frozen.

    A step that meets something ends where it meets it. A step to nowhere (a pose that is not
    finite) moves nothing and ends as `Outcome.LEFT_MAP`. A rover that goes by an estimate stops
    where this says that it has arrived, and ends as `Outcome.ASTRAY`: had it arrived in truth, it
    would have ended before.
    """
    rovers = state.rovers
    observation, sensors, remembered = _observe(drive, state)
    command, memory = drive.controller.act(observation, state.controller)
    _need_rows(command.twist, rovers, "commands", 3)
    command, state = _stopped(drive, state, observation, command)
    return DriveState(
        rovers=_moved(drive, state, command),
        sensors=sensors,
        controller=memory,
        mapper=remembered,
        motion=state.motion,
        observation=observation,
        command=command,
    )


def retrace(drive: Drive, state: DriveState, channels: Mapping[str, Any], twist: Any) -> DriveState:
    """One step of every rover by readings and a command that are known; memories stay."""
    goal = np.empty_like(drive.mission.goal)
    kernels.goal_in_body(_believed(state.rovers, channels), drive.mission.goal, goal)
    observation = Observation(goal=goal, twist=twist, channels=channels)
    command, state = _stopped(drive, state, observation, Command(twist=twist))
    moved = _moved(drive, state, command)
    return replace(state, rovers=moved, observation=observation, command=command)


def _stopped(
    drive: Drive, state: DriveState, seen: Observation, command: Command
) -> tuple[Command, DriveState]:
    """Rovers that believe themselves at the goal, and are not, are told to stop and have ended."""
    if Odometry.name not in seen.channels:
        return command, state
    rovers = state.rovers
    there = rovers.driving & (
        (seen.goal[:, 0] ** 2 + seen.goal[:, 1] ** 2) <= drive.mission.goal_radius**2
    )
    if not there.any():
        return command, state
    outcome = np.where(there, np.int8(Outcome.ASTRAY), rovers.outcome)
    still = Command(twist=np.where(there[:, None], 0.0, command.twist))
    halted = replace(rovers, outcome=outcome, twist=np.where(there[:, None], 0.0, rovers.twist))
    return still, replace(state, rovers=halted)


def _moved(drive: Drive, state: DriveState, command: Command) -> RoverState:
    """Every rover that still drives one step on, where it meets something or ends."""
    rovers = state.rovers
    if isinstance(drive.motion, Body):
        return drive.motion.move(drive.worlds, drive.mission, rovers, command, state.motion)
    return _met(drive, rovers, drive.motion.step(rovers, command))


def _met(drive: Drive, rovers: RoverState, moved: RoverState) -> RoverState:
    """The rovers after a step, where it meets something or ends; those that ended stay."""
    mission, worlds = drive.mission, drive.worlds
    after = kernels.StepArrays(
        before=rovers.pose,
        driving=rovers.outcome,
        clock=rovers.time,
        way=rovers.odometry,
        goal=mission.goal,
        bounds=worlds.bounds,
        pose=moved.pose.copy(),
        twist=moved.twist.copy(),
        time=moved.time.copy(),
        length=np.empty(len(rovers.pose)),
        outcome=np.empty(len(rovers.pose), np.int8),
    )
    limit = mission.time_limit - SLACK
    kernels.meet(after, worlds.arrays(), mission.goal_radius, limit, _ENDS)
    return replace(
        moved, time=after.time, pose=after.pose, twist=after.twist, odometry=after.length,
        outcome=after.outcome,
    )  # fmt: skip


def _observe(drive: Drive, state: DriveState) -> tuple[Observation, tuple[Memory, ...], Memory]:
    """What every rover knows now, and the memories of sensors and mapper after it."""
    channels: dict[str, Any] = {}
    memories: list[Memory] = []
    for sensor, memory in zip(drive.sensors, state.sensors, strict=True):
        reading, after = sensor.read(drive.worlds, state.rovers, memory)
        _need_rows(reading, state.rovers, f"readings of the sensor {sensor.name!r}")
        channels[sensor.name] = reading
        memories.append(after)
    pose, remembered = _believed(state.rovers, channels), state.mapper
    if drive.mapper is not None:
        more, remembered = drive.mapper.update(remembered, pose, drive.mission.goal, channels)
        channels.update(more)
    goal = np.empty((len(pose), 2))
    kernels.goal_in_body(pose, drive.mission.goal, goal)
    seen = Observation(
        goal=goal, twist=state.rovers.twist, channels=channels, map=remembered, pose=pose
    )
    return seen, tuple(memories), remembered


def _believed(rovers: RoverState, channels: Mapping[str, Any]) -> np.ndarray:
    """Where each rover thinks it is (n, 3): its estimate if a sensor makes one, else the truth."""
    if Odometry.name not in channels:
        return rovers.pose
    return np.ascontiguousarray(channels[Odometry.name][:, :3])


def _need_rows(array: Any, rovers: RoverState, what: str, columns: int | None = None) -> None:
    """Kernels read rows without looking: there must be one for each rover."""
    n = len(rovers.pose)
    if array.ndim != 2 or len(array) != n or array.shape[1] != (columns or array.shape[1]):
        raise ShapeError(f"{what} must have shape ({n}, {columns or 'b'}), got {array.shape}")
