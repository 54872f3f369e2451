"""The Train tab."""

from __future__ import annotations

from nicegui import ui

from ._session import Session


def train_tab(session: Session) -> None:
    """Placeholder."""
    ui.label("Train")
