"""A planned route on its ground, or where the way ends."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..plan import Going, Route, Trip
from ..terrain import Terrain
from ._canvas import INK, footer, heading, in_metres, picture
from ._map import (
    LEGEND,
    SIDE,
    WIDE,
    colour_bar,
    forbidden_legend,
    origin_words,
    overview,
    scale_bar,
    unseen_legend,
    window_around,
)
from ._relief import draw_forbidden, draw_relief, draw_unseen, piece_of
from ._words import BLUE, GREEN, ORANGE, VERMILION

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ZONE = "#b2182b"


def draw_trip(trip: Trip, path: Path, *, terrain: Terrain, title: str | None = None) -> Path:
    """Draw a trip over its judged ground, north up; see `draw_route`."""
    return draw_route(
        trip.route, path, terrain=terrain, stops=trip.stops, ground=trip.ground, title=title
    )


def draw_route(
    route: Route,
    path: Path,
    *,
    terrain: Terrain,
    stops: Any,
    ground: Going | None = None,
    title: str | None = None,
) -> Path:
    """Draw a route, north up; where there is none, its stops and the nearest reachable point.

    Args:
        route: The route, in the local metres of the terrain.
        path: The PNG file.
        terrain: The ground.
        stops: Local points (n, 2) [m] that were asked for, from start to goal.
        ground: What was planned on: where the rover can stand is drawn by reason, and the zones.
        title: Instead of the terrain's name.

    Returns:
        `path`.
    """
    width, height = terrain.frame.extent
    stops = np.asarray(stops, np.float64)
    near = [] if route.nearest is None else [route.nearest]
    shown = np.clip(np.vstack([route.points, stops, *near]), 0.0, [width, height])

    def draw(figure: Figure) -> None:
        window = window_around(shown, terrain.frame)
        axes = figure.add_axes((0.065, 0.115, 0.64, 0.81))
        piece = piece_of(terrain, window)
        tint = draw_relief(axes, piece)
        legend = []
        if ground is not None:
            standing = ground.hazards.standing
            legend = forbidden_legend(draw_forbidden(axes, piece, standing), standing)
            if draw_unseen(axes, piece, standing):
                legend.append(unseen_legend())
            _draw_zones(axes, ground)
        _draw_way(axes, route, stops)
        scale_bar(axes, window, shown)
        in_metres(axes)
        axes.set(xlim=window[::2], ylim=window[1::2], facecolor="#dddddd")
        heading(figure, f"{title or terrain.name}: {_summary(route, ground)}")
        whole = figure.add_axes((SIDE, 0.6, WIDE, 0.3))
        small = piece_of(terrain)
        draw_relief(whole, small, tinted=False)
        if ground is not None:
            draw_unseen(whole, small, ground.hazards.standing)
        overview(whole, terrain, window)
        handles = [*axes.get_legend_handles_labels()[0], *legend]
        figure.legend(handles=handles, bbox_to_anchor=(SIDE - 0.015, 0.56), **LEGEND)
        if not terrain.plain:
            colour_bar(figure, (SIDE, 0.125, WIDE, 0.02), tint, "elevation [m]")
        footer(figure, origin_words(terrain))

    return picture(path, (11.0, 7.4), draw)


def _draw_zones(axes: Axes, ground: Going) -> None:
    """Outlines of the zones, and of their margins dotted."""
    import shapely
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path as Outline
    from shapely.geometry import polygon

    zones = ground.zones
    if zones is None:
        return
    for area, colour, grown, words in (
        (zones.avoid, ZONE, zones.margin, "zone to keep out of"),
        (zones.keep_in, GREEN, -zones.margin, "zone to stay within"),
    ):
        if area is None:
            continue
        for outline, style in ((area, "-"), (area.buffer(grown), ":")):
            for part in shapely.get_parts(outline):
                for ring in (part.exterior, *part.interiors):
                    x, y = np.array(ring.coords)[:, :2].T
                    axes.plot(x, y, style, color=colour, lw=1.6, zorder=4, label=words)
                    words = "_" + words.lstrip("_")
            if zones.margin == 0.0:
                break
        if colour == ZONE:
            for part in shapely.get_parts(area):
                rings = polygon.orient(part)  # holes run the other way round, and stay open
                outlines = [Outline(ring.coords) for ring in (rings.exterior, *rings.interiors)]
                filled = Outline.make_compound_path(*outlines)
                axes.add_patch(PathPatch(filled, facecolor=colour, alpha=0.18, lw=0))


def _draw_way(axes: Axes, route: Route, stops: Any) -> None:
    start, *via, goal = stops
    straight = "straight line to the goal" if not via else "straight from stop to stop"
    axes.plot(*stops.T, "--", color=INK, lw=1.1, zorder=4, label=straight)
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
    for number, stop in enumerate(via):
        axes.plot(
            *stop, "o", color=ORANGE, mec="black", mew=1.2, ms=12, zorder=7,
            label="_" if number else "stops in order",
        )  # fmt: skip
        axes.text(stop[0], stop[1], f"{number + 1}", ha="center", va="center", fontsize=8, zorder=8)
    axes.plot(*start, "o", color="white", mec="black", mew=1.5, ms=10, zorder=7, label="start")
    axes.plot(*goal, "*", color="white", mec="black", mew=1.2, ms=17, zorder=7, label="goal")


def _summary(route: Route, ground: Going | None) -> str:
    if not route.found:
        return f"no way ({route.way.replace('_', ' ')})"
    least = "" if ground is None else f", least {ground.objective} for {ground.rover.name}"
    return f"a way of {route.length:,.1f} m{least}"
