"""What is kept: all samples as JSON, and a small Markdown page for people."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from .ccode import HOME
from .report import as_markdown

FOLDER = HOME / "results"
NOISY = (
    "noisy: samples during which other processes used more than a tenth of a core; they count with "
    "their processor time."
)


def keep(record: dict[str, Any]) -> Path:
    """Merge new measurements into the last results, and write the page."""
    FOLDER.mkdir(exist_ok=True)
    kept = FOLDER / "latest.json"
    merged = json.loads(kept.read_text()) if kept.exists() else {"workloads": {}}
    if not same_place(merged.get("machine", {}), record["machine"]):
        merged = {"workloads": {}}  # figures of two machines do not mix
    for work in merged["workloads"].values():
        work.setdefault("machine", merged["machine"])  # measured with the packages of that day
    merged = {**record, "workloads": {**merged["workloads"], **record["workloads"]}}
    kept.write_text(json.dumps(merged, indent=1) + "\n")
    page = FOLDER / "latest.md"
    page.write_text(markdown(merged))
    return page


def same_place(a: dict[str, Any], b: dict[str, Any]) -> bool:
    """Whether two records are of the same machine, whatever packages it had."""
    return all(a.get(name) == b.get(name) for name in ("processor", "cores", "system"))


def markdown(record: dict[str, Any]) -> str:
    """The page."""
    machine = dict(record["machine"])
    head = f"{machine.pop('processor')}, {machine.pop('cores')} cores, {machine.pop('system')}"
    versions = ", ".join(f"{name} {version}" for name, version in machine.items())
    lines = [
        "# Benchmark results",
        "",
        "Written by `python benchmarks/run.py`; do not edit.",
        f"{head}.",
        f"{versions[:1].upper()}{versions[1:]}.",
        "",
        f"{NOISY[:1].upper()}{NOISY[1:]}",
    ]
    for name, work in record["workloads"].items():
        low, high = work["load"]
        lines += ["", f"## {name}", "", work["title"]]
        lines += [f"Measured {work['when']}, load of the machine {low:.1f} to {high:.1f}."]
        lines += [*earlier(work.get("machine", {}), record["machine"]), ""]
        lines += [as_markdown(work["table"]), ""]
        lines += [f"- {target['text']}" for target in work["targets"]]
    return "\n".join(lines) + "\n"


def earlier(then: dict[str, Any], now: dict[str, Any]) -> list[str]:
    """A line on packages that were others when a workload was measured."""
    other = [f"{name} {version}" for name, version in then.items() if now.get(name) != version]
    return [f"With {', '.join(other)}."] if other else []
