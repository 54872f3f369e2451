"""The timeline under the map: what the motors did, how steep it was, how far the goal still is."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape

import numpy as np

from ..core import F64
from ._drive_map import COLOURS, DASHES
from ._drive_run import DriveRun

WIDE, HIGH, AXIS = 1000.0, 236.0, 22.0
LEFT, RIGHT = 172.0, 24.0
MOST = 4
"""Rows at most; fewer are higher."""


class Line:
    """One curve over time.

    Args:
        words: What it is, with its unit.
        colour: Its colour's name.
        time: Times (k,) [s].
        numbers: Values (k,).
        dash: Its dash pattern.
    """

    def __init__(self, words: str, colour: str, time: F64, numbers: F64, dash: str = "") -> None:
        self.words, self.colour, self.dash = words, colour, dash
        self.time, self.numbers = time, numbers


def strip(runs: Sequence[DriveRun], focus: int, length: float) -> str:
    """All rows of the timeline: motors and slope of the drive in focus, way to go of every one."""
    if not runs or not 0 <= focus < len(runs):
        return ""
    rows = [*_of_one(runs[focus]), [_to_goal(run, i) for i, run in enumerate(runs)]][-MOST:]
    high, length = (HIGH - AXIS) / len(rows), max(length, 1e-9)
    parts = [_row(lines, i * high, high, length) for i, lines in enumerate(rows)]
    return "".join(parts) + _axis(length)


def cursor(seconds: float, length: float) -> str:
    """The present moment in the timeline."""
    x = _x(min(seconds, length), max(length, 1e-9))
    return (
        f'<line x1="{x:.1f}" y1="0" x2="{x:.1f}" y2="{HIGH - AXIS}" stroke="var(--rn-ink)" '
        'stroke-width="1.5"/>'
    )


def seconds_at(x: float, length: float) -> float:
    """The time at a place of the timeline."""
    share = (x - LEFT) / (WIDE - LEFT - RIGHT)
    return max(0.0, min(1.0, share)) * length


def _of_one(run: DriveRun) -> list[list[Line]]:
    count = run.steps
    time = np.array(run.times[:count])
    twist = np.array(run.commands[:count]).reshape(-1, 3)
    rows = []
    if run.rover.drive == "two-axis":
        rows.append([Line("along [m/s]", "blue", time, twist[:, 0]),
                     Line("across [m/s]", "orange", time, twist[:, 1], "5 4")])  # fmt: skip
    else:
        rows.append([Line("speed [m/s]", "blue", time, twist[:, 0])])
        rows.append([Line("turn [°/s]", "orange", time, np.degrees(twist[:, 2]))])
    where = run.standing
    if where is not None:
        steps = range(0, count + 1, max(1, count // 400))
        tilts = np.array([math.degrees(run.moment(step).tilt) for step in steps])
        rows.append([Line("tilt [°]", "purple", np.array([run.times[s] for s in steps]), tilts)])
    return rows


def _to_goal(run: DriveRun, number: int) -> Line:
    goal = run.scene.mission.goal[0]
    poses = np.array(run.poses[: run.steps + 1])
    far = np.hypot(poses[:, 0] - goal[0], poses[:, 1] - goal[1])
    colour = COLOURS[number % 8]
    return Line("to goal [m]", colour, np.array(run.times[: len(far)]), far, DASHES[number % 8])


def _x(seconds: float, length: float) -> float:
    return LEFT + (WIDE - LEFT - RIGHT) * seconds / length


def _row(lines: Sequence[Line], top: float, row: float, length: float) -> str:
    known = np.concatenate([line.numbers for line in lines])
    known = known[np.isfinite(known)]
    low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)
    low, high = min(low, 0.0), max(high, 0.0)
    if high - low < 1e-9:
        high = low + 1.0
    span = row - 12
    base = top + 6 + span * high / (high - low)
    parts = [
        f'<rect x="{LEFT}" y="{top + 3:.0f}" width="{WIDE - LEFT - RIGHT}" height="{row - 6:.1f}" '
        'fill="var(--rn-field)" stroke="var(--rn-line)"/>'
        f'<line x1="{LEFT}" y1="{base:.1f}" x2="{WIDE - RIGHT}" y2="{base:.1f}" '
        'stroke="var(--rn-muted)" stroke-width=".7" stroke-dasharray="2 4"/>'
    ]
    names: list[str] = []
    for line in lines:
        y = top + 6 + span * (high - line.numbers) / (high - low)
        points = " ".join(
            f"{_x(t, length):.1f},{v:.1f}" for t, v in _thin(line.time, y) if math.isfinite(v)
        )
        parts.append(
            f'<polyline points="{points}" fill="none" stroke="var(--rn-{line.colour})" '
            f'stroke-width="1.8" stroke-dasharray="{line.dash}" stroke-linejoin="round"/>'
        )
        if line.words not in names:
            at = top + 21 + 19 * len(names)
            names.append(line.words)
            colour = line.colour if len(lines) < 3 and lines[0].words != "to goal [m]" else "ink"
            parts.append(
                f'<text x="4" y="{at:.0f}" font-weight="600" '
                f'style="fill:var(--rn-{colour})">{escape(line.words)}</text>'
            )
    for value, at in ((high, top + 14), (low, top + row - 6)):
        parts.append(
            f'<text x="{LEFT - 5}" y="{at:.0f}" class="rnd-small" text-anchor="end" '
            f'style="fill:var(--rn-muted)">{value:.2g}</text>'
        )
    return "".join(parts)


def _axis(length: float) -> str:
    step = 10.0 ** math.floor(math.log10(length / 3))
    step = next(n * step for n in (5.0, 2.0, 1.0) if n * step <= length / 3)
    return "".join(
        f'<text x="{_x(t, length):.1f}" y="{HIGH - 6}" class="rnd-small" text-anchor="middle" '
        f'style="fill:var(--rn-muted)">{t:g} s</text>'
        for t in np.arange(0, math.floor(length / step) + 1) * step
    )


def _thin(time: F64, y: F64, most: int = 500) -> list[tuple[float, float]]:
    every = max(1, math.ceil(len(time) / most))
    return list(zip(time[::every].tolist(), y[::every].tolist(), strict=True))
