"""Our metrics: what a drive was worth, rover by rover."""

from __future__ import annotations

from typing import final

import numpy as np

from ..core import F64, Bool, Outcome
from ._metrics import clearance
from ._trace import Trace
from ._world import Worlds


@final
class Length:
    """Distance driven [m]."""

    name, unit = "length", "m"

    def compute(self, trace: Trace, worlds: Worlds) -> tuple[F64, Bool]:
        """Of every rover."""
        return trace.length.copy(), np.ones(len(trace.length), bool)


@final
class Detour:
    """Distance driven over that of the straight line, of those that reached their goals."""

    name, unit = "detour", "1"

    def compute(self, trace: Trace, worlds: Worlds) -> tuple[F64, Bool]:
        """Where the straight line has a length."""
        straight = np.hypot(*(trace.mission.goal - trace.mission.start[:, :2]).T)
        valid = (trace.outcome == Outcome.REACHED) & (straight > 0.0)
        return trace.length / np.where(valid, straight, 1.0), valid


@final
class Closest:
    """Smallest distance to anything that must not be touched [m]."""

    name, unit = "closest", "m"

    def compute(self, trace: Trace, worlds: Worlds) -> tuple[F64, Bool]:
        """Of rovers with something to touch, where the trace keeps the path."""
        if len(trace.pose) <= int(np.max(trace.steps, initial=0)):
            return np.zeros(len(trace.steps)), np.zeros(len(trace.steps), bool)
        gap = np.array([clearance(trace.path(k), worlds, k) for k in range(len(trace.steps))])
        valid = np.isfinite(gap)
        return np.where(valid, gap, 0.0), valid


@final
class Energy:
    """Energy spent [J]."""

    name, unit = "energy", "J"

    def compute(self, trace: Trace, worlds: Worlds) -> tuple[F64, Bool]:
        """Of rovers with bodies."""
        n = len(trace.steps)
        if trace.energy is None:
            return np.zeros(n), np.zeros(n, bool)
        return trace.energy[-1].copy(), np.ones(n, bool)
