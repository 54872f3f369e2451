"""Parts of a drive from outside of the house, found by the entry points of installed packages.

Nothing is imported before a part is asked for by name: listing reads only what installers wrote.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from .errors import PluginError, suggest
from .values import value

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

GROUPS = {
    "controller": "rovernav.controllers",
    "sensor": "rovernav.sensors",
    "metric": "rovernav.metrics",
}
"""The entry point group of each kind of part."""
USED: list[Plugin] = []
"""Plug-ins made in this process: whose fault an unknown error may be."""


@value
class Plugin:
    """A part that an installed distribution offers.

    Attributes:
        kind: ``controller``, ``sensor`` or ``metric``.
        name: How it is asked for.
        target: Where it is, ``module:attribute``.
        distribution: Who offers it, with its version.
    """

    kind: str
    name: str
    target: str
    distribution: str

    @property
    def called(self) -> str:
        """What sentences call it."""
        return f"the {self.kind} {self.name!r} of {self.distribution}"

    def make(self) -> Any:
        """The part: what the target gives when it is called without arguments.

        Raises:
            PluginError: It cannot be loaded or made.
        """
        from importlib.metadata import EntryPoint  # late: few drives need one

        USED.append(self)
        point = EntryPoint(self.name, self.target, GROUPS[self.kind])
        try:
            made = point.load()
        except (Exception, SystemExit) as error:
            raise PluginError(f"{self.called} cannot be loaded: {_told(error)}") from error
        try:
            return made()
        except (Exception, SystemExit) as error:
            raise PluginError(f"{self.called} cannot be made: {_told(error)}") from error


def plugins(kind: str) -> list[Plugin]:
    """All parts of a kind that installed distributions offer, by name."""
    from importlib.metadata import entry_points

    found = [
        Plugin(kind=kind, name=point.name, target=point.value, distribution=_owner(point))
        for point in entry_points(group=GROUPS[kind])
    ]
    return sorted(found, key=lambda one: (one.name, one.distribution))


def plugin(kind: str, name: str) -> Plugin | None:
    """The part of that kind and name; None where nobody offers one.

    Raises:
        PluginError: Two distributions offer it.
    """
    found = [one for one in plugins(kind) if one.name == name]
    owners = sorted({one.distribution for one in found})
    if len(owners) > 1:
        raise PluginError(
            f"{' and '.join(owners)} both offer a {kind} {name!r}; uninstall one of them"
        )
    return found[0] if found else None


def make_plugin(kind: str, name: str, *, also: Iterable[str] = ()) -> Any:
    """The part of that kind and name.

    Args:
        kind: ``controller``, ``sensor`` or ``metric``.
        name: Its name.
        also: Names that somebody else knows, for the error message.

    Raises:
        PluginError: Nobody offers it, or it cannot be made.
    """
    found = plugin(kind, name)
    if found is None:
        known = {*also, *(one.name for one in plugins(kind))}
        more = suggest(name, known) if known else f"no installed package offers a {kind}"
        raise PluginError(f"there is no {kind} {name!r}; {more}")
    return found.make()


def _owner(point: EntryPoint) -> str:
    owner = point.dist
    return "an unknown distribution" if owner is None else f"{owner.name} {owner.version}"


def _told(error: BaseException) -> str:
    return f"{type(error).__name__}: {error}"
