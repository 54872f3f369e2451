"""Who hears that a kernel is being compiled; light, for it is imported before Numba is."""

from __future__ import annotations

from collections.abc import Callable

LISTENERS: list[Callable[[str], None]] = []
"""Each is called with the name of a kernel for which no compiled code was found."""


def tell(name: str) -> None:
    """Tell everyone who listens."""
    for listener in tuple(LISTENERS):
        listener(name)
