"""Whether made ground is what was asked for: each part measured by itself, beside the request."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..core import F64
from ._elevation import Terrain
from ._making import Ground
from ._raster import Window
from ._relief import slope
from ._roughness import hurst_exponent, rms_slope

LARGEST = 2048
"""Ground with longer sides is measured in a square of so many cells in its middle."""


def measured(ground: Ground) -> dict[str, Any]:
    """Measured statistics of made ground, each beside what was asked for.

    Keys: ``area_m2`` of the square that was measured, ``slope_deg`` (percentiles of all of it) and
    one group for each part of the recipe. Angles are in degrees, lengths in metres.
    """
    h, w = ground.frame.shape
    rows, columns = min(h, LARGEST), min(w, LARGEST)
    window = Window(row=(h - rows) // 2, column=(w - columns) // 2, rows=rows, columns=columns)
    parts, terrain = ground.parts(window), ground.read(window)
    cell = ground.frame.cell
    area = rows * columns * cell**2
    degrees = np.degrees(slope(terrain))
    at = np.nanpercentile(degrees, (50, 95, 99)) if np.isfinite(degrees).any() else [math.nan] * 3
    out: dict[str, Any] = {
        "area_m2": area,
        "slope_deg": dict(zip(("p50", "p95", "p99"), map(float, at), strict=True)),
        "holes": {"asked": ground.recipe.holes, "measured": 1.0 - terrain.finite},
    }
    out |= _relief(ground, parts["relief"])
    edges = (window.column * cell, window.row * cell,
             (window.column + columns) * cell, (window.row + rows) * cell)  # fmt: skip
    out |= _strewn(ground, parts, area, edges)
    out |= _forms(ground, parts)
    return out


def _relief(ground: Ground, heights: F64) -> dict[str, Any]:
    r = ground.recipe.relief
    if r.slope == 0.0:
        return {}
    terrain = Terrain.from_heights(
        heights, ground.frame.part(0, 0, heights.shape), name="relief", source="relief"
    )
    most = min(heights.shape) // 8
    lags = [n for n in (1, 2, 4, 8, 16, 32) if n <= max(most, 2)]
    return {
        "hurst": {"asked": r.hurst, "measured": hurst_exponent(terrain, lags)},
        "rms_slope_deg": {
            "asked": math.degrees(r.slope),
            "measured": math.degrees(math.atan(rms_slope(terrain, r.baseline)))
            if r.baseline < min(terrain.frame.extent)
            else None,
            "baseline_m": r.baseline,
        },
    }


def _strewn(
    ground: Ground, parts: dict[str, Any], area: float, edges: tuple[float, float, float, float]
) -> dict[str, Any]:
    out: dict[str, Any] = {}
    recipe = ground.recipe
    for name, many in (("craters", recipe.craters), ("pits", recipe.pits)):
        if many is not None:
            inside = _inside(parts[name], edges)
            largest = float(inside[:, 2].max()) if len(inside) else 0.0
            out[name] = {"expected": many.expected(area), "count": len(inside),
                         "largest_m": largest}  # fmt: skip
    rocks = recipe.rock_field()
    if rocks is not None:
        inside = _inside(parts["rocks"], edges)
        cover = float((math.pi / 4.0 * inside[:, 2] ** 2).sum()) / area
        out["rocks"] = {"asked_cover": rocks.cover, "cover": cover, "count": len(inside),
                        "expected": rocks.expected(area), "smallest_m": rocks.smallest,
                        "largest_m": rocks.largest}  # fmt: skip
    return out


def _forms(ground: Ground, parts: dict[str, Any]) -> dict[str, Any]:
    out: dict[str, Any] = {}
    recipe, cell = ground.recipe, ground.frame.cell
    if recipe.dunes is not None:
        z = parts["dunes"]
        out["dunes"] = {
            "asked_wavelength_m": recipe.dunes.wavelength,
            "wavelength_m": _wavelength(z, cell, recipe.dunes.wind),
            "asked_height_m": recipe.dunes.height,
            "height_m": float(z.max() - z.min()),
        }
    if recipe.cliffs is not None:
        z = parts["cliffs"]
        rise = np.hypot(*np.gradient(z, cell))
        out["cliffs"] = {
            "asked_height_m": recipe.cliffs.height,
            "height_m": float(z.max() - z.min()),
            "steepest_deg": math.degrees(math.atan(float(rise.max()))),
            "plateau_share": float((z > recipe.cliffs.height / 2.0).mean()),
        }
    return out


def _wavelength(z: F64, cell: float, wind: float) -> float:
    """Wavelength along the wind [m]: one over the mean frequency, by power, near the peak."""
    power = np.abs(np.fft.rfft2(z - z.mean())) ** 2
    fy, fx = np.fft.fftfreq(z.shape[0], cell)[:, None], np.fft.rfftfreq(z.shape[1], cell)[None, :]
    along = np.abs(fx * math.sin(wind) + fy * math.cos(wind))
    i, j = np.unravel_index(int(np.argmax(power)), power.shape)
    peak = float(along[i, j])
    near = (along > 0.6 * peak) & (along < 1.5 * peak)
    return float(power[near].sum() / (power[near] * along[near]).sum())


def _inside(rows: F64, edges: tuple[float, float, float, float]) -> F64:
    west, south, east, north = edges
    x, y = rows[:, 0], rows[:, 1]
    return rows[(x >= west) & (x < east) & (y >= south) & (y < north)]
