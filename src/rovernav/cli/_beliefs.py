"""Where a rover by drifting odometry thought it was, beside where it was."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from ._console import say

if TYPE_CHECKING:
    from ..sim import Trace


def belief_report(trace: Trace, k: int = 0) -> dict[str, Any]:
    """What rover k believed when it last looked; null where it knew its true pose."""
    believed = trace.believed(k)
    if believed is None:
        return {"believed_end": None, "believed_off_m": None, "believed_to_goal_m": None}
    last = believed[-1]
    return {
        "believed_end": last,
        "believed_off_m": math.dist(last, trace.pose[len(believed) - 1, k, :2]),
        "believed_to_goal_m": math.dist(last, trace.mission.goal[k]),
    }


def say_belief(report: dict[str, Any]) -> None:
    """How far off the rover was in its own mind, in words."""
    off, left = report["believed_off_m"], report["believed_to_goal_m"]
    if report["outcome"] == "astray":
        say(f"It believed itself at the goal and stopped: its odometry was {off:.2f} m off.")
    else:
        say(f"It believed itself {left:.2f} m from the goal: its odometry was {off:.2f} m off.")
