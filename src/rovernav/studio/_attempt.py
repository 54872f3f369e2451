"""One run from its initial weights: what must be known to tell of it and to do it again."""

from __future__ import annotations

import dataclasses
from typing import final

from ..learn import OnlineSettings, Patterns, StopReason, Training, progress
from ..nets import Network
from ._curve import Curve
from ._kept import Kept
from ._setup import Setup


@final
class Attempt:
    """A run as it goes on.

    Args:
        initial: The network that it begins with.
        weights: Where its weights came from: ``paper``, ``seeded`` or ``given``.
        table: What it learns.
    """

    def __init__(self, initial: Network, weights: str, table: Patterns) -> None:
        self.initial, self.weights = initial, weights
        self.now = Training.fresh(initial)
        self._boundary = self.now
        self.curve = Curve()
        self.exact = True
        """Whether its settings alone end it where it ends."""
        self.seconds = 0.0
        self.kept_at = -1
        """Updates done when it was last kept by itself."""
        self.look(table)

    @property
    def ended(self) -> bool:
        """Whether it came to an end, with something learnt."""
        return self.now.stop is not None and self.now.updates > 0

    def commit(self, training: Training) -> None:
        """Where it stands now; one that diverges within an epoch goes back to its beginning."""
        if training.stop is StopReason.INTERRUPTED:
            training = dataclasses.replace(training, stop=None)
        if training.stop is StopReason.DIVERGED and training.pattern:
            training = dataclasses.replace(self._boundary, stop=StopReason.DIVERGED)
        if not training.pattern:
            self._boundary = training
        self.now = training

    def go_on(self) -> None:
        """It need not stay where it stopped: there may be more epochs, or a smaller tolerance."""
        if self.now.stop is not StopReason.DIVERGED:
            self.now = dataclasses.replace(self.now, stop=None)

    def soften(self, old: OnlineSettings, new: OnlineSettings) -> None:
        """Another end: a run from the beginning might now end earlier than this one stands."""
        if self.now.updates and (new.tolerance > old.tolerance or new.epochs < old.epochs):
            self.exact = False
        self.go_on()

    def look(self, table: Patterns) -> None:
        """A point of the curve for where it stands."""
        self.curve.add(progress(self.now, table, 0.0))

    def snapshot(self, setup: Setup) -> Kept:
        """All that there is to keep of it."""
        return Kept(
            setup=setup,
            initial=self.initial,
            weights=self.weights,
            training=self.now,
            curve=self.curve.points,
            exact=self.exact,
            seconds=self.seconds,
        )
