"""How the cost of training grows with members, patterns and workers.

    python benchmarks/experiments/scaling.py [--quick]

Sweeps of 10^2 to 10^6 networks 2-3-2 on the paper's four patterns, 100 epochs each, and one epoch
of a 48-64-64-2 network over 10^2 to 10^6 patterns in 8 shards, with 1, 2, 4 and 8 threads. More
threads than the machine has cores are marked: they show what oversubscription costs. Writes
scaling.json and the figure of docs/when-parallel-training-pays.md, and prints the model of a
cluster of 1,000 cores that this page gives.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import statistics
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rovernav.core import Threads, cores
from rovernav.learn import (
    BatchSettings,
    Patterns,
    SweepSettings,
    shipped_patterns,
    sweep,
    train_batches,
)
from rovernav.nets import Network, default_activations

HERE = Path(__file__).resolve().parent
IMAGE = HERE.parent.parent / "docs" / "images" / "scaling.png"
SIZES = (10**2, 10**3, 10**4, 10**5, 10**6)
WORKERS = (1, 2, 4, 8)
EPOCHS = 100
COLOURS = {1: "#555555", 2: "#0072b2", 4: "#009e73", 8: "#d55e00"}

Times = dict[int, dict[int, float]]
"""Seconds, by size and by workers."""
Work = Callable[[int], None]
"""Does the work with so many workers."""


def main() -> None:
    """Measure, print, draw, keep."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--rounds", type=int, default=3, help="the median counts (3)")
    parser.add_argument("--quick", action="store_true", help="small sizes, one round, no files")
    asked = parser.parse_args()
    sizes, rounds = (SIZES[:3], 1) if asked.quick else (SIZES, asked.rounds)
    members = measure(sizes, rounds, sweep_of)
    patterns = measure(sizes, rounds, epoch_of)
    show("networks", members, 4 * EPOCHS)
    show("patterns", patterns, 1)
    model(members, patterns)
    if not asked.quick:
        whole = {"cores": cores(), "seconds_members": members, "seconds_patterns": patterns}
        (HERE / "scaling.json").write_text(json.dumps(whole, indent=1) + "\n")
        draw(members, patterns)


def measure(sizes: tuple[int, ...], rounds: int, prepare: Callable[[int], Work]) -> Times:
    """Median seconds for each size and number of workers, which take turns."""
    found: Times = {}
    for size in sizes:
        work = prepare(size)
        work(2)  # compile, and draw pages of memory
        times: dict[int, list[float]] = {workers: [] for workers in WORKERS}
        for _ in range(rounds):
            for workers in WORKERS:
                times[workers].append(seconds(work, workers))
        found[size] = {workers: statistics.median(several) for workers, several in times.items()}
    return found


def seconds(work: Work, workers: int) -> float:
    """Time of one call; short ones are repeated for a fifth of a second."""
    calls, begun = 0, time.perf_counter()
    while True:
        work(workers)
        calls += 1
        took = time.perf_counter() - begun
        if took > 0.2:
            return took / calls


def sweep_of(members: int) -> Work:
    """A sweep with so many members; every epoch is done."""
    table = shipped_patterns("bassil-v1")
    settings = SweepSettings(
        topology=(2, 3, 2),
        etas=(0.25,),
        momenta=(0.5,),
        seeds=members,
        tolerance=0.0,
        epochs=EPOCHS,
    )

    def work(workers: int) -> None:
        sweep(table, settings, executor=Threads(workers))

    return work


def epoch_of(rows: int) -> Work:
    """One epoch over so many patterns."""
    rng = np.random.default_rng(0)
    table = Patterns(
        x=rng.standard_normal((rows, 48)),
        y=rng.uniform(-0.5, 0.5, (rows, 2)),
        inputs=tuple(f"x{i}" for i in range(48)),
        outputs=("left", "right"),
    )
    topology = (48, 64, 64, 2)
    network = Network.seeded(topology, default_activations(topology, "tanh"), rng, dtype=np.float32)
    settings = BatchSettings(optimizer="sgd", eta=0.05, epochs=1, order="cyclic", shards=8)

    def work(workers: int) -> None:
        train_batches(network, table, settings, workers=workers)

    return work


def show(what: str, times: Times, updates: int) -> None:
    """A Markdown table."""
    print(f"\n| {what} | " + " | ".join(f"{workers} workers [s]" for workers in WORKERS)
          + " | 1 to 2 workers | ns each, 1 worker |")  # fmt: skip
    print("| ---: |" + " ---: |" * (len(WORKERS) + 2))
    for size, row in times.items():
        cells = " | ".join(f"{row[workers]:.3g}" for workers in WORKERS)
        print(
            f"| {size:,} | {cells} | {row[1] / row[2]:.2f}x | {row[1] / size / updates * 1e9:.3g} |"
        )


def model(members: Times, patterns: Times) -> None:
    """What 1,000 cores would give, from one core's figures and stated overheads.

    A task costs the scheduler 1 ms, one after the other; a result of a gradient travels at
    1 GB/s with 0.2 ms latency up and down a binary tree of cores.
    """
    largest = max(members)
    update = members[largest][1] / largest / (4 * EPOCHS)
    for epochs, block in ((1000, 1024), (1000, 65536), (100_000, 1024)):
        task = block * 4 * epochs * update
        share = min(1.0, task / 1e-3 / 1000)
        print(f"sweep, {epochs:,} epochs, {block:,} networks a task ({task:.3g} s): "
              f"{1000 * share:,.0f} of 1,000 cores busy")  # fmt: skip
    pattern = patterns[max(patterns)][1] / max(patterns)
    weights = 49 * 64 + 65 * 64 + 65 * 2
    hop = 0.2e-3 + weights * 4 / 1e9
    for batch in (256, 4096, 65536, 10**6):
        alone = batch * pattern
        best = min((alone / n + 2 * math.ceil(math.log2(n)) * hop, n) for n in (1, 10, 100, 1000))
        print(f"data-parallel, batch {batch:,}: {alone * 1e3:.3g} ms alone, best with {best[1]:,} "
              f"cores: {alone / best[0]:.3g}x")  # fmt: skip


def draw(members: Times, patterns: Times) -> None:
    """Seconds over size, one line per number of workers."""
    figure = Figure(figsize=(9.4, 3.6), dpi=130, facecolor="white")
    left, right = figure.subplots(1, 2)
    panel(left, members, f"networks 2-3-2, {EPOCHS} epochs of 4 patterns each")
    panel(right, patterns, "patterns, one epoch of a 48-64-64-2 network")
    left.set_ylabel("time [s]")
    left.legend(loc="upper left")
    figure.subplots_adjust(left=0.07, right=0.985, bottom=0.15, top=0.96, wspace=0.15)
    figure.savefig(IMAGE)


def panel(axes: Axes, times: Times, label: str) -> None:
    """One set of lines on logarithmic scales."""
    here = os.cpu_count() or 1
    for workers in WORKERS:
        name = f"{workers} thread{'s' * (workers > 1)}" + (
            ", oversubscribed" if workers > here else ""
        )
        values = [row[workers] for row in times.values()]
        axes.plot(list(times), values, "o-" if workers <= here else "o--", ms=4,
                  color=COLOURS[workers], label=name)  # fmt: skip
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel(label)
    axes.grid(color="#dddddd", lw=0.6)


if __name__ == "__main__":
    main()
