"""Predictions for real rovers: Perseverance's stops at Jezero, Cuadriga's motor currents.

    ROVERNAV_DATA=FOLDER python benchmarks/experiments/real_drives.py

Jezero: 114 recorded stops inside the elevation model, moved by the known shift of the model's
datum (+5 m, -110 m). Is the stop called a hazard; how far is the settled attitude, at the recorded
heading, from the recorded one?

Cuadriga: a skid-steered electric robot on slopes. Power is taken to follow the sum of the two
motor currents; idle current, current per newton and rolling resistance are fitted on every second
log, in the order of their names, and judged on the others. Attitude comes once from the elevation
model along the course, once from the IMU. Nothing else is fitted, and no log is left out.
"""

from __future__ import annotations

import json
import math
import os
import sys
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from pyproj import Transformer
from scipy import ndimage, optimize

from rovernav.core import Frame
from rovernav.rover import (
    Mobility,
    Rover,
    Soil,
    drive_cost,
    drive_table,
    read_rover,
    settle,
    standing,
    surface,
)
from rovernav.terrain import Terrain, planes_over, read_terrain

SHIFT = (5.0, -110.0)
"""From the mission's map to the elevation model [m]; data sheet of the development data."""
RADIUS, PARALLEL, MERIDIAN = 3394839.8133163, 15.0, 77.44
CORNER = (366966.844, 4064291.833)
"""South-west corner of Cuadriga's elevation model, UTM zone 30N [m]."""
STRAIGHT, SLOWEST, WORST_FIX = 0.45, 0.2, 1.0
"""Largest curvature [1/m], as the authors of the logs take it; least speed [m/s]; GPS error [m]."""


def main() -> None:
    """Measure and print."""
    named = os.environ.get("ROVERNAV_DATA")
    if not named:
        sys.exit("set ROVERNAV_DATA to the folder of the development data")
    for name, value in {**jezero(Path(named)), **cuadriga(Path(named))}.items():
        print(f"{name:44s} {value:.3f}" if isinstance(value, float) else f"{name:44s} {value}")


def jezero(data: Path) -> dict[str, Any]:
    """Perseverance's stops: shares called hazards, and errors of attitude [deg]."""
    terrain = read_terrain(data / "dem/mars_jezero_hirise")
    stops = json.loads((data / "traverse/perseverance_waypoints_sol13-401.json").read_text())
    seen = [stop["properties"] for stop in stops["features"]]
    x, y = (np.array(c) for c in zip(*(_on_the_model(p, terrain) for p in seen), strict=True))
    inside = np.array([terrain.frame.contains(*p) for p in zip(x, y, strict=True)])
    rover, out = read_rover("perseverance"), {"jezero: stops inside the model": int(inside.sum())}
    where = standing(terrain, rover)
    cells = [terrain.frame.cell_of(*p) for p in zip(x[inside], y[inside], strict=True)]
    out["jezero: stops called hazards"] = int(sum(where.blocked[cell] for cell in cells))
    yaw = np.radians([p["yaw"] for p in seen])  # clockwise from north
    poses = np.stack([x, y, 0.5 * math.pi - yaw], axis=1)[inside]
    stands = settle(surface(terrain, rover), poses)
    out["jezero: settled poses that are not safe"] = int((~stands.safe).sum())
    slope = planes_over(terrain, rover.footing).slope()
    guesses = {
        "tilt": stands.tilt,
        "pitch": stands.pitch,
        "roll": stands.roll,
        "tilt, plane fit": np.array([slope[cell] for cell in cells]),
    }
    for name, guess in guesses.items():
        told = np.array([p[name.split(",")[0]] for p in seen])[inside]
        _compare(out, f"jezero: {name} [deg]", np.degrees(guess), told)
    return out


def _on_the_model(stop: dict[str, float], terrain: Terrain) -> tuple[float, float]:
    east = RADIUS * math.cos(math.radians(PARALLEL)) * math.radians(stop["lon"] - MERIDIAN)
    north = RADIUS * math.radians(stop["lat"])
    return terrain.frame.to_local(east + SHIFT[0], north + SHIFT[1])


def _compare(out: dict[str, Any], name: str, guess: Any, told: Any) -> None:
    error = guess - told
    out[f"{name}: RMSE"] = float(np.sqrt(np.mean(error**2)))
    out[f"{name}: mean error"] = float(error.mean())
    out[f"{name}: correlation"] = float(np.corrcoef(guess, told)[0, 1])


class Log(NamedTuple):
    """What is used of one of Cuadriga's logs: rise along the course, speed, current."""

    dem: Any
    imu: Any
    speed: Any
    current: Any


def cuadriga(data: Path) -> dict[str, Any]:
    """Cuadriga's currents: fitted on half of the logs, judged on the others."""
    z = np.genfromtxt(data / "dem/earth_uma_rescue_1m/UMARescueArea_1mDEM.csv")
    frame = Frame(cell=1.0, shape=z.shape, origin=CORNER)
    terrain = Terrain.from_heights(z, frame, name="uma", source="UMA rescue area")
    paths = sorted((data / "rover_logs/cuadriga").glob("*/*.txt"))
    logs = [_read(path, terrain) for path in paths]
    fit, test = logs[0::2], logs[1::2]
    out: dict[str, Any] = {
        "cuadriga: rows fitted": sum(len(log.speed) for log in fit),
        "cuadriga: rows judged": sum(len(log.speed) for log in test),
    }
    told = np.concatenate([log.current for log in test])
    mean = np.concatenate([log.current for log in fit]).mean()
    out["cuadriga: RMSE of the mean current [A]"] = float(np.sqrt(np.mean((told - mean) ** 2)))
    both = [np.concatenate([getattr(log, key) for log in logs]) for key in ("dem", "imu")]
    out["cuadriga: IMU against model, correlation"] = float(np.corrcoef(*both)[0, 1])
    for source in ("dem", "imu"):
        guess, numbers = _fitted(fit, test, source)
        _compare(out, f"cuadriga: current by {source} [A]", guess, told)
        out[f"cuadriga: by {source}: idle A, A s/m, resistance"] = ", ".join(
            f"{number:.3f}" for number in numbers
        )
        each = [_fitted(fit, [log], source)[0] for log in test]
        rho = [np.corrcoef(g, log.current)[0, 1] for g, log in zip(each, test, strict=True)]
        out[f"cuadriga: by {source}: correlation in each log"] = ", ".join(
            f"{number:.2f}" for number in rho
        )
    return out


def _fitted(fit: list[Log], test: list[Log], source: str) -> tuple[Any, Any]:
    """Currents that the drive model predicts for `test`, with three numbers fitted to `fit`."""
    rise, speed, current = (
        np.concatenate([getattr(log, key) for log in fit]) for key in (source, "speed", "current")
    )

    def error(numbers: Any) -> Any:
        return _current(numbers, rise, speed) - current

    best = optimize.least_squares(error, (2.0, 30.0, 0.2), bounds=((0, 0, 0), (30, 500, 2)))
    rise, speed = (np.concatenate([getattr(log, key) for log in test]) for key in (source, "speed"))
    return _current(best.x, rise, speed), best.x


def _current(numbers: Any, rise: Any, speed: Any) -> Any:
    """Current [A] for idle current, current per unit of weight and speed, rolling resistance.

    The drive model's power for a rover of weight 1 N at 1 m/s, scaled: power is linear in speed.
    """
    idle, gain, resistance = numbers
    flat, none = np.radians([0.0, 60.0]), np.zeros(2)
    soil = Soil(
        name="field", source="fitted", rolling_resistance=resistance, slope=flat, slip=none,
        slip_low=none, slip_high=none, side_slip=none, measured_up=0.5, measured_down=0.5,
        measured_side=0.5, sinkage=0.0,
    )  # fmt: skip
    mobility = Mobility(
        mass=1.0, gravity=1.0, efficiency=1.0, idle_power=0.0, drive_power=0.0, max_slip=0.9,
        soil="compacted",
    )  # fmt: skip
    rover = Rover(
        name="cuadriga", source="fitted", drive="differential", length=1.2, width=0.9,
        wheel_radius=0.2, clearance=0.2, max_slope=0.7, max_step=0.2, speed=1.0, turn_rate=1.0,
        track=0.7, mobility=mobility,
    )  # fmt: skip
    power = drive_cost(rise, 0.0, 0.0, drive_table(rover, soil)).power
    return idle + gain * speed * power


def _read(path: Path, terrain: Terrain) -> Log:
    """Rows of a log while it drives forward, about straight, with a good fix."""
    rows = np.loadtxt(path, usecols=range(15))
    to_utm = Transformer.from_crs(4326, 32630, always_xy=True)
    east, north = to_utm.transform(rows[:, 10], rows[:, 9])
    x = ndimage.uniform_filter1d(np.array(east) - CORNER[0], 10)
    y = ndimage.uniform_filter1d(np.array(north) - CORNER[1], 10)
    course, bend = _course(x, y)
    keep = (rows[:, 0] > 0) & (rows[:, 14] < WORST_FIX) & (rows[:, 13] > SLOWEST)
    keep &= bend < STRAIGHT
    planes = planes_over(terrain, 3.0)
    i, j = np.clip(y.astype(int), 0, 199), np.clip(x.astype(int), 0, 199)
    dem = planes.east[i, j] * np.cos(course) + planes.north[i, j] * np.sin(course)
    imu = -np.tan(np.radians(rows[:, 7] + 13.7))  # mounting angle: the authors' reader
    current = ndimage.median_filter(np.abs(rows[:, 4]) + np.abs(rows[:, 5]), size=10)
    return Log(*(a[keep].astype(float) for a in (dem, imu, rows[:, 13], current)))


def _course(x: Any, y: Any, reach: int = 10) -> tuple[Any, Any]:
    """Course [rad] and curvature [1/m] over a second before and after; infinite at the ends."""
    course, bend = np.zeros(len(x)), np.full(len(x), np.inf)
    a, b, c = slice(0, -2 * reach), slice(reach, -reach), slice(2 * reach, None)
    course[b] = np.arctan2(y[c] - y[a], x[c] - x[a])
    before = np.arctan2(y[b] - y[a], x[b] - x[a])
    after = np.arctan2(y[c] - y[b], x[c] - x[b])
    turn = np.abs(np.angle(np.exp(1j * (after - before))))
    way = 0.5 * np.hypot(x[c] - x[a], y[c] - y[a])
    bend[b] = np.where(way > 0.1, turn / np.maximum(way, 0.1), np.inf)
    return course, bend


if __name__ == "__main__":
    main()
