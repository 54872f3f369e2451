"""The clock of a drive that is looked at: it plays, waits, jumps, and never runs ahead."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import final

from ..core import SettingError

SPEEDS = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)
"""How much faster than the rover's own time it can play."""


@final
class Playback:
    """Where in a drive the page is.

    Args:
        clock: Seconds of the wall, ever rising; another one in tests.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._at, self._since = 0.0, clock()
        self.playing, self.speed = False, 5.0

    def begin(self) -> None:
        """Play from the start."""
        self._at, self._since, self.playing = 0.0, self._clock(), True

    def play(self, length: float) -> None:
        """Go on, or from the start where the end was reached."""
        if self.playing:
            return
        at = self._at if self._at < length else 0.0
        self._at, self._since, self.playing = at, self._clock(), True

    def hold(self) -> None:
        """Stop here."""
        self._at, self.playing = self._place(), False

    def seek(self, seconds: float) -> None:
        """Jump there."""
        self._at, self._since = max(0.0, float(seconds)), self._clock()

    def set_speed(self, speed: float) -> None:
        """Play faster or slower from here on.

        Raises:
            SettingError: Not one of `SPEEDS`.
        """
        if speed not in SPEEDS:
            raise SettingError(f"the speed must be one of {', '.join(f'{s:g}' for s in SPEEDS)}")
        self._at, self._since, self.speed = self._place(), self._clock(), float(speed)

    def now(self, length: float, *, more: bool = False) -> float:
        """Where it is [s], at most `length`; at the end it stops, unless there will be more."""
        at = self._place()
        if at < length:
            return at
        if self.playing:
            self._at, self._since = length, self._clock()
            self.playing = more
        return min(at, length)

    def _place(self) -> float:
        return self._at + (self._clock() - self._since) * self.speed if self.playing else self._at
