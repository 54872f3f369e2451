"""The simulator: worlds, sensors, motion, one loop, and the trace it leaves."""

from ._metrics import clearance, path_length
from ._motion import TwoAxis
from ._sensors import ClearSight, OffLine
from ._simulate import Drive, DriveState, begin, simulate, tick
from ._trace import Trace, load_trace, save_trace
from ._world import Grid, Worlds

__all__ = [
    "ClearSight",
    "Drive",
    "DriveState",
    "Grid",
    "OffLine",
    "Trace",
    "TwoAxis",
    "Worlds",
    "begin",
    "clearance",
    "load_trace",
    "path_length",
    "save_trace",
    "simulate",
    "tick",
]
