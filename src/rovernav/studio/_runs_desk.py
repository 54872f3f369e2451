"""The kept runs on the desk: which are listed, marked for comparison, opened."""

from __future__ import annotations

from typing import final

from ..core import RovernavError
from ._library import Library, Run

PER_PAGE = 12
COMPARED = 8
"""Runs that are compared at once at most."""


@final
class RunsDesk:
    """What a person looks at in the library.

    Args:
        library: The kept runs; others may add and delete there at any time.
    """

    def __init__(self, library: Library) -> None:
        self.library = library
        self.kind: str | None = None
        self.page = 1
        self.opened = ""
        self.marked: list[str] = []

    def listed(self) -> list[Run]:
        """The runs of the chosen kind, the latest first; marks of those that are gone go too."""
        runs = self.library.list(kind=self.kind)
        known = {run.id for run in (runs if self.kind is None else self.library.list())}
        self.marked = [run for run in self.marked if run in known]
        if self.opened not in known:
            self.opened = runs[0].id if runs else ""
        self.page = max(1, min(self.page, self.pages(runs)))
        return runs

    def pages(self, runs: list[Run]) -> int:
        """How many pages the list has."""
        return max(1, -(-len(runs) // PER_PAGE))

    def on_page(self, runs: list[Run]) -> list[Run]:
        """The runs of the open page."""
        first = (self.page - 1) * PER_PAGE
        return runs[first : first + PER_PAGE]

    def open_run(self) -> Run | None:
        """The run that is opened, if it is still there."""
        try:
            return self.library.get(self.opened) if self.opened else None
        except RovernavError:
            return None

    def mark(self, run: str, on: bool) -> None:
        """Mark a run for comparison, or no longer; beyond `COMPARED` the oldest mark goes."""
        self.marked = [other for other in self.marked if other != run]
        if on:
            self.marked = [*self.marked, run][-COMPARED:]

    def compared(self) -> list[Run]:
        """The marked runs of the kind of the one marked last."""
        runs = [run for run in self.library.list() if run.id in self.marked]
        if not runs:
            return []
        kind = next(run.kind for run in runs if run.id == self.marked[-1])
        return [run for run in runs if run.kind == kind]

    def forget(self, run: str) -> None:
        """Delete a run for good."""
        self.library.delete(run)
        self.mark(run, False)
