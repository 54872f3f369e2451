"""The environment of the benchmarks: `benchmarks/.venv`, with the peers in exact versions."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
import tomllib
from pathlib import Path

from .ccode import HOME

VENV = HOME / ".venv"
PYTHON = VENV / "bin" / "python"


def install() -> None:
    """Make `.venv`: what rovernav needs at run time, and every peer of requirements.txt."""
    root = HOME.parent
    project = tomllib.loads((root / "pyproject.toml").read_text())["project"]
    if not PYTHON.exists():
        subprocess.run([sys.executable, "-m", "venv", str(VENV)], check=True)
    subprocess.run(
        [
            *(str(PYTHON), "-m", "pip", "install", "--disable-pip-version-check", "--quiet"),
            *("--constraint", str(root / "constraints.txt")),
            *("--requirement", str(HOME / "requirements.txt")),
            *project["dependencies"],
        ],
        check=True,
    )
    print(f"installed in {VENV}; some of it is large: remove the folder to be rid of it")


def use(*, here: bool) -> None:
    """Go on under `.venv` where there is one, unless told to stay under this interpreter."""
    if not here and Path(sys.prefix).resolve() != VENV.resolve() and PYTHON.exists():
        os.execv(PYTHON, [str(PYTHON), *sys.argv])
    if importlib.util.find_spec("numpy") is None:
        sys.exit("this Python has no NumPy; first run: python benchmarks/run.py --setup")
    if not PYTHON.exists():
        print("benchmarks/.venv is missing, so only peers that this Python has are measured;")
        print("for all of them, first run: python benchmarks/run.py --setup")
