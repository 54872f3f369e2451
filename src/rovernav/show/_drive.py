"""A drive on its ground: where the rover went, when, and what it kept off."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..core import F64, ShapeError
from ..rover import Standing
from ..sim import Trace, Worlds, tilt
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
    window_around,
)
from ._relief import Window, draw_forbidden, draw_relief, piece_of
from ._words import BELIEF, BLUE, SKY, amount, end_colour, end_marker, end_words, path_of
from ._worlds import draw_boxes, draw_shapes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FEW = 9
"""Lines of a legend that may stand at ease."""


def draw_drive(  # noqa: PLR0913 - each is a layer of the picture, by keyword
    trace: Trace,
    path: Path,
    *,
    terrain: Terrain,
    standing: Standing | None = None,
    sensed: F64 | None = None,
    seen: F64 | None = None,
    worlds: Worlds | None = None,
    route: F64 | None = None,
    title: str | None = None,
) -> Path:
    """Draw the drive of the first rover of a trace, north up.

    Where the rover went by odometry that drifts, the way that it believed it went is drawn too.

    Args:
        trace: The drive, in the local metres of the terrain.
        path: The PNG file.
        terrain: The ground.
        standing: Where the rover could stand, drawn by reason.
        sensed: Points (m, 2) that the rover's beams met [m].
        seen: Places (m, 2) whose heights its eyes told [m]; the edge of all of them is drawn.
        worlds: Where it was driven, for the obstacles that somebody drew.
        route: Points (k, 2) [m] of the route that it was given.
        title: Instead of the terrain's name.

    Returns:
        `path`.

    Raises:
        InputError: The trace kept no path.
        ShapeError: Points or forbidden ground of another shape than the terrain's.
    """
    driven = path_of(trace)
    for name, points in (("sensed", sensed), ("route", route)):
        if points is not None and (points.ndim != 2 or points.shape[1] != 2):
            raise ShapeError(f"{name} points must have shape (m, 2), got {points.shape}")

    def draw(figure: Figure) -> None:
        ends = np.vstack([driven, trace.mission.start[:1, :2], trace.mission.goal[:1]])
        window = window_around(ends, terrain.frame)
        axes = figure.add_axes((0.065, 0.115, 0.64, 0.81))
        extra, tint = _ground(axes, terrain, standing, window)
        if worlds is not None:
            draw_boxes(axes, worlds)
            draw_shapes(axes, worlds, labelled=not len(worlds.boxes))
        if seen is not None and len(seen):
            _edge_of_the_seen(axes, seen, window)
        line = _path(axes, trace, driven, sensed)
        if route is not None and len(route):
            axes.plot(*route.T, "-", color=BLUE, lw=1.6, zorder=4.5, label="route given")
        draw_belief(axes, trace)
        if trace.attitude is not None:
            _worst_tilt(axes, trace.attitude[: len(driven), 0], driven)
        if trace.slip is not None:
            _worst_slip(axes, trace.slip[: len(driven), 0, 0], driven)
        scale_bar(axes, window, ends)
        in_metres(axes)
        axes.set(xlim=window[::2], ylim=window[1::2], facecolor="#dddddd")
        heading(figure, f"{title or terrain.name}: {_summary(trace)}")
        _side(figure, terrain, window)
        handles = [*axes.get_legend_handles_labels()[0], *extra]
        spaced: dict[str, Any] = LEGEND if len(handles) <= FEW else {**LEGEND, "labelspacing": 0.45}
        figure.legend(handles=handles, bbox_to_anchor=(SIDE - 0.015, 0.58), **spaced)
        colour_bar(figure, (SIDE, 0.215, WIDE, 0.02), line, "time since the start [s]")
        if not terrain.plain:
            colour_bar(figure, (SIDE, 0.105, WIDE, 0.02), tint, "elevation [m]")
        footer(figure, origin_words(terrain))

    return picture(path, (11.0, 7.4), draw)


def _ground(
    axes: Axes, terrain: Terrain, standing: Standing | None, window: Window
) -> tuple[list[Any], Any]:
    piece = piece_of(terrain, window)
    tint = draw_relief(axes, piece)
    if standing is None:
        return [], tint
    return forbidden_legend(draw_forbidden(axes, piece, standing), standing), tint


def _path(axes: Axes, trace: Trace, driven: F64, sensed: F64 | None) -> Any:
    """Draw the way, its ends and the straight line; returns what a colour bar of time needs."""
    from matplotlib.collections import LineCollection
    from matplotlib.patches import Circle

    start, goal, ended = trace.mission.start[0, :2], trace.mission.goal[0], trace.ended()
    if sensed is not None and len(sensed):
        axes.plot(*sensed.T, ".", color="black", ms=2.0, zorder=3, label="what its beams met")
    axes.plot(
        *np.stack([start, goal]).T, "--", color=INK, lw=1.1, zorder=4, label="straight line to goal"
    )
    axes.plot(*driven.T, color="white", lw=5.2, solid_capstyle="round", zorder=5)
    axes.plot(*driven.T, color=INK, lw=4.0, solid_capstyle="round", zorder=5)
    time = trace.time[: len(driven), 0]
    line = LineCollection(
        list(np.stack([driven[:-1], driven[1:]], axis=1)),
        cmap="viridis", lw=2.4, zorder=6, capstyle="round", array=(time[:-1] + time[1:]) / 2.0,
    )  # fmt: skip
    line.set_clim(0.0, max(float(time[-1]), 1e-9))
    axes.add_collection(line)
    axes.add_patch(Circle(tuple(goal), trace.mission.goal_radius, fill=False, ls=":", zorder=4))
    axes.plot(*start, "o", color="white", mec="black", mew=1.5, ms=10, zorder=7, label="start")
    axes.plot(
        *goal,
        "*",
        color="white",
        mec="black",
        mew=1.2,
        ms=17,
        zorder=7,
        label="goal; dotted: near enough",
    )
    axes.plot(
        *driven[-1], end_marker(ended), color=end_colour(ended), mec="black", mew=1.0,
        ms=8 if end_marker(ended) == "o" else 12, zorder=8, label=f"end: {end_words(ended)}",
    )  # fmt: skip
    return line


def draw_belief(axes: Axes, trace: Trace, k: int = 0) -> None:
    """Where the rover thought it was, if that was not where it was, and how far off it ended."""
    believed = trace.believed(k)
    if believed is None:
        return
    true, last = trace.pose[len(believed) - 1, k, :2], believed[-1]
    off = float(np.hypot(*(last - true)))
    axes.plot(*np.stack([true, last]).T, ":", color=BELIEF, lw=1.6, zorder=7)
    axes.plot(
        *believed.T, "-", color=BELIEF, lw=1.6, zorder=6.5, label="where it believed itself to be"
    )
    axes.plot(
        *last, "D", color=BELIEF, mec="black", mew=1.0, ms=8, zorder=8,
        label=f"believed end, {off:.2f} m from the true one",
    )  # fmt: skip


def _worst_tilt(axes: Axes, attitude: F64, driven: F64) -> None:
    """Mark where the body tilted most."""
    angles = np.degrees(tilt(attitude))
    worst = int(np.argmax(angles))
    axes.plot(
        *driven[worst], "^", color="#ffd24d", mec="black", mew=1.1, ms=10, zorder=8,
        label=f"most tilted: {angles[worst]:.1f} deg",
    )  # fmt: skip


def _worst_slip(axes: Axes, slip: F64, driven: F64) -> None:
    """Mark where the body slipped most."""
    worst = int(np.argmax(slip))
    if slip[worst] > 0.0:
        axes.plot(
            *driven[worst], "v", color=SKY, mec="black", mew=1.1, ms=10, zorder=8,
            label=f"slipped most: {slip[worst]:.0%}",
        )  # fmt: skip


def _edge_of_the_seen(axes: Axes, seen: F64, window: Window) -> None:
    """Draw the outline of the ground that was seen, on a grid of some two hundred cells."""
    west, south, east, north = window
    cell = max(max(east - west, north - south) / 150.0, 0.25)
    edges = [np.arange(low, high + cell, cell) for low, high in ((west, east), (south, north))]
    count, _, _ = np.histogram2d(*seen.T, bins=edges)
    middles = [(each[:-1] + each[1:]) / 2.0 for each in edges]
    axes.contour(
        *middles, (count > 0).T.astype(float), levels=[0.5], colors=BLUE, linestyles=":",
        linewidths=1.3, zorder=3,
    )  # fmt: skip
    axes.plot([], [], ":", color=BLUE, lw=1.3, label="edge of the ground that its eyes saw")


def _side(figure: Figure, terrain: Terrain, window: Window) -> None:
    """The whole map, small, with the window marked."""
    axes = figure.add_axes((SIDE, 0.6, WIDE, 0.3))
    draw_relief(axes, piece_of(terrain), tinted=False)
    overview(axes, terrain, window)


def _summary(trace: Trace) -> str:
    words = end_words(trace.ended())
    steps, metres = amount(int(trace.steps[0]), "step"), float(trace.length[0])
    seconds = float(trace.time[min(int(trace.steps[0]), len(trace.time) - 1), 0])
    told = f"{words} after {metres:,.1f} m, {seconds:,.0f} s"
    if trace.energy is None:
        return f"{told} and {steps}"
    last = min(int(trace.steps[0]), len(trace.energy) - 1)
    return f"{told}, {steps} and {float(trace.energy[last, 0]) / 1000.0:,.1f} kJ"
