"""A drive in three dimensions: one HTML file that needs no network, no server and no library."""

from __future__ import annotations

import base64
import html
import json
import math
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from ..core import F64, InputError, write_text
from ..rover import Rover, Standing
from ..sim import Trace, Worlds
from ..terrain import Terrain
from ._map import origin_words
from ._movie import window_of
from ._raster import data_uri, png
from ._relief import Window
from ._surface import surface_of
from ._words import BELIEF, ORANGE, PALETTE, amount, end_words, path_of

TEMPLATE = "page.html"
POINTS, PIXELS = 224, 768
"""Points along a side of the ground, cells along a side of its colours."""
MOST = 24
"""Drives on one page."""
STEPS = 3000
"""Poses of a drive; steps in between are left out."""
TALL = 0.6
"""Obstacles have no height of their own: they are drawn this high [m]."""
NOTHING = 65535
"""Stands for a height that is not known."""


def write_page(
    trace: Trace,
    path: Path,
    *,
    terrain: Terrain | None = None,
    standing: Standing | None = None,
    worlds: Worlds | None = None,
    rover: Rover | None = None,
) -> Path:
    """Write a page that shows drives in three dimensions, to be turned and played.

    It holds everything itself, opens from a folder in any browser with WebGL 2, and may ask the
    network for nothing. Where there are several drives, the first 24 that share the world of the
    first are shown.

    Args:
        trace: The drives, in the local metres of the terrain.
        path: The HTML file.
        terrain: The ground, if any; flat where not given.
        standing: Where the rover could stand, drawn by reason.
        worlds: Where it was driven, for obstacles.
        rover: Whose body.

    Returns:
        `path`.

    Raises:
        InputError: The trace kept no path.
        FileError: The file cannot be written.
    """
    chosen = _chosen(trace, worlds)
    if not chosen:
        raise InputError("a page needs a drive to show; this trace has none")
    ways = [path_of(trace, k) for k in chosen]
    points = [*ways, trace.mission.start[chosen, :2], trace.mission.goal[chosen]]
    window = window_of(np.concatenate(points), terrain)
    data = {
        "title": "A drive" if terrain is None else terrain.name,
        "words": _words(trace, chosen),
        "note": "Flat ground." if terrain is None else origin_words(terrain),
        "ground": _ground(terrain, standing, window),
        "obstacles": _obstacles(worlds, chosen[0], terrain, window),
        "rovers": [
            *(_rover(trace, k, way, terrain) for k, way in zip(chosen, ways, strict=True)),
            *_thought(trace, chosen, terrain),
        ],
        "body": _body(rover, window),
        "ends": [_ends(trace, k, terrain) for k in chosen],
    }
    template = resources.files("rovernav.show").joinpath(TEMPLATE).read_text(encoding="utf-8")
    # "<" is escaped in the data, so that no name in it can end the script.
    text = json.dumps(data, allow_nan=False).replace("<", "\\u003c")
    title = html.escape(str(data["title"]))
    write_text(path, template.replace("@TITLE@", title).replace("@DATA@", text))
    return path


def _chosen(trace: Trace, worlds: Worlds | None) -> list[int]:
    every = range(len(trace.outcome))
    if worlds is None or len(worlds.of) != len(every):
        return list(every[:MOST])
    return [k for k in every if worlds.of[k] == worlds.of[0]][:MOST]


def _words(trace: Trace, chosen: list[int]) -> str:
    k = chosen[0]
    seconds = float(trace.time[int(trace.steps[k]), k])
    first = f"{end_words(trace.ended(k))} after {float(trace.length[k]):,.1f} m, {seconds:,.0f} s"
    if len(chosen) == 1:
        believed = trace.believed(k)
        if believed is None:
            return first
        off = math.dist(believed[-1], trace.pose[len(believed) - 1, k, :2])
        told = "Blue: where it was. Orange: where it believed itself"
        return f"{first}. {told}, at last {off:.1f} m off"
    return f"{amount(len(chosen), 'drive')}; the first {first}"


def _packed(array: Any, dtype: str) -> str:
    """Numbers as text: little-endian bytes in base64."""
    return base64.b64encode(np.ascontiguousarray(array, dtype=dtype).tobytes()).decode()


def _ground(terrain: Terrain | None, standing: Standing | None, window: Window) -> dict[str, Any]:
    if terrain is None:
        tile = np.full((64, 64, 3), 236, np.uint8)
        tile[::8] = tile[:, ::8] = 205
        return {
            "size": [2, 2], "window": window, "low": 0.0, "high": 0.0,
            "z": _packed(np.zeros((2, 2)), "<u2"), "image": data_uri(png(tile)),
        }  # fmt: skip
    found = surface_of(terrain, window=window, standing=standing, points=POINTS, pixels=PIXELS)
    known = found.z[np.isfinite(found.z)]
    low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 0.0)
    share = (found.z - low) / max(high - low, 1e-9)
    levels = np.where(np.isfinite(share), np.rint(share * (NOTHING - 1)), NOTHING)
    return {
        "size": [len(found.x), len(found.y)],
        "window": [float(found.x[0]), float(found.y[-1]), float(found.x[-1]), float(found.y[0])],
        "low": low, "high": high,
        "z": _packed(levels, "<u2"), "image": data_uri(png(found.colours)),
    }  # fmt: skip


def _heights(points: F64, terrain: Terrain | None) -> F64:
    """Heights (m,) above the lowest point of the terrain; 0 where none is known."""
    if terrain is None:
        return np.zeros(len(points))
    return np.nan_to_num(terrain.elevation_at(*points.T) - terrain.span[0], nan=0.0)


def _obstacles(
    worlds: Worlds | None, k: int, terrain: Terrain | None, window: Window
) -> list[dict[str, Any]]:
    """Outlines of what stands in the window, with the ground below and the top."""
    if worlds is None:
        return []
    outlines = [
        np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]]) for x0, y0, x1, y1 in worlds.row(k).boxes
    ]
    outlines += [each for shape in worlds.shapes_of(k) for each in shape.outline()]
    west, south, east, north = window
    found: list[dict[str, Any]] = []
    for corners in outlines:
        (x0, y0), (x1, y1) = corners.min(axis=0), corners.max(axis=0)
        if x1 < west or x0 > east or y1 < south or y0 > north:
            continue
        z = _heights(corners, terrain)
        found.append(
            {"xy": corners.round(4).tolist(), "z": [float(z.min()) - 0.05, float(z.max()) + TALL]}
        )
    return found


def _rover(trace: Trace, k: int, way: F64, terrain: Terrain | None) -> dict[str, Any]:
    every = max(1, math.ceil(len(way) / STEPS))
    steps = sorted({*range(0, len(way), every), len(way) - 1})
    z, tilt = _heights(way[steps], terrain), np.zeros((len(steps), 2))
    if trace.attitude is not None:
        tilt = trace.attitude[steps, k, 1:]
    poses = np.column_stack([trace.time[steps, k], way[steps], z, trace.pose[steps, k, 2], tilt])
    colour = list(PALETTE.values())[k % len(PALETTE)]
    body = ORANGE if len(trace.outcome) == 1 and trace.believed(k) is None else colour
    return {"count": len(steps), "poses": _packed(poses, "<f4"), "colour": colour, "body": body}


def _thought(trace: Trace, chosen: list[int], terrain: Terrain | None) -> list[dict[str, Any]]:
    """The way that the only rover believed to go, as that of another one beside it."""
    believed = trace.believed(chosen[0]) if len(chosen) == 1 else None
    if believed is None:
        return []
    k, z = chosen[0], _heights(believed, terrain)
    told = trace.channels["estimate"][: len(believed), k]
    flat = np.zeros((len(believed), 2))
    poses = np.column_stack([trace.time[: len(believed), k], believed, z, told[:, 2], flat])
    return [{"count": len(poses), "poses": _packed(poses, "<f4"), "colour": BELIEF, "body": BELIEF}]


def _body(rover: Rover | None, window: Window) -> list[float]:
    """Length, width and height of the body that is drawn [m]: never too small to see."""
    size = max(window[2] - window[0], window[3] - window[1])
    long, wide = (rover.length, rover.width) if rover is not None else (0.0, 0.0)
    grow = max(1.0, size / 70.0 / max(wide, 1e-9)) if wide > 0.0 else 1.0
    if wide <= 0.0:
        long = wide = size / 70.0
    return [grow * long, grow * wide, 0.6 * grow * min(long, wide)]


def _ends(trace: Trace, k: int, terrain: Terrain | None) -> dict[str, Any]:
    both = np.stack([trace.mission.start[k, :2], trace.mission.goal[k]])
    z = _heights(both, terrain)
    start, goal = np.column_stack([both, z]).tolist()
    return {"start": start, "goal": goal}
