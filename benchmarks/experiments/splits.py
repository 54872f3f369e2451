"""One small training split among threads, in three ways, against the same training not split.

    python benchmarks/experiments/splits.py [--quick] [--seeds 20]

Local averaging, lock-free updates (Hogwild: Recht et al. 2011) and node-parallel training of the
paper's 2-3-2 network on its four patterns: time to tolerance. All are C with threads that spin
(benchmarks/c/splits.c), the best that each way can do; the clock runs once all threads have
started. Writes the three figures of docs/when-parallel-training-pays.md and splits.json.
"""

from __future__ import annotations

import argparse
import ctypes
import dataclasses
import json
import os
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))  # the harness

from harness.ccode import c_function, pointer  # noqa: E402

from experiments.splits_figures import Run, draw  # noqa: E402
from rovernav.learn import shipped_patterns  # noqa: E402
from rovernav.nets import Network, default_activations  # noqa: E402

IMAGES = HERE.parent.parent / "docs" / "images"
SERIAL, AVERAGING, HOGWILD, NODES = range(4)
ETA, MOMENTUM, TOLERANCE, EPOCHS = 0.25, 0.5, 0.01, 50_000
EVERY = (1, 4, 16, 64, 256, 1024)
HIDDEN = (3, 30, 100, 300, 1000, 3000)


@dataclasses.dataclass(frozen=True)
class Way:
    """One way to train: its mode, threads, and epochs between two averages."""

    name: str
    mode: int
    threads: int
    every: int = 1


def main() -> None:
    """Measure, print, draw, keep."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--seeds", type=int, default=20, help="initial networks (20)")
    parser.add_argument("--rounds", type=int, default=7, help="times per network (7)")
    parser.add_argument("--quick", action="store_true", help="3 networks, 2 rounds, no files")
    asked = parser.parse_args()
    seeds, rounds = (3, 2) if asked.quick else (asked.seeds, asked.rounds)
    runs = to_tolerance(seeds, rounds)
    sizes = per_update(rounds)
    for name, found in runs.items():
        print(f"{name:32} {sentence(found)}")
    for hidden, times in sizes.items():
        words = ", ".join(f"{n} threads {t * 1e9:,.0f} ns" for n, t in times.items())
        print(f"{hidden:5} hidden units: {words}")
    if not asked.quick:
        keep(runs, sizes)
        draw(runs, sizes, IMAGES)


def ways() -> Iterator[Way]:
    """All that is compared."""
    yield Way("serial", SERIAL, 1)
    for every in EVERY:
        yield Way(f"averaging every {every}", AVERAGING, 2, every)
    for threads in (2, 4):
        yield Way(f"lock-free, {threads} threads", HOGWILD, threads)
    yield Way("node-parallel", NODES, 2)


def to_tolerance(seeds: int, rounds: int) -> dict[str, list[Run]]:
    """For each way the median run of every initial network; the ways take turns."""
    table = shipped_patterns("bassil-v1")
    kept: dict[str, list[Run]] = {way.name: [] for way in ways()}
    for seed in range(seeds):
        start = Network.seeded(
            (2, 3, 2), default_activations((2, 3, 2)), np.random.default_rng(seed)
        ).parameters
        found: dict[str, list[Run]] = {way.name: [] for way in ways()}
        for _ in range(rounds):
            for way in ways():
                found[way.name].append(train(way, start, (table.x, table.y), TOLERANCE, EPOCHS))
        for name, runs in found.items():
            runs.sort(key=lambda run: (not run.solved, run.seconds))
            kept[name].append(runs[len(runs) // 2])
    return kept


def per_update(rounds: int) -> dict[int, dict[int, float]]:
    """Seconds per update of wider and wider hidden layers, by the number of threads."""
    rng = np.random.default_rng(0)
    found: dict[int, dict[int, float]] = {}
    for hidden in HIDDEN:
        x, y = rng.uniform(-1, 1, (64, 16)), rng.uniform(-1, 1, (64, 16))
        start = rng.uniform(-0.1, 0.1, hidden * 17 + 16 * (hidden + 1))
        epochs = max(1, 20_000 // hidden)
        found[hidden] = {}
        for threads in (1, 2):
            way = Way("", NODES if threads > 1 else SERIAL, threads)
            runs = [train(way, start, (x, y), 1e-9, epochs) for _ in range(rounds)]
            found[hidden][threads] = float(np.median([run.seconds / run.updates for run in runs]))
    return found


def train(way: Way, start: Any, table: Any, tolerance: float, epochs: int) -> Run:
    """One training by the C code, of a network with one hidden layer."""
    start, x, y = (np.ascontiguousarray(a, np.float64) for a in (start, *table))
    hidden = (len(start) - y.shape[1]) // (x.shape[1] + 1 + y.shape[1])
    sizes = np.array([x.shape[1], hidden, y.shape[1], len(x)], np.int_)
    end, out = np.empty_like(start), np.empty(3)
    failed = c_function("splits", "-lpthread")(
        *(ctypes.c_long(n) for n in (way.mode, way.threads, way.every)),
        *(pointer(a) for a in (sizes, start, x, y)),
        ctypes.c_long(epochs),
        *(ctypes.c_double(n) for n in (ETA, MOMENTUM, tolerance)),
        *(pointer(a) for a in (end, out)),
    )
    if failed:
        sys.exit("splits.c: no memory or no threads")
    return Run(seconds=float(out[0]), updates=int(out[1]), solved=bool(out[2]))


def sentence(runs: Sequence[Run]) -> str:
    """Quartiles of those that met the tolerance, and how many did."""
    solved = [run for run in runs if run.solved]
    if not solved:
        return f"0 of {len(runs)} met the tolerance"
    low, mid, high = np.percentile([run.seconds * 1e3 for run in solved], (25, 50, 75))
    updates = np.median([run.updates for run in solved])
    return (
        f"{mid:9.3f} ms ({low:.3f} to {high:.3f}), {updates:,.0f} updates, "
        f"{len(solved)} of {len(runs)} met the tolerance"
    )


def keep(runs: dict[str, list[Run]], sizes: dict[int, dict[int, float]]) -> None:
    """Write every figure to splits.json."""
    whole = {
        "threads_of_the_machine": os.cpu_count(),
        "runs": {name: [dataclasses.asdict(run) for run in found] for name, found in runs.items()},
        "seconds_per_update": sizes,
    }
    (HERE / "splits.json").write_text(json.dumps(whole, indent=1) + "\n")


if __name__ == "__main__":
    main()
