"""Scenes on an elevation model: from a terrain, a rover and two points to a drive."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..core import U8, Mapper, Mission, Motion, Sensor, SettingError, value
from ..mapping import LocalMapper
from ..rover import Reason, Rover, Standing, standing
from ..sim import (
    ClearSight,
    DifferentialDrive,
    Grid,
    OffLine,
    RangeFan,
    Shape,
    TwoAxis,
    Worlds,
    clearance,
)
from ..terrain import Raster, Terrain
from ._bassil import Scene

PATIENCE = 5.0
"""A drive may last this many times as long as the straight line would take."""
GOAL_RADIUS = 0.5
"""A differential rover within this distance has reached its goal [m]."""
REACH, REACH_CELLS = 6.0, 20.0
"""Reach of the range fan [m], and at least as many cells of the terrain."""


@value
class Ground:
    """A scene on real or generated ground.

    Attributes:
        scene: The drive but for its controller.
        terrain: The ground.
        rover: Who drives.
        standing: Where it can stand.
    """

    scene: Scene
    terrain: Terrain
    rover: Rover
    standing: Standing

    @property
    def motion(self) -> Motion:
        """How the rover moves."""
        return self.scene.motion


def ground_scene(  # noqa: PLR0913 - the last three by keyword
    terrain: Terrain,
    rover: Rover,
    start: tuple[float, float],
    goal: tuple[float, float],
    *,
    time_limit: float | None = None,
    obstacles: Sequence[Shape] = (),
    where: Standing | None = None,
) -> Ground:
    """A drive over a terrain: obstacles are the places where the rover cannot stand.

    Args:
        terrain: The ground.
        rover: Who drives; `equip` says what it carries.
        start: Local x, y [m].
        goal: Local x, y [m].
        time_limit: Seconds [s]; five times the straight line where not given.
        obstacles: What somebody drew on the ground besides, local metres.
        where: Where this rover can stand on this terrain, if it is known already.

    Raises:
        SettingError: Start or goal lie off the map, in an obstacle, or where the rover cannot
            stand.
    """
    where = where or standing(terrain, rover)
    for name, point in (("start", start), ("goal", goal)):
        check_end(name, point, where, rover, obstacles)
    sensors, mapper, motion, pace = equip(rover, terrain.frame.cell)
    straight = math.dist(start, goal)
    limit = max(60.0, PATIENCE * straight / pace) if time_limit is None else time_limit
    radius = 1e-9 if rover.drive == "two-axis" else max(GOAL_RADIUS, 0.25 * terrain.frame.cell)
    blocked = where.blocked if rover.drive == "two-axis" else fenced(where.blocked)
    scene = Scene(
        name=terrain.name,
        worlds=Worlds.single(
            grid=Grid(frame=terrain.frame, blocked=blocked), **among(obstacles, rover)
        ),
        mission=Mission.between(start, goal, goal_radius=radius, time_limit=limit),
        sensors=sensors,
        motion=motion,
        mapper=mapper,
        note="Obstacles are the places where the rover cannot stand; nobody drew them.",
    )
    return Ground(scene=scene, terrain=terrain, rover=rover, standing=where)


def among(obstacles: Sequence[Shape], rover: Rover) -> dict[str, Any]:
    """Obstacles as `Worlds.single` takes them: grown by the rover's radius.

    Rectangles stay exact boxes for a rover without a size.
    """
    if not rover.is_point:
        return {"shapes": [shape.grown(rover.radius) for shape in obstacles]}
    boxes = [box for shape in obstacles if (box := _box_of(shape))]
    return {"boxes": boxes, "shapes": [shape for shape in obstacles if not _box_of(shape)]}


def _box_of(shape: Shape) -> tuple[float, float, float, float] | None:
    """x0, y0, x1, y1 of a shape that is a rectangle along the axes, as `Shape.box` makes it."""
    if shape.radius or len(shape.corners) != 4:
        return None
    (x0, y0), _, (x1, y1), _ = shape.corners.tolist()
    same = shape.corners.tolist() == Shape.box(x0, y0, x1, y1).corners.tolist()
    return (x0, y0, x1, y1) if same and x0 <= x1 and y0 <= y1 else None


def check_end(
    name: str,
    point: tuple[float, float],
    where: Standing,
    rover: Rover,
    obstacles: Sequence[Shape] = (),
) -> None:
    """Raise `SettingError` with the reason where a rover cannot stand at a start or goal.

    Args:
        name: ``start`` or ``goal``.
        point: Local x, y [m].
        where: Where the rover can stand.
        rover: Who.
        obstacles: What was drawn on the ground besides.
    """
    _check_point(name, point, where, rover)
    _check_clear(name, point, obstacles, rover)


def _check_clear(
    name: str, point: tuple[float, float], obstacles: Sequence[Shape], rover: Rover
) -> None:
    for shape in obstacles:
        gap = clearance(np.array([point]), Worlds.single(shapes=[shape]))
        if gap <= rover.radius:
            near = f"nearer than its radius of {rover.radius:.2f} m" if gap > 0 else "there"
            raise SettingError(
                f"rover {rover.name} cannot stand at the {name}: an obstacle is {near}; "
                f"choose another point"
            )


def fenced(blocked: U8) -> U8:
    """The same ground with the outermost cells forbidden: nothing is known beyond the map."""
    out = blocked.copy()
    out[[0, -1], :] = 1
    out[:, [0, -1]] = 1
    return out


def equip(
    rover: Rover, cell: float, *, period: float = 1.0
) -> tuple[tuple[Sensor, ...], Mapper | None, Motion, float]:
    """What a rover carries on ground with cells of `cell` metres.

    A two-axis rover carries the paper's two sensors and decides once a second. A differential
    rover carries an idealised range fan and a local map of what the fan met; the fan reaches 6 m,
    or 20 cells where the terrain is coarse, because a rover cannot steer by less.

    Args:
        rover: Who drives.
        cell: Cell of the terrain [m].
        period: Time between two decisions of a differential rover [s].

    Returns:
        Sensors, mapper, motion, and the pace on free ground [m/s].
    """
    if rover.drive == "two-axis":
        return (ClearSight(), OffLine(rover.step / 2)), None, TwoAxis(period=1.0), rover.step
    fan = RangeFan(reach=max(REACH, REACH_CELLS * cell))
    motion = DifferentialDrive(speed=rover.speed, turn_rate=rover.turn_rate, period=period)
    return (fan,), LocalMapper(fan.angles, reach=fan.reach), motion, rover.speed


def nearest_free(where: Standing, point: tuple[float, float]) -> tuple[float, float]:
    """The middle of the free cell nearest to a local point [m].

    Raises:
        SettingError: Nowhere on this ground can the rover stand.
    """
    rows, columns = np.nonzero(where.blocked == 0)
    if not len(rows):
        raise SettingError("nowhere on this ground can the rover stand; choose another rover")
    cell = where.frame.cell
    far = (columns + 0.5 - point[0] / cell) ** 2 + (rows + 0.5 - point[1] / cell) ** 2
    nearest = int(np.argmin(far))
    return where.frame.centre_of(int(rows[nearest]), int(columns[nearest]))


def to_local(
    terrain: Terrain | Raster, point: tuple[float, float], frame: str = "crs"
) -> tuple[float, float]:
    """A point given in the terrain's coordinates, local metres or pixels, as local metres.

    Args:
        terrain: The ground.
        point: x, y; for ``pixel`` column and row counted from the top left of the image, whole
            numbers being the middles of pixels.
        frame: ``crs``, ``local`` or ``pixel``.
    """
    return terrain.frame.place(*point, frame)


def _check_point(name: str, point: tuple[float, float], where: Standing, rover: Rover) -> None:
    width, height = where.frame.extent
    x, y = point
    if not where.frame.contains(x, y):
        low, high = where.frame.to_map(0.0, 0.0), where.frame.to_map(width, height)
        at = where.frame.to_map(x, y)
        raise SettingError(
            f"the {name} ({at[0]:.10g}, {at[1]:.10g}) lies off the map, which reaches from "
            f"({low[0]:.10g}, {low[1]:.10g}) to ({high[0]:.10g}, {high[1]:.10g})"
        )
    cell = where.frame.cell_of(x, y)
    if where.blocked[cell]:
        raise SettingError(
            f"rover {rover.name} cannot stand at the {name}: {_why(where, cell, rover)}; "
            f"{_instead(where, point)}"
        )


def _instead(where: Standing, point: tuple[float, float]) -> str:
    """The nearest place where it can stand, as the map and as the local frame have it."""
    if where.blocked.all():
        return "it can stand nowhere on this ground; choose another rover"
    at = nearest_free(where, point)
    on_map = where.frame.to_map(*at)
    local = "" if math.dist(at, on_map) < 1e-9 else f", locally ({at[0]:.10g}, {at[1]:.10g})"
    return (
        f"the nearest place where it can is {math.dist(at, point):.3g} m away, "
        f"({on_map[0]:.10g}, {on_map[1]:.10g}){local}"
    )


def _why(where: Standing, cell: tuple[int, int], rover: Rover) -> str:
    reason = Reason(int(where.reason[cell]))
    if reason is Reason.NO_DATA:
        return "the map does not call it free" if where.plain else "the terrain has no data there"
    if reason is Reason.SLOPE:
        slope, limit = math.degrees(where.slope[cell]), math.degrees(rover.max_slope)
        return f"the slope is {slope:.1f} deg, its limit {limit:.1f} deg"
    if reason is Reason.STEP:
        return f"a step of {where.step[cell]:.2f} m is there, its limit is {rover.max_step:.2f} m"
    return f"forbidden ground is nearer than its radius of {rover.radius:.2f} m"
