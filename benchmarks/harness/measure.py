"""Rounds: every peer once in turn, again and again, so that a drift of the machine hits all."""

from __future__ import annotations

import re
import statistics
import time
from dataclasses import dataclass
from typing import NamedTuple

from .machine import busy
from .model import Peer, Workload
from .process import FreshStarts, Sample, Worker

NOISE = 0.1
"""A sample is noisy when other processes used more than this [cores], or took as much from it."""


@dataclass(frozen=True, kw_only=True)
class Plan:
    """How long to measure.

    Attributes:
        words: Only peers with a word in their name that begins so; none means all.
        rounds: Samples of each peer.
        seconds: Length of one sample [s], where the work can be repeated.
        patience: Time to wait for a quiet machine, in all, for each workload [s].
        quick: A shorter workload, for a look at the harness rather than at the figures.
    """

    words: tuple[str, ...] = ()
    rounds: int = 5
    seconds: float = 0.25
    patience: float = 20.0
    quick: bool = False


class Row(NamedTuple):
    """What came out for one peer: samples, or why it was skipped."""

    peer: Peer
    samples: list[Sample]
    skipped: str

    @property
    def times(self) -> list[float]:
        """Seconds per unit of work of each sample, in the order of the rounds."""
        return [seconds(sample) for sample in self.samples]

    @property
    def noisy(self) -> int:
        """Samples during which other processes were busy."""
        return sum(map(is_noisy, self.samples))


def measure(workload: Workload, plan: Plan) -> list[Row]:
    """Measure the peers of a workload that `plan` asks for."""
    size = workload.quick if plan.quick else workload.size
    start = FreshStarts if workload.fresh else Worker
    runs: list[tuple[Peer, Worker | FreshStarts]] = []
    patience = Patience(plan.patience)
    try:
        for peer in wanted(workload, plan.words):
            run = start(workload, peer, size, 0.0 if workload.rate else plan.seconds)
            runs.append((peer, run))
            say(workload, peer, f"skipped: {run.skipped}" if run.skipped else "ready")
        for _ in range(plan.rounds):
            for _peer, run in runs:
                if not run.skipped:
                    patience.wait()
                    run.measure()
    finally:
        for _peer, run in runs:
            run.close()
    return [Row(peer, run.samples, run.skipped) for peer, run in runs]


def wanted(workload: Workload, words: tuple[str, ...]) -> list[Peer]:
    """The peers with a word in their name that begins with one of `words`; no words means all."""
    beginnings = tuple(word.lower() for word in words)
    return [
        peer
        for peer in workload.peers
        if not words or any(w.startswith(beginnings) for w in re.findall(r"\w+", peer.name.lower()))
    ]


def seconds(sample: Sample) -> float:
    """Seconds per unit of work: clock time or, if the sample is noisy, processor time.

    Every peer runs in one thread, so the two are equal while nobody else wants the core.
    """
    taken = min(sample["wall"], sample["cpu"]) if is_noisy(sample) else sample["wall"]
    return taken / sample["units"]


def is_noisy(sample: Sample) -> bool:
    """Whether other processes were busy meanwhile, or the peer had to wait for the core."""
    waited = not sample["fresh"] and sample["wall"] > (1.0 + NOISE) * sample["cpu"]
    return waited or (sample["others"] is not None and sample["others"] > NOISE)


def ratio(one: Row, other: Row) -> float:
    """How many times as long `one` takes: the median of the rounds' own ratios."""
    return statistics.median(a / b for a, b in zip(one.times, other.times, strict=False))


def say(workload: Workload, peer: Peer, text: str) -> None:
    """One line of progress."""
    print(f"{workload.name}: {peer.name}: {text}", flush=True)


class Patience:
    """Waits for a quiet machine, but not for ever."""

    def __init__(self, seconds: float) -> None:
        self.left = seconds

    def wait(self) -> None:
        """Return when the machine has been quiet for a moment, or when the time is up."""
        while self.left > 0:
            before, began = busy(), time.perf_counter()
            time.sleep(0.2)
            took, after = time.perf_counter() - began, busy()
            if before is None or after is None or (after - before) / took < NOISE:
                return
            self.left -= took
