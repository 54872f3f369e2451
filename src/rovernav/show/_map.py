"""What every map carries: scale bar, north arrow, origin, overview, legend of forbidden ground."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..core import F64, Frame, InputError
from ..rover import Reason, Standing
from ..terrain import Terrain, true_north
from ._canvas import INK
from ._relief import UNSEEN, WHY, Window

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LEGEND: dict[str, Any] = {"loc": "upper left", "frameon": False, "labelspacing": 0.75}
SIDE, WIDE = 0.725, 0.25
"""Left edge and width of the column beside a map, as shares of the figure."""


def window_around(points: F64, frame: Frame, *, margin: float = 0.3) -> Window:
    """A window [m] around points (p, 2) with a margin of a share of their extent.

    It is at least three quarters as high as wide and the other way round, at least eight cells
    wide, and within the map where the points are.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    length = max(float(np.hypot(*(high - low))), 4.0 * frame.cell)
    size = high - low + 2.0 * margin * length
    size = np.maximum(size, 0.75 * size.max())
    edge = np.array(frame.extent)
    size = np.minimum(size, np.maximum(edge, 1.04 * (high - low)))
    corner = (low + high - size) / 2.0
    inside = np.clip(corner, 0.0, np.maximum(edge - size, 0.0))
    corner = np.where((low < 0.0) | (high > edge), corner, inside)
    west, south = (float(c) for c in corner)
    return west, south, west + float(size[0]), south + float(size[1])


def scale_bar(axes: Axes, window: Window, busy: F64, north: float = 0.0) -> None:
    """A scale bar with a north arrow, in the corner farthest from the points `busy` (p, 2) [m].

    Args:
        axes: The picture.
        window: What it shows [m].
        busy: Points to keep away from.
        north: Direction of true north, clockwise from up [rad].
    """
    u = _unit(window)
    length = round_length(min(20.0 * u, 0.4 * (window[2] - window[0])))
    x, y = _free_corner(window, busy, length)
    right, top = x + length + 9.0 * u, y + 6.6 * u
    left, low = x - 2.0 * u, y - 1.6 * u
    axes.fill(
        [left, right, right, left], [low, low, top, top],
        color="white", alpha=0.8, lw=0, zorder=8,
    )  # fmt: skip
    axes.plot([x, x + length], [y, y], color=INK, lw=3.5, solid_capstyle="butt", zorder=9)
    text = f"{length / 1000:g} km" if length >= 1000 else f"{length:g} m"
    axes.text(x + length / 2, y + u, text, ha="center", va="bottom", zorder=9)
    _north_arrow(axes, (x + length + 5.5 * u, low, top, u), north)


def _north_arrow(axes: Axes, place: tuple[float, float, float, float], north: float) -> None:
    """An arrow to true north, in a column of the scale bar: its middle, low, top, and unit."""
    x, low, top, u = place
    if abs(north) < math.radians(0.5):
        axes.annotate(
            "N", (x, top - 0.6 * u), (0, -26), textcoords="offset points",
            ha="center", va="bottom", fontsize=8.5, fontweight="bold", zorder=9,
            arrowprops={"arrowstyle": "-|>", "color": INK, "shrinkA": 0, "shrinkB": 0},
        )  # fmt: skip
        return
    y, half = (low + top) / 2.0, 0.36 * (top - low)
    east, up = half * math.sin(north), half * math.cos(north)
    axes.annotate(
        "", (x + 0.9 * east, y + 0.9 * up), (x - 0.2 * east, y - 0.2 * up), zorder=9,
        arrowprops={"arrowstyle": "-|>", "color": INK, "shrinkA": 0, "shrinkB": 0},
    )  # fmt: skip
    axes.text(x - 0.55 * east, y - 0.55 * up, "N", ha="center", va="center", fontsize=8.5,
              fontweight="bold", zorder=9)  # fmt: skip


def northward(frame: Frame) -> float:
    """Direction of true north in the middle of a grid, clockwise from its +y [rad]."""
    width, height = frame.extent
    try:
        return true_north(frame.crs, *frame.to_map(width / 2.0, height / 2.0))
    except InputError:  # a coordinate system that nobody can place still makes a picture
        return 0.0


def round_length(length: float) -> float:
    """The largest of 1, 2 or 5 times a power of ten that is not above `length`."""
    power = 10.0 ** math.floor(math.log10(length))
    return next(n * power for n in (5.0, 2.0, 1.0) if n * power <= length * (1 + 1e-9))


def overview(axes: Axes, terrain: Terrain, window: Window) -> None:
    """Mark on a picture of the whole map which part the main picture shows."""
    from matplotlib.patches import Rectangle

    west, south, east, north = window
    width, height = terrain.frame.extent
    axes.add_patch(
        Rectangle((west, south), east - west, north - south, fill=False, ec="white", lw=3.2)
    )
    axes.add_patch(
        Rectangle((west, south), east - west, north - south, fill=False, ec="black", lw=1.4)
    )
    axes.set(xlim=(0.0, width), ylim=(0.0, height), xticks=[], yticks=[], aspect="equal")
    size = f"{width / 1000:.3g} x {height / 1000:.3g} km" if width >= 2000 else (
        f"{width:.3g} x {height:.3g} m"
    )  # fmt: skip
    axes.set_title(f"the whole map, {size}", fontsize=8.5)


def forbidden_legend(reasons: Sequence[Reason], standing: Standing) -> list[Any]:
    """Legend entries for the reasons that occur; on a plain map missing cells are blocked ones."""
    from matplotlib.colors import to_rgba
    from matplotlib.patches import Patch

    words = {Reason.NO_DATA: "not free on the map"} if standing.plain else {}
    return [
        Patch(
            facecolor=to_rgba(WHY[why][0], WHY[why][1]), edgecolor="#888888",
            label=words.get(why, WHY[why][2]),
        )
        for why in reasons
    ]  # fmt: skip


def unseen_legend() -> Any:
    """The legend entry for ground that was not looked at."""
    from matplotlib.patches import Patch

    return Patch(facecolor=UNSEEN, edgecolor="#888888", label="not looked at")


def colour_bar(figure: Figure, place: Sequence[float], item: Any, label: str) -> None:
    """A horizontal colour bar at `place` (left, bottom, width, height as shares of the figure)."""
    axes = figure.add_axes((place[0], place[1], place[2], place[3]))
    bar = figure.colorbar(item, cax=axes, orientation="horizontal")
    bar.set_label(label, fontsize=8.5)
    bar.ax.tick_params(labelsize=8)
    bar.ax.locator_params(nbins=5)


def origin_words(terrain: Terrain) -> str:
    """Where the local metres lie on the map of the whole body."""
    x, y = terrain.frame.origin
    if terrain.frame.crs is None:
        moved = f"; local (0, 0) is ({x:.6g}, {y:.6g}) there" if (x, y) != (0.0, 0.0) else ""
        return f"Local metres; the map has no coordinate system{moved}."
    named = re.search(r'"([^"]*)"', terrain.frame.crs)
    name = named.group(1) if named else "its coordinate system"
    if terrain.frame.axes[0][0] < 0.01:  # degrees
        return f"Local (0, 0) m is ({x:.6f}, {y:.6f}) deg in {name}."
    return f"Local (0, 0) m is ({x:.2f}, {y:.2f}) m in {name}."


def _free_corner(window: Window, busy: F64, length: float) -> tuple[float, float]:
    """Left end of a scale bar in the corner with the most room around it."""
    west, south, east, north = window
    u = _unit(window)
    left, right = west + 4.0 * u, east - 11.0 * u - length
    low, high = south + 3.6 * u, north - 8.6 * u
    corners = [(left, low), (right, low), (left, high), (right, high)]
    middle = np.array([length / 2, 0.0])
    room = [float(np.hypot(*(busy - (np.array(c) + middle)).T).min()) for c in corners]
    best = max(room)
    return next(c for c, r in zip(corners, room, strict=True) if r > 0.8 * best)


def _unit(window: Window) -> float:
    """About 0.07 inch of the picture, in metres of the ground."""
    return max(window[2] - window[0], 1.2 * (window[3] - window[1])) / 100.0
