"""Finer ground under a coarse elevation model, of which any window can be had by itself.

Orbital models have posts metres apart; wheels are half a metre wide. What lies between posts is not
known, but its statistics can be carried on: the self-affine spectrum that the model shows at its
own posts is continued below them, and rocks are strewn by the law of their sizes. Symbols: L posts
apart [m], H Hurst exponent, S structure function, n fine cells along a post.

The fine ground is a smooth surface through the posts plus random relief with

    S(h) = S(L) ((h / L)^(2H) - (h / L)^2)   for h < L,

the second term being what a surface that is smooth between posts has already, plus rocks. The mean
over each coarse cell is then brought back to its post, so that the large scale stays as it was.
H and S(L) come from second differences at 1, 2, 4 and 8 posts, which no slope of the whole enters;
where the file is noisy or coarsely rounded, from 8, 16 and 32.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any, TypeAlias

import numpy as np

from ..core import F64, Frame, SettingError, value
from ..kernels import refine as k
from ._elevation import Terrain
from ._field import Field, fitted_field
from ._making import STRIP
from ._quality import quality, sample
from ._raster import MAX_CELLS, Progress, Raster, Window
from ._rocks import RockField
from ._roughness import self_affine

CHANNEL = 41
MARGIN = 7
"""Posts around a window that its heights may depend on, holes filled from their neighbours."""
FILLS = 4
SMALLEST_ROCK = 2.0
"""Rocks are at least so many fine cells large."""
LARGEST_ROCK = 2.0
"""And at most so large [m], or a post: larger ones are in the model already."""

Coarse: TypeAlias = Terrain | Raster


@value
class Refined:
    """A finer grid under an elevation model; nothing is computed before it is read.

    Attributes:
        coarse: The model.
        n: Fine cells along a coarse one.
        frame: The whole fine grid.
        hurst: Hurst exponent that is continued below the posts.
        post_slope: Root mean square slope between neighbouring posts, without the slope of the
            whole [1].
        relief: The random relief; None where the model is level.
        rocks: The rocks; None where there are none.
        seed: Where all randomness comes from.
        base: Height that float32 heights count from [m].
    """

    coarse: Coarse
    n: int
    frame: Frame
    hurst: float
    post_slope: float
    relief: Field | None
    rocks: RockField | None
    seed: int
    base: float

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the whole fine grid."""
        return self.frame.shape

    def window(self, west: float, south: float, east: float, north: float) -> Window:
        """The fine cells that a rectangle in map coordinates touches; see `Raster.window`."""
        corners = [self.frame.to_local(x, y) for x in (west, east) for y in (south, north)]
        if not (west < east and south < north):
            raise SettingError(
                "a window is written west, south, east, north and spans an area, got "
                f"{west:.10g},{south:.10g},{east:.10g},{north:.10g}"
            )
        x, y = np.array(corners).T / self.frame.cell
        (h, w), slack = self.shape, 1e-6
        row, top = max(0, math.floor(y.min() + slack)), min(h, math.ceil(y.max() - slack))
        column, right = max(0, math.floor(x.min() + slack)), min(w, math.ceil(x.max() - slack))
        if row >= top or column >= right:
            raise SettingError("the window lies off the map; rovernav inspect shows its bounds")
        return Window(row=row, column=column, rows=top - row, columns=right - column)

    def read(self, window: Window | None = None, *, on_progress: Progress | None = None) -> Terrain:
        """Fine ground; the same window has the same bits, whatever was read before.

        Raises:
            SettingError: The window leaves the grid or has more than `MAX_CELLS` cells.
        """
        window = window or Window(row=0, column=0, rows=self.shape[0], columns=self.shape[1])
        self.check(window)
        heights = np.empty((window.rows, window.columns), np.float32)
        for first, part in self._strips(window):
            heights[first : first + part.rows] = self.heights(part) - self.base
            if on_progress is not None:
                on_progress((first + part.rows) / window.rows)
        frame = self.frame.part(window.row, window.column, heights.shape)
        return Terrain(
            frame=frame, height=heights, offset=self.base, name=f"{self.coarse.name}-fine",
            source=f"{self.coarse.source}; {self.words()}",
        )  # fmt: skip

    def heights(self, window: Window) -> F64:
        """Absolute heights (rows, columns) [m] of a window, in full precision."""
        n = self.n
        south, west = window.row // n, window.column // n
        rows = -(-(window.row + window.rows) // n) - south
        columns = -(-(window.column + window.columns) // n) - west
        known, z = self._posts(south, west, rows, columns)
        out = np.empty((rows * n, columns * n))
        k.smooth(z, n, MARGIN, out)
        corner = (west * n * self.frame.cell, south * n * self.frame.cell)
        if self.relief is not None:
            self.relief.add_to(out, south * n, west * n)
        if self.rocks is not None:
            self.rocks.raise_on(out, corner, self.frame.cell, self.seed)
        k.keep_means(np.ascontiguousarray(known), n, _bump(n), out)
        top, left = window.row - south * n, window.column - west * n
        return np.ascontiguousarray(out[top : top + window.rows, left : left + window.columns])

    def statistics(self) -> dict[str, Any]:
        """What was continued, and what the fine relief has by it; slopes in degrees."""
        cell = self.frame.cell
        fine = 0.0 if self.relief is None else float(self.relief.structure(np.array([cell]))[0])
        return {
            "post_m": self.coarse.frame.cell,
            "cell_m": cell,
            "cells_per_post": self.n,
            "hurst": self.hurst,
            "rms_slope_deg_at_posts": math.degrees(math.atan(self.post_slope)),
            "added_rms_slope_deg_at_cells": math.degrees(math.atan(math.sqrt(fine) / cell)),
            "rock_cover": 0.0 if self.rocks is None else self.rocks.cover,
            "rock_abundance": None if self.rocks is None else self.rocks.abundance,
            "rock_sizes_m": None if self.rocks is None
            else [self.rocks.smallest, self.rocks.largest],
            "seed": self.seed,
        }  # fmt: skip

    def words(self) -> str:
        """What was added, in a line."""
        rocks = "" if self.rocks is None else f", rocks over {self.rocks.abundance:.1%}"
        return (f"refined to {self.frame.cell:.4g} m with Hurst exponent {self.hurst:.2f}{rocks}, "
                f"seed {self.seed}")  # fmt: skip

    def _strips(self, window: Window) -> Any:
        rows = max(self.n, STRIP // max(1, window.columns) // self.n * self.n)
        first = 0
        while first < window.rows:
            row = window.row + first
            count = min(rows - row % self.n, window.rows - first)
            yield first, dataclasses.replace(window, row=row, rows=count)
            first += count

    def _posts(self, south: int, west: int, rows: int, columns: int) -> tuple[F64, F64]:
        """Coarse heights of a window; and with a margin around, holes and edges filled."""
        h, w = self.coarse.frame.shape
        low, left = max(0, south - MARGIN), max(0, west - MARGIN)
        top, right = min(h, south + rows + MARGIN), min(w, west + columns + MARGIN)
        window = Window(row=low, column=left, rows=top - low, columns=right - left)
        z = _coarse_heights(self.coarse, window)
        known = z[south - low : south - low + rows, west - left : west - left + columns]
        filled = _filled(z)
        pad = ((low - south + MARGIN, south + rows + MARGIN - top),
               (left - west + MARGIN, west + columns + MARGIN - right))  # fmt: skip
        return known, np.ascontiguousarray(np.pad(filled, pad, mode="edge"))

    def check(self, window: Window | None) -> None:
        """Whether a window, or all of it, can be read.

        Raises:
            SettingError: It leaves the grid or has more than `MAX_CELLS` cells.
        """
        window = window or Window(row=0, column=0, rows=self.shape[0], columns=self.shape[1])
        h, w = self.shape
        if window.row + window.rows > h or window.column + window.columns > w:
            raise SettingError(f"{window} leaves the fine grid of {h:,} x {w:,} cells")
        if window.rows * window.columns > MAX_CELLS:
            raise SettingError(
                f"{window.columns:,} x {window.rows:,} fine cells are more than {MAX_CELLS:,} at a "
                "time; read a part with --window WEST,SOUTH,EAST,NORTH or give a larger --cell"
            )


def refine(
    coarse: Coarse,
    cell: float,
    *,
    seed: int = 0,
    rocks: float | None = None,
    hurst: float | None = None,
    slope: float | None = None,
) -> Refined:
    """Finer ground under an elevation model: see the head of this file.

    Args:
        coarse: A terrain, or a raster of any size.
        cell: Largest side of a fine cell [m]; a whole number of them makes a coarse cell.
        seed: Where all randomness comes from.
        rocks: Share of the ground that rocks of all sizes cover (Golombek and Rapp 1997).
        hurst: Hurst exponent below the posts; that of the model where not given.
        slope: Rms slope between neighbouring posts [rad]; that of the model where not given.

    Raises:
        SettingError: A number out of range, or a model whose roughness cannot be measured.
    """
    post = coarse.frame.cell
    if not (math.isfinite(cell) and 0.0 < cell <= post):
        raise SettingError(
            f"--cell must lie above 0 and up to the posts of {post:.4g} m, got {cell:g}"
        )
    n = math.ceil(post / cell - 1e-9)
    if n > 10_000 or max(coarse.frame.shape) * n > 2**40:
        raise SettingError(
            f"{n:,} fine cells along a post are more than 10,000; give a larger --cell"
        )
    own_hurst, own_slope = (0.8, 0.0)
    if hurst is None or slope is None:
        own_hurst, own_slope = _continued(coarse)
    h = own_hurst if hurst is None else _checked_hurst(hurst)
    s = own_slope if slope is None else math.tan(_checked_slope(slope))
    (rows, columns), fine = coarse.frame.shape, post / n
    field = RockField(
        abundance=rocks, smallest=max(SMALLEST_ROCK * fine, 0.1),
        largest=max(min(LARGEST_ROCK, post), 4.0 * fine, 0.2),
    ) if rocks is not None else None  # fmt: skip
    frame = Frame(
        cell=fine, shape=(rows * n, columns * n), origin=coarse.frame.origin,
        crs=coarse.frame.crs, axes=coarse.frame.axes,
    )  # fmt: skip
    return Refined(
        coarse=coarse, n=n, frame=frame, hurst=h, post_slope=s,
        relief=_below(h, s * post, post, fine, seed) if s > 0.0 and n > 1 else None,
        rocks=field, seed=seed, base=_base(coarse),
    )  # fmt: skip


def _below(hurst: float, rise: float, post: float, fine: float, seed: int) -> Field:
    """Random relief with the structure that a smooth surface between posts lacks."""

    def law(lags: F64) -> F64:
        share = np.minimum(lags / post, 0.999)
        return rise**2 * (share ** (2.0 * hurst) - share**2)

    return fitted_field(law, fine, longest=post, farthest=0.5 * post, seed=seed, channel=CHANNEL)


def _continued(coarse: Coarse) -> tuple[float, float]:
    """Hurst exponent of a model, and the rms slope between its posts [1]."""
    found = quality(coarse)
    lags = (8, 16, 32) if found.noisy or found.stepped else (1, 2, 4, 8)
    hurst, square = self_affine(sample(coarse), lags)
    return hurst, math.sqrt(square) / coarse.frame.cell


def _checked_hurst(hurst: float) -> float:
    if not 0.2 <= hurst <= 0.98:
        raise SettingError(f"the Hurst exponent must lie in 0.2 to 0.98, got {hurst:g}")
    return hurst


def _checked_slope(slope: float) -> float:
    if not 0.0 <= slope <= math.radians(60.0):
        raise SettingError(f"the rms slope must lie in 0 to 60 deg, got {math.degrees(slope):g}")
    return slope


def _base(coarse: Coarse) -> float:
    """A height near all of them [m], the same for every window."""
    if isinstance(coarse, Terrain):
        return coarse.offset
    middles = [float(np.nanmedian(part)) for part in sample(coarse) if np.isfinite(part).any()]
    return math.floor(float(np.median(middles))) if middles else 0.0


def _coarse_heights(coarse: Coarse, window: Window) -> F64:
    if isinstance(coarse, Raster):
        return np.asarray(coarse.heights(window), np.float64)
    rows = slice(window.row, window.row + window.rows)
    columns = slice(window.column, window.column + window.columns)
    return coarse.height[rows, columns].astype(np.float64) + coarse.offset


def _filled(z: F64) -> F64:
    """Holes filled from their neighbours, ring by ring; far from all posts with 0."""
    if np.isfinite(z).all():
        return z
    z = z.copy()
    for _ in range(FILLS):
        wide = np.pad(z, 1, constant_values=np.nan)
        known = np.isfinite(wide)
        height = np.where(known, wide, 0.0)
        total, count = np.zeros(z.shape), np.zeros(z.shape)
        for di in range(3):
            for dj in range(3):
                part = (slice(di, di + z.shape[0]), slice(dj, dj + z.shape[1]))
                total += height[part]
                count += known[part]
        hole = np.isnan(z) & (count > 0)
        z[hole] = total[hole] / count[hole]
    return np.where(np.isnan(z), 0.0, z)


def _bump(n: int) -> F64:
    """u^2 (1 - u)^2 at the middles of n cells, scaled to a mean of 1: it leaves no crease."""
    u = (np.arange(n) + 0.5) / n
    shape = (u * (1.0 - u)) ** 2
    return shape / shape.mean()
