"""The ground as a picture: shaded relief with a tint of elevation, and forbidden ground on it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from ..core import F32, F64, U8, Frame, ShapeError, value
from ..rover import Reason, Standing
from ..terrain import Terrain, hillshade
from ._words import PURPLE, VERMILION, YELLOW

if TYPE_CHECKING:
    from matplotlib.axes import Axes

PIXELS = 1200
"""Cells along a side above which a picture leaves some out."""
TINT = "cividis"
NOTHING = "#5a5a5a"
"""Ground without data."""
UNSEEN = "#e4e4e4"
"""Ground that was not looked at."""

WHY = {
    Reason.SLOPE: (VERMILION, 0.65, "too steep"),
    Reason.STEP: (PURPLE, 0.75, "step too high"),
    Reason.NO_DATA: (NOTHING, 0.75, "no data"),
    Reason.NEAR: (YELLOW, 0.38, "within the rover's radius"),
}
"""Colour, opacity and words for each reason why the rover must keep off."""

Window = tuple[float, float, float, float]
"""West, south, east, north [m]."""


@value
class Piece:
    """A part of a terrain, thinned out to the size of a picture.

    Attributes:
        height: Heights (h, w) [m], the terrain's offset included; row 0 south.
        shade: Brightness (h, w), 0 to 1.
        extent: West, east, south, north [m], as matplotlib takes it.
        rows: First, last and step of the rows taken.
        columns: First, last and step of the columns taken.
        whole: The frame of the terrain.
    """

    height: F64
    shade: F32
    extent: tuple[float, float, float, float]
    rows: slice
    columns: slice
    whole: Frame


def piece_of(terrain: Terrain, window: Window | None = None, *, pixels: int = PIXELS) -> Piece:
    """The cells of `terrain` within `window` [m], all of it by default, thinned to `pixels`."""
    cell, (h, w) = terrain.frame.cell, terrain.frame.shape
    west, south, east, north = window or (0.0, 0.0, w * cell, h * cell)
    rows, columns = (
        _cells(south, north, cell, h, pixels),
        _cells(west, east, cell, w, pixels),
    )
    step = max(rows.step, columns.step)
    rows, columns = slice(rows.start, rows.stop, step), slice(columns.start, columns.stop, step)
    height = np.ascontiguousarray(terrain.height[rows, columns])
    frame = Frame(cell=cell * step, shape=height.shape)
    part = Terrain(
        frame=frame, height=height, offset=terrain.offset, name=terrain.name, source=terrain.source
    )
    x0, y0 = columns.start * cell, rows.start * cell
    extent = (x0, x0 + frame.extent[0], y0, y0 + frame.extent[1])
    return Piece(
        height=height.astype(np.float64) + terrain.offset,
        shade=hillshade(part),
        extent=extent,
        rows=rows,
        columns=columns,
        whole=terrain.frame,
    )


def draw_relief(axes: Axes, piece: Piece, *, tinted: bool = True) -> Any:
    """Draw shaded relief; returns what a colour bar of elevation [m] needs."""
    from matplotlib.cm import ScalarMappable

    image, norm, tint = _coloured(piece, tinted=tinted)
    axes.imshow(image, origin="lower", extent=piece.extent, interpolation="nearest", zorder=0)
    return ScalarMappable(norm, tint)


def relief_pixels(
    terrain: Terrain,
    *,
    window: Window | None = None,
    standing: Standing | None = None,
    pixels: int = PIXELS,
) -> tuple[U8, Window]:
    """Shaded relief with forbidden ground on it, as colours, in the manner of the pictures.

    Args:
        terrain: The ground.
        window: Which part [m]; all by default.
        standing: Where a rover could stand, drawn by reason.
        pixels: Cells along a side above which some are left out.

    Returns:
        Colours (h, w, 3) with row 0 in the north, and the part that they show: west, south, east,
        north [m].
    """
    piece = piece_of(terrain, window, pixels=pixels)
    image, _, _ = _coloured(piece)
    if standing is not None:
        over, _ = _forbidden(piece, standing)
        image = image * (1.0 - over[..., 3:]) + over[..., :3] * over[..., 3:]
    west, east, south, north = piece.extent
    colours = np.round(255.0 * image[::-1]).astype(np.uint8)
    return np.ascontiguousarray(colours), (west, south, east, north)


def _coloured(piece: Piece, *, tinted: bool = True) -> tuple[F64, Any, Any]:
    """Colours (h, w, 3) from 0 to 1, row 0 south, and the scale and tint of the elevation."""
    from matplotlib import colormaps
    from matplotlib.colors import ListedColormap, Normalize

    pale = 0.58 + 0.42 * colormaps[TINT](np.linspace(0.0, 1.0, 256))[:, :3]
    known = piece.height[np.isfinite(piece.height)]
    low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 0.0)
    norm = Normalize(low, high) if high > low else Normalize(low - 0.5, low + 0.5)
    tint = ListedColormap(pale)
    colour = tint(norm(piece.height))[..., :3] if tinted else np.full((*piece.shade.shape, 3), 0.95)
    image = np.clip(colour * _contrast(piece.shade)[..., None], 0.0, 1.0)
    image[~np.isfinite(piece.height)] = [int(NOTHING[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    return image, norm, tint


def draw_forbidden(axes: Axes, piece: Piece, standing: Standing) -> list[Reason]:
    """Draw where the rover must keep off, by reason; returns the reasons that occur."""
    image, found = _forbidden(piece, standing)
    axes.imshow(image, origin="lower", extent=piece.extent, interpolation="nearest", zorder=1)
    return found


def draw_unseen(axes: Axes, piece: Piece, standing: Standing) -> bool:
    """Draw ground that was not looked at: without a height, and nothing said against it."""
    from matplotlib.colors import to_rgba

    reason: U8 = standing.reason[piece.rows, piece.columns]
    unseen = np.isnan(piece.height) & (reason == Reason.FREE)
    image = np.zeros((*reason.shape, 4))
    image[unseen] = to_rgba(UNSEEN)
    if unseen.any():
        axes.imshow(image, origin="lower", extent=piece.extent, interpolation="nearest", zorder=1)
    return bool(unseen.any())


def _forbidden(piece: Piece, standing: Standing) -> tuple[F64, list[Reason]]:
    """Colours with opacity (h, w, 4) of forbidden ground, row 0 south, and why it is."""
    from matplotlib.colors import to_rgba

    if standing.reason.shape != piece.whole.shape:
        raise ShapeError(
            f"forbidden ground has shape {standing.reason.shape}, the terrain {piece.whole.shape}"
        )
    reason: U8 = standing.reason[piece.rows, piece.columns]
    image = np.zeros((*reason.shape, 4))
    found = [why for why in WHY if (reason == why).any()]
    for why in found:
        colour, opacity, _ = WHY[why]
        image[reason == why] = to_rgba(colour, opacity)
    return image, found


def _cells(low: float, high: float, cell: float, count: int, pixels: int) -> slice:
    """The cells that cover `low` to `high` [m], at least three, thinned to `pixels`."""
    first = min(max(0, math.floor(low / cell)), max(0, count - 3))
    last = max(min(count, math.ceil(high / cell)), min(first + 3, count))
    return slice(first, last, max(1, math.ceil((last - first) / pixels)))


def _contrast(shade: F32) -> F64:
    """Brightness 0.61 to 1.05: stretched over what occurs, but not so far that noise shows."""
    known = shade[np.isfinite(shade)]
    if not known.size:
        return np.ones(shade.shape)
    low, middle, high = np.percentile(known, (2.0, 50.0, 98.0))
    reach = max(high - middle, middle - low, 0.08)
    return np.where(np.isnan(shade), 0.85, 0.83 + 0.22 * np.clip((shade - middle) / reach, -1, 1))
