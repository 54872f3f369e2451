"""A map to look at before driving: relief, and where a rover could stand."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..rover import Reason, Standing
from ..terrain import Terrain
from ._canvas import footer, heading, in_metres, picture
from ._map import colour_bar, forbidden_legend, northward, origin_words, scale_bar
from ._relief import draw_forbidden, draw_relief, piece_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw_terrain(
    terrain: Terrain, path: Path, *, standing: Standing | None = None, title: str | None = None
) -> Path:
    """Draw a whole terrain, north up.

    Args:
        terrain: The ground.
        path: The PNG file.
        standing: Where a rover could stand, drawn by reason with its share of the map.
        title: Instead of the terrain's name and size.

    Returns:
        `path`.
    """

    def draw(figure: Figure) -> None:
        axes = figure.add_axes((0.08, 0.125, 0.63, 0.8))
        piece = piece_of(terrain)
        tint = draw_relief(axes, piece)
        legend = (
            [] if standing is None else _legend(draw_forbidden(axes, piece, standing), standing)
        )
        width, height = terrain.frame.extent
        corner = np.array([[width, height]])
        scale_bar(axes, (0.0, 0.0, width, height), corner, northward(terrain.frame))
        in_metres(axes)
        axes.set(xlim=(0.0, width), ylim=(0.0, height))
        heading(figure, title or terrain.name)
        figure.text(0.735, 0.915, _facts(terrain), fontsize=9, va="top", linespacing=1.6)
        if legend:
            figure.legend(
                handles=legend, loc="upper left", bbox_to_anchor=(0.722, 0.77), frameon=False,
                title="Where the rover can stand", alignment="left", labelspacing=0.75,
            )  # fmt: skip
        if not terrain.plain:
            colour_bar(figure, (0.735, 0.125, 0.24, 0.02), tint, "elevation [m]")
        footer(figure, origin_words(terrain))

    return picture(path, (10.6, 7.4), draw)


def _facts(terrain: Terrain) -> str:
    (width, height), (h, w) = terrain.frame.extent, terrain.frame.shape
    low, high = terrain.span
    missing = 1.0 - terrain.finite
    lines = [
        f"{width:,.4g} x {height:,.4g} m",
        f"{w:,} x {h:,} cells of {terrain.frame.cell:.4g} m",
        f"elevation {low:,.2f} to {high:,.2f} m",
        f"without data: {_percent(missing)}" if missing else "no data missing",
    ]
    return "\n".join(lines)


def _legend(reasons: list[Reason], standing: Standing) -> list[Any]:
    from matplotlib.patches import Patch

    share = standing.share_by_reason()
    handles = forbidden_legend(reasons, standing)
    for why, handle in zip(reasons, handles, strict=True):
        handle.set_label(f"{_percent(share[why.name.lower()])}  {handle.get_label()}")
    free = f"{_percent(share['free'])}  free to drive"
    return [Patch(facecolor="#b9b9b9", edgecolor="#888888", label=free), *handles]


def _percent(share: float) -> str:
    return f"{share:.1%}" if share >= 0.0005 else "< 0.1%"
