"""A drive under the hands of a person: to be written."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


class DriveModel:
    """Placeholder until the Drive tab is there."""

    def __init__(
        self, *, current_network: Callable[[], Any], keep: Callable[..., str]
    ) -> None:
        self.running = False
