"""Rovers with bodies of every kind of steering, and rough worlds for them."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np

from rovernav.rover import Rover, Steering, read_rover
from rovernav.sim import Ground, Rocks, Worlds
from tests.rover.rough_ground import rough_ground

CELL, CELLS, SIDE = 0.1, 64, 6.4
WAYS = {"speed": 0.6, "turn_rate": 0.8}
RESEARCH = dataclasses.replace(read_rover("research"), **WAYS)
MARS = dataclasses.replace(read_rover("perseverance"), **WAYS)
LOWER = dataclasses.replace(RESEARCH, clearance=0.06, max_step=0.3, max_slope=math.radians(60.0))


def steered(rover: Rover, kind: Any, **more: Any) -> Rover:
    drives = {"drive": "two-axis", "step": 0.6} if kind == "two-axis" else {}
    return dataclasses.replace(rover, steering=Steering(kind=kind, **more), **drives)


LAZY = {"lag": 0.3, "acceleration": 0.9, "turn_acceleration": 1.2}
CARS = {
    "two-axis": steered(LOWER, "two-axis", wheel_speed=0.5),
    "skid": steered(RESEARCH, "skid", **LAZY),
    "ackermann-four": steered(LOWER, "ackermann", max_steer=math.radians(35.0), lag=0.2),
    "ackermann-six": steered(MARS, "ackermann", max_steer=math.radians(60.0), acceleration=0.8),
    "crab": steered(MARS, "crab", max_steer=math.radians(50.0), wheel_speed=0.5, **LAZY),
}
SOILS = {"skid": "loose-sand", "ackermann-six": "loose-sand"}


def worlds_of(seed: int, rovers: int) -> Worlds:
    """Rough ground with rocks, a steep slope, ridges, and a box beside ground that is missing."""
    rng, at = np.random.default_rng([7, seed]), (np.arange(CELLS) + 0.5) * CELL
    rough, steep, ridged, holed = (
        rough_ground(4 * seed + k, slope=slope, cell=CELL, cells=CELLS)
        for k, slope in enumerate((0.1, 0.72, 0.0, 0.1))
    )
    height = np.stack([g.height + np.float32(g.offset) for g in (rough, steep, ridged, holed)])
    height[2] += (0.28 * np.maximum(0.0, 1.0 - np.abs(np.mod(at, 1.4) - 0.7) / 0.25))[None]
    height[3, 20:26, 35:40] = np.nan
    rocks = np.column_stack(
        [rng.uniform(0, SIDE, (20, 2)), rng.uniform(0.15, 0.2, 20), rng.uniform(0.05, 0.4, 20)]
    )
    return Worlds(
        boxes=np.array([[2.0, 3.0, 2.3, 4.0], [4.0, 4.5, 4.1, 6.0]]),
        offsets=np.array([0, 0, 0, 0, 2]),
        bounds=np.tile([0.3, 0.3, SIDE - 0.3, SIDE - 0.3], (4, 1)),
        of=np.arange(rovers) % 4,
        ground=Ground(frame=rough.frame, height=height, offset=2.0),
        rocks=Rocks(place=rocks, offsets=np.array([0, 20, 20, 20, 20])),
    )
