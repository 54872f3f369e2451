"""Least energy against shortest: 100 generated sand terrains, both routes driven with other slip.

    python benchmarks/experiments/least_energy.py [--cautious] [--quick] [--pilot] [--only KIND]

Frozen before the first run, and not changed after it: everything in capitals below. Spirit's twin
(`mer`) goes from the west to the east of 200 m x 200 m of dunes and hills, all loose sand. Two
routes under the same limits, as `rovernav route --objective distance` and `energy` plan them with
the expected slip. Each is then driven in two ways, 8 times each, by a follower that knows where it
is and steers for a point of the route ahead of it; it knows nothing of slip.
In the simulator (`sim.Body`), slip and side slip of each rover are those expected times factors of
0.7 to 1.3; the body stands on the ground, and its own attitude decides how it slips.
On patches: by a factor of 0.7 to 1.3 for the whole terrain, times another of 0.7 to 1.3 for each
patch of 5 m in each drive; the gradient is the planner's, the rover a point.
Both routes have the same luck. Terrains where the goal cannot be reached under the limits are
counted and replaced by the next seed. `--only simulator` drives kept routes in the simulator alone.
`--cautious` was added after the first run and changes one thing: both routes are planned, and
limits kept, with the high edge of the likely slip. Its numbers go to least_energy_cautious.json.
`--pilot` looks at other seeds, and only at whether there is a way and how long that takes.
Writes least_energy.json and the picture of docs/least-energy.md.
"""

from __future__ import annotations

import argparse
import json
import math
import time
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from rovernav.core import Command, Mission, Observation, Outcome
from rovernav.kernels import traction
from rovernav.plan import Going, directed, going
from rovernav.rover import Rover, drive_cost, drive_table, hazards, read_rover
from rovernav.sim import Body, Drive, DriveState, Worlds, simulate
from rovernav.sim import Ground as GroundHeights
from rovernav.terrain import Dunes, Ground, Recipe, Relief, Terrain

HERE = Path(__file__).resolve().parent
IMAGES = HERE.parent.parent / "docs" / "images"

# ---- frozen: the ground ------------------------------------------------------------------------
TERRAINS, SIDE, CELL = 100, 200.0, 0.5
HURST, HILL_SLOPE, HILL_BASELINE = 0.8, 5.0, 10.0
"""Hills under the dunes: rms slope [deg] over a baseline [m]."""
WAVELENGTH, LEE = (20.0, 40.0), (10.0, 18.0)
"""Dunes: drawn per terrain [m]; steepest slope on the lee side [deg]. Any wind."""
WEST, EAST, MARGIN = 20.0, 180.0, 30.0
"""Start and goal: x [m]; y is drawn, this far from the edge at least [m]."""
# ---- frozen: the rover, its slip and energy ----------------------------------------------------
ROVER, SOIL = "mer", "loose-sand"
"""Limits, masses, powers, slip over slope and side slip are those that the package ships."""
# ---- frozen: the drives ------------------------------------------------------------------------
DRIVES, FACTOR, PATCH = 8, (0.7, 1.3), 5.0
STEP, AHEAD, TURN_FIRST = 0.2, 2.0, math.radians(60.0)
"""Way of the wheels in a step [m]; the point steered for lies this far ahead [m]; a rover that
looks farther away from it than this turns on the spot."""
GOAL, STUCK, TOO_LONG = 1.0, 0.05, 4.0
"""Arrived within [m]; stuck below this share of the wheels' way over two wheelbases; given up
after so many times the planned time."""
SPREAD, PERIOD = 0.3, 4.0
"""In the simulator: of slip; time between two commands [s], in which the wheels go as far."""
DIGGING = 0.8
"""Slip that counts as digging in."""
# ------------------------------------------------------------------------------------------------
KINDS = ("distance", "energy")
ENDS = ("driving", "arrived", "stuck", "tipped", "off the map", "timed out")


class Driven(NamedTuple):
    """What became of the drives of one route (DRIVES,)."""

    end: Any
    energy: Any
    wheels: Any
    ground: Any
    dug: Any


def main() -> None:
    """Plan, drive, print, draw, keep."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--quick", action="store_true", help="5 terrains, no files")
    parser.add_argument("--pilot", action="store_true", help="5 other seeds: is there a way?")
    parser.add_argument("--cautious", action="store_true", help="plan for the high edge of slip")
    parser.add_argument("--only", choices=["pictures", "simulator"], help="from the routes kept")
    asked = parser.parse_args()
    band = "high" if asked.cautious else "expected"
    kept = HERE / ("least_energy_cautious.json" if asked.cautious else "least_energy.json")
    if asked.pilot:
        for seed in range(10_000, 10_005):
            clock = time.process_time()
            task = task_of(seed)
            found = [directed(task.ground.by(k), task.start, task.goal).found for k in KINDS]
            print(seed, found, f"{time.process_time() - clock:.1f} s")
        return
    if asked.only is None:
        check_model()
        rows, skipped, seed = [], 0, 0
        while len(rows) < (5 if asked.quick else TERRAINS):
            row = compared(task_of(seed, band), seed)
            seed += 1
            if row is None:
                skipped += 1
                continue
            rows.append(row)
            print(len(rows), seed - 1, said(row), flush=True)
        if asked.quick:
            print(json.dumps({w: summary(rows, w) for w in ("patches", "simulator")}, indent=1))
            return
        keep(kept, rows, skipped)
    if asked.only == "simulator":
        again(kept, band)
    if not asked.cautious:
        draw(json.loads(kept.read_text(encoding="utf-8")))


def again(kept: Path, band: str) -> None:
    """Drive the routes that are kept in the simulator once more."""
    found = json.loads(kept.read_text(encoding="utf-8"))
    for row in found["terrains"]:
        task = task_of(row["seed"], band)
        for kind in KINDS:
            points = np.array(row[kind]["points"])
            planned = row[kind]["planned time"]
            row[kind]["simulator"] = simulated(task, points, row["seed"], planned)
        print(row["seed"], said(row), flush=True)
    keep(kept, found["terrains"], found["without a way"])


def keep(path: Path, rows: list[dict[str, Any]], skipped: int) -> None:
    """Write the numbers; those of the routes in one line each."""
    ways = ("patches", "simulator")
    said = {way: summary(rows, way) for way in ways if way in rows[0]["energy"]}
    found = {"without a way": skipped, **said, "terrains": rows}
    path.write_text(json.dumps(found, separators=(",", ":")) + "\n", encoding="utf-8")
    print(json.dumps(said, indent=1))


class Task(NamedTuple):
    """A terrain with two places on it, and what going costs there."""

    terrain: Terrain
    ground: Going
    start: tuple[float, float]
    goal: tuple[float, float]


def task_of(seed: int, band: str = "expected") -> Task:
    """The terrain of a seed, judged for the rover with an edge of the likely slip."""
    rng = np.random.default_rng((seed, 18))
    wavelength, lee = rng.uniform(*WAVELENGTH), math.radians(rng.uniform(*LEE))
    height = math.tan(lee) * 0.35 * wavelength / 1.5  # the inverse of `Dunes.lee`
    dunes = Dunes(wavelength=wavelength, height=height, wind=rng.uniform(0.0, 2.0 * math.pi))
    relief = Relief(hurst=HURST, slope=math.radians(HILL_SLOPE), baseline=HILL_BASELINE)
    recipe = Recipe(size=(SIDE, SIDE), cell=CELL, relief=relief, dunes=dunes)
    terrain = Ground.made(recipe, seed).read()
    rover = read_rover(ROVER)
    ends = rng.uniform(MARGIN, SIDE - MARGIN, 2)
    ground = going(hazards(terrain, rover, soil=SOIL), rover, objective="energy", slip=band)
    return Task(terrain, ground, (WEST, float(ends[0])), (EAST, float(ends[1])))


def compared(task: Task, seed: int) -> dict[str, Any] | None:
    """Both routes planned and driven; None where there is no way."""
    routes = {kind: directed(task.ground.by(kind), task.start, task.goal) for kind in KINDS}
    if not all(route.found for route in routes.values()):
        return None
    row: dict[str, Any] = {"seed": seed}
    for kind, route in routes.items():
        d = driven(task.ground, route.points, seed)
        planned = task.ground.by("time").cost_of(route.points)
        row[kind] = {
            "length": route.length,
            "planned energy": task.ground.by("energy").cost_of(route.points),
            "planned time": planned,
            "points": np.round(route.points, 2).tolist(),
            "patches": told([ENDS[end] for end in d.end], d),
            "simulator": simulated(task, route.points, seed, planned),
        }
    return row


def told(ends: list[str], d: Driven) -> dict[str, Any]:
    """Drives as plain data."""
    slip = 1.0 - d.ground / np.maximum(d.wheels, 1e-9)
    return {
        "end": ends,
        "energy": np.round(d.energy).tolist(),
        "slip": np.round(slip, 5).tolist(),
        "dug": d.dug.tolist(),
    }


def simulated(task: Task, points: Any, seed: int, planned: float) -> dict[str, Any]:
    """One route, planned to take so long [s], driven DRIVES times in the simulator."""
    ground, terrain = task.ground, task.terrain
    rover, (path, way) = ground.rover, fine(points)
    first = math.atan2(*(path[4] - path[0])[::-1])
    mission = Mission(
        start=np.tile([*points[0], first], (DRIVES, 1)), goal=np.tile(points[-1], (DRIVES, 1)),
        goal_radius=GOAL, time_limit=TOO_LONG * planned,
    )  # fmt: skip
    under = GroundHeights(frame=terrain.frame, height=terrain.height, offset=terrain.offset)
    body = Body(rover, period=PERIOD, soil=SOIL, spread=SPREAD)
    drive = Drive(
        worlds=Worlds.single(ground=under, rovers=DRIVES), mission=mission, sensors=(),
        controller=Along(path, way, rover), motion=body,
    )  # fmt: skip
    wheels, moved, dug = np.zeros(DRIVES), np.zeros(DRIVES), np.zeros(DRIVES, int)

    def watch(state: DriveState) -> None:
        rovers, asked = state.rovers, state.command
        assert asked is not None
        rolled = rovers.driving * np.abs(asked.twist[:, 0]) * PERIOD
        wheels[:] += rolled
        moved[:] += rolled * (1.0 - rovers.slip[:, 0])
        dug[:] += (rolled > 0.0) & (rovers.slip[:, 0] > DIGGING)

    trace = simulate(drive, seed=seed, on_event=watch, record="path")
    ends = [Outcome(int(end)).name.lower().replace("_", " ") for end in trace.outcome]
    ends = ["arrived" if end == "reached" else end for end in ends]
    return told(ends, Driven(trace.outcome, trace.energy[-1], wheels, moved, dug))


class Along:
    """Steers for a point of a path ahead of each rover.

    Args:
        path: Points (k, 2) [m].
        way: Distance between two of them [m].
        rover: For its speed and turn rate.
    """

    def __init__(self, path: Any, way: float, rover: Rover) -> None:
        self._path, self._ahead, self._rover = path, round(AHEAD / way), rover

    def start(self, mission: Mission, rng: np.random.Generator) -> Any:
        """How far along each rover is."""
        del rng
        return np.zeros(len(mission.start), int)

    def act(self, observation: Observation, memory: Any) -> tuple[Command, Any]:
        """Forward, unless it looks elsewhere, and towards the path."""
        pose = observation.pose
        at = nearest(self._path, pose[:, :2], memory)
        target = self._path[np.minimum(at + self._ahead, len(self._path) - 1)]
        off = turned(np.arctan2(*(target - pose[:, :2]).T[::-1]) - pose[:, 2])
        twist = np.zeros((len(pose), 3))
        twist[:, 0] = np.where(np.abs(off) < TURN_FIRST, self._rover.speed, 0.0)
        twist[:, 2] = np.clip(off / PERIOD, -self._rover.turn_rate, self._rover.turn_rate)
        return Command(twist=twist), at


def driven(ground: Going, points: Any, seed: int) -> Driven:
    """One route driven DRIVES times at once, each time on other ground."""
    rover, table = ground.rover, ground.table
    assert table is not None
    assert rover.chassis is not None
    path, way = fine(points)
    factor = Slips(ground, seed)
    n, dt = DRIVES, STEP / rover.speed
    place, heading = np.tile(points[0], (n, 1)), np.full(n, math.atan2(*(path[4] - path[0])[::-1]))
    at, end = np.zeros(n, int), np.zeros(n, int)
    energy, wheels, moved, dug = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n, int)
    window = max(2, math.ceil(2.0 * rover.chassis.wheelbase / STEP))
    recent = np.full((window, n), STEP)
    late = TOO_LONG * ground.by("time").cost_of(points)
    for step in range(int(late / dt) + 1):
        go = end == 0
        if not go.any():
            break
        at = nearest(path, place, at)
        target = path[np.minimum(at + round(AHEAD / way), len(path) - 1)]
        off = turned(np.arctan2(*(target - place).T[::-1]) - heading)
        most = rover.turn_rate * dt
        heading = np.where(go, heading + np.clip(off, -most, most), heading)
        p, q, known = factor.slope(place)
        ex, ey = np.cos(heading), np.sin(heading)
        along, across = p * ex + q * ey, q * ex - p * ey
        stretch = np.sqrt(1.0 + along * along)
        slip, side = factor.of(place, (p, q, heading))
        rolls = go & (np.abs(off) < TURN_FIRST)
        force = np.maximum(0.0, table[0, traction.WEIGHT] * (along + table[0, traction.ROLLING]))
        pull = force / stretch / table[0, traction.EFFICIENCY]
        energy += go * dt * (table[0, traction.IDLE] + rolls * pull * rover.speed)
        forward = rolls * STEP * (1.0 - slip) / stretch
        left = -STEP * rolls * side / np.sqrt(1.0 + across * across)
        step_xy = np.column_stack([forward * ex - left * ey, forward * ey + left * ex])
        place = np.where(go[:, None], place + step_xy, place)
        wheels += rolls * STEP
        moved += rolls * STEP * (1.0 - slip)
        recent[step % window] = np.where(rolls, STEP * (1.0 - slip), recent[step % window])
        dug += rolls & (slip > DIGGING)
        ends = (
            (5, step * dt >= late - dt),
            (2, recent.mean(axis=0) < STUCK * STEP),
            (3, np.hypot(p, q) > math.tan(rover.chassis.static_tilt)),
            (4, ~known),
            (1, np.hypot(*(place - points[-1]).T) <= GOAL),
        )
        for code, so in ends:
            end = np.where(go & so, code, end)
    return Driven(end, energy, wheels, moved, dug)


class Slips:
    """How much wheels really slip: what was expected, times what nobody knows.

    Args:
        ground: For gradient and curves.
        seed: Of the terrain; the drives of one terrain follow from it.
    """

    def __init__(self, ground: Going, seed: int) -> None:
        layers = ground.hazards.layers
        self._table = drive_table(ground.rover, SOIL)  # as expected, whatever was planned with
        self._p, self._q = (np.asarray(layers[key].values, float) for key in ("east", "north"))
        self._cell = ground.frame.cell
        count = math.ceil(max(ground.frame.extent) / PATCH)
        whole = np.random.default_rng((seed, 30)).uniform(*FACTOR)
        draws = np.random.default_rng((seed, 31)).uniform(*FACTOR, (DRIVES, count, count))
        self._factor = whole * draws

    def slope(self, place: Any) -> tuple[Any, Any, Any]:
        """Gradient to the east and north, bilinear; and where it is known."""
        h, w = self._p.shape
        u, v = np.clip(place.T / self._cell - 0.5, 0.0, [[w - 1.001], [h - 1.001]])
        j, i = u.astype(int), v.astype(int)
        u, v = u - j, v - i
        out = []
        for grid in (self._p, self._q):
            low = (1 - u) * grid[i, j] + u * grid[i, j + 1]
            high = (1 - u) * grid[i + 1, j] + u * grid[i + 1, j + 1]
            out.append((1 - v) * low + v * high)
        extent = np.array([w, h]) * self._cell
        known = np.isfinite(out[0]) & ((place > 0.0) & (place < extent)).all(axis=1)
        return np.nan_to_num(out[0]), np.nan_to_num(out[1]), known

    def of(self, place: Any, posed: tuple[Any, Any, Any]) -> tuple[Any, Any]:
        """Slip and side slip [share of the wheels' way], to the right positive, of each drive."""
        p, q, heading = posed
        told = drive_cost(p, q, heading, self._table)
        last = self._factor.shape[1] - 1
        j, i = np.clip((place.T / PATCH).astype(int), 0, last)
        factor = self._factor[np.arange(DRIVES), i, j]
        slip = np.minimum(told.slip * factor, 0.999)
        return slip, np.clip(told.side_slip * factor, -0.999, 0.999)


def fine(points: Any, way: float = 0.1) -> tuple[Any, float]:
    """A path with a point every `way` [m], and that distance."""
    length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    every = np.linspace(0.0, length[-1], max(2, round(length[-1] / way) + 1))
    return np.column_stack([np.interp(every, length, c) for c in points.T]), every[1]


def nearest(path: Any, place: Any, at: Any) -> Any:
    """The nearest point of the path from where each was, up to 4 m on."""
    ahead = np.minimum(at[:, None] + np.arange(40), len(path) - 1)
    off = path[ahead] - place[:, None]
    return ahead[np.arange(len(at)), (off**2).sum(axis=2).argmin(axis=1)]


def turned(angle: Any) -> Any:
    """The same angle within half a turn [rad]."""
    return np.angle(np.exp(1j * angle))


def check_model() -> None:
    """A straight climb without a factor must cost what `drive_cost` says."""
    rover = read_rover(ROVER)
    table = drive_table(rover, SOIL)
    for rise in (-0.2, 0.0, 0.1, 0.2):
        told = drive_cost(rise, 0.0, 0.0, table)
        stretch = math.sqrt(1.0 + rise * rise)
        force = max(0.0, table[0, traction.WEIGHT] * (rise + table[0, traction.ROLLING]) / stretch)
        power = force / table[0, traction.EFFICIENCY] * rover.speed + table[0, traction.IDLE]
        mine = power * stretch / (rover.speed * (1.0 - float(told.slip)))
        if not math.isclose(mine, float(told.energy), rel_tol=1e-9):
            raise AssertionError(f"the drive's energy {mine} is not the planner's {told.energy}")


def said(row: dict[str, Any]) -> str:
    """A line."""
    parts = []
    for kind in KINDS:
        r, d = row[kind], row[kind]["simulator"]
        told, spent = r["planned energy"] / 1e3, np.mean(d["energy"]) / 1e3
        parts.append(
            f"{kind}: {r['length']:.0f} m, planned {told:.0f} kJ, driven {spent:.0f} kJ, slip "
            f"{np.mean(d['slip']):.3f}, arrived {d['end'].count('arrived')}/{DRIVES}"
        )
    return "  |  ".join(parts)


def summary(rows: list[dict[str, Any]], way: str) -> dict[str, Any]:
    """What is stated: savings by terrain, over drives in which both arrived; shares of ends."""
    out: dict[str, Any] = {"terrains": len(rows)}
    pairs = savings(rows, way)
    ends = [(r["distance"][way]["end"], r["energy"][way]["end"]) for r in rows]
    whole = sum(set(a) == set(b) == {"arrived"} for a, b in ends)
    out["terrains where all arrived"] = whole
    rng = np.random.default_rng(1)
    for key, found in pairs.items():
        saved = np.array(found)
        again = np.median(rng.choice(saved, (2000, len(saved))), axis=1)
        out[f"less {key}"] = {
            "terrains": len(saved),
            "median": float(np.median(saved)),
            "median, 95 % interval": np.percentile(again, [2.5, 97.5]).tolist(),
            "5, 25, 75, 95 %": np.percentile(saved, [5, 25, 75, 95]).tolist(),
        }
    for kind in KINDS:
        out[kind] = of_kind([row[kind] for row in rows], way)
    return out


def savings(rows: list[dict[str, Any]], way: str) -> dict[str, list[float]]:
    """Shares saved by terrain; of what was driven, over the drives in which both arrived."""
    pairs: dict[str, list[float]] = {"energy": [], "slip": [], "planned energy": [], "length": []}
    for row in rows:
        short, least = row["distance"][way], row["energy"][way]
        both = [a == b == "arrived" for a, b in zip(short["end"], least["end"], strict=True)]
        for key in ("energy", "slip"):
            if any(both):
                a, b = (np.mean(np.array(r[key])[both]) for r in (short, least))
                pairs[key].append(float(1.0 - b / a))
        for key in ("planned energy", "length"):
            pairs[key].append(1.0 - row["energy"][key] / row["distance"][key])
    return pairs


def of_kind(routes: list[dict[str, Any]], way: str) -> dict[str, Any]:
    """How the drives of one kind of route ended, and how well their energy was foretold."""
    ends = [end for route in routes for end in route[way]["end"]]
    ratio = np.concatenate([
        np.array(r[way]["energy"])[np.array(r[way]["end"]) == "arrived"] / r["planned energy"]
        for r in routes
    ])  # fmt: skip
    return {
        "ends": {end: ends.count(end) for end in sorted(set(ends))},
        "drives that dug in": sum(d > 0 for r in routes for d in r[way]["dug"]),
        "energy of all drives for each that arrived": float(
            sum(sum(r[way]["energy"]) for r in routes) / max(1, ends.count("arrived"))
        ),
        "mean slip": float(np.mean([s for r in routes for s in r[way]["slip"]])),
        "driven over planned energy: median, 5, 95 %": [
            float(np.median(ratio)), *np.percentile(ratio, [5, 95]).tolist(),
        ],
        "within 15 % of planned": float(np.mean(np.abs(ratio - 1.0) <= 0.15)),
    }  # fmt: skip


def draw(found: dict[str, Any]) -> None:
    """Savings in the simulator, how drives ended, and one terrain."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.0, 7.8), dpi=95)
    ((one, two), (three, four)) = figure.subplots(2, 2)
    rows = found["terrains"]
    for axes, key, aim in ((one, "energy", 15.0), (two, "slip", 30.0)):
        got = 100.0 * np.array(savings(rows, "simulator")[key])
        axes.hist(got, bins=20, color="#0072B2", alpha=0.8)
        axes.axvline(np.median(got), color="black", lw=1.5, label=f"median {np.median(got):.1f} %")
        axes.axvline(aim, color="#D55E00", lw=1.5, ls="--", label=f"expected {aim:.0f} %")
        axes.set(xlabel=f"less {key} than on the shortest route [%]", ylabel="terrains")
        axes.set_title("where both arrived", fontsize=10)
        axes.legend(frameon=False)
        axes.grid(alpha=0.3)
    names, left = [], np.zeros(4)
    parts: dict[str, list[int]] = {"arrived": [], "stuck": [], "collided": []}
    for way in ("simulator", "patches"):
        for kind, name in zip(KINDS, ("shortest", "least energy"), strict=True):
            names.append(f"{name},\n{way}")
            for end, counts in parts.items():
                counts.append(found[way][kind]["ends"].get(end, 0))
    for (end, counts), colour in zip(parts.items(), ("#0072B2", "#E69F00", "#D55E00"), strict=True):
        three.barh(names, counts, left=left, color=colour, label=end)
        left = left + counts
    three.invert_yaxis()
    three.set(xlabel="drives")
    three.legend(frameon=False, ncols=3, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    shown = sorted(
        rows, key=lambda r: r["energy"]["planned energy"] / r["distance"]["planned energy"]
    )
    row = shown[len(shown) // 4]
    slope = np.degrees(task_of(row["seed"]).ground.hazards.layers["slope"].values)
    image = four.imshow(slope, origin="lower", extent=(0, SIDE, 0, SIDE), cmap="Greys", vmax=20.0)
    figure.colorbar(image, ax=four, label="slope over the rover's footing [deg]")
    for kind, colour, name in zip(
        KINDS, ("#D55E00", "#0072B2"), ("shortest", "least energy"), strict=True
    ):
        four.plot(*np.array(row[kind]["points"]).T, color=colour, lw=2.0, label=name)
    four.legend(fontsize=9, loc="upper right")
    four.set(xlabel="east [m]", ylabel="north [m]")
    figure.tight_layout()
    figure.savefig(IMAGES / "least-energy.png")


if __name__ == "__main__":
    main()
