"""Compiled code on disk: one process compiles a kernel, the others wait, and nobody for ever."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

fcntl = pytest.importorskip("fcntl")

SUM = """
import sys
from pathlib import Path
import numba, numpy as np
from rovernav.kernels import _kept, news
from summing import inner, outer
news.LISTENERS.append(print)
for kernel in (inner, outer):
    _kept.keep(kernel, Path("kept"))
print(outer(np.arange(5.0)), "scipy.linalg" in sys.modules)
"""
SUMMING = """
import numba
@numba.njit
def inner(x):
    total = 0.0
    for i in range(x.size):
        total += x[i] * x[i]
    return total
@numba.njit
def outer(x):
    return inner(x) + inner(x[:2])
"""
FAILING = """
from pathlib import Path
import numba
from rovernav.kernels import _kept
from summing import inner
_kept.keep(inner, Path("kept"))
try:
    inner("text")
except numba.TypingError:
    print("refused", inner._cache._held)
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "summing.py").write_text(SUMMING)
    (tmp_path / "kept").mkdir()
    return tmp_path


def begun(code: str, folder: Path) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-W", "error", "-c", code],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(folder), *sys.path])},
        stdout=subprocess.PIPE,
        text=True,
    )


def said(process: subprocess.Popen[str]) -> list[str]:
    out = process.communicate(timeout=240)[0]
    assert process.returncode == 0
    return out.split()


def test_of_several_processes_one_compiles(folder: Path) -> None:
    words = [said(one) for one in [begun(SUM, folder) for _ in range(3)]]
    assert [one[-2] for one in words] == ["31.0"] * 3
    compiled = sorted(name for one in words for name in one[:-2])
    assert compiled == ["inner", "outer"]


def test_kept_code_needs_no_tables_of_the_compiler(folder: Path) -> None:
    assert said(begun(SUM, folder)) == ["outer", "inner", "31.0", "True"]
    assert said(begun(SUM, folder)) == ["31.0", "False"]


def test_a_kernel_that_cannot_be_compiled_keeps_nobody_waiting(folder: Path) -> None:
    assert said(begun(FAILING, folder)) == ["refused", "[]"]


def test_a_lock_that_is_never_given_back_is_not_waited_for(folder: Path) -> None:
    said(begun(SUM, folder))
    (index,) = (folder / "kept").rglob("summing.inner*.nbi")
    for code in (folder / "kept").rglob("*.nbc"):
        code.unlink()
    with open(f"{index}.lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        told = "_kept.time.sleep = lambda seconds: news.tell('wait')\n"
        code = SUM.replace("for kernel", f"_kept.PATIENCE = 0.5\n{told}for kernel")
        words = said(begun(code, folder))
    assert words.count("wait") > 1
    assert [word for word in words if word != "wait"][:-1] == ["outer", "inner", "31.0"]
