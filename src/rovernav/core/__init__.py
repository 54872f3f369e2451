"""The values that flow through the house, the roles, the errors and the file envelope."""

from ._arrays import F32, F64, I8, I64, U8, Bool, Float
from ._contract import check_steps, unchanged
from .drive import Command, Mission, Observation, RoverState
from .errors import (
    ContractError,
    FileError,
    InputError,
    MissingExtraError,
    PatternError,
    PluginError,
    RovernavError,
    SettingError,
    ShapeError,
    WorkerError,
    suggest,
)
from .executors import Processes, Serial, Threads, cores, in_order
from .files import (
    canonical_json,
    plain_data,
    read_bytes,
    read_text,
    sha256_of,
    write_atomic,
    write_text,
)
from .frame import FRAMES, Frame
from .outcome import Outcome
from .plugins import Plugin, make_plugin, plugin, plugins
from .roles import Codec, Controller, Executor, Mapper, Memory, Metric, Motion, Sensor
from .settings import build, read_yaml
from .shares import wilson
from .values import map_arrays, read_only, value

__all__ = [
    "F32",
    "F64",
    "FRAMES",
    "I8",
    "I64",
    "U8",
    "Bool",
    "Codec",
    "Command",
    "ContractError",
    "Controller",
    "Executor",
    "FileError",
    "Float",
    "Frame",
    "InputError",
    "Mapper",
    "Memory",
    "Metric",
    "MissingExtraError",
    "Mission",
    "Motion",
    "Observation",
    "Outcome",
    "PatternError",
    "Plugin",
    "PluginError",
    "Processes",
    "RoverState",
    "RovernavError",
    "Sensor",
    "Serial",
    "SettingError",
    "ShapeError",
    "Threads",
    "WorkerError",
    "build",
    "canonical_json",
    "check_steps",
    "cores",
    "in_order",
    "make_plugin",
    "map_arrays",
    "plain_data",
    "plugin",
    "plugins",
    "read_bytes",
    "read_only",
    "read_text",
    "read_yaml",
    "sha256_of",
    "suggest",
    "unchanged",
    "value",
    "wilson",
    "write_atomic",
    "write_text",
]
