"""The simulator: worlds, sensors, motion, one loop, and the trace it leaves."""

from ._body import Body
from ._check import check_sensor
from ._check_metric import check_metric
from ._curves import CURVES, Curve
from ._fan import RangeFan
from ._found import find_metric, find_sensor, metric_names
from ._metrics import clearance, path_length, tilt
from ._motion import DifferentialDrive, TwoAxis
from ._noise import LIDAR, SONAR, InfraRed, NoisyFan, RangeNoise, Tilt, ranger
from ._odometry import Drift, Odometry
from ._patch import HoleSensor, Patch
from ._sensors import ClearSight, OffLine
from ._shapes import Shape, Shapes
from ._simulate import replay, simulate
from ._tick import Drive, DriveState, begin, tick
from ._trace import Trace, TraceBuilder, load_trace, save_trace
from ._world import Grid, Ground, Rocks, Worlds

__all__ = [
    "CURVES",
    "LIDAR",
    "SONAR",
    "Body",
    "ClearSight",
    "Curve",
    "DifferentialDrive",
    "Drift",
    "Drive",
    "DriveState",
    "Grid",
    "Ground",
    "HoleSensor",
    "InfraRed",
    "NoisyFan",
    "Odometry",
    "OffLine",
    "Patch",
    "RangeFan",
    "RangeNoise",
    "Rocks",
    "Shape",
    "Shapes",
    "Tilt",
    "Trace",
    "TraceBuilder",
    "TwoAxis",
    "Worlds",
    "begin",
    "check_metric",
    "check_sensor",
    "clearance",
    "find_metric",
    "find_sensor",
    "load_trace",
    "metric_names",
    "path_length",
    "ranger",
    "replay",
    "save_trace",
    "simulate",
    "tick",
    "tilt",
]
