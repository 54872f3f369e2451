"""How rough ground is at each scale: structure functions, Hurst exponent, rms slope.

Symbols: z height [m], h lag [cells], S(h) = mean (z(x+h) - z(x))^2, and the second one
D(h) = mean (z(x-h) - 2 z(x) + z(x+h))^2, which no plane enters. On self-affine ground both grow as
h^(2H), D(h) = S(h) (4 - 2^(2H)), and the rms slope over a baseline L is sqrt(S(L)) / L
(M. K. Shepard et al., The roughness of natural terrain, J. Geophys. Res. 106, 2001).
Pairs and triples with a missing height are left out.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from ..core import F64, Float, SettingError
from ._elevation import Terrain

FEWEST = 50
"""Fewer triples than this give no estimate."""

LARGEST = 0.95
"""Hurst exponents are taken as at most this, the smoothest that R. Orosei et al. (J. Geophys. Res.
108, 2003) find on Mars: heights matched over patches seem smoother than the ground is."""


def structure(terrain: Terrain, lags: Sequence[int]) -> F64:
    """S(h) [m^2] of each lag [cells], the mean of both axes; NaN where no pair is known.

    Raises:
        SettingError: A lag is below 1 or does not fit onto the ground.
    """
    z = terrain.height
    for h in lags:
        if not 1 <= h < min(z.shape):
            raise SettingError(f"lags must lie in 1 to {min(z.shape) - 1} cells, got {h}")
    return np.array([_mean([_first(z, h), _first(z.T, h)]) for h in lags])


def hurst_exponent(terrain: Terrain, lags: Sequence[int] = (1, 2, 4, 8)) -> float:
    """Hurst exponent: half the slope of log S over log h at the lags [cells].

    Raises:
        SettingError: A lag does not fit, or ground at one of them is level or unknown.
    """
    s = structure(terrain, lags)
    if not (s > 0).all():
        raise SettingError("a Hurst exponent needs ground that rises and falls at every lag")
    return float(np.polyfit(np.log(lags), np.log(s), 1)[0] / 2.0)


def rms_slope(terrain: Terrain, baseline: float) -> float:
    """Root mean square slope [1] along a baseline [m], rounded to whole cells.

    Raises:
        SettingError: The baseline is longer than the ground.
    """
    lag = max(1, round(baseline / terrain.frame.cell))
    return math.sqrt(float(structure(terrain, [lag])[0])) / (lag * terrain.frame.cell)


AXES = ((0, 1), (1, 0))
"""Rows and columns of a step of one lag to the east and to the north."""


def second_structure(
    parts: Iterable[Float], lags: Sequence[int], steps: Sequence[tuple[int, int]] = AXES
) -> F64:
    """D [m^2] over several arrays (h, w): one row per lag, one column per direction.

    A triple lies one lag times a step apart: rows and columns, rows 0 or above. NaN where fewer
    than `FEWEST` triples are known.
    """
    total, count = np.zeros((2, len(lags), len(steps)))
    for z in parts:
        z = np.asarray(z, np.float64)
        for row, lag in enumerate(lags):
            for k, (i, j) in enumerate(steps):
                bend = _bend(z, lag * i, lag * j)
                if bend is not None:
                    bend = bend[np.isfinite(bend)]
                    count[row, k] += bend.size
                    total[row, k] += float(np.square(bend).sum())
    return np.where(count >= FEWEST, total / np.maximum(count, 1), np.nan)


def self_affine(parts: Iterable[Float], lags: Sequence[int]) -> tuple[float, float]:
    """Hurst exponent and S(1) [m^2] of the self-affine part of ground, whatever its tilt.

    Both come from a line through log D over log h along the axes. The exponent is kept within
    0.3 to `LARGEST`.

    Raises:
        SettingError: Too little ground is known at every lag, or it is level.
    """
    d = second_structure(parts, lags).mean(axis=1)
    known = np.isfinite(d) & (d > 0)
    if known.sum() < 2:
        raise SettingError(
            "too little of the ground is known, or it is level: its roughness cannot be measured; "
            "give the Hurst exponent and the slope yourself"
        )
    x, y = np.log(np.array(lags)[known]), np.log(d[known])
    hurst = min(max(float(np.polyfit(x, y, 1)[0]) / 2.0, 0.3), LARGEST)
    first = math.exp(float((y - 2.0 * hurst * x).mean()))
    return hurst, first / (4.0 - 2.0 ** (2.0 * hurst))


def _bend(z: F64, i: int, j: int) -> F64 | None:
    """The first of three heights - 2 the second + the third; None where they do not fit."""
    h, w = z.shape
    if 2 * i >= h or 2 * abs(j) >= w:
        return None
    if j < 0:
        z, j = z[:, ::-1], -j
    rows, columns = h - 2 * i, w - 2 * j
    near, middle, far = (z[n * i : n * i + rows, n * j : n * j + columns] for n in range(3))
    return near - 2.0 * middle + far


def _first(z: Float, h: int) -> F64:
    z = np.asarray(z, np.float64)
    return np.square(z[:, h:] - z[:, :-h])


def _mean(parts: Sequence[F64]) -> float:
    known = [part[np.isfinite(part)] for part in parts]
    count = sum(part.size for part in known)
    return sum(float(part.sum()) for part in known) / count if count else math.nan
