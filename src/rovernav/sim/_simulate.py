"""The one loop: `tick` is a step, `simulate` folds it and keeps the trace."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import replace
from threading import Event
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
from ._crew import (
    Crew,
    joined_commands,
    joined_observations,
    joined_rovers,
    neighbours,
    rows,
    slices,
)
from ._odometry import Odometry
from ._trace import Trace, TraceBuilder
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


Watcher = Callable[[DriveState], bool | None]
"""Called after every step; a watcher that returns False ends the drive early."""


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

    With several workers the batch is driven in parts by as many threads: in step with each other
    if somebody watches, else each part by itself to its end; so are rovers in many large worlds, a
    few worlds at a time. Rovers know nothing of each other, so the trace is the same to the last
    bit.

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
    most = neighbours(drive.worlds) if on_event is None else None
    parts = [_part(drive, part) for part in slices(len(drive.mission.start), workers, most)]
    if on_event is None and len(parts) > 1:
        builder, rovers = _apart(parts, seed, record, workers)
    else:
        builder = TraceBuilder(record, body=isinstance(drive.motion, Body))
        rovers = _watched(parts, seed, workers, builder, on_event)
    return builder.finish(drive.mission, rovers, seed=seed, settings=dict(settings or {}))


def _watched(
    parts: Sequence[Drive], seed: int, workers: int, builder: TraceBuilder, watch: Watcher | None
) -> RoverState:
    """All parts driven to the end, in step with each other; each step is kept and watched."""
    with contextlib.closing(_states(parts, seed, workers)) as states:
        state = next(states)
        builder.add(state.rovers, None, None)
        while state.rovers.driving.any():
            state = next(states)
            builder.add(state.rovers, state.observation, state.command)
            if watch is not None and watch(state) is False:
                break
    return state.rovers


def _apart(
    parts: Sequence[Drive], seed: int, record: str, workers: int
) -> tuple[TraceBuilder, RoverState]:
    """All parts driven to the end, each by itself: no thread waits for another at every step."""
    halt = Event()

    def begun(part: Drive) -> _Course:
        return _Course(part, seed, TraceBuilder(record, body=isinstance(part.motion, Body)))

    crew = Crew(workers)
    try:
        courses = crew.each(begun, parts)
        crew.each(lambda course: course.drive(halt), courses, halt)
        if record == "all":  # what rovers that have ended read and are told is kept to the end
            last = max(course.steps for course in courses)
            crew.each(lambda course: course.drive(halt, last), courses, halt)
    finally:
        halt.set()
        crew.leave()
    builder = courses[0].builder
    builder.join([course.builder for course in courses[1:]])
    return builder, joined_rovers([course.state.rovers for course in courses])


class _Course:
    """A part of a batch on its way, and what is kept of it."""

    def __init__(self, part: Drive, seed: int, builder: TraceBuilder) -> None:
        self._part, self.builder, self.steps = part, builder, 0
        self.state = begin(part, np.random.default_rng(seed))
        builder.add(self.state.rovers, None, None)

    def drive(self, halt: Event, last: int = 0) -> None:
        """Until every rover has ended, and at least to step `last`; or until told to halt."""
        while (self.steps < last or self.state.rovers.driving.any()) and not halt.is_set():
            self.state = tick(self._part, self.state)
            self.builder.add(self.state.rovers, self.state.observation, self.state.command)
            self.steps += 1


def _states(parts: Sequence[Drive], seed: int, workers: int) -> Generator[DriveState]:
    """The drive at its start and after each step, for ever."""
    if len(parts) == 1:
        state = begin(parts[0], np.random.default_rng(seed))
        while True:
            yield state
            state = tick(parts[0], state)
    crew = Crew(workers)
    try:
        states = crew.each(lambda part: begin(part, np.random.default_rng(seed)), parts)
        while True:
            yield _joined(states)
            states = crew.each(lambda both: tick(*both), list(zip(parts, states, strict=True)))
    finally:
        crew.leave()


def _part(drive: Drive, part: slice) -> Drive:
    if part == slice(0, len(drive.mission.start)):
        return drive
    worlds = replace(drive.worlds, of=drive.worlds.of[part])
    return replace(drive, worlds=worlds, mission=rows(drive.mission, part))


def _joined(states: Sequence[DriveState]) -> DriveState:
    """All parts as one, without their memories."""
    seen = [state.observation for state in states if state.observation is not None]
    commands = [state.command for state in states if state.command is not None]
    return DriveState(
        rovers=joined_rovers([state.rovers for state in states]),
        sensors=(),
        controller=None,
        observation=joined_observations(seen) if seen else None,
        command=joined_commands(commands) if commands else None,
    )


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
        goal = np.empty_like(drive.mission.goal)
        kernels.goal_in_body(_believed(state.rovers, seen), drive.mission.goal, goal)
        observation = Observation(goal=goal, twist=twist, channels=seen)
        command, state = _stopped(drive, state, observation, Command(twist=twist))
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
