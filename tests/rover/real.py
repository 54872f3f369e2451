"""Perseverance's recorded stops on the elevation model of Jezero."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

from rovernav.rover import read_rover, settle, standing, surface
from rovernav.terrain import read_terrain


class Found(NamedTuple):
    stops: int
    blocked: int
    tilt_rmse: float
    tilt_correlation: float
    pitch_correlation: float
    roll_correlation: float


def jezero(data: Path) -> Found:
    terrain = read_terrain(data / "dem/mars_jezero_hirise")
    text = (data / "traverse/perseverance_waypoints_sol13-401.json").read_text()
    poses, told = [], []
    for stop in json.loads(text)["features"]:
        p = stop["properties"]
        # The model's own projection, and the known shift between it and the mission's map.
        radius, parallel = 3394839.8133163, math.radians(15.0)
        x = radius * math.cos(parallel) * math.radians(p["lon"] - 77.44) + 5.0
        y = radius * math.radians(p["lat"]) - 110.0
        x, y = terrain.frame.to_local(x, y)
        if terrain.frame.contains(x, y):
            poses.append([x, y, math.radians(90.0 - p["yaw"])])
            told.append([p["tilt"], p["pitch"], p["roll"]])
    rover = read_rover("perseverance")
    where = standing(terrain, rover)
    blocked = sum(int(where.blocked[terrain.frame.cell_of(x, y)]) for x, y, _ in poses)
    stands = settle(surface(terrain, rover), poses)
    guess = np.degrees([stands.tilt, stands.pitch, stands.roll])
    known = np.array(told).T
    rho = [float(np.corrcoef(a, b)[0, 1]) for a, b in zip(guess, known, strict=True)]
    rmse = float(np.sqrt(np.mean((guess[0] - known[0]) ** 2)))
    return Found(len(poses), blocked, rmse, *rho)
