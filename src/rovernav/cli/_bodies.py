"""What a drive did to the rover's body, in numbers and in words."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from ._console import say

if TYPE_CHECKING:
    from ..sim import Trace


def body_report(trace: Trace, k: int = 0) -> dict[str, float]:
    """What a drive of rover k did to its body; nothing for a point."""
    if trace.attitude is None or trace.slip is None or trace.energy is None:
        return {}
    from ..sim import tilt

    last = min(int(trace.steps[k]), len(trace.energy) - 1)
    slip = trace.slip[1 : last + 1, k, 0]
    return {
        "energy_kj": float(trace.energy[last, k]) / 1000.0,
        "worst_tilt_deg": math.degrees(float(tilt(trace.attitude[: last + 1, k]).max())),
        "mean_slip": float(slip.mean()) if len(slip) else 0.0,
        "worst_slip": float(slip.max()) if len(slip) else 0.0,
    }


def estimate_report(trace: Trace, k: int = 0) -> dict[str, float]:
    """How far off rover k believed itself at its last reading; nothing where it knew its pose."""
    steps, thought = int(trace.steps[k]), trace.channels.get("estimate")
    if thought is None or not steps:
        return {}
    x, y = map(float, thought[steps - 1, k, :2])
    return {
        "estimate_off_m": math.dist((x, y), trace.pose[steps - 1, k, :2]),
        "estimate_to_goal_m": math.dist((x, y), trace.mission.goal[k]),
    }


def say_body(report: dict[str, Any]) -> None:
    """Energy, tilt and slip in words."""
    on = f" on {report['soil']}" if report.get("soil") else ""
    say(f"Spent {report['energy_kj']:.2f} kJ; tilted at most {report['worst_tilt_deg']:.1f} deg; "
        f"slipped {report['mean_slip']:.1%} on average, at most {report['worst_slip']:.1%}{on}."
    )  # fmt: skip
