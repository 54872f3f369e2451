"""An estimate of the pose in plain Python: complex numbers for places and headings."""

from __future__ import annotations

import cmath
import math
from typing import Any

from tests.naive.noise import deviate


def advanced(  # noqa: PLR0913
    e: list[float], last: Any, pose: Any, slip: Any, key: int, step: int, rise: float, d: dict
) -> list[float]:
    """The estimate after a motion; the ground rose by `rise` [m]."""

    def e_(channel: int, at: int) -> float:
        return deviate(key, at, channel)

    turned = cmath.phase(cmath.exp(1j * (pose[2] - last[2])))
    moved = complex(pose[0] - last[0], pose[1] - last[1]) / cmath.exp(1j * (last[2] + turned / 2))
    way = moved.real / (1.0 - min(slip[0], 0.99))
    aside = moved.imag - slip[1] * way
    w = abs(way) + abs(aside)
    way = way * (1.0 + d["scale"] * e_(0, 0)) + d["walk"] * math.sqrt(w) * e_(2, step)
    turned += d["curl"] * w * e_(1, 0) + d["turn"] * math.sqrt(w) * e_(3, step)
    x, y, a, z, v, p, vz, c, whole = e
    place = complex(x, y) + complex(way, aside) * cmath.exp(1j * (a + turned / 2))
    a = cmath.phase(cmath.exp(1j * (a + turned)))
    z += rise + d["rise"] * math.sqrt(w) * e_(4, step)
    grown = d["turn"] ** 2 * w + d["curl"] ** 2 * ((whole + w) ** 2 - whole**2)
    was = c
    cubes = d["curl"] ** 2 * ((whole + w) ** 3 - whole**3)
    c += p * w + d["turn"] ** 2 * w**2 / 2.0 + cubes / 2.0 - d["curl"] ** 2 * whole**2 * w
    v += d["walk"] ** 2 * w + d["scale"] ** 2 * ((whole + w) ** 2 - whole**2) + (was + c) * w
    p += grown
    vz += d["rise"] ** 2 * w
    if d["sun"]:
        seen = pose[2] + d["sun"] * e_(5, step)
        gain = p / (p + d["sun"] ** 2)
        a = cmath.phase(cmath.exp(1j * (a + gain * cmath.phase(cmath.exp(1j * (seen - a))))))
        p, c = p * (1.0 - gain), c * (1.0 - gain)
    return [place.real, place.imag, a, z, v, p, vz, c, whole + w]
