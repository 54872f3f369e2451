"""How the paper's controller fares on real ground: random pairs of points in the Mars Yard.

    ROVERNAV_DATA=FOLDER python benchmarks/experiments/mars_yard.py

Draws pairs of places where the paper's point rover can stand, at least 5 m apart, with a way
between them (free cells over shared edges). Half of them have ground in their straight line on
which the rover cannot stand; the other half, a control, have none. Seed 0. The border of the
model, triangulated skirts outside the yard, is left out.
"""

from __future__ import annotations

import collections
import math
import os
import sys
from pathlib import Path

import numpy as np
from scipy import ndimage

from rovernav.control import NeuralController
from rovernav.learn import trained_paper_network
from rovernav.rover import read_rover, standing
from rovernav.scenes import ground_scene
from rovernav.sim import simulate
from rovernav.terrain import read_terrain

YARD = Path("dem/earth_marsyard2021_9cm/marsyard_terrain_hm.tif")
INNER = (3.0, 8.5, 44.0, 44.0)
"""The part of the model that is yard: x0, y0, x1, y1, local [m]."""
PAIRS, APART = 200, 5.0


def main() -> None:
    """Measure and print."""
    named = os.environ.get("ROVERNAV_DATA")
    if not named:
        sys.exit("set ROVERNAV_DATA to the folder of the development data")
    terrain = read_terrain(Path(named) / YARD)
    rover = read_rover("paper-point")
    region, _ = ndimage.label(standing(terrain, rover).blocked == 0)
    controller = NeuralController(trained_paper_network())
    rng = np.random.default_rng(0)
    ends: dict[bool, collections.Counter[str]] = {
        False: collections.Counter(),
        True: collections.Counter(),
    }
    ratio = []
    while any(sum(count.values()) < PAIRS for count in ends.values()):
        a, b = (tuple(rng.uniform(INNER[:2], INNER[2:])) for _ in range(2))
        here, there = (region[terrain.frame.cell_of(*p)] for p in (a, b))
        if math.dist(a, b) < APART or here == 0 or here != there:
            continue
        scene = ground_scene(terrain, rover, a, b).scene
        trace = simulate(scene.drive(controller))
        clear = bool(trace.channels["clear_sight"][0, 0, 0])
        if sum(ends[clear].values()) < PAIRS:
            ends[clear][trace.ended().label] += 1
            if not clear and trace.ended().label == "reached":
                ratio.append(trace.length[0] / math.dist(a, b))
    for clear, count in ends.items():
        words = ", ".join(f"{name} {number}" for name, number in count.most_common())
        print(f"straight line {'clear' if clear else 'blocked'}: {words}")
    if ratio:
        print(f"driven / straight of those that reached past something: {np.median(ratio):.2f}")


if __name__ == "__main__":
    main()
