"""Real rovers: Perseverance's stops at Jezero, Cuadriga's motor currents, Spirit's odometry.

    ROVERNAV_DATA=FOLDER python benchmarks/experiments/real_drives.py

Jezero: 114 recorded stops inside the elevation model, moved by the known shift of the model's
datum (+5 m, -110 m). Is the stop called a hazard; how far is the settled attitude, at the recorded
heading, from the recorded one?

Cuadriga: a skid-steered electric robot on slopes. Power is taken to follow the sum of the two
motor currents; idle current, current per newton and rolling resistance are fitted on every second
log, in the order of their names, and judged on the others. Attitude comes once from the elevation
model along the course, once from the IMU. Nothing else is fitted, and no log is left out.

Spirit: the track by wheel odometry and IMU beside the one corrected from images, by site: the
stretch between two places where its position was taken anew. For each the scale and the turn that
bring the first nearest to the second; a model of both is fitted on every second site, in their
order, and judged on the others.
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
from scipy import ndimage, optimize, stats

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
    data = Path(named)
    for name, value in {**jezero(data), **cuadriga(data), **spirit(data)}.items():
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


class Sites(NamedTuple):
    """Of each site of Spirit: way, errors of scale and heading [rad], where it ended wrongly."""

    way: Any
    scale: Any
    turn: Any
    net: Any

    def some(self, which: Any) -> Sites:
        """The sites of an index."""
        return Sites(*(column[which] for column in self))


SHORTEST, FREEDOM = 10.0, 3.0
"""Sites with less way are left out [m]; tails are Student's, with so many degrees of freedom."""


def spirit(data: Path) -> dict[str, Any]:
    """Spirit's odometry: error of scale and of heading by site, fitted on half, judged on half."""
    sites = _sites(data / "traverse/spirit_traverse.csv")
    fit, test = sites.some(slice(0, None, 2)), sites.some(slice(1, None, 2))
    out: dict[str, Any] = {
        "spirit: sites, way [m]": f"{len(sites.way)}, {sites.way.sum():.0f}",
        "spirit: error of place per way: quartiles, 95 %": _quartiles(sites.net / sites.way),
        "spirit: error of scale: quartiles, 95 % of size": _quartiles(sites.scale),
        "spirit: error of heading [deg]: quartiles": _quartiles(np.degrees(sites.turn)),
    }
    # A constant part for a site and one that grows on the way: a noise of d per root of a metre
    # gives the mean scale of a way L the variance d^2 / L; a random walk of w per root of a metre
    # gives the mean heading the variance w^2 L / 3.
    scale = _spread(fit.scale, 1.0 / fit.way)
    turn = _spread(fit.turn, fit.way / 3.0)
    out["spirit: scale: mean, constant part, noise [m^0.5]"] = _three(scale)
    out["spirit: heading: mean, constant part [rad], walk [rad/m^0.5]"] = _three(turn)
    for name, got, law, grows in (
        ("scale", test.scale, scale, 1.0 / test.way), ("heading", test.turn, turn, test.way / 3.0),
    ):  # fmt: skip
        z = np.abs(got - law[0]) / np.sqrt(law[1] ** 2 + law[2] ** 2 * grows)
        inside = [float(np.mean(z <= stats.t.ppf(0.5 + 0.5 * p, FREEDOM))) for p in (0.5, 0.9)]
        out[f"spirit: held out: {name} within 50 %, 90 % bounds"] = (
            f"{inside[0]:.2f}, {inside[1]:.2f}"
        )
    rng, draws = np.random.default_rng(0), (2000, len(test.way))
    size = np.sqrt(scale[1] ** 2 + scale[2] ** 2 / test.way)
    bent = np.sqrt(turn[1] ** 2 + turn[2] ** 2 * test.way / 3.0)
    drawn = (1.0 + scale[0] + size * rng.standard_t(FREEDOM, draws)) * np.exp(
        1j * (turn[0] + bent * rng.standard_t(FREEDOM, draws))
    )
    told = np.abs(drawn - 1.0)
    for p in (50, 90):
        share = float(np.mean(test.net / test.way <= np.percentile(told, p, axis=0)))
        out[f"spirit: held out: error of place within the {p} % bound"] = share
    rho = stats.spearmanr(np.abs(sites.turn - np.median(sites.turn)), sites.way)
    out["spirit: size of the heading's error over way, rank correlation"] = float(rho.statistic)
    return out


def _sites(path: Path) -> Sites:
    rows = np.genfromtxt(path, delimiter=",", skip_header=1)
    site, raw, told = rows[:, 0], rows[:, 4] + 1j * rows[:, 5], rows[:, 7] + 1j * rows[:, 8]
    found: list[tuple[float, float, float, float]] = []
    for number in np.unique(site):
        at = np.flatnonzero(site == number)
        at = np.arange(max(0, at[0] - 1), at[-1] + 1)  # from where the last one ended
        step, true = np.diff(raw[at]), np.diff(told[at])
        way = np.abs(step).sum()
        if way >= SHORTEST:
            z = np.vdot(step, true) / np.vdot(step, step).real
            net = abs(true.sum() - step.sum())
            found.append((way, abs(z) - 1.0, float(np.angle(z)), net))
    return Sites(*np.array(found).T)


def _spread(got: Any, grows: Any) -> tuple[float, float, float]:
    """Mean, and the constant and the growing part of the spread, most likely by Student's t."""

    def unlikely(x: Any) -> float:
        size = np.sqrt(np.exp(2.0 * x[1]) + np.exp(2.0 * x[2]) * grows)
        return -float(stats.t.logpdf((got - x[0]) / size, FREEDOM).sum() - np.log(size).sum())

    starts = [(np.median(got), math.log(a), math.log(b)) for a in (0.01, 0.05) for b in (1e-3, 0.1)]
    fits = [optimize.minimize(unlikely, x, method="Nelder-Mead", options={"maxiter": 4000})
            for x in starts]  # fmt: skip
    best = min(fits, key=lambda fit: fit.fun).x
    return float(best[0]), math.exp(best[1]), math.exp(best[2])


def _quartiles(got: Any) -> str:
    low, middle, high = np.percentile(got, [25, 50, 75])
    return f"{low:.3f}, {middle:.3f}, {high:.3f}; {np.percentile(np.abs(got), 95):.3f}"


def _three(numbers: Any) -> str:
    return ", ".join(f"{number:.4f}" for number in numbers)


if __name__ == "__main__":
    main()
