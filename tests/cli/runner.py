"""The command line in this process: fast, with what it printed."""

from __future__ import annotations

import contextlib
import io
import json
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from rovernav.cli import main


class Said(NamedTuple):
    code: int
    out: str
    err: str


def run(*words: str | Path) -> Said:
    """Exit code, standard output and error stream of ``rovernav WORDS``."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main([str(word) for word in words])
    return Said(code, out.getvalue(), err.getvalue())


def tell(*words: str | Path, code: int = 0) -> dict[str, Any]:
    """The one JSON object that ``rovernav WORDS --json`` prints."""
    said = run(*words, "--json")
    assert said.code == code, said.err
    report = json.loads(said.out)
    assert isinstance(report, dict)
    return report


def write_ground(path: Path, **changes: Any) -> Path:
    """A GeoTIFF whose rows, columns, sides and heights all differ: nothing is symmetric.

    60 x 40 cells of half a metre at x from -7 to 23 and y from -11 to 9, with a wall in the way.
    """
    import rasterio

    column, row = np.meshgrid(np.arange(60.0), np.arange(40.0))
    heights = 0.01 * column + 0.02 * row
    heights[12:22, 30:33] += 5.0
    profile: dict[str, Any] = {
        "driver": "GTiff", "count": 1, "dtype": "float32", "width": 60, "height": 40,
        "crs": "EPSG:32633", "transform": rasterio.Affine(0.5, 0.0, -7.0, 0.0, -0.5, 9.0),
    }  # fmt: skip
    profile |= changes
    with rasterio.open(path, "w", **profile) as file:
        for band in range(1, profile["count"] + 1):
            file.write(heights.astype(profile["dtype"]), band)
    return path
