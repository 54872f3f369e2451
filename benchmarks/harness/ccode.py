"""C peers: compiled once for this machine, called through ctypes."""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
from pathlib import Path
from typing import Any

from .model import Skipped

HOME = Path(__file__).resolve().parent.parent
BUILD = HOME / "build"
FLAGS = ("-O3", "-march=native", "-shared", "-fPIC")


def c_function(source: str, *libraries: str, advice: str = "") -> Any:
    """The function `train` of ``c/<source>.c``; it returns 0 when all went well.

    Raises:
        Skipped: There is no gcc, or it cannot compile this; `advice` says what to install.
    """
    code = HOME / "c" / f"{source}.c"
    built = BUILD / f"{source}.so"
    if not built.exists() or built.stat().st_mtime < code.stat().st_mtime:
        _compile(code, built, libraries, advice)
    return ctypes.CDLL(str(built)).train


def pointer(array: Any) -> ctypes.c_void_p:
    """Where a C-ordered array begins; the caller keeps the array alive."""
    if not array.flags.c_contiguous:
        raise ValueError("C reads arrays in C order only")
    return ctypes.c_void_p(array.ctypes.data)


def _compile(code: Path, built: Path, libraries: tuple[str, ...], advice: str) -> None:
    gcc = shutil.which("gcc")
    if gcc is None:
        raise Skipped("gcc is not installed")
    BUILD.mkdir(exist_ok=True)
    draft = built.with_suffix(f".{os.getpid()}")
    command = [gcc, *FLAGS, str(code), "-o", str(draft), *libraries, "-lm"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        first = done.stderr.strip().splitlines()[0] if done.stderr.strip() else "no message"
        raise Skipped(advice or f"gcc failed: {first}")
    draft.replace(built)
