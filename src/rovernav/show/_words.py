"""Plain words and colours for what pictures show. Colours: Okabe and Ito, for all eyes."""

from __future__ import annotations

import numpy as np

from ..core import F64, InputError, Outcome
from ..sim import Trace

BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
YELLOW, BLUE, VERMILION, PURPLE = "#F0E442", "#0072B2", "#D55E00", "#CC79A7"
PALETTE = {
    "blue": BLUE,
    "orange": ORANGE,
    "green": GREEN,
    "vermilion": VERMILION,
    "sky": SKY,
    "purple": PURPLE,
    "yellow": YELLOW,
}
"""The colours by name, in the order in which lines beside each other take them."""
OBSTACLE_FILL, OBSTACLE_EDGE = "#BBBBBB", "#444444"
PATH, BELIEF = BLUE, ORANGE

_ENDS = {
    Outcome.DRIVING: "still driving",
    Outcome.REACHED: "reached the goal",
    Outcome.COLLIDED: "collided",
    Outcome.TIPPED: "tipped over",
    Outcome.HIGH_CENTRED: "hung up on its belly",
    Outcome.STUCK: "got stuck",
    Outcome.LEFT_MAP: "left the map",
    Outcome.TIMED_OUT: "ran out of time",
    Outcome.ASTRAY: "stopped where it took the goal to be",
}


def end_words(outcome: Outcome) -> str:
    """How a drive ended, in plain words."""
    return _ENDS[outcome]


def end_colour(outcome: Outcome) -> str:
    """Green for reached, vermilion for harm, blue for the rest."""
    if outcome == Outcome.REACHED:
        return GREEN
    harm = (Outcome.COLLIDED, Outcome.TIPPED, Outcome.HIGH_CENTRED)
    return VERMILION if outcome in harm else BLUE


def end_marker(outcome: Outcome) -> str:
    """A cross for harm, a disc for reached, a square for the rest."""
    return {GREEN: "o", VERMILION: "X", BLUE: "s"}[end_colour(outcome)]


def path_of(trace: Trace, k: int = 0) -> F64:
    """Points (at most steps + 1, 2) of rover k [m], those that are finite.

    Raises:
        InputError: The trace kept only the ends.
    """
    if len(trace.pose) <= int(np.max(trace.steps, initial=0)):
        raise InputError("this trace kept no path to draw; record='path' or 'all' keeps it")
    driven = trace.path(k)
    return driven[np.isfinite(driven).all(axis=1)]


def amount(count: int, one: str) -> str:
    """``1 step``, ``2 steps``."""
    return f"{count:,} {one}{'' if count == 1 else 's'}"
