"""The one loop: `simulate` folds steps and keeps the trace, `replay` repeats one."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import replace
from threading import Event
from typing import Any

import numpy as np

from ..core import InputError, RoverState, SettingError
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
from ._tick import Drive, DriveState, begin, retrace, tick
from ._trace import Trace, TraceBuilder

Watcher = Callable[[DriveState], bool | None]
"""Called after every step; a watcher that returns False ends the drive early."""


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
        state = retrace(drive, state, seen, twist)
        builder.add(state.rovers, state.observation, state.command)
    return builder.finish(
        drive.mission, state.rovers, seed=trace.seed, settings=dict(trace.settings)
    )
