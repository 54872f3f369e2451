"""The seed paper's figure 3, drawn from a drive."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..core import F64, Outcome
from ..scenes import OBSTACLE, PAPER_POINTS, Scene
from ..sim import Trace, clearance
from ._canvas import INK, footer, heading, in_metres, picture
from ._words import (
    BLACK,
    GREEN,
    OBSTACLE_EDGE,
    OBSTACLE_FILL,
    ORANGE,
    PURPLE,
    SKY,
    VERMILION,
    amount,
    end_words,
    path_of,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SEEN = {
    (0, 0): (ORANGE, "x=0, y=0: sight of B blocked, on the line"),
    (0, 1): (SKY, "x=0, y=1: sight of B blocked, off the line"),
    (1, 1): (GREEN, "x=1, y=1: B in sight, off the line"),
    (1, 0): (PURPLE, "x=1, y=0: B in sight, on the line"),
}
"""Colour and words of the four things that the paper's two sensors can say."""

_LABELS = {
    "first": ("first point", (24, -72), "left"),
    "apex": ("apex", (30, 6), "left"),
    "end": ("B", (-34, -32), "right"),
}
_LEGEND: dict[str, Any] = {"ncols": 3, "frameon": False, "markerscale": 0.75}
_NOTE = (
    "From the paper: A, B, the 2-3-2 network with its first weights, the learning rate, the pattern"
    " (0, 0), the three quoted points.\n"
    "Ours: obstacle, step length, what the sensors mean, the other three patterns, momentum,"
    " tolerance. "
)
_REPLAY = (
    "Calibrated: the targets of the training patterns were computed from the coordinates that the"
    " paper quotes, so that the drive meets them.\nIt shows that a 2-3-2 network can learn them, no"
    " more. Obstacle, meaning of the sensors and tolerances are ours."
)


def draw_paper_figure(
    trace: Trace,
    scene: Scene,
    path: Path,
    *,
    paper_points: Mapping[str, tuple[float, float]] = PAPER_POINTS,
    title: str | None = None,
) -> Path:
    """Draw the paper's test case as it was driven.

    Args:
        trace: The drive, with its channels for colours that tell what the network was shown.
        scene: Where it was driven.
        path: The PNG file.
        paper_points: Points that the paper quotes [m], by name.
        title: Instead of the usual one.

    Returns:
        `path`.
    """

    def draw(figure: Figure) -> None:
        axes = figure.add_axes((0.06, 0.235, 0.925, 0.665))
        driven = path_of(trace)
        _scene(axes, trace, scene)
        _steps(axes, trace, driven)
        _quoted(axes, driven, paper_points)
        _limits(axes, driven, scene, paper_points)
        in_metres(axes)
        heading(figure, title or _title(scene))
        axes.set_title(_summary(trace, driven, scene), fontsize=9, color="#555555")
        figure.legend(loc="lower center", bbox_to_anchor=(0.5, 0.06), **_LEGEND)
        footer(figure, _REPLAY if "replay" in scene.name else _NOTE + scene.note)

    return picture(path, (10.0, 7.6), draw)


def _title(scene: Scene) -> str:
    boxes = scene.worlds.row(0).boxes
    same = boxes.shape == (1, 4) and bool((boxes[0] == OBSTACLE).all())
    what = "the test case" if same else "the test case with another obstacle,"
    return f"Bassil 2012, figure 3: {what} as driven by the trained 2-3-2 network ({scene.name})"


def _scene(axes: Axes, trace: Trace, scene: Scene) -> None:
    from matplotlib.patches import Rectangle

    start, goal = trace.mission.start[0, :2], trace.mission.goal[0]
    for i, (x0, y0, x1, y1) in enumerate(scene.worlds.row(0).boxes):
        label = "obstacle, unknown beforehand" if i == 0 else None
        axes.add_patch(
            Rectangle(
                (x0, y0), x1 - x0, y1 - y0, label=label,
                facecolor=OBSTACLE_FILL, edgecolor=OBSTACLE_EDGE, linewidth=1.2,
            )
        )  # fmt: skip
    axes.plot(*np.stack([start, goal]).T, "--", color=INK, lw=1, label="direct line A–B", zorder=2)
    for name, at in (("A", start), ("B", goal)):
        axes.annotate(
            name, (at[0], at[1]), (-15 if name == "A" else 15, 0), textcoords="offset points",
            fontsize=14, fontweight="bold", ha="center", va="center",
        )  # fmt: skip


def _steps(axes: Axes, trace: Trace, driven: F64) -> None:
    axes.plot(*driven.T, "-", color="#777777", lw=1.3, zorder=3, label="driven path")
    seen = _seen(trace, len(driven) - 1)
    for key, (colour, words) in SEEN.items():
        rows = np.flatnonzero((seen == key).all(axis=1))
        if len(rows):
            axes.plot(
                *driven[rows].T, "o", color=colour, mec=BLACK, mew=0.6, ms=7, zorder=5, label=words
            )
    axes.plot(*driven[len(seen) :].T, "o", color=INK, ms=5, zorder=5)
    if trace.ended() == Outcome.COLLIDED:
        axes.plot(*driven[-1], "X", color=VERMILION, mec=BLACK, ms=12, zorder=7, label="collided")
    _numbers(axes, driven)


def _numbers(axes: Axes, driven: F64) -> None:
    """The number of each step, to the left of the way; none where two would overlap."""
    before, after = driven[:-1], np.vstack([driven[2:], driven[-1:]])
    for i, (a, here, b) in enumerate(zip(before, driven[1:], after, strict=True), 1):
        length = float(np.hypot(*(b - a)))
        if np.hypot(*(here - a)) > 0.3 and length > 0.0:
            left = (15.0 * (a[1] - b[1]) / length, 15.0 * (b[0] - a[0]) / length)
            axes.annotate(
                str(i), here, left, textcoords="offset points",
                fontsize=7.5, color="#555555", ha="center", va="center",
            )  # fmt: skip


def _seen(trace: Trace, steps: int) -> F64:
    """What the network was shown before each step (steps, 2); no rows where it was not kept."""
    channels = trace.channels
    if not {"clear_sight", "off_line"} <= set(channels):
        return np.empty((0, 2))
    columns = (channels["clear_sight"][:steps, 0, 0], channels["off_line"][:steps, 0, 0])
    return np.stack(columns, axis=1)


def _quoted(axes: Axes, driven: F64, points: Mapping[str, tuple[float, float]]) -> None:
    """The paper's points, hollow, each beside the nearest one of this drive."""
    for i, (name, at) in enumerate(points.items()):
        words, offset, side = _LABELS.get(name, (name, (20, 20), "left"))
        axes.plot(
            *at, "D", mfc="none", mec=VERMILION, mew=1.6, ms=13, zorder=6,
            label="point that the paper quotes" if i == 0 else None,
        )  # fmt: skip
        axes.annotate(
            f"paper: {words}\n({at[0]:g}, {at[1]:g}){_nearest(driven, at)}",
            at, offset, textcoords="offset points", fontsize=8, ha=side, va="center",
            color="#8a3d00", zorder=8,
            arrowprops={"arrowstyle": "-", "color": VERMILION, "lw": 0.8, "shrinkB": 7},
        )  # fmt: skip


def _nearest(driven: F64, at: tuple[float, float]) -> str:
    """The point of the drive that belongs to `at`, if there is one within half a metre."""
    away = np.hypot(*(driven - at).T)
    x, y = driven[np.argmin(away)]
    return f"\nhere: ({x:.3f}, {y:.3f})" if away.min() < 0.5 else "\nnot met here"


def _limits(
    axes: Axes, driven: F64, scene: Scene, points: Mapping[str, tuple[float, float]]
) -> None:
    boxes = scene.worlds.row(0).boxes
    corners = [driven, boxes[:, :2], boxes[:, 2:], np.array(list(points.values())).reshape(-1, 2)]
    low, high = np.vstack(corners).min(axis=0), np.vstack(corners).max(axis=0)
    axes.set_xlim(low[0] - 0.8, high[0] + 0.8)
    axes.set_ylim(low[1] - 0.8, high[1] + 0.9)
    axes.grid(color="#eeeeee")
    axes.set_axisbelow(True)


def _summary(trace: Trace, driven: F64, scene: Scene) -> str:
    words = end_words(trace.ended()).replace("the goal", "B")
    steps = amount(int(trace.steps[0]), "step")
    said = f"{words} after {steps} and {float(trace.length[0]):.2f} m"
    gap = clearance(driven, scene.worlds)
    return said if not np.isfinite(gap) else f"{said}; nearest to the obstacle {gap:.2f} m"
