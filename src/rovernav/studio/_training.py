"""A training under the hands of a person."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


class TrainModel:
    """Placeholder."""

    def __init__(self, *, keep: Callable[..., str]) -> None:
        self.running = False

    def driver(self) -> Any:
        from ..learn import trained_paper_network

        return trained_paper_network()

    def close(self) -> None:
        return


def warm_up() -> None:
    """Compile."""
