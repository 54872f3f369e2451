"""One person's work: a training, a drive, where they are. It outlives the page that shows it."""

from __future__ import annotations

import secrets
import threading
import time
from typing import Any

from ._desk import TableDesk
from ._drive import DriveModel
from ._lessons import LessonsModel
from ._library import Library
from ._options import Options
from ._runs_desk import RunsDesk
from ._training import TrainModel

MOST = 64
"""Sessions kept; beyond it the one that was looked at longest ago, and does no work, is let go."""


class Session:
    """What one browser tab works on; it goes on without the tab.

    Args:
        key: Its name in the address of the page, not to be guessed.
        owner: The browser that began it.
        options: How the studio was started.
        library: Where finished runs are kept.
    """

    def __init__(self, key: str, owner: str, options: Options, library: Library) -> None:
        self.key, self.owner = key, owner
        self.options, self.library = options, library
        self.tab = "Train"
        self.dark: bool | None = None
        self.seen = time.monotonic()
        self.train = TrainModel(keep=self.keep)
        self.desk = TableDesk(self.train)
        self.shown = 0
        """Which pattern the drawings of the Train tab show."""
        self.page = 1
        """Which page of a long table is open."""
        self.surface_axes = [0, 1]
        """Which inputs vary in the pictures of the answers."""
        self.worked, self.worked_rule = 0, "paper"
        """Where the worked example stands."""
        self.lessons = LessonsModel()
        self.drive = DriveModel(current_network=self.train.driver, keep=self.keep)
        for path in options.terrain:
            self.drive.offer_terrain(path, options.cell)
        self.runs = RunsDesk(library)

    def go(self, tab: str) -> None:
        """Turn to another tab."""
        self.tab = tab

    def keep(self, **run: Any) -> str:
        """Keep a finished run in the library; returns its name there."""
        return self.library.add(**run)

    @property
    def busy(self) -> bool:
        """Whether something is at work in it."""
        return self.train.running or self.drive.running

    def close(self) -> None:
        """Stop its work; what was finished is in the library."""
        self.train.close()
        self.drive.close()


class Sessions:
    """All sessions of a studio, by key.

    Args:
        options: How the studio was started.
        library: Where finished runs are kept.
    """

    def __init__(self, options: Options, library: Library) -> None:
        self._options, self._library = options, library
        self._all: dict[str, Session] = {}
        self._lock = threading.Lock()

    def begin(self, owner: str = "") -> Session:
        """A fresh session."""
        session = Session(secrets.token_urlsafe(18), owner, self._options, self._library)
        with self._lock:
            self._all[session.key] = session
            gone = self._spare()
        for old in gone:
            old.close()
        return session

    def find(self, key: str) -> Session | None:
        """The session of that key, now looked at; None if there is none."""
        with self._lock:
            session = self._all.get(key)
        if session is not None:
            session.seen = time.monotonic()
        return session

    def of(self, owner: str) -> list[Session]:
        """All sessions that a browser began, the latest seen first."""
        with self._lock:
            mine = [one for one in self._all.values() if owner and one.owner == owner]
        return sorted(mine, key=lambda one: -one.seen)

    def close(self) -> None:
        """Stop all work."""
        for session in list(self._all.values()):
            session.close()

    def _spare(self) -> list[Session]:
        """Take out what is more than `MOST`, the longest unseen first, never one at work."""
        idle = sorted((s for s in self._all.values() if not s.busy), key=lambda s: s.seen)
        gone = idle[: max(0, len(self._all) - MOST)]
        for session in gone:
            del self._all[session.key]
        return gone
