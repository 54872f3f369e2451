"""Scenario files: a drive described in YAML."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationInfo,
    field_validator,
)

from ..core import Mission, SettingError, build, read_yaml, suggest
from ..rover import Rover, Standing, read_rover
from ..sim import Shape, Worlds, find_sensor
from ..terrain import Terrain, read_terrain, scatter_rocks, with_rocks
from ._bassil import Scene
from ._embodied import embodied
from ._generated import Hills, generate
from ._ground import GOAL_RADIUS, PATIENCE, Ground, among, equip, ground_scene, to_local
from ._sensing import sensed

FARTHEST = 100_000.0
"""Largest coordinate on ground without a terrain [m]."""
SMALLEST_ROCK, LARGEST_ROCK = 0.15, 2.0
"""Diameters of scattered rocks [m]."""
SUFFIXES = (".yaml", ".yml")
MOST_OBSTACLES, MOST_CORNERS = 1000, 500
"""Obstacles of one kind in a scenario, corners of a polygon."""


def _point(item: Any) -> tuple[float, ...]:
    return _numbers(item, 2, "two numbers, like [-3.5, 1.2]")


def _greys(item: Any) -> tuple[float, ...]:
    low, high = _numbers(item, 2, "two numbers LOW, HIGH, like [-110, 8.5]")
    if low >= high:
        raise ValueError("the lowest height must be below the highest")
    return low, high


def _box(item: Any) -> tuple[float, ...]:
    corners = _numbers(item, 4, "four numbers x0, y0, x1, y1, like [4, -1, 7, 3]")
    if corners[0] > corners[2] or corners[1] > corners[3]:
        raise ValueError("a box needs x0 <= x1 and y0 <= y1")
    return corners


def _circle(item: Any) -> tuple[float, ...]:
    x, y, radius = _numbers(item, 3, "three numbers x, y, radius, like [4, -1, 0.5]")
    if not 0 < radius <= FARTHEST:
        raise ValueError("a circle needs a radius above 0")
    return x, y, radius


def _polygon(item: Any) -> tuple[tuple[float, ...], ...]:
    corners = list(item) if isinstance(item, (list, tuple)) else []
    if not 3 <= len(corners) <= MOST_CORNERS:
        raise ValueError(
            f"a polygon needs 3 to {MOST_CORNERS} corners, like [[0, 0], [2, 0], [1, 3]]"
        )
    return tuple(_point(corner) for corner in corners)


def _numbers(item: Any, count: int, wanted: str) -> tuple[float, ...]:
    parts = list(item) if isinstance(item, (list, tuple)) else []
    if len(parts) != count or not all(type(part) in (int, float) for part in parts):
        raise ValueError(f"give {wanted}")
    if not all(abs(part) <= 1e300 for part in parts):  # False for NaN
        raise ValueError("coordinates must be finite numbers")
    return tuple(map(float, parts))


Greys = Annotated[tuple[float, float], BeforeValidator(_greys)]
_OF_FILES = ("cell", "heights", "south_first")
"""Keys that only a terrain file may need."""
Point = Annotated[tuple[float, float], BeforeValidator(_point)]
Box = Annotated[tuple[float, float, float, float], BeforeValidator(_box)]
Circle = Annotated[tuple[float, float, float], BeforeValidator(_circle)]
Polygon = Annotated[tuple[Point, ...], BeforeValidator(_polygon)]
Few = Field(max_length=MOST_OBSTACLES)
Above0 = Field(gt=0, le=1e6, allow_inf_nan=False, strict=True)


class Scenario(BaseModel):
    """Everything about a drive; the same settings as ``rovernav drive`` takes as options.

    Attributes:
        terrain: Elevation model, relative to the scenario file; without one and without `generate`
            the ground is flat.
        cell: Cell of a terrain file that does not say its own [m].
        heights: Lowest and highest height [m] of the greys of a terrain that is a picture.
        south_first: Whether row 0 of a terrain that is a table or array is its south edge.
        generate: Ground to be made from `seed`, instead of a terrain.
        boxes: Obstacles: rectangles x0, y0, x1, y1 in `frame`.
        circles: Obstacles: x, y in `frame` and radius [m].
        polygons: Obstacles: corners x, y in `frame`, in order.
        start: Key ``from``: x, y in `frame`.
        goal: Key ``to``: x, y in `frame`.
        frame: How `start` and `goal` are given: ``crs``, ``local`` or ``pixel``.
        rocks: Share of the ground that scattered rocks cover, 0.05 for 5 %; none where not given;
            goes with a terrain or generated ground.
        rover: Preset, or rover file relative to the scenario file; the controller's usual one where
            not given.
        body: Whether the rover is driven as a body that settles on the ground, slips and spends
            energy, or as a point that keeps its radius from bad ground; goes with a terrain or
            generated ground.
        soil: Soil for slip and energy of a body, a name or a soil file relative to the scenario
            file; the rover's own where not given.
        slip_spread: Share by which a body's slip may differ from the soil's usual one, by `seed`.
        sensing: What the rover sees with: ``ideal``, ``lidar``, ``sonar``, ``stereo`` or
            ``stereo+holes``; see `sensed`.
        drift: Whether the rover goes by odometry that drifts, instead of its true pose.
        route: GeoJSON file of a way to follow, relative to the scenario file, or ``plan`` for one
            that is planned over the terrain; none where not given.
        controller: A controller's name, or a network file relative to the scenario file.
        carry: Sensors of installed plug-ins that the rover carries besides its own, by name.
        time_limit_s: Longest drive [s]; five times the straight line where not given.
        seed: Seed of everything random.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True)

    terrain: Path | None = None
    cell: Annotated[float, Above0] | None = None
    heights: Greys | None = None
    south_first: Annotated[bool, Field(strict=True)] | None = None
    generate: Hills | None = None
    boxes: Annotated[tuple[Box, ...], Few] = ()
    circles: Annotated[tuple[Circle, ...], Few] = ()
    polygons: Annotated[tuple[Polygon, ...], Few] = ()
    start: Point = Field(alias="from")
    goal: Point = Field(alias="to")
    frame: Literal["crs", "local", "pixel"] = "crs"
    rocks: Annotated[float, Field(strict=True)] | None = None
    rover: str | None = None
    body: Annotated[bool, Field(strict=True)] = False
    soil: str | None = None
    slip_spread: Annotated[float, Field(ge=0, le=1, allow_inf_nan=False, strict=True)] = 0.0
    sensing: Literal["ideal", "lidar", "sonar", "stereo", "stereo+holes"] = "ideal"
    drift: Annotated[bool, Field(strict=True)] = False
    route: Annotated[str, Field(min_length=1)] | None = None
    controller: str = "bassil"
    carry: Annotated[tuple[str, ...], Field(min_length=1, max_length=20)] | None = None
    time_limit_s: Annotated[float, Above0] | None = None
    seed: Annotated[int, Field(ge=0, lt=2**63, strict=True)] = 0

    @classmethod
    def allowed(cls) -> list[str]:
        """The keys as a scenario file writes them."""
        return [field.alias or name for name, field in cls.model_fields.items()]

    @property
    def flat(self) -> bool:
        """Whether the ground is flat: neither read nor generated."""
        return self.terrain is None and self.generate is None

    @field_validator(*_OF_FILES, "frame", "rocks")
    @classmethod
    def _goes_with_terrain(cls, item: Any, info: ValidationInfo) -> Any:
        made = info.data.get("generate") is not None and info.field_name not in _OF_FILES
        if item not in (None, "crs", "local") and not made and not info.data.get("terrain", ...):
            raise ValueError("that goes with a terrain, and there is none")
        return item

    @field_validator("body")
    @classmethod
    def _body_on_ground(cls, item: Any, info: ValidationInfo) -> Any:
        if item and (info.data.get("terrain", ...), info.data.get("generate", ...)) == (None, None):
            raise ValueError(
                "a body goes with a terrain or generated ground, and there is none; write "
                "terrain: FILE, or generate: {name: hills}"
            )
        return item

    @field_validator("soil", "slip_spread")
    @classmethod
    def _of_a_body(cls, item: Any, info: ValidationInfo) -> Any:
        if item and not info.data.get("body", True):
            raise ValueError("that goes with a body; write body: true")
        return item

    @field_validator("generate")
    @classmethod
    def _one_ground(cls, item: Any, info: ValidationInfo) -> Any:
        if item is not None and info.data.get("terrain") is not None:
            raise ValueError("give a terrain or generate one, not both")
        return item

    @field_validator("boxes", "circles", "polygons", "start", "goal")
    @classmethod
    def _near(cls, item: Any, info: ValidationInfo) -> Any:
        grounds = (info.data.get("terrain", ...), info.data.get("generate", ...))
        if grounds == (None, None) and _farthest(item) > FARTHEST:
            raise ValueError("without a terrain, coordinates lie within 100 km of (0, 0)")
        return item


def _farthest(item: Any) -> float:
    """The largest coordinate of points and obstacles, as deep as they are nested."""
    if isinstance(item, tuple):
        return max((_farthest(part) for part in item), default=0.0)
    return abs(float(item))


def read_scenario(path: Path) -> Scenario:
    """Read a scenario file; the files that it names are taken from its own folder.

    Raises:
        FileError: It cannot be read or is not YAML.
        SettingError: An unknown key or a value that is not allowed.
    """
    data: dict[str, Any] = read_yaml(path, what="scenario")
    allowed = Scenario.allowed()
    for key in data:
        if key not in allowed:
            raise SettingError(f"{path}: unknown key {key!r}; {suggest(str(key), allowed)}")
    scenario = build(Scenario, data, source=str(path))
    beside: dict[str, Any] = {}
    if scenario.terrain is not None:
        beside["terrain"] = path.parent / scenario.terrain
    if scenario.rover and scenario.rover.endswith(SUFFIXES):
        beside["rover"] = str(path.parent / scenario.rover)
    if scenario.soil and scenario.soil.endswith(SUFFIXES):
        beside["soil"] = str(path.parent / scenario.soil)
    if scenario.route is not None and scenario.route != "plan":
        beside["route"] = str(path.parent / scenario.route)
    if scenario.controller.endswith(".safetensors"):
        beside["controller"] = str(path.parent / scenario.controller)
    return scenario.model_copy(update=beside)


def scenario_text(scenario: Scenario) -> str:
    """The scenario as a YAML file that `read_scenario` reads back to the same values.

    What has its default is left out, but for the seed, the rover and the controller.
    """
    import yaml

    whole = scenario.model_dump(mode="json", by_alias=True, exclude_none=True)
    few = scenario.model_dump(mode="json", by_alias=True, exclude_defaults=True)
    named = {key: whole[key] for key in ("rover", "controller", "seed") if key in whole}
    ground = {"generate": whole["generate"]} if scenario.generate is not None else {}
    first = "# rovernav drive SCENARIO.yaml\n"
    data = {**few, **ground, **named}
    return first + yaml.safe_dump(data, sort_keys=False, default_flow_style=None, width=95)


def set_scene(scenario: Scenario) -> Scene | Ground:
    """The scene that a scenario describes: on an elevation model, on generated ground, or flat.

    Raises:
        RovernavError: The terrain or rover cannot be read, or start or goal cannot be stood on.
    """
    return carry(_bare(scenario), scenario.carry or ())


def carry(scene: Scene | Ground, names: Sequence[str]) -> Scene | Ground:
    """The same scene with sensors of installed plug-ins on board besides.

    Raises:
        PluginError: There is no such sensor, or it cannot be used.
        SettingError: Two sensors have the same name.
    """
    if not names:
        return scene
    if isinstance(scene, Ground):
        inner = carry(scene.scene, names)
        return dataclasses.replace(scene, scene=inner)
    sensors = (*scene.sensors, *map(find_sensor, names))
    channels = [sensor.name for sensor in sensors]
    for channel in channels:
        if channels.count(channel) > 1:
            raise SettingError(f"the rover would carry two sensors {channel!r}; leave one out")
    return dataclasses.replace(scene, sensors=sensors)


def _bare(scenario: Scenario) -> Scene | Ground:
    """The scene with what the rover carries anyway."""
    rover = read_rover(scenario.rover or "paper-point")
    if scenario.flat:
        return sensed(_flat(scenario, rover), scenario.sensing, drift=scenario.drift)
    if scenario.generate is not None:
        return on_terrain(scenario, generate(scenario.generate, seed=scenario.seed), rover)
    assert scenario.terrain is not None
    terrain = read_terrain(
        scenario.terrain, cell=scenario.cell, heights=scenario.heights,
        south_first=bool(scenario.south_first),
    )  # fmt: skip
    return on_terrain(scenario, terrain, rover)


def on_terrain(
    scenario: Scenario, terrain: Terrain, rover: Rover, *, where: Standing | None = None
) -> Ground:
    """The scene of a scenario on a terrain that has been read already, its rocks scattered.

    Args:
        scenario: What to do there.
        terrain: The ground.
        rover: Who drives.
        where: Where the rover can stand, if it is known already: then the rocks lie there too.
    """
    if scenario.body and not rover.wheel_radius:
        raise SettingError(
            f"rover {rover.name} has no wheels to set onto the ground; a body needs a rover that "
            "has, such as research, and a controller for it, such as neural"
        )
    if scenario.rocks is not None and where is None:
        terrain = strewn(terrain, scenario.rocks, seed=scenario.seed)
    shapes = obstacles(scenario, terrain)
    ground = ground_scene(
        terrain,
        rover,
        to_local(terrain, scenario.start, scenario.frame),
        to_local(terrain, scenario.goal, scenario.frame),
        time_limit=scenario.time_limit_s,
        obstacles=shapes,
        where=where,
    )
    if scenario.body:
        spread = scenario.slip_spread
        ground = embodied(ground, obstacles=shapes, soil=scenario.soil, spread=spread)
    return sensed(ground, scenario.sensing, drift=scenario.drift)


def obstacles(scenario: Scenario, terrain: Terrain | None = None) -> list[Shape]:
    """The boxes, circles and polygons of a scenario, in that order, in local metres."""

    def local(point: tuple[float, ...]) -> tuple[float, float]:
        at = (point[0], point[1])
        return at if terrain is None else to_local(terrain, at, scenario.frame)

    found: list[Shape] = []
    for x0, y0, x1, y1 in scenario.boxes:
        (u0, v0), (u1, v1) = local((x0, y0)), local((x1, y1))
        found.append(Shape.box(min(u0, u1), min(v0, v1), max(u0, u1), max(v0, v1)))
    found += [Shape.disc(*local(circle), circle[2]) for circle in scenario.circles]
    found += [Shape.polygon([local(corner) for corner in each]) for each in scenario.polygons]
    return found


def strewn(terrain: Terrain, abundance: float, *, seed: int) -> Terrain:
    """The terrain with rocks scattered over it (Golombek and Rapp 1997).

    Rocks are 0.15 to 2 m large; on coarse terrain at least half a cell and up to four times that,
    because a post cannot show less.

    Args:
        terrain: The ground.
        abundance: Share of the ground that rocks of all sizes cover.
        seed: Where the rocks lie.
    """
    smallest = max(SMALLEST_ROCK, 0.5 * terrain.frame.cell)
    rocks = scatter_rocks(
        terrain.frame, abundance, smallest=smallest, largest=max(LARGEST_ROCK, 4.0 * smallest),
        rng=np.random.default_rng([seed, 17]),
    )  # fmt: skip
    return with_rocks(terrain, rocks)


def _flat(scenario: Scenario, rover: Rover) -> Scene:
    sensors, mapper, motion, pace = equip(rover, 0.0)
    points = [scenario.start, scenario.goal]
    edge = max(20.0, 2.0 * max(_farthest(tuple(points)), _reach(scenario)))
    straight = math.dist(scenario.start, scenario.goal)
    limit = scenario.time_limit_s or max(60.0, PATIENCE * straight / pace)
    radius = 1e-9 if rover.drive == "two-axis" else GOAL_RADIUS
    return Scene(
        name="boxes",
        worlds=Worlds.single(
            **among(obstacles(scenario), rover), bounds=(-edge, -edge, edge, edge)
        ),
        mission=Mission.between(
            scenario.start, scenario.goal, goal_radius=radius, time_limit=limit
        ),
        sensors=sensors,
        motion=motion,
        mapper=mapper,
    )


def _reach(scenario: Scenario) -> float:
    """The largest coordinate of what stands on flat ground [m]."""
    circles = tuple((abs(x) + r, abs(y) + r) for x, y, r in scenario.circles)
    return _farthest((scenario.boxes, circles, scenario.polygons))
