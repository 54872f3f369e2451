"""What the machine is, and what else it is doing."""

from __future__ import annotations

import importlib.metadata
import os
import platform
import shutil
import subprocess
from pathlib import Path

PACKAGES = (
    *("rovernav", "numpy", "numba", "llvmlite", "scikit-learn", "jax", "jaxlib", "torch"),
    *("onnxruntime", "keras", "scipy", "pyastar2d", "scikit-fmm", "scikit-image", "dijkstra3d"),
    *("networkx", "xarray-spatial", "richdem2", "ompl"),
)
_BUSY = (0, 1, 2, 5, 6)  # /proc/stat: user, nice, system, irq, softirq


def busy() -> float | None:
    """Processor time that the whole machine has used so far [s]; None where nobody tells."""
    try:
        fields = Path("/proc/stat").read_text().split("\n", 1)[0].split()[1:]
    except OSError:
        return None
    return sum(int(fields[i]) for i in _BUSY) / os.sysconf("SC_CLK_TCK")


def others(before: float | None, after: float | None, own: float, wall: float) -> float | None:
    """Cores that other processes used between two readings of `busy`; None where nobody tells."""
    if before is None or after is None:
        return None
    return max(0.0, after - before - own) / wall


def load() -> float:
    """Load of the last minute: processes that were running or waiting to."""
    try:
        return os.getloadavg()[0]
    except OSError:
        return float("nan")


def describe() -> dict[str, str]:
    """Processor, system, compiler and the versions of all peers."""
    about = {
        "processor": _processor(),
        "cores": str(os.cpu_count()),
        "system": platform.system(),
        "python": platform.python_version(),
        "gcc": _gcc(),
    }
    for package in PACKAGES:
        try:
            about[package] = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            about[package] = "this checkout" if package == "rovernav" else "not installed"
    return about


def _processor() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def _gcc() -> str:
    found = shutil.which("gcc")
    if found is None:
        return "not installed"
    said = subprocess.run([found, "-dumpfullversion"], capture_output=True, text=True, check=False)
    return said.stdout.strip() or "unknown"
