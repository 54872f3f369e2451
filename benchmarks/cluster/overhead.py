"""What the Dask path costs beside worker processes, for items of about a second.

    python benchmarks/cluster/overhead.py                two workers, 24 items of 1 s, 5 rounds
    python benchmarks/cluster/overhead.py --seconds 0.1  shorter items

An item is real work: online training of the 2-3-2 network for a fixed number of updates. Both
ways run the same items with the same number of workers, in turn. A map over processes starts them
each time, a cluster runs already; so the clock starts when the first item does. Each item takes
its own time too, so that the overhead is also seen on a busy machine: the time of all workers over
the time within items. Target: Dask takes at most 1.15 times as long as processes for items of 1 s
and more.
"""

from __future__ import annotations

import argparse
import json
import platform
import statistics
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

from rovernav.adapters import open_executor
from rovernav.core import Executor, Processes
from rovernav.learn import OnlineSettings, paper_training, train

TARGET = 1.15


class Took(NamedTuple):
    """Seconds from the first item's beginning to the end, and the sum of those within items."""

    clock: float
    within: float


def work(_shared: Any, epochs: int) -> tuple[int, float, float]:
    """Train the paper's network for so many epochs of four patterns; no tolerance ends it.

    Returns:
        Updates done, when it began and when it ended [s].
    """
    began = time.time()  # the same clock in all processes
    network, patterns, _ = paper_training()
    settings = OnlineSettings(momentum=0.9, tolerance=0.0, epochs=epochs)
    updates = train(network, patterns, settings).updates
    return updates, began, time.time()


def timed(executor: Executor, items: list[int]) -> Took:
    """Do all items."""
    done = list(executor.map(work, items))
    ended = time.time()
    if [updates for updates, _, _ in done] != [4 * epochs for epochs in items]:
        sys.exit("overhead.py: an item did not do its work")
    first = min(began for _, began, _ in done)
    return Took(ended - first, sum(end - began for _, began, end in done))


def epochs_for(seconds: float) -> int:
    """Epochs that take so long on an idle core of this machine."""
    work(None, 2_000_000)  # compiles what long trainings use
    probe = 2_000_000
    best = min(_clock(lambda: work(None, probe)) for _ in range(3))
    return max(1, round(probe * seconds / best))


def _clock(what: Callable[[], object]) -> float:
    began = time.perf_counter()
    what()
    return time.perf_counter() - began


def rounds(arguments: argparse.Namespace, epochs: int) -> Iterator[dict[str, float]]:
    """Seconds of both ways, round by round."""
    items, processes = [epochs] * arguments.items, Processes(arguments.workers)
    workers = arguments.workers
    with open_executor("local", workers=workers) as dask:
        timed(dask, [2_000_000] * 2 * workers)  # loads or compiles on each worker
        for _ in range(arguments.rounds):
            one, other = timed(processes, items), timed(dask, items)
            yield {
                "processes": one.clock,
                "dask": other.clock,
                "processes_over_items": workers * one.clock / one.within,
                "dask_over_items": workers * other.clock / other.within,
                "dask_item_of_no_work": timed(dask, [1] * 200).clock / 200,
            }


def main() -> None:
    """Measure and print."""
    reader = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    reader.add_argument("--workers", type=int, default=2)
    reader.add_argument("--items", type=int, default=24)
    reader.add_argument("--seconds", type=float, default=1.0, help="of an item")
    reader.add_argument("--rounds", type=int, default=5)
    reader.add_argument("--json", type=Path, help="file for the samples")
    arguments = reader.parse_args()
    epochs = epochs_for(arguments.seconds)
    samples: list[dict[str, float]] = []
    print(f"{arguments.items} items of about {arguments.seconds:g} s ({4 * epochs:,} updates), "
          f"{arguments.workers} workers, {platform.machine()}")  # fmt: skip
    print("processes [s]   Dask [s]   time of workers / within items: both")
    for one in rounds(arguments, epochs):
        samples.append(one)
        over = f"{one['processes_over_items']:.3f}, {one['dask_over_items']:.3f}"
        print(f"{one['processes']:13.2f}   {one['dask']:8.2f}   {over}")
    ratio = statistics.median(one["dask"] / one["processes"] for one in samples)
    over = statistics.median(one["dask_over_items"] for one in samples)
    idle = statistics.median(one["dask_item_of_no_work"] for one in samples)
    verdict = "met" if ratio <= TARGET else "MISSED"
    print(f"Dask / processes, median: {ratio:.3f}; target at most {TARGET} for items of 1 s: "
          f"{verdict}")  # fmt: skip
    print(f"time of Dask's workers / within items, median: {over:.3f}")
    print(f"an item of no work, many sharing a task: {1e3 * idle:.2f} ms with Dask")
    if arguments.json:
        record = {**vars(arguments), "json": None, "epochs": epochs, "samples": samples}
        arguments.json.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
