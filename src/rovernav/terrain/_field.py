"""Self-affine relief of which any part can be had by itself.

It is a sum of smooth random fields with nodes 1, 2, 4, ... cells apart (kernels/field.py). A field
of cubic B-splines with nodes l apart and variance s^2 has the structure function

    S(h) = 2 s^2 (1 - B7(h / l) / B7(0))   along an axis,

B7 being the B-spline of degree 7, the autocorrelation of the cubic one (M. Unser, Splines: a
perfect fit for signal and image processing, IEEE Signal Processing Magazine 16, 1999). The
variances are fitted, none below zero, so that the sum follows the structure function that was asked
for.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from ..core import F64, value
from ..kernels import field as k

SHARE = 151.0 / 315.0
"""Mean square of a cubic B-spline's weights: B7(0)."""
OUTER = 64.0
"""Waves up to this many times the extent, so that the largest are not missed."""

Law = Callable[[F64], F64]
"""Structure function S [m^2] at lags [m]."""


@value
class Field:
    """Random relief over an endless grid.

    Attributes:
        cell: Side of a cell [m].
        spacing: Nodes of each part (k,) [cells].
        rms: Rms height of each part (k,) [m].
        grain: Rms height of what cells do not share [m].
        seed: Where the randomness comes from.
        channel: Keeps fields of one seed apart.
    """

    cell: float
    spacing: F64
    rms: F64
    grain: float
    seed: int
    channel: int

    def add_to(self, out: F64, row: int, column: int) -> None:
        """Add the relief of the cells from (row, column) on to `out` (h, w) [m]."""
        for n, (spacing, rms) in enumerate(zip(self.spacing, self.rms, strict=True)):
            if rms > 0.0:
                k.add_waves(out, row, column, 1.0 / spacing, self._key(n), rms / SHARE)
        if self.grain > 0.0:
            k.add_grain(out, row, column, self._key(-1), self.grain)

    def structure(self, lags: F64) -> F64:
        """Expected S [m^2] at lags [m] along an axis."""
        columns = [2.0 * s**2 * (1.0 - _correlation(lags / (self.cell * n)))
                   for n, s in zip(self.spacing, self.rms, strict=True)]  # fmt: skip
        return np.sum(columns, axis=0) + 2.0 * self.grain**2

    def _key(self, part: int) -> Any:
        return key_of(self.seed, self.channel, part)


def key_of(seed: int, channel: int, part: int) -> Any:
    """64 bits for one random field; fields of other channels and parts have others."""
    words = np.random.SeedSequence([seed, channel, part + 1]).generate_state(1, np.uint64)
    return words[0]


def fitted_field(
    law: Law, cell: float, *, longest: float, farthest: float, seed: int, channel: int
) -> Field:
    """A field whose structure function follows `law` from one cell to the lag `farthest`.

    Args:
        law: S [m^2] at lags [m].
        cell: Side of a cell [m].
        longest: Largest spacing of nodes [m].
        farthest: Largest lag that is fitted [m].
        seed: Where the randomness comes from.
        channel: Keeps fields of one seed apart.
    """
    from scipy.optimize import nnls

    parts = max(1, 1 + math.floor(math.log2(max(longest / cell, 1.0)) + 1e-9))
    spacing: F64 = np.exp2(np.arange(parts, dtype=np.float64))
    count = max(1, 1 + math.floor(2.0 * math.log2(max(farthest / cell, 1.0)) + 1e-9))
    lags = np.unique(np.rint(2.0 ** (0.5 * np.arange(count)))) * cell
    wanted = law(lags)
    shapes = [2.0 * (1.0 - _correlation(lags / (cell * n))) for n in spacing]
    matrix = np.column_stack([*shapes, np.full(len(lags), 2.0)]) / wanted[:, None]
    # a little of a power law in each part: no scale is left empty where lags leave a choice
    size = spacing ** (2.0 * _steepness(wanted, lags))
    matrix = matrix * np.append(size, size[0])
    smooth = 1e-3 * (np.eye(parts + 1)[:-2] - np.eye(parts + 1)[1:-1])
    found, _ = nnls(np.vstack([matrix, smooth * matrix[0, 0]]), np.append(
        np.ones(len(lags)), np.zeros(len(smooth))))  # fmt: skip
    variance = found * np.append(size, size[0])
    return Field(
        cell=cell, spacing=spacing, rms=np.sqrt(variance[:-1]), grain=math.sqrt(variance[-1]),
        seed=seed, channel=channel,
    )  # fmt: skip


def self_affine_law(hurst: float, slope: float, baseline: float) -> Law:
    """S(h) = (slope * baseline)^2 (h / baseline)^(2 hurst)."""

    def law(lags: F64) -> F64:
        return (slope * baseline) ** 2 * (lags / baseline) ** (2.0 * hurst)

    return law


def _steepness(wanted: F64, lags: F64) -> float:
    if len(lags) < 2:
        return 0.8
    return float(np.polyfit(np.log(lags), np.log(wanted), 1)[0]) / 2.0


def _correlation(t: F64) -> F64:
    """B7(t) / B7(0)."""
    return np.nan_to_num(_septic()(np.asarray(t, np.float64))) / SHARE


@functools.cache
def _septic() -> Any:
    from scipy.interpolate import BSpline

    return BSpline.basis_element(np.arange(9) - 4.0, extrapolate=False)
