"""A layer of judged ground as a picture."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..core import ShapeError
from ..rover import Layer, Standing
from ..terrain import Terrain
from ._canvas import footer, heading, in_metres, picture
from ._map import colour_bar, forbidden_legend, northward, origin_words, scale_bar
from ._relief import draw_forbidden, draw_relief, piece_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLOURS = "viridis"
BOTH_WAYS = "RdBu_r"
"""For layers with values on both sides of 0."""


def draw_layer(
    terrain: Terrain, layer: Layer, path: Path, *, standing: Standing | None = None
) -> Path:
    """Draw a layer over shaded relief, north up, with what it means below.

    The colours reach from the 2nd to the 98th percentile; angles are shown in degrees.

    Args:
        terrain: The ground.
        layer: Out of `Hazards.layers`.
        path: The PNG file.
        standing: Where the rover could stand, drawn by reason.

    Returns:
        `path`.

    Raises:
        ShapeError: The layer is of another shape than the terrain.
    """
    if layer.values.shape != terrain.frame.shape:
        raise ShapeError(
            f"layer {layer.name} has shape {layer.values.shape}, the terrain {terrain.frame.shape}"
        )

    def draw(figure: Figure) -> None:
        from matplotlib.cm import ScalarMappable
        from matplotlib.colors import Normalize

        axes = figure.add_axes((0.08, 0.125, 0.63, 0.8))
        piece = piece_of(terrain)
        draw_relief(axes, piece, tinted=False)
        values = np.array(layer.values[piece.rows, piece.columns], np.float64)
        unit = layer.unit
        if unit == "rad":
            values, unit = np.degrees(values), "deg"
        known = values[np.isfinite(values)]
        low, high = np.percentile(known, (2.0, 98.0)) if known.size else (0.0, 1.0)
        if low < 0.0 < high:
            low, high = -max(-low, high), max(-low, high)
        norm = Normalize(low, high if high > low else low + 1e-6)
        colours = BOTH_WAYS if low < 0.0 else COLOURS
        shown = np.ma.masked_invalid(values)
        axes.imshow(
            shown, origin="lower", extent=piece.extent, cmap=colours, norm=norm, alpha=0.72,
            interpolation="nearest", zorder=1,
        )  # fmt: skip
        reasons = [] if standing is None else draw_forbidden(axes, piece, standing)
        width, height = terrain.frame.extent
        corner = np.array([[width, height]])
        scale_bar(axes, (0.0, 0.0, width, height), corner, northward(terrain.frame))
        in_metres(axes)
        axes.set(xlim=(0.0, width), ylim=(0.0, height))
        heading(figure, f"{terrain.name}: {layer.name}")
        text = [*textwrap.wrap(layer.words, 38), "", *textwrap.wrap(layer.formula, 38)]
        figure.text(0.735, 0.915, "\n".join(text), fontsize=9, va="top", parse_math=False)
        if reasons and standing is not None:
            figure.legend(
                handles=forbidden_legend(reasons, standing), loc="upper left",
                bbox_to_anchor=(0.722, 0.6),
                frameon=False, title="Where the rover cannot stand", alignment="left",
            )  # fmt: skip
        bar = f"{layer.name} [{unit}]" if unit != "1" else layer.name
        colour_bar(figure, (0.735, 0.125, 0.24, 0.02), ScalarMappable(norm, colours), bar)
        footer(figure, origin_words(terrain))

    return picture(path, (10.6, 7.4), draw)
