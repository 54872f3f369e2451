"""A planned route on its ground, or where the way ends."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..plan import Route
from ..rover import Standing
from ..terrain import Terrain
from ._canvas import INK, footer, heading, in_metres, picture
from ._map import (
    colour_bar,
    forbidden_legend,
    origin_words,
    overview,
    scale_bar,
    window_around,
)
from ._relief import draw_forbidden, draw_relief, piece_of
from ._words import BLUE, VERMILION

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LEGEND: dict[str, Any] = {"loc": "upper left", "frameon": False, "labelspacing": 0.75}
_SIDE, _WIDE = 0.725, 0.25
"""Left edge and width of the column beside the map, as shares of the figure."""

Ends = tuple[tuple[float, float], tuple[float, float]]


def draw_route(
    route: Route,
    path: Path,
    *,
    terrain: Terrain,
    ends: Ends,
    standing: Standing | None = None,
    title: str | None = None,
) -> Path:
    """Draw a route, north up; where there is none, its ends and the nearest reachable point.

    Args:
        route: The route, in the local metres of the terrain.
        path: The PNG file.
        terrain: The ground.
        ends: Start and goal that were asked for, local points [m].
        standing: Where the rover could stand, drawn by reason.
        title: Instead of the terrain's name.

    Returns:
        `path`.
    """
    width, height = terrain.frame.extent
    near = [] if route.nearest is None else [route.nearest]
    shown = np.clip(np.vstack([route.points, *ends, *near]), 0.0, [width, height])

    def draw(figure: Figure) -> None:
        window = window_around(shown, terrain.frame)
        axes = figure.add_axes((0.065, 0.115, 0.64, 0.81))
        piece = piece_of(terrain, window)
        tint = draw_relief(axes, piece)
        legend = [] if standing is None else forbidden_legend(draw_forbidden(axes, piece, standing))
        _draw_way(axes, route, ends)
        scale_bar(axes, window, shown)
        in_metres(axes)
        axes.set(xlim=window[::2], ylim=window[1::2], facecolor="#dddddd")
        heading(figure, f"{title or terrain.name}: {_summary(route)}")
        whole = figure.add_axes((_SIDE, 0.6, _WIDE, 0.3))
        draw_relief(whole, piece_of(terrain), tinted=False)
        overview(whole, terrain, window)
        handles = [*axes.get_legend_handles_labels()[0], *legend]
        figure.legend(handles=handles, bbox_to_anchor=(_SIDE - 0.015, 0.56), **LEGEND)
        colour_bar(figure, (_SIDE, 0.125, _WIDE, 0.02), tint, "elevation [m]")
        footer(figure, origin_words(terrain))

    return picture(path, (11.0, 7.4), draw)


def _draw_way(axes: Axes, route: Route, ends: Ends) -> None:
    start, goal = ends
    axes.plot(
        *np.array(ends).T, "--", color=INK, lw=1.1, zorder=4, label="straight line to the goal"
    )
    if route.found:
        axes.plot(*route.points.T, color="white", lw=4.6, solid_capstyle="round", zorder=5)
        axes.plot(
            *route.points.T, color=BLUE, lw=2.6, solid_capstyle="round", zorder=6, label="route"
        )
    elif route.nearest is not None:
        axes.plot(
            *route.nearest, "X", color=VERMILION, mec="black", ms=12, zorder=8,
            label="nearest to the goal that can be reached",
        )  # fmt: skip
    axes.plot(*start, "o", color="white", mec="black", mew=1.5, ms=10, zorder=7, label="start")
    axes.plot(*goal, "*", color="white", mec="black", mew=1.2, ms=17, zorder=7, label="goal")


def _summary(route: Route) -> str:
    if route.found:
        return f"a way of {route.length:,.1f} m"
    return f"no way ({route.way.replace('_', ' ')})"
