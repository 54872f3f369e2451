"""Tables, as plain text for the terminal and as Markdown for the repository."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from typing import Any, NamedTuple

from .measure import Row, ratio
from .model import Target, Workload

Table = list[list[str]]


class Judged(NamedTuple):
    """A target and how it went.

    Attributes:
        text: The line and the figure, in one sentence.
        passed: Whether it was met; None if a row it needs was not measured.
    """

    text: str
    passed: bool | None


def table(workload: Workload, rows: Sequence[Row], size: int) -> Table:
    """Head and rows of a workload's table."""
    anchors = [row for row in rows if row.peer.name in workload.anchors and row.samples]
    short = [f"{workload.anchors[row.peer.name]} / peer" for row in anchors]
    memory = ["peak MB"] if workload.memory else []
    out = [["peer", workload.unit, "min to max", "noisy", *memory, *short, workload.check, "note"]]
    for row in rows:
        if row.skipped:
            out.append(
                [row.peer.name, *[""] * (len(short) + len(memory) + 4), f"skipped: {row.skipped}"]
            )
            continue
        values = sorted(workload.figure(taken) for taken in row.times)
        check = row.samples[-1]["check"]
        out.append(
            [
                row.peer.name,
                number(statistics.median(values)),
                f"{number(values[0])} to {number(values[-1])}",
                f"{row.noisy}/{len(row.samples)}",
                *(f"{max(s['peak_mb'] for s in row.samples):,.0f}" for _ in memory),
                *(f"{compared(workload, anchor, row):.3f}" for anchor in anchors),
                f"{check:.9g}",
                "; ".join(filter(None, (objection(workload, row, size), noted(row)))),
            ]
        )
    return out


def compared(workload: Workload, anchor: Row, row: Row) -> float:
    """Figure of the anchor over figure of the row."""
    times = ratio(anchor, row)
    return 1.0 / times if workload.rate else times


def objection(workload: Workload, row: Row, size: int) -> str:
    """A warning if the peer did other work than it should have."""
    expected = workload.expected(row.peer.group, size)
    check = row.samples[-1]["check"]
    if expected is None or math.isclose(
        check, expected, rel_tol=workload.tolerance, abs_tol=0.0 if expected else workload.tolerance
    ):
        return ""
    return f"another result: expected {expected:.9g}"


def noted(row: Row) -> str:
    """What the last sample has to tell."""
    return str(row.samples[-1].get("note", ""))


def judge(workload: Workload, rows: Sequence[Row]) -> list[Judged]:
    """Every target of the workload against what was measured."""
    found = {row.peer.name: row for row in rows if row.samples}
    return [_judge(workload, target, found) for target in workload.targets]


def _judge(workload: Workload, target: Target, found: dict[str, Row]) -> Judged:
    what, unit = target.row, f" {workload.unit}"
    if target.against:
        what, unit = f"{target.row} / {target.against}", ""
    line = f"{what}: target {'at least' if target.at_least else 'at most'} {target.limit:g}{unit}"
    if target.row not in found or (target.against and target.against not in found):
        return Judged(f"{line}: not measured", None)
    row = found[target.row]
    if target.against:
        value = ratio(row, found[target.against])
    else:
        value = statistics.median(workload.figure(taken) for taken in row.times)
    passed = value >= target.limit if target.at_least else value <= target.limit
    return Judged(f"{line}: {number(value)}: {'pass' if passed else 'MISS'}", passed)


def number(value: float) -> str:
    """Three or four digits that count."""
    return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.4g}"


def as_text(rows: Table) -> str:
    """Columns side by side; all but the first and the last to the right."""
    widths = [max(len(row[c]) for row in rows) for c in range(len(rows[0]))]
    last = len(widths) - 1
    lines = [
        "  ".join(
            cell.ljust(width) if c in (0, last) else cell.rjust(width)
            for c, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    ]
    return "\n".join([lines[0], "  ".join("-" * width for width in widths), *lines[1:]])


def as_markdown(rows: Table) -> str:
    """The same as a Markdown table."""
    head, *body = [f"| {' | '.join(row)} |" for row in rows]
    return "\n".join([head, "|" + " --- |" * len(rows[0]), *body])


def record(workload: Workload, rows: Sequence[Row], size: int, when: str) -> dict[str, Any]:
    """Everything that was measured, for the JSON file."""
    return {
        "title": workload.title,
        "unit": workload.unit,
        "size": size,
        "when": when,
        "load": [min(loads(rows), default=0.0), max(loads(rows), default=0.0)],
        "table": table(workload, rows, size),
        "targets": [judged._asdict() for judged in judge(workload, rows)],
        "rows": [
            {"peer": row.peer.name, "skipped": row.skipped, "samples": row.samples} for row in rows
        ],
    }


def loads(rows: Sequence[Row]) -> list[float]:
    """The machine's load during the samples."""
    return [sample["load"] for row in rows for sample in row.samples]
