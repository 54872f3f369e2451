"""What driving costs on a slope: slip, speed, power, energy and time, for a rover on a soil.

Symbols: p, q gradient of the ground to the east and north; (ex, ey) unit heading on the map;
A = p ex + q ey rise along and B = q ex - p ey rise to the left, per metre of map; s slip, y side
slip; W weight [N], c rolling resistance, e efficiency, P0 idle power [W], v wheel speed [m/s].

    force     F = W (A + c) / sqrt(1 + A^2), not below 0: nothing is won back downhill
    wheels    v, or less where F v / e would exceed the drive motors' power
    progress  m = sqrt((1 - s)^2 - y^2): the rover aims uphill to hold its line against side slip
    per metre of ground: energy (F / e + P0 / v) / m, time 1 / (v m); of map: times sqrt(1 + A^2)

After Helmick and others (2009): power at the wheels is paid for wheel speed, not for ground speed.
A table has a row (COLUMNS,) for each soil, with the numbers that the constants name; then slip at
NODES rises from -1 to 1 and side slip at NODES rises from -1 to 1, all evenly spaced.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ._jit import kernel

F32: TypeAlias = NDArray[np.float32]
F64: TypeAlias = NDArray[np.float64]
I64: TypeAlias = NDArray[np.int64]

WEIGHT, ROLLING, EFFICIENCY, IDLE, SPEED, POWER, MOST_PITCH, MOST_ROLL, MOST_TILT = range(9)
MOST_SLIP, MEASURED_UP, MEASURED_DOWN, MEASURED_SIDE = range(9, 13)
FIRST, NODES = 13, 129
COLUMNS = FIRST + 2 * NODES

ALLOWED, PITCH, ROLL, TILT, SLIP = range(5)
"""Codes: the first limit that is broken. Limits are tangents, that of tilt its square."""
UNMEASURED, SIDE_UNMEASURED = 8, 16
"""Added to the code where a slope lies outside of what was measured on that soil."""

OUT = 9


@kernel(inline=True)
def _at(table: F64, soil: int, first: int, rise: float) -> float:
    """A curve between its nodes; level beyond the last."""
    u = (min(max(rise, -1.0), 1.0) + 1.0) * (0.5 * (NODES - 1))
    k = min(int(u), NODES - 2)
    low, high = table[soil, first + k], table[soil, first + k + 1]
    return low + (u - k) * (high - low)


@kernel(inline=True)
def _code(along: float, across: float, slip: float, table: F64, soil: int) -> int:
    """The code for a slope, with what is added to it."""
    steep = along * along + across * across
    roll = abs(across) / np.sqrt(1.0 + along * along)
    code = ALLOWED
    if slip > table[soil, MOST_SLIP]:
        code = SLIP
    if steep > table[soil, MOST_TILT]:
        code = TILT
    if roll > table[soil, MOST_ROLL]:
        code = ROLL
    if abs(along) > table[soil, MOST_PITCH]:
        code = PITCH
    if along > table[soil, MEASURED_UP] or along < -table[soil, MEASURED_DOWN]:
        code += UNMEASURED
    if abs(across) > table[soil, MEASURED_SIDE]:
        code += SIDE_UNMEASURED
    return code


@kernel(inline=True)
def slips(along: float, across: float, table: F64, soil: int) -> tuple[float, float]:
    """Slip and side slip on ground that rises by A along the way and B to the left of it."""
    slip = _at(table, soil, FIRST, along)
    return slip, _at(table, soil, FIRST + NODES, across / np.sqrt(1.0 + along * along))


@kernel(inline=True)
def pull_of(along: float, table: F64, soil: int) -> float:
    """F / e: what the drive motors draw for each m/s of the wheels [N]."""
    stretch = np.sqrt(1.0 + along * along)
    force = max(0.0, table[soil, WEIGHT] * (along + table[soil, ROLLING]) / stretch)
    return force / table[soil, EFFICIENCY]


@kernel(inline=True)
def drive_edge(
    p: float, q: float, ex: float, ey: float, table: F64, soil: int
) -> tuple[float, float, float, float, int]:
    """Energy [J] and time [s] per metre of map, slip, side slip and code for one heading.

    Energy and time are infinite where the wheels get nowhere. `code & 7` is ALLOWED where the
    rover may go; the costs of forbidden ground are true all the same. NaN in, NaN out.
    """
    along, across = p * ex + q * ey, q * ex - p * ey
    stretch = np.sqrt(1.0 + along * along)
    slip, side = slips(along, across, table, soil)
    code = _code(along, across, slip, table, soil)
    squared = (1.0 - slip) * (1.0 - slip) - side * side
    if slip >= 1.0 or squared <= 1e-6:
        code = SLIP + (code - (code & 7)) if code & 7 == ALLOWED else code
        return np.inf, np.inf, slip, side, code
    pull = pull_of(along, table, soil)
    speed = table[soil, SPEED]
    if pull * speed > table[soil, POWER]:
        speed = table[soil, POWER] / pull
    time = stretch / (speed * np.sqrt(squared))
    return time * (pull * speed + table[soil, IDLE]), time, slip, side, code


@kernel()
def drive_all(p: F64, q: F64, ex: F64, ey: F64, soil: I64, table: F64, out: F64) -> None:
    """`drive_edge` for n slopes and headings, all (n,); writes `out` (n, OUT).

    Columns: pitch [rad], roll [rad], slip, side slip, speed over ground [m/s], power [W], energy
    [J per metre of map], time [s per metre of map], code.
    """
    for k in range(len(p)):
        energy, time, slip, side, code = drive_edge(p[k], q[k], ex[k], ey[k], table, soil[k])
        along, across = p[k] * ex[k] + q[k] * ey[k], q[k] * ex[k] - p[k] * ey[k]
        stretch = np.sqrt(1.0 + along * along)
        out[k, 0], out[k, 1] = np.arctan(along), np.arctan(across / stretch)
        out[k, 2], out[k, 3] = slip, side
        out[k, 4] = stretch / time
        out[k, 5] = energy / time if time < np.inf else np.nan
        out[k, 6], out[k, 7], out[k, 8] = energy, time, code


@kernel()
def drive_layer(
    p: F32, q: F32, heading: tuple[float, float], table: F64, soil: int, slip: F32, energy: F32
) -> None:
    """Slip and energy [J per metre of map] for every cell (h, w); a heading of (0, 0) is uphill."""
    ex, ey = heading
    for i in range(p.shape[0]):
        for j in range(p.shape[1]):
            a, b = np.float64(p[i, j]), np.float64(q[i, j])
            if ex == 0.0 and ey == 0.0:
                a, b = np.sqrt(a * a + b * b), 0.0
                cost, _, lost, _, _ = drive_edge(a, b, 1.0, 0.0, table, soil)
            else:
                cost, _, lost, _, _ = drive_edge(a, b, ex, ey, table, soil)
            slip[i, j], energy[i, j] = lost, cost


@kernel()
def lean(p: F32, q: F32, heading: tuple[float, float], pitch: F32, roll: F32) -> None:
    """Pitch and roll [rad] of a body flush with the ground, for every cell (h, w)."""
    ex, ey = heading
    for i in range(p.shape[0]):
        for j in range(p.shape[1]):
            along, across = p[i, j] * ex + q[i, j] * ey, q[i, j] * ex - p[i, j] * ey
            pitch[i, j] = np.arctan(along)
            roll[i, j] = np.arctan(across / np.sqrt(1.0 + along * along))
