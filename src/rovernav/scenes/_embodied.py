"""A scene on ground driven by a rover with a body instead of a point."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..core import U8, Frame
from ..kernels.shapes import first_shape
from ..rover import Soil
from ..sim import Body, Grid, Shape, Shapes
from ..sim import Ground as Heights
from ..terrain import Terrain
from ._ground import Ground


def embodied(
    ground: Ground,
    *,
    obstacles: Sequence[Shape] = (),
    soil: str | Soil | None = None,
    spread: float = 0.0,
) -> Ground:
    """The same scene with a body: the rover settles on the ground, slips and spends energy.

    Obstacles stand as they are instead of grown by the rover's radius, and its exact footprint
    must not touch them; nor what stands on a map of free and blocked cells. Where the rover should
    not stand, steep ground and what is near obstacles, its sensors see as before, but only what the
    ground does to the body ends the drive.

    Args:
        ground: From `ground_scene`.
        obstacles: Those that `ground` was made with.
        soil: A soil or its name; the rover's own where not given.
        spread: Share by which slip differs from rover to rover.

    Raises:
        SettingError: The rover has no wheels, or there is no such soil.
    """
    scene, terrain, rover = ground.scene, ground.terrain, ground.rover
    rover.chassis_array()
    seen = scene.worlds.grid
    assert seen is not None
    blocked = _burnt(seen.blocked, seen.frame, [each.grown(rover.radius) for each in obstacles])
    solid = [*obstacles, *(_walls(terrain) if terrain.plain else ())]
    worlds = replace(
        scene.worlds,
        grid=Grid(frame=seen.frame, blocked=blocked),
        shapes=Shapes.packed([solid]) if solid else None,
        ground=Heights(frame=terrain.frame, height=terrain.whole, offset=terrain.offset),
    )
    body = Body(rover, period=scene.motion.period, soil=soil, spread=spread, grid=False)
    note = "The rover has a body; sensors see where it should not stand."
    return replace(ground, scene=replace(scene, worlds=worlds, motion=body, note=note))


def _walls(terrain: Terrain) -> list[Shape]:
    """The cells of a map that are not free, as few rectangles that do not overlap.

    Equal runs of cells in rows above each other are one rectangle.
    """
    cell, (h, _) = terrain.frame.cell, terrain.frame.shape
    out: list[Shape] = []
    open_since: dict[tuple[int, int], int] = {}
    for row in range(h + 1):
        runs = _runs(np.isnan(terrain.height[row])) if row < h else []
        for run in [each for each in open_since if each not in runs]:
            west, east, south = *run, open_since.pop(run)
            out.append(Shape.box(west * cell, south * cell, east * cell, row * cell))
        for run in runs:
            open_since.setdefault(run, row)
    return out


def _runs(marked: Any) -> list[tuple[int, int]]:
    """First and one past the last index of each stretch of ones."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], marked, [False]])))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]


def _burnt(blocked: U8, frame: Frame, shapes: Sequence[Shape]) -> U8:
    """The grid with the cells blocked whose middles lie in a shape."""
    if not shapes:
        return blocked
    out, (h, w) = blocked.copy(), frame.shape
    for shape in shapes:
        corners = np.ascontiguousarray(shape.corners)
        low = (corners.min(axis=0) - shape.radius) / frame.cell
        high = (corners.max(axis=0) + shape.radius) / frame.cell
        (j0, i0), (j1, i1) = (
            np.clip(np.floor(at), 0, (w, h)).astype(int) for at in (low, high + 1)
        )
        for i in range(i0, i1):
            for j in range(j0, j1):
                x, y = frame.centre_of(i, j)
                if first_shape(x, y, x, y, corners, float(shape.radius)) <= 1.0:
                    out[i, j] = 1
    return out
