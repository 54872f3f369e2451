"""The one loop: `tick` is a step, `simulate` folds it and keeps the trace."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..core import (
    Command,
    Controller,
    InputError,
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
from ._crew import Crew, joined_commands, joined_observations, joined_rovers, rows, slices
from ._odometry import Odometry
from ._trace import Trace, TraceBuilder
from ._world import Worlds

_DRIVING = int(Outcome.DRIVING)  # plain numbers: members take half a microsecond to find
_ENDS = tuple(map(int, (Outcome.TIMED_OUT, Outcome.REACHED, Outcome.LEFT_MAP, Outcome.COLLIDED)))
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


Watcher = Callable[[DriveState], bool | None]
"""Called after every step; a watcher that returns False ends the drive early."""


def begin(drive: Drive, rng: np.random.Generator) -> DriveState:
    """All rovers at their starts; those already in an obstacle or at the goal have ended."""
    mission, motion = drive.mission, drive.motion
    rovers = RoverState.at_start(mission)
    if isinstance(motion, Body):
        rovers = motion.place(drive.worlds, mission, rovers)
    else:
        hit = _contacts(drive, rovers.pose, rovers.pose) <= 1.0
        outcome = _ends(drive, rovers, hit=hit, lost=np.zeros(len(hit), bool))
        rovers = _with(rovers, outcome=outcome)
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
    finite) moves nothing and ends as `Outcome.LEFT_MAP`.
    """
    rovers = state.rovers
    observation, sensors, remembered = _observe(drive, state)
    command, memory = drive.controller.act(observation, state.controller)
    _need_rows(command.twist, rovers, "commands", 3)
    return DriveState(
        rovers=_moved(drive, state, command),
        sensors=sensors,
        controller=memory,
        mapper=remembered,
        motion=state.motion,
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
    workers: int = 1,
) -> Trace:
    """Drive until every rover has ended.

    With several workers the batch is driven in parts, in step with each other, by as many threads.
    Rovers know nothing of each other, so the trace is the same to the last bit.

    Args:
        drive: Who drives where.
        seed: Seed of everything random; the same seed gives the same trace.
        on_event: Watches every step.
        settings: Plain data kept in the trace: what is needed to run it again.
        record: ``all`` keeps poses, commands and readings, ``path`` poses alone, ``none`` only
            the ends.
        workers: Threads. With more than one, a watcher sees rovers, observation and command of all,
            but no memories: these stay with their parts.

    Returns:
        The trace; its `outcome` says how each rover ended.

    Raises:
        SettingError: Fewer than one worker.
    """
    if workers < 1:
        raise SettingError(f"workers must be 1 or more, got {workers}")
    builder = TraceBuilder(record, body=isinstance(drive.motion, Body))
    wanted = record == "all" or on_event is not None
    with contextlib.closing(_states(drive, seed, workers, wanted)) as states:
        state = next(states)
        builder.add(state.rovers, None, None)
        while state.rovers.driving.any():
            state = next(states)
            builder.add(state.rovers, state.observation, state.command)
            if on_event is not None and on_event(state) is False:
                break
    return builder.finish(drive.mission, state.rovers, seed=seed, settings=dict(settings or {}))


def _states(drive: Drive, seed: int, workers: int, wanted: bool) -> Generator[DriveState]:
    """The drive at its start and after each step, for ever; observations if they are wanted."""
    parts = [_part(drive, part) for part in slices(len(drive.mission.start), workers)]
    if len(parts) == 1:
        state = begin(drive, np.random.default_rng(seed))
        while True:
            yield state
            state = tick(drive, state)
    crew = Crew(workers)
    try:
        states = crew.each(lambda part: begin(part, np.random.default_rng(seed)), parts)
        while True:
            yield _joined(states, wanted)
            states = crew.each(lambda both: tick(*both), list(zip(parts, states, strict=True)))
    finally:
        crew.leave()


def _part(drive: Drive, part: slice) -> Drive:
    worlds = replace(drive.worlds, of=drive.worlds.of[part])
    return replace(drive, worlds=worlds, mission=rows(drive.mission, part))


def _joined(states: Sequence[DriveState], wanted: bool) -> DriveState:
    """All parts as one, without their memories; observation and command where they are wanted."""
    seen = [state.observation for state in states if wanted and state.observation is not None]
    commands = [state.command for state in states if wanted and state.command is not None]
    return DriveState(
        rovers=joined_rovers([state.rovers for state in states]),
        sensors=(),
        controller=None,
        observation=joined_observations(seen) if seen else None,
        command=joined_commands(commands) if commands else None,
    )


def _moved(drive: Drive, state: DriveState, command: Command) -> RoverState:
    """Every rover that still drives one step on, where it meets something or ends."""
    rovers = state.rovers
    if isinstance(drive.motion, Body):
        return drive.motion.move(drive.worlds, drive.mission, rovers, command, state.motion)
    moved = drive.motion.step(rovers, command)
    lost = np.logical_not(np.isfinite(moved.pose).all(axis=1))
    pose = np.where((rovers.driving & ~lost)[:, None], moved.pose, rovers.pose)
    contact = _contacts(drive, rovers.pose, pose)
    hit = contact <= 1.0
    pose = np.where(hit[:, None], _at_contact(rovers.pose, pose, contact), pose)
    after = replace(
        moved,
        time=np.where(rovers.driving, moved.time, rovers.time),
        pose=pose,
        odometry=rovers.odometry + _length(rovers.pose, pose),
        outcome=rovers.outcome,
    )
    outcome = np.where(rovers.driving, _ends(drive, after, hit=hit, lost=lost), rovers.outcome)
    return _with(after, outcome=outcome.astype(np.int8))


def replay(trace: Trace, drive: Drive) -> Trace:
    """Drive again what a trace commanded: the same states, to the last bit.

    Sensors and controller only begin; commands are the trace's, and its readings are kept.

    Args:
        trace: Recorded with ``record="all"``.
        drive: The drive set up as it was.

    Returns:
        The trace of the repeated drive.

    Raises:
        InputError: The trace kept no commands, or is of other missions.
    """
    ours, theirs = drive.mission, trace.mission
    same = all(
        np.array_equal(getattr(ours, name), getattr(theirs, name))
        for name in ("start", "goal", "number")
    )
    if not same:
        raise InputError("the trace is of other missions than the drive; give the drive it is of")
    if len(trace.commands) < int(np.max(trace.steps, initial=0)):
        raise InputError('the trace kept no commands; record the drive with record="all"')
    state = begin(drive, np.random.default_rng(trace.seed))
    builder = TraceBuilder("all", body=isinstance(drive.motion, Body))
    builder.add(state.rovers, None, None)
    for step, twist in enumerate(trace.commands):
        seen = {name: reading[step] for name, reading in trace.channels.items()}
        command = Command(twist=twist)
        observation = Observation(goal=drive.mission.goal, twist=twist, channels=seen)
        state = replace(state, rovers=_moved(drive, state, command))
        builder.add(state.rovers, observation, command)
    return builder.finish(
        drive.mission, state.rovers, seed=trace.seed, settings=dict(trace.settings)
    )


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


def _contacts(drive: Drive, before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Share t of each rover's step at which it first meets something, above 1 if it does not."""
    out = np.empty(len(before))
    kernels.contacts(before, after, drive.worlds.arrays(), out)
    return out


def _ends(drive: Drive, rovers: RoverState, *, hit: np.ndarray, lost: np.ndarray) -> np.ndarray:
    """How each rover ends at its pose, the last reason here first; DRIVING where it goes on."""
    bounds, here = drive.worlds.bounds[drive.worlds.of], rovers.pose[:, :2]
    reached = _length(rovers.pose, drive.mission.goal) <= drive.mission.goal_radius
    outside = ((here < bounds[:, :2]) | (here > bounds[:, 2:])).any(axis=1)
    late = rovers.time >= drive.mission.time_limit - SLACK
    outcome = np.full(len(here), _DRIVING, np.int8)
    for ends, how in zip((late, reached, outside | lost, hit), _ENDS, strict=True):
        outcome[ends] = how
    return outcome


def _at_contact(before: np.ndarray, after: np.ndarray, t: np.ndarray) -> np.ndarray:
    share = np.minimum(t, 1.0)[:, None]
    return np.concatenate([before[:, :2] + share * (after - before)[:, :2], after[:, 2:]], axis=1)


def _length(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.hypot(b[:, 0] - a[:, 0], b[:, 1] - a[:, 1])


def _with(rovers: RoverState, *, outcome: np.ndarray) -> RoverState:
    """The rovers with these ends; those that ended stand still."""
    twist = np.where((outcome == _DRIVING)[:, None], rovers.twist, 0.0)
    return replace(rovers, twist=twist, outcome=outcome)
