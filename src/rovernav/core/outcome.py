"""How a drive ends. Ordinary ends are values, never exceptions."""

from __future__ import annotations

import enum


class Outcome(enum.IntEnum):
    """The state or end of one rover's drive; stored as int8 in batches."""

    DRIVING = 0
    """Not ended yet."""
    REACHED = 1
    """Within the goal radius."""
    COLLIDED = 2
    """The swept step met an obstacle or ground the rover cannot stand on."""
    TIPPED = 3
    """Tilt beyond the rover's limit."""
    HIGH_CENTRED = 4
    """The belly rests on the ground."""
    STUCK = 5
    """Commanded to move, but makes no progress."""
    LEFT_MAP = 6
    """Beyond the edge of the world."""
    TIMED_OUT = 7
    """Neither reached nor ended otherwise within the time limit."""
    ASTRAY = 8
    """Stopped where it believed the goal to be, and was not there."""

    @property
    def label(self) -> str:
        """The name as files and reports write it: ``timed_out``."""
        return self.name.lower()
