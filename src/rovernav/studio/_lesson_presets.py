"""What the buttons of lessons do to a session."""

from __future__ import annotations

from typing import Any

_PAPER: dict[str, Any] = {
    "table": "bassil-v1", "hidden": "3", "rule": "paper", "eta": 0.25, "momentum": 0.5,
    "tolerance": 0.01, "epochs": 5000, "order": "cyclic", "weights": "paper", "speed": "watch",
}  # fmt: skip


def train_paper(session: Any, **changes: Any) -> None:
    """Train the paper's network from the start, with some settings changed."""
    session.train.preset({**_PAPER, **changes})
    session.train.start()


def set_up(session: Any, **changes: Any) -> None:
    """Set the paper's training up without starting it."""
    session.train.preset({**_PAPER, **changes})


def drive_in(session: Any, scene: str, *keys: str) -> None:
    """Drive these controllers in a named scene."""
    session.drive.set_world(session.drive.flat[scene])
    session.drive.choose(keys)
    session.drive.drive()
