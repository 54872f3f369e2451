"""Optional packages put to use, one in each file.

Dask as an executor, MuJoCo as a second opinion on how rovers stand, bags for ROS 2. Nothing below
this room knows them, and they are loaded when something of theirs is called.
"""

from ._bag import write_bag
from ._cluster import connect, open_executor
from ._dask import DaskExecutor
from ._mujoco import Physics, Rested

__all__ = ["DaskExecutor", "Physics", "Rested", "connect", "open_executor", "write_bag"]
