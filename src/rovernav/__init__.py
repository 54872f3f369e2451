"""rovernav: neural path planning for planetary rovers, from an elevation model to a driven path.

The rooms, from the top of the house to the ground: `cli`, `studio`, `adapters`, `bench`, `show`,
`learn` and `export`, `control`, `scenes`, `plan`, `mapping` and `sim`, `rover`, `terrain` and
`nets`, `core` and `kernels`. A room imports only from rooms below it. Rooms load when they are
first used, so ``import rovernav``
costs next to nothing.
"""

from __future__ import annotations

import importlib
import sys
from typing import TYPE_CHECKING

from ._version import __version__ as __version__

if TYPE_CHECKING:
    from types import ModuleType

    from . import (
        adapters,
        bench,
        control,
        core,
        export,
        learn,
        mapping,
        nets,
        plan,
        rover,
        scenes,
        show,
        sim,
        studio,
        terrain,
    )

__all__ = [
    "__version__",
    "adapters",
    "bench",
    "control",
    "core",
    "export",
    "learn",
    "mapping",
    "nets",
    "plan",
    "rover",
    "scenes",
    "show",
    "sim",
    "studio",
    "terrain",
]


def __getattr__(name: str) -> ModuleType:
    if name in __all__:
        return importlib.import_module(f"{__name__}.{name}")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)


if "gymnasium.envs.registration" in sys.modules:  # make("rovernav:RovernavRover-v1") imports us
    importlib.import_module(f"{__name__}.adapters").register_envs()
