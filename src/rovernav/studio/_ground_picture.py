"""Pictures of the ground for the map, made once for what they show."""

from __future__ import annotations

import dataclasses
import math
import threading
from collections import OrderedDict
from html import escape
from typing import Any, final

from ..rover import Rover
from ..show import WHY, data_uri, png, relief_pixels
from ._drive_map import View, Window
from ._drive_world import Surfaces, World

PIXELS = 560
"""Cells along a side of a picture, above which some are left out."""


@dataclasses.dataclass(frozen=True)
class Picture:
    """A picture of a part of the ground.

    Attributes:
        address: The picture itself, as an address.
        window: What it shows: west, south, east, north [m].
    """

    address: str
    window: Window


@final
class GroundPictures:
    """Relief with forbidden ground on it, the last few kept.

    Args:
        surfaces: Where the ground comes from.
        most: How many are kept.
    """

    def __init__(self, surfaces: Surfaces, most: int = 6) -> None:
        self._surfaces, self._most = surfaces, most
        self._kept: OrderedDict[Any, Picture] = OrderedDict()
        self._lock = threading.Lock()

    def of(self, world: World, rover: Rover, view: View) -> Picture | None:
        """The part of the ground that a view shows; None where it is flat or off the map."""
        terrain = self._surfaces.terrain(world)
        if terrain is None:
            return None
        west, south, east, north = view.window
        width, height = terrain.frame.extent
        window = (max(west, 0.0), max(south, 0.0), min(east, width), min(north, height))
        if window[0] >= window[2] or window[1] >= window[3]:
            return None
        key = (world.surface, rover.name, window)
        with self._lock:
            if key not in self._kept:
                where = self._surfaces.standing(world, rover)
                colours, shown = relief_pixels(
                    terrain, window=window, standing=where, pixels=PIXELS
                )
                self._kept[key] = Picture(data_uri(png(colours)), shown)
                while len(self._kept) > self._most:
                    self._kept.popitem(last=False)
            return self._kept[key]

    def height_words(self, world: World, x: float, y: float) -> str:
        """The elevation under the pointer, if the ground has been made already."""
        terrain = self._surfaces.known(world)
        if terrain is None or not terrain.frame.contains(x, y):
            return ""
        z = float(terrain.elevation_at(x, y))
        return f", {z:.2f} m high" if math.isfinite(z) else ", no data"

    @staticmethod
    def legend(rover: Rover) -> str:
        """What the colours on the ground mean."""
        shown = [(colour, words) for colour, _, words in WHY.values()]
        if rover.is_point:
            shown = shown[:-1]
        items = "".join(f'<span><i style="background:{c}"></i>{w}</span>' for c, w in shown)
        return f"<span>Forbidden to {escape(rover.name)}:</span>{items}"
