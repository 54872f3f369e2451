from __future__ import annotations

import subprocess
import sys
from pathlib import Path

HEAVY = (
    "dask", "distributed", "matplotlib", "nicegui", "numba", "pydantic", "rasterio", "scipy",
)  # fmt: skip
COMMAND = Path(sys.executable).with_name("rovernav")


def loaded(*arguments: str) -> tuple[set[str], str]:
    """The packages that a fresh Python loads, and what it prints."""
    done = subprocess.run(
        [sys.executable, "-X", "importtime", *arguments],
        capture_output=True,
        text=True,
        check=False,
    )
    lines = done.stderr.splitlines()
    times = [line for line in lines if line.startswith("import time:")]
    assert done.returncode == 0, "\n".join(line for line in lines if line not in times)
    return {line.rsplit("|", 1)[1].strip().split(".")[0] for line in times}, done.stdout


def test_import_loads_nothing_heavy() -> None:
    packages, said = loaded("-c", "import rovernav")
    assert "rovernav" in packages
    assert packages.isdisjoint({*HEAVY, "numpy"})
    assert said == ""


def test_help_loads_nothing_heavy() -> None:
    packages, said = loaded(str(COMMAND), "--help")
    assert "rovernav" in packages
    assert packages.isdisjoint(HEAVY)
    assert "rovernav" in said
