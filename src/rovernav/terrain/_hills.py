"""Generated ground: rolling hills like those of Mars, with craters.

Symbols: H Hurst exponent, f spatial frequency [1/m], D crater diameter [m], R its radius [m].
"""

from __future__ import annotations

import math

import numpy as np

from ..core import F64, Frame, SettingError
from ._elevation import Terrain

SETTLED = 12.0
"""Waves shorter than this are levelled [cells], as dust and small impacts level real ground."""

SMALLEST_CRATER = 8
"""Diameter of the smallest crater [cells]; smaller ones would be a few posts only."""


def hills(
    rng: np.random.Generator,
    *,
    shape: tuple[int, int] = (256, 256),
    cell: float = 0.5,
    relief: float = 10.0,
    hurst: float = 0.9,
    craters: int = 40,
) -> Terrain:
    """Hilly ground that looks like Mars; the same seed gives the same ground.

    Hills are random waves whose amplitude falls with frequency as f^-(H+1) (spectral synthesis;
    Voss, in The Science of Fractal Images, 1988). Craters are strewn on top, few large and many
    small, fresh ones and worn ones.

    Args:
        rng: The only source of chance.
        shape: Rows and columns, at least 3 each.
        cell: Side of a cell [m].
        relief: Highest minus lowest height before the craters come [m]; 0 is a plain.
        hurst: Roughness between 0 (jagged) and 1 (smooth); Mars has about 0.7 to 0.95.
        craters: How many craters.

    Raises:
        SettingError: A number that gives no ground; the sentence names what is allowed.
    """
    frame = Frame(cell=cell, shape=_checked(shape, relief, hurst, craters))
    heights = _waves(rng, shape, hurst)
    spread = float(heights.max() - heights.min())
    heights *= relief / spread
    for x, y, diameter, age in _crater_list(rng, frame, craters):
        add_crater(heights, frame, (x, y), diameter, depth=0.2 * diameter * (1.0 - age))
    name = f"hills-{shape[0]}x{shape[1]}"
    made = f"generated hills, {relief:g} m relief, Hurst exponent {hurst:g}, {craters} craters"
    return Terrain.from_heights(heights, frame, name=name, source=made)


def add_crater(
    heights: F64, frame: Frame, centre: tuple[float, float], diameter: float, *, depth: float
) -> None:
    """Dig one bowl-shaped crater into `heights` (h, w), in place.

    The bowl is a parabola from the floor to the rim; the rim stands up a fifth of the depth and
    falls off outside as (R/r)^3 (after H. J. Melosh, Impact Cratering, 1989). Fresh craters are
    about a fifth as deep as wide, worn ones shallower.

    Args:
        heights: Ground to change [m].
        frame: Where its cells lie.
        centre: Local x, y of the middle [m]; it may lie off the grid.
        diameter: From rim to rim [m].
        depth: From rim to floor [m].
    """
    h, w = frame.shape
    x = (np.arange(w) + 0.5) * frame.cell - centre[0]
    y = (np.arange(h) + 0.5) * frame.cell - centre[1]
    r = np.hypot(x[None, :], y[:, None]) / (diameter / 2.0)
    rim = 0.2 * depth
    outside = rim / np.maximum(r, 1.0) ** 3
    bowl = rim - depth * (1.0 - np.minimum(r, 1.0) ** 2)
    heights += np.where(r < 1.0, bowl, outside)


def _checked(shape: tuple[int, int], relief: float, hurst: float, craters: int) -> tuple[int, int]:
    if min(shape) < 3 or shape[0] * shape[1] > 40_000_000:
        raise SettingError(f"hills need 3 x 3 to 40 million cells, got shape {shape}")
    if not 0.0 <= relief <= 1e4:
        raise SettingError(f"relief must lie in 0 to 10000 m, got {relief}")
    if not 0.0 < hurst <= 1.0:
        raise SettingError(
            f"the Hurst exponent must lie above 0 and up to 1, got {hurst}; 0.9 is smooth ground"
        )
    if not 0 <= craters <= 100_000:
        raise SettingError(f"the number of craters must lie in 0 to 100000, got {craters}")
    return shape


def _waves(rng: np.random.Generator, shape: tuple[int, int], hurst: float) -> F64:
    """Random waves (h, w) of any scale; made on a grid twice as large, for waves wrap around."""
    side = 2 * max(shape)
    f = np.hypot(np.fft.fftfreq(side)[:, None], np.fft.rfftfreq(side)[None, :])
    f[0, 0] = np.inf  # no mean height
    noise = np.fft.rfft2(rng.standard_normal((side, side)))
    settled = 1.0 + (f * SETTLED) ** 2
    settled[0, 0] = 1.0
    waves = np.fft.irfft2(noise * f ** -(hurst + 1.0) / settled, s=(side, side))
    return np.ascontiguousarray(waves[: shape[0], : shape[1]])


def _crater_list(
    rng: np.random.Generator, frame: Frame, count: int
) -> list[tuple[float, float, float, float]]:
    """For each its x, y, diameter [m] and wear (0 fresh, 1 gone); number above D falls as D^-2."""
    width, height = frame.extent
    small = SMALLEST_CRATER * frame.cell
    large = max(small, math.sqrt(width * height) / 4.0)
    u = rng.random((count, 4))
    diameter = (small**-2 - u[:, 2] * (small**-2 - large**-2)) ** -0.5
    columns = (u[:, 0] * width, u[:, 1] * height, diameter, 0.9 * u[:, 3])
    order = np.argsort(-diameter)  # large ones first: small ones are dug into them
    return [tuple(row) for row in np.stack(columns, axis=1)[order].tolist()]
