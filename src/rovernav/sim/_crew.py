"""A batch driven in parts by threads."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields, replace
from itertools import pairwise
from threading import Event
from typing import Any, TypeVar

import numpy as np

from ..core import Command, Observation, RoverState, map_arrays
from ._world import Worlds

LEAST = 32
"""Rovers that are worth a thread."""
NEAR, FEW = 2**20, 128
"""Cells whose tables and heights stay in a near cache, and rovers that are worth a part for it."""

Part = TypeVar("Part")
Result = TypeVar("Result")


def slices(n: int, workers: int, most: int | None = None) -> list[slice]:
    """How n rovers are parted: contiguous, about equal, in order; `most` rovers to a part."""
    parts = 1 if workers == 1 else max(1, min(workers, n // LEAST))
    parts = parts if most is None else max(parts, -(-n // most))
    edges = [n * k // parts for k in range(parts + 1)]
    return [slice(a, b) for a, b in pairwise(edges)]


def neighbours(worlds: Worlds) -> int | None:
    """How many rovers next to each other share few enough worlds for a near cache.

    None where it does not matter: one grid for all, worlds in no order, or too few rovers in each.
    """
    grids = (worlds.grid and worlds.grid.blocked, worlds.ground and worlds.ground.height)
    each = [layers for layers in grids if layers is not None and layers.ndim == 3]
    if not each or (np.diff(worlds.of) < 0).any():
        return None
    cells = sum(layers.size for layers in each)
    most = int(len(worlds.of) * min(1.0, NEAR / max(cells, 1)))
    return most if most >= FEW else None


def rows(item: Any, part: slice) -> Any:
    """`item` with those rows of all its arrays, each of which has one for each rover."""
    return map_arrays(item, lambda array: array[part])


class Crew:
    """Threads that stay for a drive."""

    def __init__(self, workers: int) -> None:
        self._pool = ThreadPoolExecutor(workers, thread_name_prefix="rovernav")

    def each(
        self, job: Callable[[Part], Result], parts: Sequence[Part], halt: Event | None = None
    ) -> list[Result]:
        """The job done to every part; the first error is raised once all have ended.

        Args:
            job: What to do.
            parts: To what.
            halt: Set at the first error, for jobs that look at it and end early.
        """

        def done(part: Part) -> Result:
            try:
                return job(part)
            except BaseException:
                if halt is not None:
                    halt.set()
                raise

        return [future.result() for future in [self._pool.submit(done, part) for part in parts]]

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
