"""rovernav beside its peers, and beside its targets.

    python benchmarks/run.py --setup                  install the peers in benchmarks/.venv, once
    python benchmarks/run.py                          everything
    python benchmarks/run.py online --peers C FANN    some rows of one workload
    python benchmarks/run.py --quick --rounds 2       a quick look

Every peer runs in its own process; each round goes through all peers in turn.
"""

from __future__ import annotations

import argparse
import datetime
import json
import sys
from pathlib import Path

from harness import machine, report, results, setup
from harness.measure import Plan, measure, wanted
from harness.worker import find

WORKLOADS = (
    *("online", "sweep", "firstcall", "decision", "minibatch", "dataparallel"),
    *("plan", "planmaze", "planstart", "hazards", "simulate", "simground", "onerover"),
)


def main() -> None:
    """Measure what was asked for, print it, keep it."""
    asked = arguments()
    if asked.setup:
        return setup.install()
    setup.use(here=asked.here)
    names = asked.workloads or WORKLOADS
    for word in asked.peers:
        if not any(wanted(find(name), (word,)) for name in names):
            sys.exit(f"run.py: no row of {', '.join(names)} has a word that begins with {word!r}")
    plan = Plan(
        words=tuple(asked.peers),
        rounds=asked.rounds or (2 if asked.quick else 5),
        seconds=0.1 if asked.quick else 0.25,
        patience=0.0 if asked.quick else asked.patience,
        quick=asked.quick,
    )
    whole = {"machine": machine.describe(), "workloads": {}}
    for name in names:
        whole["workloads"][name] = one(name, plan)
    if asked.json:
        asked.json.write_text(json.dumps(whole, indent=1) + "\n")
    if plan.quick or plan.words:
        print("\nbenchmarks/results is left as it was: this was not a whole run")
    else:
        print(f"\nkept in {results.keep(whole)}")


def one(name: str, plan: Plan) -> dict[str, object]:
    """Measure and print one workload."""
    workload = find(name)
    size = workload.quick if plan.quick else workload.size
    rows = measure(workload, plan)
    when = datetime.datetime.now().astimezone().strftime("%Y-%m-%d %H:%M %Z")
    record = report.record(workload, rows, size, when)
    low, high = record["load"]
    if size != workload.size:
        print(f"\nQUICK: size {size:,} instead of {workload.size:,}")
    print(f"\n{workload.title}\n{when}, load of the machine {low:.1f} to {high:.1f}\n")
    print(report.as_text(record["table"]) + "\n")
    for target in record["targets"]:
        print(target["text"])
    print(f"{results.NOISY}\n", flush=True)
    return record


def arguments() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    add = parser.add_argument
    add("workloads", nargs="*", metavar="WORKLOAD", help=f"of {', '.join(WORKLOADS)}; all if none")
    add("--peers", nargs="+", default=[], metavar="WORD", help="only rows with words that begin so")
    add("--rounds", type=int, help="samples of each peer (5, or 2 with --quick)")
    add("--patience", type=float, default=20.0, help="seconds to wait for quiet, per workload")
    add("--quick", action="store_true", help="short samples of short workloads")
    add("--json", type=Path, metavar="FILE", help="write all samples to this file too")
    add("--setup", action="store_true", help="make benchmarks/.venv with all peers, and stop")
    add("--here", action="store_true", help="use this Python even if benchmarks/.venv is there")
    asked = parser.parse_args()
    for name in asked.workloads:
        if name not in WORKLOADS:
            parser.error(f"unknown workload {name!r}; there are {', '.join(WORKLOADS)}")
    return asked


if __name__ == "__main__":
    main()
