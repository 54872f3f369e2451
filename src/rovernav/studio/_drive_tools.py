"""What the mouse does on the map: place start and goal, draw and delete obstacles."""

from __future__ import annotations

import math
from typing import final

from ._drive import DriveModel
from ._drive_map import View, obstacle_shape
from ._drive_world import Obstacle

TOOLS = {
    "look": ("pan_tool_alt", "Click a track to ask why; drag to move the map; wheel to zoom"),
    "start": ("trip_origin", "Click where the rover shall start"),
    "goal": ("flag", "Click where it shall go"),
    "box": ("crop_square", "Drag a rectangle"),
    "circle": ("radio_button_unchecked", "Drag a circle from its middle"),
    "polygon": ("pentagon", "Click the corners; double-click or Enter closes, Escape gives up"),
    "delete": ("delete_outline", "Click an obstacle to delete it"),
}
"""Icon and words of each tool."""
SMALLEST = 0.02
"""Obstacles smaller than this are slips of the hand [m]."""


@final
class Pen:
    """The tool in hand and what is half drawn with it.

    Args:
        model: What it draws into.
    """

    def __init__(self, model: DriveModel) -> None:
        self.model, self.tool = model, "look"
        self.corners: list[tuple[float, float]] = []
        self._begin: tuple[float, float] | None = None
        self._at = (0.0, 0.0)

    @property
    def begun(self) -> bool:
        """Whether something is half drawn."""
        return self._begin is not None or bool(self.corners)

    def choose(self, tool: str) -> None:
        """Take another tool; what was half drawn is gone."""
        self.tool = tool if tool in TOOLS else "look"
        self.cancel()

    def cancel(self) -> None:
        """Give up what is half drawn."""
        self._begin, self.corners = None, []

    def down(self, x: float, y: float) -> None:
        """The button went down at a place [m]."""
        self._at = (x, y)
        if self.tool in ("box", "circle"):
            self._begin = (x, y)

    def move(self, x: float, y: float) -> None:
        """The pointer is at a place [m]."""
        self._at = (x, y)

    def up(self, x: float, y: float, *, still: bool) -> bool:
        """The button went up at a place [m].

        Args:
            x: East [m].
            y: North [m].
            still: Whether it went down just there.

        Returns:
            Whether the world changed.

        Raises:
            RovernavError: That cannot be placed or drawn there.
        """
        self._at = (x, y)
        if self.tool in ("start", "goal"):
            self.model.place(self.tool, round(x, 3), round(y, 3))
            return True
        if self.tool == "delete":
            found = self.model.obstacle_at(x, y)
            if found is not None:
                self.model.delete(found)
            return found is not None
        if self.tool == "polygon":
            if not self.corners or math.dist(self.corners[-1], (x, y)) > SMALLEST:
                self.corners.append((x, y))
            return False
        obstacle = self._half()
        self._begin = None
        if obstacle is None or still:
            return False
        self.model.draw(obstacle.kind, obstacle.numbers)
        return True

    def close(self) -> bool:
        """Close the polygon; returns whether one was drawn."""
        corners, self.corners = self.corners, []
        if len(corners) < 3:
            return False
        self.model.draw("polygon", [n for corner in corners for n in corner])
        return True

    def draft(self, view: View) -> str:
        """What is half drawn, as SVG."""
        if self.corners:
            line = view.points([*self.corners, self._at])
            return (
                f'<polyline points="{line}" fill="var(--rn-muted)" fill-opacity=".25" '
                'stroke="var(--rn-ink)" stroke-width="1.5" stroke-dasharray="5 4"/>'
            )
        obstacle = self._half()
        return "" if obstacle is None else obstacle_shape(view, obstacle, draft=True)

    def _half(self) -> Obstacle | None:
        if self._begin is None:
            return None
        (x0, y0), (x1, y1) = self._begin, self._at
        if self.tool == "circle":
            radius = math.dist((x0, y0), (x1, y1))
            return Obstacle("circle", (x0, y0, radius)) if radius > SMALLEST else None
        if min(abs(x1 - x0), abs(y1 - y0)) <= SMALLEST:
            return None
        return Obstacle("box", (min(x0, x1), min(y0, y1), max(x0, x1), max(y0, y1)))
