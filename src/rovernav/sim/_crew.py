"""A batch driven in parts, each by a thread, in step with each other."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields, replace
from itertools import pairwise
from typing import Any, TypeVar

import numpy as np

from ..core import Command, Observation, RoverState, map_arrays

PARTS_PER_WORKER = 2
"""So that a part with more to do than others keeps nobody waiting for long."""
LEAST = 32
"""Rovers that are worth a part."""

Part = TypeVar("Part")
Result = TypeVar("Result")


def slices(n: int, workers: int) -> list[slice]:
    """How n rovers are parted: contiguous, about equal, in order."""
    parts = 1 if workers == 1 else max(1, min(PARTS_PER_WORKER * workers, n // LEAST))
    edges = [n * k // parts for k in range(parts + 1)]
    return [slice(a, b) for a, b in pairwise(edges)]


def rows(item: Any, part: slice) -> Any:
    """`item` with those rows of all its arrays, each of which has one for each rover."""
    return map_arrays(item, lambda array: array[part])


class Crew:
    """Threads that stay for a drive."""

    def __init__(self, workers: int) -> None:
        self._pool = ThreadPoolExecutor(workers, thread_name_prefix="rovernav")

    def each(self, job: Callable[[Part], Result], parts: Sequence[Part]) -> list[Result]:
        """The job done to every part; the first error is raised once all have ended."""
        return [future.result() for future in [self._pool.submit(job, part) for part in parts]]

    def leave(self) -> None:
        """End the threads when they are done with what they do."""
        self._pool.shutdown(cancel_futures=True)


def joined_rovers(parts: Sequence[RoverState]) -> RoverState:
    """The rovers of all parts, in order."""
    return RoverState(**_joined(parts, [field.name for field in fields(RoverState)]))


def joined_commands(parts: Sequence[Command]) -> Command:
    """The commands of all parts, in order."""
    return Command(**_joined(parts, ["twist"]))


def joined_observations(parts: Sequence[Observation]) -> Observation:
    """What the rovers of all parts know; maps stay with the parts."""
    channels = {
        name: np.concatenate([part.channels[name] for part in parts]) for name in parts[0].channels
    }
    same = replace(parts[0], channels=channels, map=None)
    names = [
        field.name
        for field in fields(Observation)
        if isinstance(getattr(parts[0], field.name), np.ndarray)
    ]
    return replace(same, **_joined(parts, names))


def _joined(parts: Sequence[Any], names: Sequence[str]) -> dict[str, Any]:
    return {name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
