"""The simulator: worlds, sensors, motion, one loop, and the trace it leaves."""

from ._body import Body
from ._check import check_sensor
from ._fan import RangeFan
from ._metrics import clearance, path_length
from ._motion import DifferentialDrive, TwoAxis
from ._sensors import ClearSight, OffLine
from ._shapes import Shape, Shapes
from ._simulate import Drive, DriveState, begin, replay, simulate, tick
from ._trace import Trace, TraceBuilder, load_trace, save_trace
from ._world import Grid, Ground, Rocks, Worlds

__all__ = [
    "Body",
    "ClearSight",
    "DifferentialDrive",
    "Drive",
    "DriveState",
    "Grid",
    "Ground",
    "OffLine",
    "RangeFan",
    "Rocks",
    "Shape",
    "Shapes",
    "Trace",
    "TraceBuilder",
    "TwoAxis",
    "Worlds",
    "begin",
    "check_sensor",
    "clearance",
    "load_trace",
    "path_length",
    "replay",
    "save_trace",
    "simulate",
    "tick",
]
