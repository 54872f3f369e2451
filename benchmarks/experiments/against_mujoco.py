"""How a rover stands and drives in MuJoCo, beside how `rover.settle` says it stands.

    MUJOCO_GL=egl python benchmarks/experiments/against_mujoco.py [--quick] [--only pictures]

Four rovers, three kinds of generated ground each, the spacing of posts 0.4 wheel radii. At rest:
300 random poses each, x, y and heading held, wheels without friction, so that shape alone decides.
Then 20 drives over 4 lengths of the rover along seeded arcs, each the first of its seed that
settling calls safe all along (on moderate ground where rough has none): at every moment the
attitude of MuJoCo's rover is compared with settling at MuJoCo's own x, y and heading, and its
place with the commands followed without slip.
Friction of contacts is not soil, so slip is not compared. Writes against_mujoco.json and the
pictures of docs/against-mujoco.md; needs the extra `physics` and, for pictures, EGL or OSMesa.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import math
import time
from pathlib import Path
from typing import Any

import numpy as np

from rovernav.adapters import Physics, Rested
from rovernav.core import Frame
from rovernav.rover import Pose, Rover, Settled, read_rover, settle, surface
from rovernav.terrain import Ground, Recipe, Relief, Terrain

HERE = Path(__file__).resolve().parent
IMAGES = HERE.parent.parent / "docs" / "images"
ROVERS = ("perseverance", "sojourner", "research", "jackal")
GROUNDS = {"gentle": (3.0, None), "moderate": (7.0, 0.03), "rough": (12.0, 0.10)}
"""Root mean square slope over the rover's length [deg], share covered by rocks."""
DRIVEN = ("gentle", "gentle", "moderate", "moderate", "rough")
SPACING, EXTENT, WAY = 0.4, 14.0, 4.0
"""Posts in wheel radii; side of the ground and length of a drive in lengths of the rover."""
ARCS, LOOKS = 8, 64
FASTEST = 0.2
PARTS = ("z", "pitch", "roll", "tilt", "rocker", "bogie_left", "bogie_right")
COLOURS = {"perseverance": "#0072B2", "sojourner": "#E69F00", "research": "#009E73",
           "jackal": "#CC79A7"}  # fmt: skip


def main() -> None:
    """Measure, print, draw, keep."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--quick", action="store_true", help="20 poses, 4 drives, no files")
    parser.add_argument("--only", choices=["pictures"], help="draw from the numbers kept")
    asked = parser.parse_args()
    kept = HERE / "against_mujoco.json"
    if asked.only is None:
        clock = time.process_time()
        count = 20 if asked.quick else 300
        found = {"rest": at_rest(count), "why": why(count)}
        found |= {"drives": driven(1 if asked.quick else len(DRIVEN))}
        found["processor_seconds"] = round(time.process_time() - clock)
        print(json.dumps(found["processor_seconds"]), "s of processor time")
        if asked.quick:
            return
        kept.write_text(json.dumps(short(found)) + "\n", encoding="utf-8")
    draw(json.loads(kept.read_text(encoding="utf-8")))
    rendered()


def rover_of(name: str) -> Rover:
    """A preset. The rigid one gets the heavier rear that settling takes it to have."""
    rover = read_rover(name)
    if name != "jackal":
        return rover
    assert rover.chassis is not None
    return dataclasses.replace(rover, chassis=dataclasses.replace(rover.chassis, mass_x=-0.02))


def ground_of(rover: Rover, kind: str, seed: int) -> Terrain:
    """Generated ground to the rover's measure; rocks up to three wheel radii across."""
    slope, rocks = GROUNDS[kind]
    cell = SPACING * rover.wheel_radius
    side = round(EXTENT * rover.length / cell) * cell
    relief = Relief(hurst=0.8, slope=math.radians(slope), baseline=rover.length)
    sizes = (0.8 * rover.wheel_radius, 3.0 * rover.wheel_radius)
    recipe = Recipe(size=(side, side), cell=cell, relief=relief, rocks=rocks, rock_sizes=sizes)
    return Ground.made(recipe, seed).read()


def at_rest(count: int) -> list[dict[str, Any]]:
    """Differences at rest, by rover and ground: of poses called safe, and of all."""
    rows: list[dict[str, Any]] = []
    for number, name in enumerate(ROVERS):
        rover = rover_of(name)
        for kind in GROUNDS:
            terrain = ground_of(rover, kind, 100 + number)
            poses = random_poses(terrain, rover, count, 7 + number)
            theirs, ours = (
                Physics(terrain, rover).rest(poses),
                settle(surface(terrain, rover), poses),
            )
            wheels = 4 if rover.chassis is None else rover.chassis.wheels
            row = {
                "rover": name, "ground": kind, "poses": count,
                "safe": int((ours.code == Pose.SAFE).sum()), "still": int(theirs.still.sum()),
                "all wheels touch": int((theirs.wheels == wheels).sum()),
                "belly theirs": int(theirs.belly.sum()),
                "belly ours": int((ours.clearance < 0.0).sum()),
                "belly both": int(((ours.clearance < 0.0) & theirs.belly).sum()),
                "radius": rover.wheel_radius,
                "of safe": differences(theirs, ours, (ours.code == Pose.SAFE) & theirs.still),
                "of all": differences(theirs, ours, (ours.code != Pose.NO_DATA) & theirs.still),
            }  # fmt: skip
            rows.append(row)
            print(name, kind, said(row["of safe"]), flush=True)
    return rows


def why(count: int) -> dict[str, Any]:
    """Where the difference comes from: Perseverance on moderate ground, one change at a time."""
    rover, out = rover_of("perseverance"), {}
    terrain = ground_of(rover, "moderate", 100)
    poses = random_poses(terrain, rover, count, 7)
    coarse = settle(surface(terrain, rover), poses)
    safe = coarse.code == Pose.SAFE
    spheres = Physics(terrain, rover).rest(poses)
    cases: dict[str, tuple[Rested, Settled]] = {"as it is": (spheres, coarse)}
    for times in (2, 4, 8):
        dense = settle(surface(denser(terrain, times), rover), poses)
        cases[f"settling on the same facets, posts {times} times as dense"] = (spheres, dense)
    cylinders = Physics(terrain, rover, wheels="cylinder").rest(poses)
    cases["MuJoCo's wheels as cylinders"] = (cylinders, coarse)
    braked = Physics(terrain, rover).rest(poses, hold=False)
    cases["MuJoCo's rover held by friction alone"] = (
        braked,
        settle(surface(terrain, rover), braked.pose),
    )
    for name, (theirs, ours) in cases.items():
        out[name] = differences(theirs, ours, safe & ~theirs.belly & (ours.code != Pose.NO_DATA))
        print(name, said(out[name]), flush=True)
    return out


def driven(each: int) -> list[dict[str, Any]]:
    """Drives: differences along each, by distance."""
    drives: list[dict[str, Any]] = []
    for name in ROVERS:
        rover = rover_of(name)
        steering = "corners" if name in ("perseverance", "sojourner") else "skid"
        for number, kind in enumerate(DRIVEN[:each]):
            terrain = ground_of(rover, kind, 200 + number)
            safe = a_drive(terrain, rover, number)
            if safe is None:
                kind = "moderate"  # gentler ground of the same seed
                terrain = ground_of(rover, kind, 200 + number)
                safe = a_drive(terrain, rover, number)
            assert safe is not None
            start, twists, period = safe
            physics = Physics(terrain, rover, steering=steering)
            stands = physics.drive(start[None], twists[None], period=period)
            theirs = joined(stands)
            ours = settle(surface(terrain, rover), theirs.pose)
            told = followed(start, twists, period)
            open_loop = settle(surface(terrain, rover), told)
            row = {
                "rover": name, "ground": kind, "seed": 200 + number, "steering": steering,
                "length": WAY * rover.length, "radius": rover.wheel_radius,
                "all": differences(theirs, ours, ours.code != Pose.NO_DATA),
                "place": np.hypot(*(theirs.pose - told)[:, :2].T).tolist(),
                "heading": wrapped(theirs.pose[:, 2] - told[:, 2]).tolist(),
                "tilt told": (theirs.tilt - open_loop.tilt).tolist(),
                "lines": {part: (getattr(theirs, part) - getattr(ours, part)).tolist()
                          for part in ("z", "pitch", "roll", "tilt")},
                "tilt": [theirs.tilt.tolist(), ours.tilt.tolist()],
            }  # fmt: skip
            drives.append(row)
            print(name, kind, said(row["all"]), f"off the way {row['place'][-1]:.3f} m", flush=True)
    return drives


def a_drive(terrain: Terrain, rover: Rover, seed: int) -> tuple[Any, Any, float] | None:
    """The first start and arcs of a seed along which every pose settles safely, in 20,000."""
    rng, ready = np.random.default_rng((seed, 11)), surface(terrain, rover)
    speed = min(rover.speed, FASTEST)
    period = WAY * rover.length / speed / LOOKS
    for _ in range(20_000):
        middle = 0.5 * np.array(terrain.frame.extent)
        xy = rng.uniform(-0.2, 0.2, 2) * terrain.frame.extent + middle
        start = np.array([*xy, rng.uniform(-math.pi, math.pi)])
        bend = np.repeat(rng.uniform(-1.0, 1.0, ARCS) / (2.0 * rover.length), LOOKS // ARCS)
        twists = np.column_stack([np.full(LOOKS, speed), speed * bend])
        if settle(ready, followed(start, twists, period)).safe.all():
            return start, twists, period
    return None


def followed(start: Any, twists: Any, period: float) -> Any:
    """Poses (k + 1, 3) of commands followed without slip on the map."""
    poses = [np.asarray(start)]
    for speed, turn in twists:
        x, y, heading = poses[-1]
        half = 0.5 * turn * period
        way = speed * period * (math.sin(half) / half if abs(half) > 1e-12 else 1.0)
        ahead = heading + half
        x, y = x + way * math.cos(ahead), y + way * math.sin(ahead)
        poses.append(np.array([x, y, heading + 2.0 * half]))
    return np.array(poses)


def random_poses(terrain: Terrain, rover: Rover, count: int, seed: int) -> Any:
    """Poses all over the ground but near its edge."""
    rng, edge = np.random.default_rng(seed), rover.radius + 3.0 * terrain.frame.cell
    xy = rng.uniform(edge, np.array(terrain.frame.extent) - edge, (count, 2))
    return np.column_stack([xy, rng.uniform(-math.pi, math.pi, count)])


def denser(terrain: Terrain, times: int) -> Terrain:
    """The same two triangles between any four posts as MuJoCo spans, with more posts on them."""
    cell, (h, w) = terrain.frame.cell / times, terrain.frame.shape
    i, j = np.indices((h * times, w * times))
    v, u = ((k + 0.5) / times - 0.5 for k in (i, j))
    v, u = np.clip(v, 0.0, h - 1.0), np.clip(u, 0.0, w - 1.0)
    row, column = np.minimum(v.astype(int), h - 2), np.minimum(u.astype(int), w - 2)
    v, u, z = v - row, u - column, terrain.height.astype(np.float64)
    a, b = z[row, column], z[row, column + 1]
    c, d = z[row + 1, column], z[row + 1, column + 1]
    east = a + u * (b - a) + v * (d - b)  # the corner triangle to the south-east
    west = a + v * (c - a) + u * (d - c)
    heights = np.where(u >= v, east, west) + terrain.offset
    frame = Frame(cell=cell, shape=heights.shape)
    return Terrain.from_heights(heights, frame, name=terrain.name, source=terrain.source)


def differences(theirs: Rested, ours: Settled, keep: Any) -> dict[str, Any]:
    """Median, 95th percentile and worst of what differs; lengths [mm], angles [deg]."""
    out: dict[str, Any] = {"count": int(keep.sum())}
    for part in PARTS:
        off = getattr(theirs, part)[keep] - getattr(ours, part)[keep]
        off = np.abs(off * 1e3 if part == "z" else np.degrees(off))
        if len(off):
            out[part] = [float(np.median(off)), float(np.percentile(off, 95)), float(off.max())]
    return out


def joined(stands: list[Rested]) -> Rested:
    """The first row of each, one below the other."""
    names = [field.name for field in dataclasses.fields(Rested)]
    return Rested(
        **{name: np.concatenate([getattr(s, name)[:1] for s in stands]) for name in names}
    )


def wrapped(angle: Any) -> Any:
    """The same angle within half a turn [rad]."""
    return np.angle(np.exp(1j * angle))


def short(found: Any) -> Any:
    """The same with seven digits."""
    if isinstance(found, dict):
        return {key: short(item) for key, item in found.items()}
    if isinstance(found, list):
        return [short(item) for item in found]
    return float(f"{found:.7g}") if isinstance(found, float) else found


def said(found: dict[str, Any]) -> str:
    """A line."""
    parts = [f"{p} {'/'.join(f'{v:.2f}' for v in found[p])}" for p in PARTS[:4] if p in found]
    return f"{found['count']:4d}  " + "  ".join(parts)


def draw(found: dict[str, Any]) -> None:
    """Shares of poses over the difference in tilt; a drive; differences along all drives."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.5, 3.9), dpi=130)
    left, middle, right = figure.subplots(1, 3)
    kinds = list(GROUNDS)
    for row in found["rest"]:
        ends = row["of safe"].get("tilt")
        if ends:
            at = kinds.index(row["ground"]) + 0.18 * (ROVERS.index(row["rover"]) - 1.5)
            colour = COLOURS[row["rover"]]
            label = row["rover"] if row["ground"] == "gentle" else None
            left.plot([at, at], [ends[0], ends[2]], color=colour, lw=1.0, alpha=0.5)
            left.plot([at, at], ends[:2], color=colour, lw=4.0, label=label)
    left.set_yscale("log")
    left.set_xticks(range(3), kinds)
    left.set(ylabel="difference of tilt [deg]", title="At rest: median to 95 %, thin to the worst")
    left.legend(frameon=False, fontsize=8, loc="upper left")
    shown = max((d for d in found["drives"] if d["rover"] == "perseverance"),
                key=lambda d: max(d["tilt"][0]))  # fmt: skip
    way = np.linspace(0.0, shown["length"], len(shown["tilt"][0]))
    middle.plot(way, np.degrees(shown["tilt"][0]), color="#D55E00", lw=2.5, label="MuJoCo")
    middle.plot(way, np.degrees(shown["tilt"][1]), color="black", lw=1.0, ls="--", label="settling")
    middle.set(xlabel="driven [m]", ylabel="tilt [deg]",
               title=f"Perseverance, {shown['ground']} ground")  # fmt: skip
    middle.legend(frameon=False, fontsize=8)
    for name in ROVERS:
        lines = [d["lines"]["tilt"] for d in found["drives"] if d["rover"] == name]
        off = np.degrees(np.abs(np.array(lines)))
        way = np.linspace(0.0, WAY, off.shape[1])
        right.plot(way, off.max(axis=0), color=COLOURS[name], lw=1.2, label=name)
    right.set_yscale("log")
    right.set(xlabel="driven [lengths of the rover]", ylabel="difference of tilt [deg]",
              title="Driving: worst of five drives")  # fmt: skip
    for axes in (left, middle, right):
        axes.grid(alpha=0.3)
        axes.title.set_fontsize(10)
    figure.tight_layout()
    figure.savefig(IMAGES / "against-mujoco.png")


def rendered() -> None:
    """Perseverance on rough ground, its joints bent, as MuJoCo shows it."""
    from matplotlib.image import imsave

    rover = rover_of("perseverance")
    terrain = ground_of(rover, "rough", 204)
    poses = random_poses(terrain, rover, 2000, 3)
    stands = settle(surface(terrain, rover), poses)
    bent = np.abs(stands.bogie_left) + np.abs(stands.bogie_right) + np.abs(stands.rocker)
    most = int(np.argmax(np.where(stands.safe, bent, -1.0)))
    physics = Physics(terrain, rover)
    shown = physics.rest(poses[most : most + 1])
    aim = math.degrees(poses[most, 2]) + 120.0
    imsave(IMAGES / "mujoco-rover.png", physics.picture(shown, view=(1.7, aim, -16.0)))


if __name__ == "__main__":
    main()
