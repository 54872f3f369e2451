"""The Runs tab."""

from __future__ import annotations

from nicegui import ui

from ._session import Session


def runs_tab(session: Session) -> None:
    """Placeholder."""
    ui.label("Runs")
