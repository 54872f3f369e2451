"""The Drive tab: to be written."""

from __future__ import annotations

from nicegui import ui

from ._session import Session


def drive_tab(session: Session) -> None:
    """Placeholder."""
    ui.label("Drive")
