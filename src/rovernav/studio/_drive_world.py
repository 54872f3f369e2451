"""The world that a person sets up, and what follows from it."""

from __future__ import annotations

import dataclasses
import math
import threading
from collections import OrderedDict
from pathlib import Path
from typing import Any, final

import numpy as np

from ..core import SettingError, build, suggest
from ..rover import Rover, Standing, presets, read_rover, standing
from ..scenes import (
    GENERATORS,
    Ground,
    Scenario,
    Scene,
    check_end,
    generate,
    named_scene,
    nearest_free,
    obstacles,
    on_terrain,
    scene_names,
    set_scene,
    strewn,
)
from ..terrain import Terrain, read_terrain

Point = tuple[float, float]
KINDS = {"box": "boxes", "circle": "circles", "polygon": "polygons"}
"""What can be drawn, and the key of a scenario file that holds it."""
FLAT_WINDOW = (-2.5, -7.0, 14.5, 8.5)
"""What a map of flat ground shows at least: west, south, east, north [m]."""
MOST_OBSTACLES = 200


@dataclasses.dataclass(frozen=True)
class Obstacle:
    """Something drawn on the map.

    Attributes:
        kind: One of `KINDS`.
        numbers: x0, y0, x1, y1; or x, y, radius; or x, y of each corner [m].
    """

    kind: str
    numbers: tuple[float, ...]

    @property
    def entry(self) -> Any:
        """As a scenario file writes it."""
        if self.kind != "polygon":
            return list(self.numbers)
        return [list(pair) for pair in zip(self.numbers[::2], self.numbers[1::2], strict=True)]

    @property
    def words(self) -> str:
        """One line about it."""
        n = self.numbers
        if self.kind == "box":
            return f"rectangle {n[0]:g}, {n[1]:g} to {n[2]:g}, {n[3]:g}"
        if self.kind == "circle":
            return f"circle at {n[0]:g}, {n[1]:g}, radius {n[2]:g} m"
        return f"polygon of {len(n) // 2} corners at {n[0]:g}, {n[1]:g}"

    def holds(self, x: float, y: float) -> bool:
        """Whether a point lies in it."""
        n = self.numbers
        if self.kind == "box":
            return n[0] <= x <= n[2] and n[1] <= y <= n[3]
        if self.kind == "circle":
            return math.hypot(x - n[0], y - n[1]) <= n[2]
        from ..kernels.shapes import inside

        return bool(inside(x, y, np.array(n).reshape(-1, 2)))


@dataclasses.dataclass(frozen=True)
class World:
    """Everything about a drive but who drives; the frame is local metres, or plain on flat ground.

    Attributes:
        ground: ``flat``, the name of a generator, or ``file``.
        made: Settings of generated ground, by key.
        file: The elevation model, for ``file``.
        cell: Its cell where it does not say it [m].
        title: What the file is called; shown, never opened.
        rocks: Share of the ground that rocks cover; 0 is none.
        seed: Seed of everything random.
        start: Where from [m].
        goal: Where to [m].
        obstacles: What was drawn.
        rover: A preset, or nothing for the controller's usual one.
        time_limit: [s]; None is five times the straight line.
    """

    ground: str = "flat"
    made: tuple[tuple[str, Any], ...] = ()
    file: Path | None = None
    cell: float | None = None
    title: str = ""
    rocks: float = 0.0
    seed: int = 0
    start: Point = (0.0, 0.0)
    goal: Point = (10.0, 0.0)
    obstacles: tuple[Obstacle, ...] = ()
    rover: str = ""
    time_limit: float | None = None

    @property
    def flat(self) -> bool:
        """Whether nothing but obstacles is on it."""
        return self.ground == "flat"

    @property
    def surface(self) -> tuple[Any, ...]:
        """What the terrain depends on, and nothing else."""
        seed = None if self.ground == "file" and not self.rocks else self.seed
        return self.ground, self.made, self.file, self.cell, self.rocks, seed

    def scenario(self, controller: str, rover: str) -> Scenario:
        """The scenario file of this world, checked as the command line checks it.

        Raises:
            SettingError: A number that is not allowed.
        """
        data: dict[str, Any] = {
            "from": list(self.start),
            "to": list(self.goal),
            "controller": controller,
            "rover": rover,
            "seed": self.seed,
            "time_limit_s": self.time_limit,
        }
        if self.ground == "file":
            data |= {"terrain": self.file, "cell": self.cell}
        elif not self.flat:
            data["generate"] = {"name": self.ground, **dict(self.made)}
        if not self.flat:
            data |= {"frame": "local", "rocks": self.rocks or None}
        for kind, key in KINDS.items():
            data[key] = [each.entry for each in self.obstacles if each.kind == kind]
        return build(Scenario, {k: v for k, v in data.items() if v is not None}, source="drive")


def checked(world: World, controller: str = "bassil", rover: str = "paper-point") -> World:
    """The world, if a scenario file could describe it.

    Raises:
        SettingError: A number that is not allowed, or too many obstacles.
    """
    if len(world.obstacles) > MOST_OBSTACLES:
        raise SettingError(f"at most {MOST_OBSTACLES} obstacles can be drawn; delete some")
    for each in world.obstacles:
        if each.kind not in KINDS:
            raise SettingError(f"no obstacle {each.kind!r}; {suggest(each.kind, KINDS)}")
        if each.kind == "polygon" and len(each.numbers) % 2:
            raise SettingError("the corners of a polygon need two numbers each")
    if world.rover and world.rover not in presets():  # never a path: it may come from a browser
        raise SettingError(f"no rover {world.rover!r}; {suggest(str(world.rover), presets())}")
    world.scenario(controller, rover)
    return world


def flat_worlds() -> dict[str, World]:
    """The named scenes that a scenario file can describe, as worlds."""
    found: dict[str, World] = {}
    for name in scene_names():
        if name.startswith("bassil"):  # the others generate their ground, which takes a while
            scene = named_scene(name)
            if isinstance(scene, Scene) and scene.mission.goal_radius <= 1e-9:
                found[name] = _as_world(scene)
    return found


def _as_world(scene: Scene) -> World:
    start, goal = scene.mission.start[0].tolist(), scene.mission.goal[0].tolist()
    boxes = [Obstacle("box", tuple(box)) for box in scene.worlds.row(0).boxes.tolist()]
    return World(
        start=(start[0], start[1]),
        goal=(goal[0], goal[1]),
        obstacles=tuple(boxes),
        rover="",
        time_limit=float(scene.mission.time_limit),
    )


@final
class Surfaces:
    """Terrains and where rovers can stand on them, the last few kept.

    Args:
        most: How many terrains are kept.
    """

    def __init__(self, most: int = 3) -> None:
        self._most = most
        self._terrains: OrderedDict[Any, Terrain] = OrderedDict()
        self._standings: OrderedDict[Any, Standing] = OrderedDict()
        self._lock = threading.Lock()

    def terrain(self, world: World) -> Terrain | None:
        """The ground of a world, its rocks on it; None where it is flat.

        Raises:
            RovernavError: The file cannot be read, or the settings make no ground.
        """
        if world.flat:
            return None
        with self._lock:
            if world.surface not in self._terrains:
                self._terrains[world.surface] = _terrain(world)
                while len(self._terrains) > self._most:
                    self._terrains.popitem(last=False)
            return self._terrains[world.surface]

    def known(self, world: World) -> Terrain | None:
        """The ground of a world if it has been made already, without waiting for it."""
        return self._terrains.get(world.surface)

    def standing(self, world: World, rover: Rover) -> Standing | None:
        """Where a rover can stand; None on flat ground."""
        terrain = self.terrain(world)
        if terrain is None:
            return None
        key = (world.surface, rover.name)
        with self._lock:
            if key not in self._standings:
                self._standings[key] = standing(terrain, rover)
                while len(self._standings) > 2 * self._most:
                    self._standings.popitem(last=False)
            return self._standings[key]

    def scene(self, world: World, controller: str, rover: str) -> tuple[Scenario, Scene | Ground]:
        """The scenario file of a drive, and its scene.

        Raises:
            RovernavError: The rover cannot stand at the start or the goal, or as `terrain`.
        """
        scenario = world.scenario(controller, rover)
        terrain = self.terrain(world)
        if terrain is None:
            return scenario, set_scene(scenario)
        body = read_rover(rover)
        where = self.standing(world, body)
        return scenario, on_terrain(scenario, terrain, body, where=where)

    def check_end(self, world: World, end: str, rover: str) -> None:
        """Raise `SettingError` unless a rover can stand at the ``start`` or ``goal`` of a world."""
        body = read_rover(rover)
        where = self.standing(world, body)
        point = getattr(world, end)
        if where is not None:
            shapes = obstacles(world.scenario("bassil", rover), self.terrain(world))
            check_end(end, point, where, body, shapes)
            return
        for each in world.obstacles:
            if each.holds(*point):
                raise SettingError(f"the {end} lies in a {each.words}; choose another point")

    def settle(self, world: World, rovers: list[str]) -> World:
        """The world with start and goal moved to where all these rovers can stand."""
        wheres = [where for r in rovers if (where := self.standing(world, read_rover(r)))]
        if not wheres:
            return world
        blocked = np.maximum.reduce([where.blocked for where in wheres])
        where = dataclasses.replace(wheres[0], blocked=blocked)
        return dataclasses.replace(
            world, start=nearest_free(where, world.start), goal=nearest_free(where, world.goal)
        )

    def window(self, world: World) -> tuple[float, float, float, float]:
        """West, south, east, north of all that there is [m]."""
        terrain = self.terrain(world)
        if terrain is not None:
            return 0.0, 0.0, *terrain.frame.extent
        west, south, east, north = FLAT_WINDOW
        points = [world.start, world.goal, *(p for each in world.obstacles for p in _ends(each))]
        for x, y in points:
            west, south = min(west, x - 1.5), min(south, y - 1.5)
            east, north = max(east, x + 1.5), max(north, y + 1.5)
        return west, south, east, north


def _terrain(world: World) -> Terrain:
    if world.ground == "file":
        assert world.file is not None
        terrain = read_terrain(world.file, cell=world.cell)
    else:
        terrain = generate(GENERATORS[world.ground](**dict(world.made)), seed=world.seed)
    return strewn(terrain, world.rocks, seed=world.seed) if world.rocks else terrain


def _ends(obstacle: Obstacle) -> list[Point]:
    n = obstacle.numbers
    if obstacle.kind == "circle":
        return [(n[0] - n[2], n[1] - n[2]), (n[0] + n[2], n[1] + n[2])]
    return list(zip(n[::2], n[1::2], strict=True))
