"""Which installed distributions another one asks for, all the way down."""

from __future__ import annotations

from importlib.metadata import Distribution, distribution

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name


def closure(name: str, *extras: str) -> dict[str, Distribution]:
    """All installed distributions that `name` with `extras` declares, by canonical name."""
    found: dict[str, Distribution] = {}
    seen: set[tuple[str, str]] = set()
    waiting = [(name, extra) for extra in ("", *extras)]
    while waiting:
        key = waiting.pop()
        if key in seen:
            continue
        seen.add(key)
        found[canonicalize_name(key[0])] = distribution(key[0])
        waiting.extend(_asked_for(*key))
    del found[canonicalize_name(name)]
    return found


def _asked_for(name: str, extra: str) -> list[tuple[str, str]]:
    asked: list[tuple[str, str]] = []
    for text in distribution(name).requires or []:
        requirement = Requirement(text)
        if requirement.marker is None or requirement.marker.evaluate({"extra": extra}):
            asked += [(requirement.name, more) for more in ("", *sorted(requirement.extras))]
    return asked
