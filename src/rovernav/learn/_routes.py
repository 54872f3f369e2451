"""A controller and a scene's route put together."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..control import Guarded, RouteFollower, shy
from ..core import F64, Controller, Frame, SettingError
from ..mapping import ElevationMapper
from ..plan import CostMap, any_angle, read_route
from ..scenes import Ground, Scene

PLANNED = "plan"
"""The route that is planned before the drive."""
LOCAL = Frame(cell=1.0, shape=(1, 1))


def routed(controller: Controller, scene: Scene | Ground, route: str | Path) -> Controller:
    """The controller, made to follow a route through a scene.

    On a terrain the follower plans anew over the places where the rover can stand, as the terrain
    tells them; obstacles that were drawn besides are not on that map, and have to be sensed.

    Args:
        controller: Who drives.
        scene: Where.
        route: A GeoJSON file, or ``plan`` for the shortest way over the terrain that leaves some
            room beside forbidden ground.

    Raises:
        SettingError: The rover keeps no map of what it senses, or there is no terrain to plan on,
            or no way.
        FileError: The file is none or damaged.
    """
    inner = scene.scene if isinstance(scene, Ground) else scene
    if inner.mapper is None:
        raise SettingError(
            "a route needs a rover that keeps a map of what it senses, which one with two axes "
            "does not; drive with --controller neural, planner or goal-seeker and their rover"
        )
    costs = None
    if isinstance(scene, Ground):
        where = scene.standing
        costs = CostMap.of(1.0, where.frame, forbidden=where.blocked)
    if str(route) == PLANNED:
        return RouteFollower(controller, _planned(costs, inner), ground=costs)
    frame = LOCAL if costs is None else costs.frame
    return RouteFollower(controller, read_route(route, frame), ground=costs)


def guarded(controller: Controller, scene: Scene | Ground) -> Controller:
    """The controller, held back from what the rover's own map of heights forbids, if it makes one.

    See `control.Guarded`. Rovers with other maps get the controller as it is.
    """
    inner = scene.scene if isinstance(scene, Ground) else scene
    mapper, motion = inner.mapper, inner.motion
    if not isinstance(mapper, ElevationMapper):
        return controller
    return Guarded(controller, period=motion.period, radius=mapper.keep)


def _planned(costs: CostMap | None, scene: Scene) -> F64:
    if costs is None:
        raise SettingError(
            "there is no terrain to plan a route on; give the route as a GeoJSON file, or drive "
            "over a terrain"
        )
    start, goal = scene.mission.start[0, :2], scene.mission.goal[0]
    found = any_angle(shy(costs), start, goal)
    if not found.found:
        raise SettingError(f"there is no route: {found.reason}")
    return np.asarray(found.points)
