"""Sensors that err, and estimates that drift, in place of the ideal ones of a scene."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from ..core import Mapper, Sensor, SettingError, suggest
from ..mapping import ElevationMapper, LocalMapper
from ..rover import Rover
from ..sim import LIDAR, SONAR, HoleSensor, NoisyFan, Odometry, Patch, RangeFan, Tilt
from ..sim import Ground as Heights
from ._bassil import Scene
from ._ground import Ground

SENSING = ("ideal", "lidar", "sonar", "stereo", "stereo+holes")
"""What a rover can see with."""
FARTHEST = 8.0
"""How far a pair of eyes makes out heights [m]."""
PLACES = 80
"""Places of a patch from the rover to its far edge."""
WIDER = 1.2
"""How far a map of heights reaches, as a multiple of the eyes' reach."""
EYES = 1.2
"""Height of the eyes over the ground, as a multiple of the rover's length; 0.5 m at least."""


def sensed(scene: Scene | Ground, sensing: str = "ideal", *, drift: bool = False) -> Any:
    """The same scene, seen with sensors that err.

    Args:
        scene: From `ground_scene` or the like, for a rover with differential drive.
        sensing: ``ideal`` leaves the sensors as they are. ``lidar`` and ``sonar`` spoil the fan:
            see `sim.LIDAR` and `sim.SONAR`. ``stereo`` takes the fan away: a pair of eyes sees
            heights, the rover makes a map of them and judges it itself; it needs a terrain.
            ``stereo+holes`` has infra-red besides, which looks down ahead of the wheels, and an
            inertial unit that tells how the rover leans.
        drift: Whether the rover goes by odometry that drifts instead of its true pose.

    Returns:
        A `Scene` or `Ground`, as given.

    Raises:
        SettingError: The rover has no fan, or there is no terrain, or no such sensors.
    """
    if sensing not in SENSING:
        raise SettingError(f"unknown sensing {sensing!r}; {suggest(sensing, SENSING)}")
    if sensing == "ideal" and not drift:
        return scene
    inner = scene.scene if isinstance(scene, Ground) else scene
    fan, mapper = next(iter(inner.sensors), None), inner.mapper
    if not (isinstance(fan, RangeFan) and isinstance(mapper, LocalMapper)):
        raise SettingError(
            "sensing and drift are for rovers with differential drive, which have a range fan; "
            "choose a rover such as research"
        )
    if sensing.startswith("stereo"):
        if not isinstance(scene, Ground):
            raise SettingError(f"{sensing} sees heights: give a terrain, or generate ground")
        if scene.terrain.plain:
            raise SettingError(
                f"{sensing} sees heights, and {scene.terrain.source} says only what is free; "
                "choose lidar or sonar"
            )
        inner = _with_heights(inner, scene)
        carried, own = _eyes(scene, fan, mapper, holes=sensing.endswith("+holes"))
    else:
        carried, own = _spoilt(fan, mapper, sensing)
    if drift:
        carried = (*carried, Odometry())
    changed = replace(inner, sensors=carried, mapper=own)
    return replace(scene, scene=changed) if isinstance(scene, Ground) else changed


def _spoilt(fan: RangeFan, mapper: LocalMapper, sensing: str) -> tuple[tuple[Sensor, ...], Mapper]:
    """The fan with noise, and a map of what it reads."""
    if sensing == "ideal":
        return (fan,), mapper
    if sensing == "lidar":
        spoilt = NoisyFan(fan, LIDAR)
    else:
        spoilt = NoisyFan(RangeFan(reach=fan.reach, beams=CONES * CONE), SONAR, cone=CONE)
    own = LocalMapper(spoilt.angles, reach=fan.reach, rays=mapper.rays, side=mapper.side)
    return (spoilt,), own


CONES, CONE = 13, 5
"""Cones of a row of sonars, and beams in each."""


HIGHEST, DOWN, APART = 0.7, (math.radians(40.0), math.radians(60.0)), 0.15
"""Height of infra-red sensors at most [m], how far their rows look down [rad], and how wide they
stand apart [m]."""


def _eyes(
    ground: Ground, fan: RangeFan, mapper: LocalMapper, *, holes: bool
) -> tuple[tuple[Sensor, ...], Mapper]:
    far = min(FARTHEST, fan.reach)
    mast = max(0.5, EYES * ground.rover.length)
    patch = Patch(far=far, near=min(0.5, 0.1 * far), cell=far / PLACES, mast=mast)
    down = _looking_down(ground.rover, mast) if holes else None
    cell = WIDER * far / (mapper.side // 2 - 1)
    own = ElevationMapper(
        ground.rover, patch, holes=down, cell=cell, rays=mapper.rays, side=mapper.side
    )
    return ((patch,) if down is None else (patch, down, Tilt())), own


def _looking_down(rover: Rover, mast: float) -> HoleSensor:
    """Infra-red on the mast, to look over the front edge, as wide as the rover's circle."""
    count = math.ceil(rover.radius / APART)
    return HoleSensor(
        ahead=0.5 * rover.length,
        across=tuple(rover.radius * k / count for k in range(-count, count + 1)),
        height=min(HIGHEST, mast),
        down=DOWN,
    )


def _with_heights(scene: Scene, ground: Ground) -> Scene:
    """The scene with the terrain's heights in its world, for those who look at them."""
    if scene.worlds.ground is not None:
        return scene
    terrain = ground.terrain
    heights = Heights(frame=terrain.frame, height=terrain.height, offset=terrain.offset)
    return replace(scene, worlds=replace(scene.worlds, ground=heights))
