"""Compiled code on disk: loaded without the compiler's tables, and compiled by one process.

Numba's own cache reads the tables of everything that Numba can compile, SciPy's BLAS with them,
before it looks for code that needs none of that; and it looks for the folder of each kernel while
the kernel is decorated. Here the folder is looked at when a kernel is first called, and the tables
are read only where something is compiled. Where two processes want the same kernel, one compiles
it and the other waits for its file.
"""

from __future__ import annotations

import contextlib
import functools
import os
import time
from collections.abc import Callable, Generator
from pathlib import Path
from typing import Any

from numba.core import config as numba_config
from numba.core.caching import FunctionCache
from numba.core.runtime.nrt import rtsys

from . import news

try:
    import fcntl
except ImportError:  # another system: both processes compile
    fcntl: Any = None

PATIENCE = 300.0
"""How long to wait for another process before compiling as well [s]."""
_LOOK = 0.02  # [s]


def keep(dispatcher: Any, folder: Path) -> Any:
    """Let a kernel keep its compiled code in `folder`; returns the kernel."""
    kept = dispatcher._cache = Kept(dispatcher.py_func, folder)
    compile_it = dispatcher._compiler.compile

    def compile_or_release(args: Any, return_type: Any) -> Any:
        try:
            return compile_it(args, return_type)
        except BaseException:
            kept.release()  # others need not wait for what cannot be compiled
            raise

    dispatcher._compiler.compile = compile_or_release
    return dispatcher


class Kept:
    """The compiled code of one kernel; what a Numba dispatcher asks of its cache.

    Args:
        function: The kernel in plain Python.
        folder: Where its code is kept.
    """

    def __init__(self, function: Callable[..., Any], folder: Path) -> None:
        self._function = function
        self._folder = folder
        self._held: list[int] = []

    @property
    def cache_path(self) -> str:
        """The folder in which Numba keeps this kernel."""
        return str(self._files.cache_path)

    def flush(self) -> None:
        """Forget what is kept."""
        self._files.flush()

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The compiled code for a signature, or None, and then the caller has to compile it."""
        rtsys.initialize(target_context)  # all that loaded code needs of `refresh`
        found = self._files._load_overload(sig, target_context)
        if found is not None:
            return found
        if self._wait():
            found = self._files._load_overload(sig, target_context)
            if found is not None:
                self.release()
                return found
        target_context.refresh()
        news.tell(self._function.__name__)
        return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep what was compiled."""
        try:
            self._files.save_overload(sig, data)
        finally:
            self.release()

    @functools.cached_property
    def _files(self) -> Any:
        with numba_folder(self._folder):
            return FunctionCache(self._function)

    def _wait(self) -> bool:
        """Become the one process that compiles this kernel; True if another one was, before.

        A lock that is not to be had, on a system or a disk without them, is gone without.
        """
        if fcntl is None or self._held:  # a kernel that calls itself holds its lock already
            return False
        path = f"{self._files._cache_file._index_path}.lock"
        try:
            lock = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
        except OSError:
            return False
        self._held.append(lock)
        begun = time.monotonic()
        while time.monotonic() - begun < PATIENCE:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                time.sleep(_LOOK)
            except OSError:
                return False
            else:
                return True
        return False

    def release(self) -> None:
        """Let others have the lock; it goes with the process too, whatever happens to that."""
        while self._held:
            os.close(self._held.pop())


@contextlib.contextmanager
def numba_folder(folder: Path) -> Generator[None]:
    """While it lasts, Numba keeps what it compiles in `folder`."""
    config: Any = numba_config
    before = config.CACHE_DIR
    config.CACHE_DIR = str(folder)
    try:
        yield
    finally:
        config.CACHE_DIR = before
