"""How fast a training shows itself: by the epoch, for people, or as fast as the engine can."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from typing import final

from ..learn import Progress

SPEEDS = ("slow", "watch", "full")
"""Two epochs a second; slow at first, then faster and faster; as fast as the engine can."""
NAP = 0.1
"""Longest wait without a look at whether something changed [s]."""


@final
class Pace:
    """Makes a training wait until its epochs are due, and measures how fast it goes.

    Args:
        speed: One of `SPEEDS`.
    """

    def __init__(self, speed: str) -> None:
        self.speed = speed
        self.rate = 0.0
        """Weight updates per second, measured over the last half second."""
        self._news = threading.Event()
        self.begin(0)

    def begin(self, epoch: int) -> None:
        """The clock starts now, at this epoch."""
        self.rate = 0.0
        self._seen = (time.perf_counter(), -1)
        self._anew(epoch)

    def choose(self, speed: str) -> None:
        """Another speed, from now on."""
        self.speed = speed
        self._news.set()

    def hurry(self) -> None:
        """End any wait: there is something to look at."""
        self._news.set()

    def wait(self, event: Progress, go_on: Callable[[], bool]) -> bool:
        """Wait until the epochs done are due; returns whether to go on at all."""
        self._measure(event.updates)
        while go_on() and self.speed != "full":
            if self._news.is_set():
                self._anew(event.epoch)
            ahead = self._due(event.epoch - self._epoch) - (time.perf_counter() - self._began)
            if ahead <= 0:
                break
            self._news.wait(min(ahead, NAP))
        return go_on()

    def _anew(self, epoch: int) -> None:
        self._news.clear()
        self._epoch, self._began = epoch, time.perf_counter()

    def _due(self, epochs: int) -> float:
        """When so many epochs are due [s]: two a second, or 30 (2^t - 1) after t seconds."""
        return 0.5 * epochs if self.speed == "slow" else math.log2(1.0 + epochs / 30.0)

    def _measure(self, updates: int) -> None:
        now, (then, before) = time.perf_counter(), self._seen
        if before < 0:
            self._seen = (now, updates)
        elif now - then > 0.5:
            self.rate = (updates - before) / (now - then)
            self._seen = (now, updates)
