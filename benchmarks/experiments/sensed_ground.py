"""What a rover sees of the ground and makes of it: two pictures, and drives by what was sensed.

    python benchmarks/experiments/sensed_ground.py pictures    # patch.png and hazard-map.png
    python benchmarks/experiments/sensed_ground.py drives [N]  # the table of docs/sensors.md

The second goes on with what build/sensed_ground.jsonl holds: delete it to drive anew.

The drives: N worlds of 60 x 60 m (hills, 30 craters, rocks over 2 %), a research rover with a body
that settles, 57 m from corner to corner, by the neural driver and by the planner that taught it.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

from rovernav.core import Frame, Mission, RoverState, build
from rovernav.learn import find_controller, guarded, routed
from rovernav.mapping import view
from rovernav.rover import Reason, Standing, read_rover, standing
from rovernav.scenes import Ground as Set
from rovernav.scenes import Scenario, generate, nearest_free, set_scene, strewn
from rovernav.sim import Ground, Patch, Worlds, begin, simulate, tick
from rovernav.terrain import Terrain

IMAGES = Path(__file__).resolve().parents[2] / "docs" / "images"
ROVER = read_rover("research")
WAYS: tuple[tuple[str, dict[str, Any]], ...] = (
    ("an ideal fan, route planned on the truth", {"route": "plan"}),
    ("an ideal fan", {}),
    ("a lidar", {"sensing": "lidar"}),
    ("a row of sonars", {"sensing": "sonar"}),
    ("a pair of eyes", {"sensing": "stereo"}),
    ("eyes and infra-red for holes", {"sensing": "stereo+holes"}),
    ("a lidar, drift", {"sensing": "lidar", "drift": True}),
    ("a pair of eyes, drift", {"sensing": "stereo", "drift": True}),
)
RESULTS = Path(__file__).resolve().parents[1] / "build" / "sensed_ground.jsonl"
"""Every drive, a line each."""


def world(seed: int) -> tuple[dict[str, Any], Terrain, Standing]:
    """The settings of a drive, its ground, and where the rover can stand there."""
    settings = {
        "generate": {
            "name": "hills", "side_m": 60.0, "cell_m": 0.15, "relief_m": 4.0, "craters": 30,
        },
        "rocks": 0.02, "seed": seed, "rover": "research", "body": True,
        "from": [8, 8], "to": [50, 48],
    }  # fmt: skip
    asked = build(Scenario, settings, source="this experiment")
    assert asked.generate is not None
    ground = strewn(generate(asked.generate, seed=seed), 0.02, seed=seed)
    where = standing(ground, ROVER)
    ends = {"from": [*nearest_free(where, (8, 8))], "to": [*nearest_free(where, (50, 48))]}
    return {**settings, **ends}, ground, where


def set_up(settings: dict[str, Any], driver: str) -> tuple[Set, Any]:
    """The scene, and who drives it."""
    asked = build(Scenario, {**settings, "controller": driver}, source="this experiment")
    scene = set_scene(asked)
    assert isinstance(scene, Set)
    found = find_controller(driver)
    led = found if asked.route is None else routed(found, scene, asked.route)
    return scene, guarded(led, scene)


def drives(count: int) -> None:
    """Drive the worlds that RESULTS does not hold yet, and print the table."""
    done = {(row["seed"], row["way"], row["driver"]) for row in kept()}
    for seed in range(count):
        settings, _, _ = world(seed)
        for name, way in WAYS:
            for driver in ("planner", "neural"):
                if (seed, name, driver) not in done:
                    keep(one(settings, name, way, driver))
    table()


def one(settings: dict[str, Any], name: str, way: dict[str, Any], driver: str) -> dict[str, Any]:
    """One drive in numbers."""
    scene, who = set_up({**settings, **way}, driver)
    trace = simulate(scene.scene.drive(who), seed=settings["seed"], record="path")
    assert trace.energy is not None
    return {
        "seed": settings["seed"], "way": name, "driver": driver, "end": trace.ended().label,
        "far_m": round(float(np.hypot(*(trace.path()[-1] - settings["to"]))), 3),
        "length_m": round(float(trace.length[0]), 3),
        "energy_kj": round(float(trace.energy[int(trace.steps[0]), 0]) / 1000.0, 4),
    }  # fmt: skip


def kept() -> list[dict[str, Any]]:
    """The drives that were driven already."""
    return (
        [json.loads(line) for line in RESULTS.read_text().splitlines()] if RESULTS.exists() else []
    )


def keep(row: dict[str, Any]) -> None:
    """Add a drive to the file."""
    print(*row.values(), flush=True)
    RESULTS.parent.mkdir(exist_ok=True)
    with RESULTS.open("a") as file:
        file.write(json.dumps(row) + "\n")


def table() -> None:
    """Print what the file holds with 95 % intervals: Wilson's for shares, a bootstrap for means."""
    print("\n| sees with | driver | reached | ended badly | late | astray | off by | energy |")
    print("|---|---|---|---|---|---|---|---|")
    rows = kept()
    for name, _ in WAYS:
        for driver in ("planner", "neural"):
            some = [row for row in rows if (row["way"], row["driver"]) == (name, driver)]
            if some:
                print(f"| {name} | {driver} | {' | '.join(figures(some))} |")


def figures(some: list[dict[str, Any]]) -> list[str]:
    """The columns of a row: which ends, how far off, and the energy of those that arrived."""
    ends = [row["end"] for row in some]
    n, calm = len(ends), ("reached", "astray", "timed_out")
    reached, bad = ends.count("reached"), sum(end not in calm for end in ends)
    low, high = wilson(reached, n)
    far = interval([row["far_m"] for row in some if row["end"] == "astray"])
    spent = interval([row["energy_kj"] for row in some if row["end"] == "reached"])
    return [
        f"{reached} of {n} ({low:.0%} to {high:.0%})",
        f"{bad} ({' to '.join(f'{share:.0%}' for share in wilson(bad, n))})",
        str(ends.count("timed_out")), str(ends.count("astray")), f"{far} m" if far else "",
        f"{spent} kJ" if spent else "",
    ]  # fmt: skip


def wilson(count: int, n: int) -> tuple[float, float]:
    """The 95 % interval of a share, by Wilson."""
    z2, p = 1.96**2, count / n
    middle, half = p + z2 / (2 * n), 1.96 * np.sqrt(p * (1 - p) / n + z2 / (4 * n * n))
    return float((middle - half) / (1 + z2 / n)), float((middle + half) / (1 + z2 / n))


def interval(numbers: list[float]) -> str:
    """The mean and its 95 % interval from 4,000 draws with replacement; none of fewer than two."""
    if len(numbers) < 2:
        return ""
    rng, all_ = np.random.default_rng(1), np.array(numbers)
    means = all_[rng.integers(len(all_), size=(4000, len(all_)))].mean(axis=1)
    low, high = np.quantile(means, (0.025, 0.975))
    return f"{all_.mean():.1f} [{low:.1f}, {high:.1f}]"


def pictures(wanted: list[str]) -> None:
    """Draw both, or one of `patch` and `hazards`."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    if "patch" in wanted or not wanted:
        shape: dict[str, Any] = {"figsize": (10, 4.2), "width_ratios": (1, 1.25)}
        figure, axes = plt.subplots(1, 2, **shape, layout="constrained")
        draw_patch(figure, axes)
        save(figure, "patch.png")
    if "hazards" in wanted or not wanted:
        figure, axes = plt.subplots(1, 3, figsize=(11, 4.1), layout="constrained")
        draw_hazards(figure, axes)
        save(figure, "hazard-map.png")


def save(figure: Any, name: str) -> None:
    """As a picture of 256 colours."""
    from PIL import Image

    figure.savefig(IMAGES / name, dpi=110)
    Image.open(IMAGES / name).convert("RGB").quantize(256).save(IMAGES / name, optimize=True)


def draw_patch(figure: Any, axes: Any) -> None:
    """A patch over a ridge from above, and the line of sight from the side."""
    cell, x = 0.1, (np.arange(120) + 0.5) * 0.1
    ridge = 0.4 * np.exp(-(((x - 6.0) / 0.45) ** 2))
    height = np.tile(ridge, (120, 1)).astype(np.float32)
    worlds = Worlds.single(ground=Ground(frame=Frame(cell=cell, shape=(120, 120)), height=height))
    sensor = Patch(far=8.0, cell=0.1, mast=1.2)
    start = np.array([[2.5, 6.0, 0.0]])
    mission = Mission(start=start, goal=start[:, :2], goal_radius=0.0, time_limit=1.0)
    memory = sensor.start(mission, np.random.default_rng(0))
    seen = sensor.read(worlds, RoverState.at_start(mission), memory)[0][0]
    left, right = axes
    drawn = left.scatter(*(sensor.places + start[0, :2]).T, c=seen, s=3, marker="s", cmap="cividis",
                         plotnonfinite=False, vmin=-0.1, vmax=0.5)  # fmt: skip
    left.plot(*start[0, :2], "o", color="tab:red")
    left.annotate("rover", start[0, :2], (1.0, 6.6), color="tab:red")
    left.set(xlabel="x [m]", ylabel="y [m]", title="seen from above: white is unknown",
             aspect="equal", xlim=(0, 11), ylim=(0, 12))  # fmt: skip
    figure.colorbar(drawn, ax=left, label="height read [m]", shrink=0.8)
    row = np.abs(sensor.places[:, 1]) < 0.05
    at, z = sensor.places[row, 0] + 2.5, seen[row]
    right.fill_between(x, ridge, -0.2, color="0.85", label="ground")
    right.plot(at[np.isfinite(z)], z[np.isfinite(z)], ".", color="tab:blue", label="read")
    again = at[np.isfinite(z) & (at > 6.5)].min(initial=11.0)
    hidden = at[np.isnan(z) & (at > 6.0) & (at < again)]
    if len(hidden):
        right.axvspan(
            hidden.min(), hidden.max(), color="tab:orange", alpha=0.25, lw=0, label="hidden"
        )
    near = np.flatnonzero((x > 4.0) & (x < 7.0))
    top = int(near[np.argmax((ridge - 1.2)[near] / (x - 2.5)[near])])
    slope = (ridge[top] - 1.2) / (x[top] - 2.5)
    right.plot(
        [2.5, 11.0], [1.2, 1.2 + slope * 8.5], "--", lw=1, color="tab:red", label="line of sight"
    )
    right.plot(2.5, 1.2, "o", color="tab:red")
    right.set(xlabel="x [m]", ylabel="height [m]", ylim=(-0.2, 1.4), xlim=(2, 11),
              title="the same along the middle")  # fmt: skip
    right.legend(loc="upper right", fontsize=8)


def draw_hazards(figure: Any, axes: Any) -> None:
    """The map of heights after a drive, what was judged from it, and the truth."""
    from matplotlib.colors import BoundaryNorm, ListedColormap

    settings, ground, where = world(1)
    scene, who = set_up({**settings, "sensing": "stereo"}, "planner")
    drive = scene.scene.drive(who)
    state, path = begin(drive, np.random.default_rng(1)), []
    while state.rovers.driving.any() and len(path) < 90:
        path.append(state.rovers.pose[0].copy())
        state = tick(drive, state)
    local = view(state.mapper)
    (x0, y0), (w, h) = local.frame.origin, local.frame.extent
    extent = (x0, x0 + w, y0, y0 + h)
    x, y = (low + (np.arange(128) + 0.5) * wide / 128 for low, wide in ((x0, w), (y0, h)))
    cells = [ground.frame.cell_of(*np.clip((a, b), 0, 59.9)) for b in y for a in x]
    truth = np.array([where.reason[at] for at in cells]).reshape(128, 128)
    colours = ListedColormap(["#f5f1e6", "#b8c4ce", "#c23b22", "#7a1fa2", "#f2b880"])
    norm = BoundaryNorm(np.arange(-0.5, 5.5), 5)
    drawn = axes[0].imshow(local.height, origin="lower", extent=extent, cmap="cividis")
    figure.colorbar(drawn, ax=axes[0], label="height [m]", shrink=0.7)
    axes[1].imshow(local.reason, origin="lower", extent=extent, cmap=colours, norm=norm)
    last = axes[2].imshow(truth, origin="lower", extent=extent, cmap=colours, norm=norm)
    bar = figure.colorbar(last, ax=axes[2], ticks=range(5), shrink=0.7)
    bar.ax.set_yticklabels([Reason(n).name.lower().replace("_", " ") for n in range(5)])
    titles = ("heights the rover knows", "judged from them", "judged from the whole terrain")
    for axis, title in zip(axes, titles, strict=True):
        axis.plot(*np.array(path)[:, :2].T, color="tab:blue", lw=1.5)
        axis.plot(*path[-1][:2], "o", color="tab:blue")
        axis.set(title=title, xlabel="x [m]", xlim=extent[:2], ylim=extent[2:])
    axes[0].set_ylabel("y [m]")


if __name__ == "__main__":
    if sys.argv[1:2] == ["pictures"]:
        pictures(sys.argv[2:])
    else:
        drives(int(sys.argv[2]) if len(sys.argv) > 2 else 24)
