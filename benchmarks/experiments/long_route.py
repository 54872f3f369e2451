"""A long route over a raster larger than memory: seconds, memory, and how close to the optimum.

    python benchmarks/experiments/long_route.py [--cells 40000] [--folder /tmp] [--rover NAME]

Makes ground with cells of 2.5 m as a tiled and compressed GeoTIFF: self-affine relief that is
repeated every 4096 cells, rough in some regions and smooth in others, on hills of 1500 m, with
holes, all of it by one seed. It asks `rovernav route` in a process of its own for the way
from corner to corner; and compares parts of it with the optimum of a planner that looks at all
cells of a window around the part at once. The file is deleted afterwards. Wall time depends on the
disk and on what else runs; processor time less so.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
import rasterio
from rasterio.windows import Window as Area
from scipy import ndimage

from rovernav.plan import directed, going
from rovernav.rover import hazards, read_rover
from rovernav.terrain import Window, open_raster

CELL, SEED, ROWS = 2.5, 11, 512
RISE = 0.48
"""Rms height between neighbouring posts where the ground is of mean roughness [m]."""
WIDE = 6000
"""Cells along a side of the windows that are planned on at once."""


def main() -> None:
    """Make, route, compare, print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cells", type=int, default=40_000)
    parser.add_argument("--folder", type=Path, default=Path(tempfile.gettempdir()))
    parser.add_argument("--rover", default="perseverance")
    parser.add_argument("--objective", default="distance")
    parser.add_argument("--keep", action="store_true", help="keep and use again the file")
    asked = parser.parse_args()
    file = asked.folder / f"long-route-{asked.cells}.tif"
    if not file.exists():
        _make(file, asked.cells)
    print(f"{file.stat().st_size / 1e9:.2f} GB on disk, {asked.cells:,} x {asked.cells:,} cells")
    try:
        told, way = _route(file, asked)
        if told["status"] == "found":
            _compare(file, asked.rover, way)
    finally:
        if not asked.keep:
            file.unlink()


def _make(file: Path, cells: int) -> None:
    began, rng = time.perf_counter(), np.random.default_rng(SEED)
    fine = _fractal(rng, 4096, 0.85)
    fine *= RISE / np.diff(fine, axis=1).std()
    hills, rough, lakes = (_fractal(rng, 512, 0.9) for _ in range(3))
    hills *= 1500.0 / np.ptp(hills)
    rough = 0.5 + 1.2 * np.clip(rough / rough.std() - 0.6, 0.0, 1.0)  # islands
    profile: dict[str, Any] = {
        "driver": "GTiff", "count": 1, "height": cells, "width": cells, "dtype": "float32",
        "nodata": float("nan"), "tiled": True, "blockxsize": 256, "blockysize": 256,
        "compress": "deflate", "zlevel": 1, "predictor": 3, "BIGTIFF": "YES",
        "num_threads": "all_cpus",
        "transform": rasterio.Affine(CELL, 0.0, 0.0, 0.0, -CELL, cells * CELL),
    }  # fmt: skip
    columns = np.arange(cells)
    with rasterio.Env(GDAL_CACHEMAX=256), rasterio.open(file, "w", **profile) as data:
        for top in range(0, cells, ROWS):
            rows = np.arange(top, min(top + ROWS, cells))
            wide = fine[np.ix_(rows % len(fine), columns % len(fine))]
            heights = wide * _between(rough, rows, columns, cells)
            heights += _between(hills, rows, columns, cells)
            heights[_between(lakes, rows, columns, cells) > 1.8 * lakes.std()] = np.nan
            data.write(np.round(heights, 2), 1, window=Area(0, top, cells, len(rows)))
            print(f"\rmade {rows[-1] + 1:,} rows, {time.perf_counter() - began:.0f} s", end="")
    print()


def _fractal(rng: np.random.Generator, n: int, hurst: float) -> Any:
    """Periodic self-affine relief (n, n), float32."""
    k = np.hypot(np.fft.fftfreq(n)[:, None], np.fft.rfftfreq(n)[None])
    k[0, 0] = np.inf
    spectrum = np.fft.rfft2(rng.normal(size=(n, n))) * k ** (-1.0 - hurst)
    return np.fft.irfft2(spectrum, (n, n)).astype(np.float32)


def _between(coarse: Any, rows: Any, columns: Any, cells: int) -> Any:
    """A coarse periodic field stretched over all cells, bilinear."""
    n = len(coarse)
    parts = []
    for at in (rows, columns):
        place = at * (n / cells)
        low = place.astype(int)
        parts.append((low, (low + 1) % n, (place - low).astype(np.float32)))
    (i, up, v), (j, right, u) = parts
    lines = coarse[i] * (1.0 - v[:, None]) + coarse[up] * v[:, None]
    return lines[:, j] * (1.0 - u) + lines[:, right] * u


def _route(file: Path, asked: argparse.Namespace) -> tuple[dict[str, Any], Any]:
    """What the command says, and its way; prints what it took."""
    far = 0.94 * asked.cells * CELL
    near = 0.06 * asked.cells * CELL
    ends = _free_ends(file, asked.rover, ((near, near), (far, far)))
    out = Path(tempfile.mkdtemp())
    words = [
        sys.executable, "-m", "rovernav", "route", str(file), "--frame", "local",
        "--from", f"{ends[0][0]},{ends[0][1]}", "--to", f"{ends[1][0]},{ends[1][1]}",
        "--rover", asked.rover, "--objective", asked.objective, "--json", "--out", str(out),
    ]  # fmt: skip
    began = time.perf_counter()
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    wall = time.perf_counter() - began
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode:
        raise SystemExit(done.stderr)
    told = json.loads(done.stdout)
    print(
        f"{told['status']}: {wall:.1f} s, {used.ru_utime + used.ru_stime:.1f} s of processor time, "
        f"{used.ru_maxrss / 1e6:.2f} GB at most"
    )
    print(told["reason"] or (
        f"{told['length_m'] / 1e3:.2f} km for {told['straight_m'] / 1e3:.2f} km in a straight "
        f"line, {told['forbidden_share']:.1%} forbidden, {told['points']:,} points, blocks of "
        f"{told['block']}"
    ))  # fmt: skip
    table = np.genfromtxt(out / "route.csv", delimiter=",", names=True)
    print("pictures:", out / "route.png", os.path.getsize(out / "route.png"))
    return told, np.column_stack([table["x_m"], table["y_m"]])


def _free_ends(file: Path, rover: str, wanted: Any) -> list[Any]:
    """The places nearest to those wanted that are free and not enclosed nearby."""
    raster, who = open_raster(file), read_rover(rover)
    ends = []
    for x, y in wanted:
        row, column = round(y / CELL) - 200, round(x / CELL) - 200
        part = raster.read(Window(row=row, column=column, rows=400, columns=400))
        pieces, _count = ndimage.label(hazards(part, who).blocked == 0)
        free = np.argwhere(pieces == np.bincount(pieces.ravel())[1:].argmax() + 1)
        i, j = free[((free - 200) ** 2).sum(axis=1).argmin()]
        ends.append(((column + j + 0.5) * CELL, (row + i + 0.5) * CELL))
    return ends


def _compare(file: Path, rover: str, way: Any) -> None:
    """Parts of the way against the optimum over all cells of a window around each."""
    raster, who = open_raster(file), read_rover(rover)
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(way, axis=0).T))])
    span = 0.5 * WIDE * CELL
    for share in (0.05, 0.25, 0.5, 0.75, 0.9):
        low = np.searchsorted(along, share * along[-1])
        high = min(np.searchsorted(along, along[low] + span), len(way) - 1)
        piece = way[low : high + 1]
        middle = np.round(0.5 * (piece.min(axis=0) + piece.max(axis=0)) / CELL).astype(int)
        first = np.clip(middle - WIDE // 2, 0, np.array(raster.frame.shape[::-1]) - WIDE)
        first = np.maximum(first, 0)
        rows, columns = (min(WIDE, side) for side in raster.frame.shape)
        window = Window(row=int(first[1]), column=int(first[0]), rows=rows, columns=columns)
        ground = going(hazards(raster.read(window), who), who)
        here = piece - first * CELL
        best = directed(ground, here[0], here[-1])
        print(
            f"from {along[low] / 1e3:.1f} km on: {along[high] - along[low]:,.1f} m against "
            f"{best.length:,.1f} m over all {WIDE:,} x {WIDE:,} cells at once, "
            f"{(along[high] - along[low]) / best.length:.4f} times"
        )


if __name__ == "__main__":
    main()
