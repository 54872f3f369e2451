"""The world in three dimensions: ground, obstacles, tracks and rovers."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any, final

import numpy as np
from nicegui import run, ui

from ..core import F64
from ..rover import read_rover
from ..show import PALETTE, data_uri, png, surface_of
from ..terrain import Terrain
from ._drive import DriveModel
from ._drive_map import COLOURS
from ._drive_run import DriveRun
from ._drive_setup import number_in
from ._drive_world import Obstacle

MOST = 128
"""Points along a side of the surface; a finer ground is thinned to it."""
MOST_LINES = 150
"""Pieces of a track."""
TALL = 1.2
"""Obstacles are drawn this high: they have no height of their own [m]."""
NO_WEBGL = "3D needs WebGL, which this browser does not offer; the 2D map shows the same drives."


@final
class Scene3D:
    """The 3D view, built when it is first looked at.

    Args:
        model: What it shows.
    """

    def __init__(self, model: DriveModel) -> None:
        self.model = model
        self.scene: Any = None
        self.rovers: list[Any] = []
        self._seen: object = None
        self._lift = 1.0

    def build(self) -> None:
        """Make room for it in the present container."""
        self.box = ui.column().classes("w-full gap-1")
        self.box.set_visibility(False)
        with self.box:
            with ui.row().classes("w-full items-center no-wrap gap-2"):
                ui.label("Heights ×").classes("rn-note")
                self.slider = ui.slider(min=1, max=5, step=0.5, value=1).props(
                    'dense label aria-label="Vertical exaggeration"'
                ).classes("w-40").mark("exaggeration")  # fmt: skip
                self.slider.on("change", self._exaggerate)
                self.words = ui.label("Drag to turn, wheel to come closer.").classes("rn-note")
            self.room = ui.element("div").classes("rnd-scene")

    async def turn(self, on: bool) -> None:
        """Show or hide it."""
        self.box.set_visibility(on)
        if not on:
            return
        can = await ui.run_javascript(
            "!!document.createElement('canvas').getContext('webgl2')", timeout=5.0
        )
        if not can:
            self.words.text = NO_WEBGL
            return
        await self.show()

    async def _exaggerate(self) -> None:
        self._lift = min(max(number_in(self.slider.value, 1.0), 1.0), 5.0)
        self._seen = None
        await self.show()

    async def show(self) -> None:
        """Build the scene anew where world or tracks are others than before."""
        state = (self.model.world, self._lift, tuple(id(r) for r in self.model.runs),
                 all(r.ended for r in self.model.runs))  # fmt: skip
        if state == self._seen:
            return
        self._seen = state
        world = self.model.world
        terrain = await run.io_bound(self.model.surfaces.terrain, world)
        window = self.model.surfaces.window(world)
        made = await run.io_bound(self._surface, terrain, window)
        if made is None:  # the studio is being stopped
            return
        address, mesh = made
        self.room.clear()
        self.rovers = []
        with self.room:
            self.scene = ui.scene(
                width=900, height=420, grid=False, background_color="#c9d6df",
                camera=ui.scene.perspective_camera(fov=42),
            ).classes("w-full")  # fmt: skip
            size = max(window[2] - window[0], window[3] - window[1])
            scene = self.scene
            with scene:
                scene.texture(address, mesh)
                for obstacle in world.obstacles:
                    self._obstacle(obstacle, terrain)
                for i, one in enumerate(self.model.runs):
                    self._track(one, i, terrain, size)
                for point, colour in ((world.start, "#ffffff"), (world.goal, PALETTE["yellow"])):
                    x, y, z = self._at(point[0], point[1], terrain)
                    tall = size / 18
                    scene.cylinder(tall / 40, tall / 40, tall).material("#222222").rotate(
                        math.pi / 2, 0, 0).move(x, y, z + tall / 2)  # fmt: skip
                    scene.sphere(tall / 6).material(colour).move(x, y, z + tall)
            self._camera(window, terrain)
        self.moment(self.model.now(), 0)

    def _surface(
        self, terrain: Terrain | None, window: tuple[float, float, float, float]
    ) -> tuple[str, list[Any]]:
        """Picture and points of the ground, row by row from the north."""
        west, south, east, north = window
        if terrain is None:
            tile = np.full((64, 64, 3), 236, np.uint8)
            tile[::8] = tile[:, ::8] = 205
            rows = [[[x, y, 0.0] for x in (west, east)] for y in (north, south)]
            return data_uri(png(tile)), rows
        rover = read_rover(self.model.rovers(self.model.world)[0])
        where = self.model.surfaces.standing(self.model.world, rover)
        found = surface_of(terrain, standing=where, points=MOST, pixels=512)
        rows = [
            [
                None if math.isnan(z) else [round(x, 3), round(y, 3), round(self._lift * z, 3)]
                for x, z in zip(found.x.tolist(), line, strict=True)
            ]
            for y, line in zip(found.y.tolist(), found.z.tolist(), strict=True)
        ]
        return data_uri(png(found.colours)), rows

    def _at(self, x: float, y: float, terrain: Terrain | None) -> tuple[float, float, float]:
        if terrain is None:
            return x, y, 0.0
        z = float(terrain.elevation_at(x, y)) - terrain.span[0]
        return x, y, self._lift * z if math.isfinite(z) else 0.0

    def _obstacle(self, obstacle: Obstacle, terrain: Terrain | None) -> None:
        n = obstacle.numbers
        if obstacle.kind == "circle":
            x, y, z = self._at(n[0], n[1], terrain)
            self.scene.cylinder(n[2], n[2], TALL, 48).material("#8d97a1").rotate(
                math.pi / 2, 0, 0).move(x, y, z + TALL / 2)  # fmt: skip
            return
        if obstacle.kind == "box":
            outline = [[n[0], n[1]], [n[2], n[1]], [n[2], n[3]], [n[0], n[3]]]
        else:
            outline = [list(pair) for pair in zip(n[::2], n[1::2], strict=True)]
        x, y = np.mean(outline, axis=0).tolist()
        z = self._at(x, y, terrain)[2]
        self.scene.extrusion(outline, TALL).material("#8d97a1").move(0, 0, z)

    def _track(self, one: DriveRun, number: int, terrain: Terrain | None, size: float) -> None:
        colour = PALETTE.get(COLOURS[number % 8], "#222222")
        every = max(1, math.ceil(len(one.poses) / MOST_LINES))
        steps = [*range(0, one.steps, every), one.steps]
        points = [self._at(*one.poses[step][:2], terrain) for step in steps]
        for (x, y, z), (u, v, w) in pairwise(points):
            self.scene.line([x, y, z + 0.15], [u, v, w + 0.15]).material(colour)
        cloud = self._dense(points)
        rgb = [[int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]] * len(cloud)
        self.scene.point_cloud(cloud.tolist(), rgb, point_size=size / 110)
        body = self.scene.box(
            max(one.rover.length, size / 45), max(one.rover.width, size / 65), size / 90
        ).material(colour)  # fmt: skip
        self.rovers.append((one, body, terrain))

    @staticmethod
    def _dense(points: list[tuple[float, float, float]]) -> F64:
        """Points so near to each other that they make a line as thick as one of them."""
        parts = [np.array(points[:1])]
        for a, b in pairwise(points):
            count = min(200, max(2, int(math.dist(a, b) / 0.06)))
            parts.append(np.linspace(a, b, count)[1:])
        return np.concatenate(parts) + np.array([0.0, 0.0, 0.15])

    def _camera(self, window: tuple[float, float, float, float], terrain: Terrain | None) -> None:
        west, south, east, north = window
        size = max(east - west, north - south)
        x, y = (west + east) / 2, (south + north) / 2
        middle = self._at(x, y, terrain)[2]
        self.scene.move_camera(
            x=x, y=y - 1.12 * size, z=middle + 0.78 * size, look_at_x=x, look_at_y=y,
            look_at_z=middle, duration=0,
        )  # fmt: skip

    def moment(self, seconds: float, focus: int) -> None:
        """Put the rovers where they are at a time."""
        if self.scene is None or not self.box.visible:
            return
        for one, body, terrain in self.rovers:
            x, y, heading = one.poses[one.step_at(seconds)]
            at = self._at(x, y, terrain)
            body.move(at[0], at[1], at[2] + 0.25).rotate(0, 0, heading)
