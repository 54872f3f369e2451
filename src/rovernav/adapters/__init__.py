"""Optional packages put to use, one in each file.

Dask as an executor, MuJoCo as a second opinion on how rovers stand, bags for ROS 2, an environment
for Gymnasium. Nothing below this room knows them, and they are loaded when something of theirs is
used.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ._bag import write_bag
    from ._cluster import connect, open_executor
    from ._dask import DaskExecutor
    from ._mujoco import Physics, Rested
    from ._register import register_envs
    from ._rows import Task, features

__all__ = [
    "DaskExecutor",
    "Physics",
    "Rested",
    "Task",
    "connect",
    "features",
    "open_executor",
    "register_envs",
    "write_bag",
]
_FILES = {
    "DaskExecutor": "_dask",
    "Physics": "_mujoco",
    "Rested": "_mujoco",
    "Task": "_rows",
    "connect": "_cluster",
    "features": "_rows",
    "open_executor": "_cluster",
    "register_envs": "_register",
    "write_bag": "_bag",
}


def __getattr__(name: str) -> Any:
    if name not in _FILES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f".{_FILES[name]}", __name__), name)


def __dir__() -> list[str]:
    return sorted(__all__)
