"""The words of the harness: a workload has peers and targets, a peer builds a trial."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple


class Skipped(Exception):
    """This peer cannot run here; the text says why."""


class Result(NamedTuple):
    """What one sample of a trial took.

    Attributes:
        wall: Time on the clock [s].
        cpu: Processor time of the process [s].
        units: Units of work done: patterns, calls, rows.
        check: A number that shows that the work was the right one, such as a final error.
        note: What else there is to tell, such as memory.
    """

    wall: float
    cpu: float
    units: int
    check: float
    note: str = ""


Trial = Callable[[int], Result]
"""Does the work as many times as it is told to, and times it."""


class Stopwatch:
    """Wall and processor time spent inside its `with` blocks [s]."""

    def __init__(self) -> None:
        self.wall = self.cpu = 0.0

    def __enter__(self) -> Stopwatch:
        self.cpu -= time.process_time()
        self.wall -= time.perf_counter()
        return self

    def __exit__(self, *_: object) -> None:
        self.wall += time.perf_counter()
        self.cpu += time.process_time()

    def result(self, units: int, check: float) -> Result:
        """The times so far, as a result."""
        return Result(self.wall, self.cpu, units, check)


@dataclass(frozen=True, kw_only=True)
class Peer:
    """One row of a table.

    Attributes:
        name: What the row is called.
        build: Makes the trial for a size (epochs, calls or batches); heavy imports go in there.
        group: Rows of one group must end with the same check.
        cache: Kernel cache of a fresh process: the user's (empty text), ``warm`` or ``empty``.
    """

    name: str
    build: Callable[[int], Trial]
    group: str = ""
    cache: str = ""


@dataclass(frozen=True, kw_only=True)
class Target:
    """A line that a row has to stay on the right side of.

    Attributes:
        row: The peer that it is about.
        limit: The line, in the workload's unit, or as a ratio if `against` is given.
        against: The peer that the row's time is divided by, in the same run.
        at_least: True where more is better.
    """

    row: str
    limit: float
    against: str = ""
    at_least: bool = False


@dataclass(frozen=True, kw_only=True)
class Workload:
    """One table.

    Attributes:
        name: What the command line calls it.
        title: One sentence: what is measured.
        unit: Unit of the figures.
        peers: The rows.
        targets: The lines.
        anchors: The rows that all others are compared with, and a short name for each.
        size: Epochs, calls or batches of one repetition.
        quick: The same for a quick look.
        scale: The figure is `scale` times seconds per unit of work ...
        rate: ... or, if this is True, `scale` divided by it: more is better.
        check: What the check is.
        expected: The right check of a group at a size; None if it is not known.
        tolerance: How far a check may be from it.
        fresh: Every sample is a process of its own, timed from its start.
        one_core: Hold the process to one core, for peers that cannot be told a thread count.
        memory: Tell the largest memory of each process too.
    """

    name: str
    title: str
    unit: str
    peers: tuple[Peer, ...]
    targets: tuple[Target, ...]
    anchors: Mapping[str, str] = field(default_factory=dict)
    size: int
    quick: int
    scale: float
    rate: bool = False
    check: str
    expected: Callable[[str, int], float | None]
    tolerance: float
    fresh: bool = False
    one_core: bool = False
    memory: bool = False

    def figure(self, seconds_per_unit: float) -> float:
        """Seconds per unit of work, in the unit of the table."""
        return self.scale / seconds_per_unit if self.rate else self.scale * seconds_per_unit

    def peer(self, name: str) -> Peer:
        """The peer of that name."""
        return next(peer for peer in self.peers if peer.name == name)
