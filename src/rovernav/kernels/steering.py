"""Inputs of the neural driver from what was sensed, and motor commands from its outputs.

Symbols: e angle from the rover's heading to the chosen one [rad], v forward speed, w turn rate.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ._jit import kernel

SHARP = 1.0
"""Beyond this angle the rover turns on the spot [rad]."""
AHEAD = 0.3
"""Beams within this angle of straight ahead limit the speed [rad]."""


class Limits(NamedTuple):
    """What the motors may do.

    Attributes:
        speed: Forward speed on free ground [m/s].
        turn_rate: Turn rate [rad/s].
        period: Time between two decisions [s].
        margin: Distance kept from what the beams see ahead [m].
        commitment: How much a heading's logit falls per radian of turning to it.
    """

    speed: float
    turn_rate: float
    period: float
    margin: float
    commitment: float


@kernel()
def encode(around: Any, reach: Any, goal: Any, out: Any) -> None:
    """Free shares (n, rays), heading relative to the goal as cosine and sine, goal distance."""
    rays = around.shape[1]
    for k in range(around.shape[0]):
        for ray in range(rays):
            out[k, ray] = min(around[k, ray] / reach[k, 0], 1.0)
        distance = math.sqrt(goal[k, 0] * goal[k, 0] + goal[k, 1] * goal[k, 1])
        scale = 1.0 / distance if distance > 0.0 else 0.0
        out[k, rays] = goal[k, 0] * scale
        out[k, rays + 1] = -goal[k, 1] * scale
        out[k, rays + 2] = min(distance / reach[k, 0], 1.0)


@kernel()
def decode(logits: Any, goal: Any, beams: Any, limits: Limits, out: Any) -> None:
    """Body twists (n, 3) from the logits of headings (n, h) and the beams (n, b) [m].

    The heading is the strongest one, drawn towards its stronger neighbour by the vertex of the
    parabola through the three logits. The fan must be centred on straight ahead and 180 deg wide.
    """
    for k in range(logits.shape[0]):
        to_goal = math.atan2(goal[k, 1], goal[k, 0])
        e = _wrap(to_goal + _strongest(logits, k, to_goal, limits.commitment))
        w = min(max(e / limits.period, -limits.turn_rate), limits.turn_rate)
        v = 0.0
        if abs(e) < SHARP:
            free = max(0.0, _free_ahead(beams, k) - limits.margin)
            distance = math.sqrt(goal[k, 0] * goal[k, 0] + goal[k, 1] * goal[k, 1])
            v = min(limits.speed * math.cos(e), min(free, distance) / limits.period)
        out[k, 0], out[k, 1], out[k, 2] = v, 0.0, w


@kernel(inline=True)
def _wrap(a: float) -> float:
    return math.atan2(math.sin(a), math.cos(a))


@kernel()
def _strongest(logits: Any, k: int, to_goal: float, commitment: float) -> float:
    """Angle of the strongest heading from the goal's direction, between bins."""
    h = logits.shape[1]
    best, most = 0, -math.inf
    for b in range(h):
        turn = abs(_wrap(to_goal + 2.0 * math.pi * b / h))
        strength = logits[k, b] - commitment * turn
        if strength > most:
            best, most = b, strength
    left, right = logits[k, (best + 1) % h], logits[k, (best - 1) % h]
    bend = 2.0 * logits[k, best] - left - right
    shift = 0.5 * (left - right) / bend if bend > 0.0 else 0.0
    return 2.0 * math.pi * (best + shift) / h


@kernel()
def _free_ahead(beams: Any, k: int) -> float:
    """Shortest beam within AHEAD of straight ahead [m]."""
    count = beams.shape[1]
    free = beams[k, count // 2]
    for b in range(count):
        angle = math.pi * (b / (count - 1) - 0.5)
        if abs(angle) <= AHEAD:
            free = min(free, beams[k, b])
    return free
