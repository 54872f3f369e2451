"""Moments of a drive as pictures: the ground drawn once, the rover drawn anew on it."""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING, Any, final

import numpy as np

from ..core import F64, U8, Outcome, value
from ..rover import Rover, Standing
from ..sim import Worlds
from ..terrain import Terrain
from ._canvas import INK, canvas, heading, in_metres
from ._map import scale_bar
from ._relief import Window, draw_forbidden, draw_relief, piece_of
from ._words import BELIEF, BLUE, ORANGE, PATH, end_colour, end_words
from ._worlds import draw_boxes, draw_cells, draw_shapes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

DPI = 100
SIZE = 6.4
"""The longer side of a picture [inch]."""
HEAD = 1.2
"""Room for the title, the words and the axis [inch]."""
SMALLEST = 0.014
"""A rover is drawn at least this large, as a share of the window."""
POINT = Rover(
    name="point", source="a rover without a size", drive="two-axis", length=0.0, width=0.0,
    wheel_radius=0.0, clearance=0.0, max_slope=1.0, max_step=0.0, speed=1.0, step=1.0,
)  # fmt: skip


NOWHERE = np.empty((0, 2))
NOWHERE.flags.writeable = False


@value
class Place:
    """Where a drive is watched.

    Attributes:
        window: What is shown [m].
        start: Where it began (2,) [m].
        goal: Where it wants to go (2,) [m].
        goal_radius: How near is near enough [m].
        title: Over the picture.
        terrain: The ground, if there is any.
        standing: Where the rover could stand.
        worlds: Obstacles.
        k: Whose obstacles.
        rover: Whose footprint; a point where not given.
    """

    window: Window
    start: F64
    goal: F64
    goal_radius: float
    title: str = ""
    terrain: Terrain | None = None
    standing: Standing | None = None
    worlds: Worlds | None = None
    k: int = 0
    rover: Rover | None = None


@value
class Moment:
    """What is seen at one time.

    Attributes:
        path: The way so far (p, 2) [m], the present place last.
        heading: [rad].
        words: Time, speed and the like.
        beams: Where the beams of range sensors end (b, 2) [m].
        met: Which of them met something (b,), bool.
        ended: How the drive ended, or still drives.
        believed: The way that the rover believes to have gone (b, 2) [m]; None where it knows.
        seen: Places whose heights it sees now (m, 2) [m].
    """

    path: F64
    heading: float
    words: str
    beams: F64
    met: Any
    ended: Outcome = Outcome.DRIVING
    believed: F64 | None = None
    seen: F64 | None = None


@final
class Stage:
    """Draws moments at one place, many a second.

    Args:
        place: Where.
    """

    def __init__(self, place: Place) -> None:
        self._place = place
        self._stack = contextlib.ExitStack()
        west, south, east, north = place.window
        scale = SIZE / max(east - west, north - south)
        self._size = (
            max(2.4, scale * (east - west)) + 0.75,
            max(2.4, scale * (north - south)) + HEAD,
        )
        with self._opened() as sheet:
            axes = self._ground(sheet)
            self._sheet, self._axes = sheet, axes
            self._parts = self._moving(axes)
            sheet.draw()
            self._empty = sheet.copy_from_bbox(sheet.figure.bbox)

    def _opened(self) -> Any:
        return canvas(self._size, dpi=DPI)

    def frame(self, moment: Moment) -> U8:
        """Colours (h, w, 3) of a moment, row 0 at the top."""
        seen, beams, met, way, thought, body, nose, words = self._parts
        seen.set_data(*(NOWHERE if moment.seen is None else moment.seen).T)
        thought.set_data(*(NOWHERE if moment.believed is None else moment.believed).T)
        here = moment.path[-1]
        beams.set_segments([np.stack([here, end]) for end in moment.beams])
        met.set_data(*moment.beams[np.asarray(moment.met, bool)].reshape(-1, 2).T)
        way.set_data(*moment.path.T)
        outline = self._outline(here, moment.heading)
        body.set_xy(outline)
        ended = moment.ended is not Outcome.DRIVING
        body.set_facecolor(end_colour(moment.ended) if ended else ORANGE)
        nose.set_data(*np.stack([here, (outline[0] + outline[1]) / 2.0]).T)
        words.set_text(moment.words + (f" · {end_words(moment.ended)}" if ended else ""))
        self._sheet.restore_region(self._empty)
        for part in self._parts:
            self._axes.draw_artist(part)
        return np.ascontiguousarray(np.asarray(self._sheet.buffer_rgba())[..., :3])

    def _ground(self, sheet: Any) -> Axes:
        """Everything that stands still."""
        from matplotlib.patches import Circle

        place, (width, height) = self._place, self._size
        axes = sheet.figure.add_axes(
            (0.62 / width, 0.5 / height, 1 - 0.75 / width, 1 - HEAD / height)
        )
        if place.terrain is not None:
            piece = piece_of(place.terrain, place.window)
            draw_relief(axes, piece)
            if place.standing is not None:
                draw_forbidden(axes, piece, place.standing)
        if place.worlds is not None:
            if place.terrain is None:
                draw_cells(axes, place.worlds, place.k)
            draw_boxes(axes, place.worlds, place.k)
            draw_shapes(axes, place.worlds, place.k)
        ends = np.stack([place.start, place.goal])
        axes.plot(*ends.T, "--", color=INK, lw=0.9, zorder=2)
        axes.add_patch(Circle(tuple(place.goal), place.goal_radius, fill=False, ls=":", zorder=2))
        axes.plot(*place.start, "o", color="white", mec="black", ms=8, zorder=3)
        axes.plot(*place.goal, "*", color="white", mec="black", ms=15, zorder=3)
        scale_bar(axes, place.window, ends)
        in_metres(axes)
        axes.set(xlim=place.window[::2], ylim=place.window[1::2], facecolor="#f2f2f2")
        heading(sheet.figure, place.title)
        return axes

    def _moving(self, axes: Axes) -> tuple[Any, ...]:
        """What is drawn for each frame: from what eyes see now to the words above the map."""
        from matplotlib.collections import LineCollection
        from matplotlib.patches import Polygon

        (seen,) = axes.plot([], [], ".", color=BLUE, ms=1.2, alpha=0.6, zorder=3, animated=True)
        beams = LineCollection([], colors=BLUE, lw=0.5, alpha=0.45, zorder=4, animated=True)
        axes.add_collection(beams)
        (met,) = axes.plot([], [], ".", color="black", ms=3.5, zorder=5, animated=True)
        (way,) = axes.plot([], [], color=PATH, lw=2.2, zorder=6, animated=True)
        (thought,) = axes.plot(
            [], [], "-D", color=BELIEF, lw=1.6, ms=6, mec="black", mew=0.8, markevery=[-1],
            zorder=6.5, animated=True,
        )  # fmt: skip
        body = Polygon(np.zeros((4, 2)), closed=True, ec="black", lw=0.9, zorder=7, animated=True)
        axes.add_patch(body)
        (nose,) = axes.plot([], [], color="black", lw=1.4, zorder=8, animated=True)
        words = axes.text(
            0.0, 1.012, "", transform=axes.transAxes, va="bottom", fontsize=9.5, zorder=9,
            animated=True,
        )  # fmt: skip
        return seen, beams, met, way, thought, body, nose, words

    def _outline(self, here: F64, turn: float) -> F64:
        """Corners (4, 2) of the footprint, the two in front first; never too small to see."""
        west, south, east, north = self._place.window
        least = SMALLEST * max(east - west, north - south)
        rover = self._place.rover or POINT
        long, wide = rover.length, rover.width
        grow = max(1.0, least / max(min(long, wide), 1e-9)) if wide > 0.0 else 1.0
        long, wide = (grow * long, grow * wide) if wide > 0.0 else (least, least)
        corners = np.array([[1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]])
        corners *= (long / 2.0, wide / 2.0)
        c, s = np.cos(turn), np.sin(turn)
        return here + corners @ np.array([[c, s], [-s, c]])
