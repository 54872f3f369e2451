"""The one decorator under which every kernel is compiled, and where compiled code is kept.

No fastmath: NaN means "no data", and reassociation would make results depend on the machine.
Compiled code is cached in a folder named by the hash of this room's sources and the Numba version,
because Numba alone would keep the old code of a kernel that was edited in another file.
"""

from __future__ import annotations

import functools
import hashlib
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba.core import config as numba_config

from ._kept import keep

Function = TypeVar("Function", bound=Callable[..., Any])

config: Any = numba_config
OPTIONS = {"error_model": "numpy", "nogil": True}
"""What every kernel is compiled with."""

JIT_DISABLED = bool(config.DISABLE_JIT)
"""True under NUMBA_DISABLE_JIT=1, where kernels run as plain Python (tests only)."""


def kernel(*, inline: bool = False, bare: bool = False) -> Callable[[Function], Function]:
    """Compile a function: nogil, NumPy division, no fastmath, cached on disk where possible.

    Args:
        inline: Make LLVM put the body into each caller, however large it is.
        bare: Count no references to arrays, which takes an atomic instruction for each row that is
            looked at. For inner kernels that make no arrays; their callers hold what they use.
    """

    def compile_it(function: Function) -> Function:
        counted: dict[str, Any] = {"_nrt": False} if bare else {}
        return cached(function, {**OPTIONS, "forceinline": inline, **counted})

    return compile_it


def cached(function: Function, options: dict[str, Any]) -> Function:
    """`function` compiled with `options`, its code kept in `cache_folder` if there is one."""
    folder = cache_folder()
    compiled = numba.njit(function, **options)
    return cast(Function, compiled if folder is None or JIT_DISABLED else keep(compiled, folder))


@functools.cache
def cache_folder() -> Path | None:
    """The folder for compiled kernels, or None where nothing can be written.

    ``ROVERNAV_CACHE_DIR`` or ``NUMBA_CACHE_DIR`` name its parent; otherwise it is the user's cache.
    """
    for parent in _parents():
        folder = parent / f"kernels-{_source_hash()}-numba-{numba.__version__}"
        try:
            folder.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=folder):
                return folder
        except OSError:
            continue
    return None


def _parents() -> list[Path]:
    named = os.environ.get("ROVERNAV_CACHE_DIR") or os.environ.get("NUMBA_CACHE_DIR")
    if named:
        return [Path(named).absolute()]
    from platformdirs import user_cache_path

    try:
        own = user_cache_path("rovernav", appauthor=False)
    except RuntimeError:  # there is no home; older releases answer "~/.cache" instead
        return []
    return [own] if own.is_absolute() else []


def _source_hash() -> str:
    digest = hashlib.sha256()
    for path in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]
