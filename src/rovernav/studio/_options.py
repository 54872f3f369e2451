"""How a studio was asked to run."""

from __future__ import annotations

import ipaddress
from collections.abc import Callable
from pathlib import Path

from ..core import SettingError, value

LOCAL = "127.0.0.1"
PORT = 8137


@value
class Options:
    """What `rovernav studio` was started with.

    Attributes:
        host: Address to listen on; anything but this machine's own needs a token.
        port: Port; 0 takes any free one.
        library: File of the kept runs; None for the one in the user's data folder.
        terrain: Elevation models that the Drive tab offers besides generated ground.
        cell: Cell of terrains that do not say their own [m].
        show: Open a browser once the page is there.
        say: Receives each line for the terminal.
    """

    host: str = LOCAL
    port: int = PORT
    library: Path | None = None
    terrain: tuple[Path, ...] = ()
    cell: float | None = None
    show: bool = True
    say: Callable[[str], object] = print

    def _check(self) -> None:
        if not 0 <= self.port <= 65535:
            raise SettingError(f"port must be from 0 (any free one) to 65535, got {self.port!r}")
        if not self.host or any(c.isspace() or c in "/@?#" for c in self.host):
            raise SettingError(
                f"host must be an address of this machine like {LOCAL} or 0.0.0.0, "
                f"got {self.host!r}"
            )

    @property
    def local(self) -> bool:
        """Whether only this machine can reach the page."""
        if self.host == "localhost":
            return True
        try:
            return ipaddress.ip_address(self.host).is_loopback
        except ValueError:
            return False
