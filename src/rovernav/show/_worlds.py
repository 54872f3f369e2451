"""Small multiples: rovers of a batch, each in its own world of boxes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..core import F64, InputError, Outcome
from ..sim import Trace, Worlds
from ._canvas import INK, heading, picture
from ._words import (
    OBSTACLE_EDGE,
    OBSTACLE_FILL,
    PATH,
    amount,
    end_colour,
    end_marker,
    end_words,
    path_of,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST = 60
"""Panels in one picture."""


def draw_worlds(
    trace: Trace,
    worlds: Worlds,
    path: Path,
    *,
    rovers: Sequence[int] | None = None,
    columns: int = 3,
    title: str = "",
) -> Path:
    """Draw the ways of several rovers, one panel each, all at the same scale.

    Args:
        trace: The drives.
        worlds: Where they were driven.
        path: The PNG file.
        rovers: Which rovers; all by default.
        columns: Panels beside each other.
        title: Over all panels.

    Returns:
        `path`.

    Raises:
        InputError: No rover, more than 60, or one that the trace does not have.
    """
    chosen = list(range(len(trace.outcome)) if rovers is None else rovers)
    _check(chosen, len(trace.outcome))
    low, high = _common_window(trace, worlds, chosen)
    across = max(1, min(columns, len(chosen)))
    rows = math.ceil(len(chosen) / across)
    width = 11.0 if across > 1 else 7.0
    tall = float((high[1] - low[1]) / (high[0] - low[0]))
    height = (width - 0.75) / across * min(2.0, max(0.3, tall)) + 0.3
    total = rows * height + 1.35 + 0.4 * bool(title)

    def draw(figure: Figure) -> None:
        panels = figure.subplots(rows, across, squeeze=False, sharex=True, sharey=True)
        entries: dict[str, Any] = {}
        for axes, k in zip(panels.flat, chosen, strict=False):
            _panel(axes, trace, worlds, k)
            axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
            entries.update(zip(*axes.get_legend_handles_labels()[::-1], strict=True))
        for axes in panels.flat[len(chosen) :]:
            axes.set_visible(False)
        for axes in panels[:, 0]:
            axes.set_ylabel("y, north [m]")
        for axes in panels[-1]:
            axes.set_xlabel("x, east [m]")
        heading(figure, title)
        figure.subplots_adjust(
            left=0.65 / width, right=1 - 0.1 / width, wspace=0.06, hspace=0.5 / height,
            top=1 - (0.4 + 0.4 * bool(title)) / total, bottom=0.95 / total,
        )  # fmt: skip
        figure.legend(entries.values(), entries, loc="lower center", ncols=5, frameon=False)

    return picture(path, (width, total), draw)


def _panel(axes: Axes, trace: Trace, worlds: Worlds, k: int) -> None:
    driven, ended = path_of(trace, k), trace.ended(k)
    start, goal = trace.mission.start[k, :2], trace.mission.goal[k]
    draw_boxes(axes, worlds, k)
    draw_shapes(axes, worlds, k, labelled=not len(worlds.row(k).boxes))
    axes.plot(*np.stack([start, goal]).T, "--", color=INK, lw=0.9, zorder=2, label="straight line")
    dots = "o-" if len(driven) <= 100 else "-"
    axes.plot(*driven.T, dots, color=PATH, lw=1.5, ms=3.2, zorder=3, label="driven path")
    axes.plot(*start, "o", color="white", mec="black", ms=8, zorder=4, label="start")
    axes.plot(*goal, "*", color="white", mec="black", ms=13, zorder=4, label="goal")
    marker = end_marker(ended)
    axes.plot(
        *driven[-1], marker, color=end_colour(ended), mec="black",
        ms=5.5 if marker == "o" else 11, zorder=5,
    )  # fmt: skip
    axes.set_title(_words(trace, k), fontsize=9.5, color=end_colour(ended), fontweight="bold")
    axes.grid(color="#eeeeee")
    axes.set_axisbelow(True)


def draw_boxes(axes: Axes, worlds: Worlds, k: int = 0) -> None:
    """Draw the rectangles in the world of rover k."""
    from matplotlib.patches import Rectangle

    for i, (x0, y0, x1, y1) in enumerate(worlds.row(k).boxes):
        axes.add_patch(
            Rectangle(
                (x0, y0), x1 - x0, y1 - y0, label="obstacle" if i == 0 else None,
                facecolor=OBSTACLE_FILL, edgecolor=OBSTACLE_EDGE, zorder=1,
            )
        )  # fmt: skip


def draw_cells(axes: Axes, worlds: Worlds, k: int = 0) -> None:
    """Draw the ground on which rover k cannot stand, cell by cell."""
    from matplotlib.colors import to_rgba

    grid = worlds.row(k).grid
    if grid is None:
        return
    image = np.zeros((*grid.frame.shape, 4))
    image[grid.blocked != 0] = to_rgba(OBSTACLE_FILL)
    width, height = grid.frame.extent
    axes.imshow(
        image, origin="lower", extent=(0.0, width, 0.0, height), interpolation="nearest", zorder=1
    )


def draw_shapes(axes: Axes, worlds: Worlds, k: int = 0, *, labelled: bool = True) -> None:
    """Draw the polygons and discs in the world of rover k, grown as they are for it."""
    outlines = [each for shape in worlds.shapes_of(k) for each in shape.outline()]
    label = "obstacle, grown by the rover's radius" if _grown(worlds, k) else "obstacle"
    for i, corners in enumerate(outlines):
        axes.fill(
            *corners.T, color=OBSTACLE_FILL, lw=0.5, zorder=1,
            label=label if labelled and i == 0 else None,
        )  # fmt: skip


def _grown(worlds: Worlds, k: int) -> bool:
    return any(shape.radius > 0 and len(shape.corners) > 1 for shape in worlds.shapes_of(k))


def _words(trace: Trace, k: int) -> str:
    ended, steps = trace.ended(k), amount(int(trace.steps[k]), "step")
    joined = "in" if ended == Outcome.REACHED else "after"
    return f"{end_words(ended)} {joined} {steps}"


def _common_window(trace: Trace, worlds: Worlds, chosen: Sequence[int]) -> tuple[F64, F64]:
    """South-west and north-east corner [m] of what all panels show."""
    points = [trace.mission.start[chosen, :2], trace.mission.goal[chosen]]
    for k in chosen:
        boxes = worlds.row(k).boxes
        points += [path_of(trace, k), boxes[:, :2], boxes[:, 2:]]
        points += [each for shape in worlds.shapes_of(k) for each in shape.outline()]
    every = np.vstack(points)
    low, high = every.min(axis=0), every.max(axis=0)
    margin = 0.07 * max(float((high - low).max()), 1e-6)
    return low - margin, high + margin


def _check(chosen: Sequence[int], count: int) -> None:
    if not 0 < len(chosen) <= MOST:
        raise InputError(f"a picture holds 1 to {MOST} worlds, got {len(chosen)}; name the rovers")
    wrong = [k for k in chosen if not 0 <= k < count]
    if wrong:
        raise InputError(f"there is no rover {wrong[0]}: this trace has 0 to {count - 1}")
