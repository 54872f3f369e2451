"""What came out of a sweep: the members' rows, counted setting by setting as they come."""

from __future__ import annotations

import math
from typing import Any, final

import numpy as np

from ..core import value, wilson
from ..kernels import wide
from ._progress import StopReason
from ._sweep_block import STOPS, Rows
from ._sweep_settings import SweepSettings

QUARTILES = (0.25, 0.5, 0.75)


@value
class SettingScore:
    """How the members with one eta and momentum did.

    Attributes:
        eta: Learning rate.
        momentum: Share of the last change that is repeated.
        members: How many there are.
        solved: How many met the tolerance.
        diverged: How many ended with a weight that was no number.
        success: Share that met the tolerance.
        low: Lower end of its 95 % confidence interval (Wilson).
        high: Upper end.
        epochs: Quartiles and median of the epochs of those that met it; NaN where none did.
        updates: The same in weight updates.
        least_error: Smallest of the members' largest |error|.
    """

    eta: float
    momentum: float
    members: int
    solved: int
    diverged: int
    success: float
    low: float
    high: float
    epochs: tuple[float, float, float]
    updates: tuple[float, float, float]
    least_error: float


@value
class MemberScore:
    """How one member did.

    Attributes:
        member: Its number.
        eta: Learning rate.
        momentum: Share of the last change that is repeated.
        seed: Seed of its weights, and of a shuffled order.
        epochs: Epochs that it did.
        updates: Weight updates.
        stop: Why it ended.
        max_error: Largest |error| of any output of any pattern at the end.
    """

    member: int
    eta: float
    momentum: float
    seed: int
    epochs: int
    updates: int
    stop: StopReason
    max_error: float


@final
class Scores:
    """Counts rows in the order of their members; holds one setting's counts at a time."""

    def __init__(self, settings: SweepSettings, patterns: int) -> None:
        self._settings, self._patterns = settings, patterns
        self._best: tuple[Any, ...] | None = None
        self._best_row: MemberScore | None = None
        self._begin()
        self.settings: list[SettingScore] = []
        self.members = self.solved = self.diverged = self.updates = 0

    def _begin(self) -> None:
        """Nothing is counted of the next setting yet."""
        self._counts = np.zeros(4, np.int64)
        self._least = math.inf
        self._epochs, self._times = np.empty(0, np.int64), np.empty(0, np.int64)

    def add(self, rows: Rows) -> None:
        """Count the rows of the next members."""
        self.solved += int(np.sum(rows["stop"] == wide.TOLERANCE))
        self.diverged += int(np.sum(rows["stop"] == wide.DIVERGED))
        self.updates += int(rows["epochs"].sum()) * self._patterns
        self._look_for_best(rows)
        while len(rows):
            room = self._settings.seeds - self.members % self._settings.seeds
            self._count(rows[:room])
            self.members += len(rows[:room])
            rows = rows[room:]
            if self.members % self._settings.seeds == 0:
                self.settings.append(self._score())
                self._begin()

    @property
    def best(self) -> MemberScore | None:
        """Of those that met the tolerance the quickest, otherwise the one with the least error."""
        return self._best_row

    def member(self, number: int, row: Any) -> MemberScore:
        """A row with what belongs to it."""
        eta, momentum = self._settings.rate(number)
        return MemberScore(
            member=number,
            eta=eta,
            momentum=momentum,
            seed=self._settings.seed(number),
            epochs=int(row["epochs"]),
            updates=int(row["epochs"]) * self._patterns,
            stop=STOPS[int(row["stop"])],
            max_error=float(row["max_error"]),
        )

    def _count(self, rows: Rows) -> None:
        self._least = min(self._least, float(np.fmin.reduce(rows["max_error"], initial=math.inf)))
        self._counts += np.bincount(rows["stop"], minlength=4)
        fresh, times = np.unique(rows["epochs"][rows["stop"] == wide.TOLERANCE], return_counts=True)
        both = np.concatenate([self._epochs, fresh])
        self._epochs, places = np.unique(both, return_inverse=True)
        self._times = np.bincount(
            places, np.concatenate([self._times, times]), len(self._epochs)
        ).astype(np.int64)

    def _look_for_best(self, rows: Rows) -> None:
        met = rows["stop"] == wide.TOLERANCE
        error = np.where(np.isnan(rows["max_error"]), np.inf, rows["max_error"])
        speed = np.where(met, rows["epochs"], np.iinfo(np.int64).max)
        place = int(np.lexsort((error, speed))[0])
        rank = (int(speed[place]), float(error[place]))
        if self._best is None or rank < self._best:
            self._best, self._best_row = rank, self.member(self.members + place, rows[place])

    def _score(self) -> SettingScore:
        eta, momentum = self._settings.rate(self.members - 1)
        members, solved = self._settings.seeds, int(self._counts[wide.TOLERANCE])
        low, high = wilson(solved, members)
        first, middle, third = (_quantile(self._epochs, self._times, q) for q in QUARTILES)
        p = self._patterns
        return SettingScore(
            eta=eta,
            momentum=momentum,
            members=members,
            solved=solved,
            diverged=int(self._counts[wide.DIVERGED]),
            success=solved / members,
            low=low,
            high=high,
            epochs=(first, middle, third),
            updates=(first * p, middle * p, third * p),
            least_error=self._least,
        )


def _quantile(values: Any, times: Any, share: float) -> float:
    """The quantile of numbers of which each occurs so many times, as NumPy's default has it."""
    total = int(times.sum())
    if not total:
        return math.nan
    place = share * (total - 1)
    below = math.floor(place)
    ends = np.cumsum(times)
    one, other = (
        float(values[np.searchsorted(ends, min(n, total - 1), side="right")])
        for n in (below, below + 1)
    )
    return one + (other - one) * (place - below)
