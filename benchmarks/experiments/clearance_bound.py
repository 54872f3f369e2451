"""How often the clearance bound calls a safe pose unsafe, over rock cover and slope.

    python benchmarks/experiments/clearance_bound.py [--picture FILE]

Perseverance on 40 m x 40 m of generated ground with posts every 10 cm: a slope, bumps of several
sizes (rms some 4 cm over the rover's length), Golombek-Rapp rocks of 0.1 m to 3 m. A pose is known
to 0.1 m each way and 0.05 rad. It counts as truly safe when all 64 poses settled within that box,
corners included, keep all limits. Also counted: poses called safe of which one settled unsafe,
which must never happen. Speeds are processor time on one core.
"""

from __future__ import annotations

import argparse
import math
import time
from pathlib import Path

import numpy as np
from scipy import ndimage

from rovernav.core import Frame
from rovernav.rover import bound, read_rover, settle, surface
from rovernav.terrain import Terrain, scatter_rocks, with_rocks

COVERS = (0.0, 0.02, 0.05, 0.07, 0.10, 0.15, 0.20)
SLOPES = (0.0, 5.0, 10.0, 15.0)
CELL, CELLS, POSES, SAMPLES, SEEDS = 0.1, 400, 500, 64, 4
DOUBT = (0.1, 0.05)


def main() -> None:
    """Measure, print, draw."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--picture", type=Path)
    asked = parser.parse_args()
    alarms, safe, wrong = (np.zeros((len(SLOPES), len(COVERS))) for _ in range(3))
    seconds = np.zeros(2)
    print("slope [deg]  cover  truly safe  false alarms  called safe but not")
    for i, slope in enumerate(SLOPES):
        for j, cover in enumerate(COVERS):
            counts = sum(_count(seed, math.radians(slope), cover, seconds) for seed in range(SEEDS))
            safe[i, j], alarms[i, j], wrong[i, j] = counts
            share, total = alarms[i, j] / max(1, safe[i, j]), SEEDS * POSES
            print(
                f"{slope:11.0f}  {cover:5.2f}  {safe[i, j] / total:10.1%}  {share:12.1%}"
                f"  {wrong[i, j]:19.0f}"
            )
    cases = len(SLOPES) * len(COVERS) * SEEDS * POSES
    print(
        f"bound: {cases / seconds[0]:,.0f} poses/s; settle: {cases * SAMPLES / seconds[1]:,.0f}/s"
    )
    if asked.picture:
        _draw(alarms / np.maximum(1, safe), safe / (SEEDS * POSES), asked.picture)


def _count(seed: int, slope: float, cover: float, seconds: np.ndarray) -> np.ndarray:
    """Poses truly safe, those of them called unsafe, and those called safe that are not."""
    rng = np.random.default_rng((seed, round(slope * 1e3), round(cover * 1e3)))
    ready = surface(_ground(rng, slope, cover), read_rover("perseverance"))
    if seconds[0] == 0.0:  # compiled outside of the clock
        bound(ready, [[20.0, 20.0, 0.0]])
        settle(ready, [[20.0, 20.0, 0.0]])
    xy, heading = rng.uniform(4.0, 36.0, (POSES, 2)), rng.uniform(-math.pi, math.pi, POSES)
    poses = np.column_stack([xy, heading])
    clock = time.process_time()
    held = bound(ready, poses, position=DOUBT[0], heading=DOUBT[1]).safe
    seconds[0] += time.process_time() - clock
    off = rng.uniform(-1.0, 1.0, (POSES, SAMPLES, 3))
    off[:, 0], off[:, 1:17] = 0.0, np.sign(off[:, 1:17])
    within = poses[:, None] + off * [DOUBT[0], DOUBT[0], DOUBT[1]]
    clock = time.process_time()
    truly = settle(ready, within.reshape(-1, 3)).safe.reshape(POSES, SAMPLES).all(axis=1)
    seconds[1] += time.process_time() - clock
    return np.array([truly.sum(), (truly & ~held).sum(), (held & ~truly).sum()])


def _ground(rng: np.random.Generator, slope: float, cover: float) -> Terrain:
    i, j = np.indices((CELLS, CELLS))
    way = rng.uniform(-math.pi, math.pi)
    z = (j * math.cos(way) + i * math.sin(way)) * CELL * math.tan(slope)
    for size in (4, 12, 40):
        bumps = ndimage.gaussian_filter(rng.normal(size=z.shape), size)
        z = z + bumps * size * 2.0 * math.sqrt(math.pi) * 0.02
    frame = Frame(cell=CELL, shape=z.shape)
    terrain = Terrain.from_heights(z, frame, name="generated", source="generated")
    if cover == 0.0:
        return terrain
    return with_rocks(terrain, scatter_rocks(frame, cover, smallest=0.1, largest=3.0, rng=rng))


def _draw(alarms: np.ndarray, safe: np.ndarray, path: Path) -> None:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.2, 3.9), dpi=130)
    left, right = figure.subplots(1, 2)
    colours = ("#0072B2", "#009E73", "#E69F00", "#D55E00")
    percent = 100.0 * np.array(COVERS)
    for k, slope in enumerate(SLOPES):
        style = {"color": colours[k], "marker": "o", "markersize": 4, "label": f"{slope:g} deg"}
        left.plot(percent, 100.0 * alarms[k], **style)
        right.plot(percent, 100.0 * safe[k], **style)
    left.axhline(20.0, color="#888888", lw=0.8, ls="--")
    left.text(0.2, 14.6, "aim at 7 % cover,\nup to 10 deg", fontsize=8, color="#555555")
    left.axvline(7.0, color="#888888", lw=0.8, ls="--")
    left.set(ylabel="safe poses called unsafe [%]", ylim=(0.0, None))
    right.set(ylabel="poses that are truly safe [%]", ylim=(0.0, 103.0))
    for axes in (left, right):
        axes.set_xlabel("ground covered by rocks [%]")
        axes.grid(alpha=0.3)
    left.legend(title="slope", frameon=False, loc="upper left")
    figure.suptitle("Perseverance, pose known to 0.1 m and 0.05 rad", fontsize=11)
    figure.tight_layout()
    figure.savefig(path)


if __name__ == "__main__":
    main()
