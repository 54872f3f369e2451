"""One peer in a process of its own: `python -m harness.worker WORKLOAD PEER SIZE SECONDS`.

It answers in lines of JSON: first how it got ready or why not, then a sample for every line read.
With SECONDS 0 a sample is one repetition, otherwise as many as take about that long.
"""

from __future__ import annotations

import importlib
import json
import os
import resource
import sys
import time
from typing import Any, TextIO

from .machine import busy, load, others
from .model import Skipped, Trial, Workload


def find(name: str) -> Workload:
    """The workload of that name."""
    return importlib.import_module(name).WORKLOAD


def main() -> None:
    """Build the peer, then measure it once for every line of standard input."""
    workload, name, size, seconds = sys.argv[1:]
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # whatever a library prints is no answer
    work = find(workload)
    if work.one_core and hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    try:
        trial = work.peer(name).build(int(size))
        first = trial(1)
        repeats = repetitions(trial, float(seconds))
    except Skipped as why:
        say(answers, skipped=str(why))
    except ModuleNotFoundError as error:
        say(answers, skipped=f"{error.name} is not installed")
    except Exception as error:
        say(answers, skipped=f"failed: {type(error).__name__}: {error}"[:200])
    else:
        say(answers, check=first.check, cpu=time.process_time(), repeats=repeats)
        for _ in sys.stdin:
            say(answers, **sample(trial, repeats))


def repetitions(trial: Trial, seconds: float) -> int:
    """How many repetitions take about `seconds`, once everything is compiled."""
    if not seconds:
        return 1
    repeats, took = 1, trial(1).cpu
    while took < seconds / 8:
        repeats = int(repeats * min(20.0, max(2.0, 0.5 * seconds / max(took, 1e-6))))
        took = trial(repeats).cpu
    return max(1, round(repeats * seconds / took))


def sample(trial: Trial, repeats: int) -> dict[str, Any]:
    """One sample, and how much of the machine others used meanwhile [cores]."""
    busy_before, cpu, wall = busy(), time.process_time(), time.perf_counter()
    result = trial(repeats)
    wall, cpu, busy_after = time.perf_counter() - wall, time.process_time() - cpu, busy()
    foreign = others(busy_before, busy_after, cpu, wall)
    facts = {"others": foreign, "load": load(), "fresh": False, "peak_mb": peak()}
    return {**result._asdict(), **facts}


def peak() -> float:
    """The most memory that this process has held so far [MB]; libraries included."""
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return most / 1e6 if sys.platform == "darwin" else most * 1024 / 1e6


def say(answers: TextIO, **facts: Any) -> None:
    """One line of JSON."""
    print(json.dumps(facts), file=answers, flush=True)


if __name__ == "__main__":
    main()
