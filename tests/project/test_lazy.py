from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np

HEAVY = (
    "dask", "distributed", "matplotlib", "nicegui", "numba", "pydantic", "rasterio", "scipy",
)  # fmt: skip
COMMAND = Path(sys.executable).with_name("rovernav")


def loaded(*arguments: str) -> tuple[set[str], str]:
    """The packages and modules that a fresh Python loads, and what it prints."""
    done = subprocess.run(
        [sys.executable, "-X", "importtime", *arguments],
        capture_output=True,
        text=True,
        check=False,
    )
    lines = done.stderr.splitlines()
    times = [line for line in lines if line.startswith("import time:")]
    assert done.returncode == 0, "\n".join(line for line in lines if line not in times)
    modules = {line.rsplit("|", 1)[1].strip() for line in times}
    return modules | {name.split(".")[0] for name in modules}, done.stdout


def test_import_loads_nothing_heavy() -> None:
    packages, said = loaded("-c", "import rovernav")
    assert "rovernav" in packages
    assert packages.isdisjoint({*HEAVY, "numpy"})
    assert said == ""


def test_a_second_route_loads_nothing_that_it_does_not_need(tmp_path: Path) -> None:
    ground = tmp_path / "ground.npy"
    np.save(ground, np.zeros((24, 24), dtype=np.float32))
    words = [str(COMMAND), "route", str(ground), "--cell", "1", "--frame", "local", "--no-picture"]
    words += ["--from", "3,3", "--to", "20,20", "--out", str(tmp_path / "out")]
    loaded(*words)  # compiles what is not kept yet, with all that Numba needs for it
    modules, said = loaded(*words)
    assert "Found a way" in said
    assert modules >= {"numba", "numpy", "rovernav.plan"}
    others = {"multiprocessing", "rich", "scipy.linalg", "shapely"}  # Numba asks SciPy its version
    rooms = {"rovernav.mapping", "rovernav.scenes", "rovernav.sim"}
    assert modules.isdisjoint({*HEAVY, *others, *rooms} - {"numba", "scipy"})


def test_help_loads_nothing_heavy() -> None:
    packages, said = loaded(str(COMMAND), "--help")
    assert "rovernav" in packages
    assert packages.isdisjoint(HEAVY)
    assert "rovernav" in said
