"""Jobs that tests send to workers. Workers import this file, so it imports little."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path
from typing import Any

import numpy as np

from rovernav.core import PatternError, SettingError, value

OPENED: dict[str, int] = {}
"""How often this process has unpickled each `Counted`."""


class Counted:
    """Says how often it was pickled here and unpickled there."""

    packed = 0

    def __init__(self, name: str, number: float = 1.0) -> None:
        self.name, self.number = name, number

    def __reduce__(self) -> tuple[Any, ...]:
        Counted.packed += 1
        return _opened, (self.name, self.number)


def _opened(name: str, number: float) -> Counted:
    OPENED[name] = OPENED.get(name, 0) + 1
    return Counted(name, number)


@value
class Ground:
    """A frozen value, as worlds and networks are."""

    heights: Any
    counted: Counted


def mixed(shared: Any, seed: int) -> np.ndarray:
    """Numbers whose last bits would tell any difference."""
    rng = np.random.default_rng(seed)
    return np.cumsum(rng.standard_normal(50)) * shared


def whose(shared: Any, item: int) -> tuple[int, dict[str, int]]:
    """The worker's process, and what it has opened so far."""
    time.sleep(0.005)
    assert shared is not None
    return os.getpid(), dict(OPENED)


def slow(shared: Any, item: int) -> float:
    """A tenth of a second of work, then something from the shared value."""
    time.sleep(0.1)
    return float(shared[item % len(shared)]) + item


def slowest(_shared: Any, item: int) -> int:
    time.sleep(0.3)
    return item


def failing(shared: str, item: int) -> int:
    """The fourth item fails, in a way that `shared` names."""
    if item != 3:
        return item
    if shared == "setting":
        raise SettingError("item 3 is bad")
    if shared == "pattern":
        raise PatternError("line 7 of the table is empty")
    if shared == "odd":
        raise Unportable("gone", 3)
    return 1 // 0


class Unportable(Exception):
    """Cannot be unpickled: its constructor takes more than it keeps."""

    def __init__(self, why: str, number: int) -> None:
        super().__init__(f"{why} at {number}")


def deadly(shared: Any, item: int) -> int:
    """The second item ends whatever worker has it."""
    if item == 1:
        os.kill(os.getpid(), signal.SIGKILL)
    return item


def flagged(shared: tuple[np.ndarray, np.ndarray], item: int) -> tuple[bool, bool, bool]:
    """Whether shared arrays can be written to, and lie where the processor likes them."""
    first, second = shared
    return first.flags.writeable, second.flags.writeable, first.flags.aligned


def threads(_shared: Any, _item: int) -> int:
    import numba

    return numba.get_num_threads()


def announced(folder: str, item: int) -> int:
    """Leaves a file when it begins, then takes its time."""
    Path(folder, f"begun-{item}").touch()
    time.sleep(0.5)
    return item


def echo(shared: Any, _item: int) -> Any:
    return shared
