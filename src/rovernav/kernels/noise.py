"""Noise of sensors that hangs on who reads what when, and on nothing else.

A draw is a function of a rover's key, the number of the reading and a channel: nothing is drawn in
sequence. So a rover in a batch has the noise that it has alone, whatever the batch and its order.
The bits are those of `kernels.field`. Symbols: r true range, R reach, s standard deviation [m].
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ._jit import kernel
from .field import deviate, mixed

_WORD: Any = np.uint64
_ELEVEN = _WORD(11)
PER_BEAM = 4
"""Channels that a beam may draw from."""


class RangeNoise(NamedTuple):
    """What spoils a range.

    Attributes:
        core: Standard deviation at range 0 [m].
        relative: What each metre adds to it [1].
        stray: Chance that a beam goes astray, for each metre of range [1/m].
        spread: Standard deviation of stray readings [m].
        back: Chance that it is back at the next reading.
        lose: Chance that a beam loses its echo, for each metre of range [1/m].
        find: Chance that it finds it again at the next reading.
        least: Nothing nearer is read [m].
        grain: Readings are whole multiples of this [m]; 0 for any number.
    """

    core: float
    relative: float
    stray: float
    spread: float
    back: float
    lose: float
    find: float
    least: float
    grain: float


@kernel()
def keys(seed: int, number: Any, out: Any) -> None:
    """The key of each rover (n,), uint64, from a seed and the rovers' numbers (n,)."""
    base = mixed(_WORD(np.int64(seed)))
    for k in range(number.shape[0]):
        out[k] = mixed(base ^ _WORD(np.int64(number[k])))


@kernel()
def share(key: np.uint64, i: int, j: int) -> float:
    """A number evenly from [0, 1) for reading i and channel j; 53 bits of the mixed word."""
    word = mixed(mixed(key ^ _WORD(np.int64(i))) ^ _WORD(np.int64(j)))
    return np.float64(word >> _ELEVEN) * 2.0**-53


@kernel()
def nearest_of(ranges: Any, group: int, out: Any) -> None:
    """The shortest of each `group` of neighbouring beams (n, b group) to out (n, b): a cone."""
    for k in range(out.shape[0]):
        for b in range(out.shape[1]):
            best = ranges[k, b * group]
            for m in range(1, group):
                best = min(best, ranges[k, b * group + m])
            out[k, b] = best


@kernel()
def spoil(
    true: Any, rovers: Any, step: int, before: Any, reach: float, p: RangeNoise, now: Any, out: Any
) -> None:
    """Write what is read instead of true ranges.

    A beam sees, is lost, or is astray. Seeing, with r < R, it is lost from now on with chance
    `lose` r, or goes astray with chance `stray` r. Lost, it sees again with chance `find`; astray,
    with chance `back`. Lost, or seeing r >= R, it reads R. Seeing, it reads r + s e1 e2 with
    s = core + relative r: a product of two deviates is heavy-tailed. Astray it reads r + spread e,
    with the same e until it is back.

    Args:
        true: True ranges (n, b) [m].
        rovers: Key of each rover (n,).
        step: Number of this reading, from 1.
        before: 0 where a beam saw, t where it is lost since reading t, -t where it is astray since
            then (n, b), int64.
        reach: R [m].
        p: The noise.
        now: The same for now, written.
        out: Readings (n, b) [m], written.
    """
    for k in range(true.shape[0]):
        key = rovers[k]
        for b in range(true.shape[1]):
            r, channel = true[k, b], PER_BEAM * b
            since = _since(share(key, step, channel), before[k, b], step, r, reach, p)
            now[k, b] = since
            if since > 0 or r >= reach:
                out[k, b] = reach
                continue
            if since < 0:
                read = r + p.spread * deviate(key, -since, channel + 1)
            else:
                s = p.core + p.relative * r
                read = r + s * deviate(key, step, channel + 2) * deviate(key, step, channel + 3)
            if p.grain > 0.0:
                read = np.floor(read / p.grain + 0.5) * p.grain
            out[k, b] = min(max(read, p.least), reach)


@kernel(inline=True)
def _since(luck: float, before: int, step: int, r: float, reach: float, p: RangeNoise) -> int:
    """How a beam fares from now on: 0 sees, above 0 lost, below 0 astray."""
    if before > 0:
        return 0 if luck < p.find else before
    if before < 0:
        return 0 if luck < p.back else before
    if r < reach and luck < p.lose * r:
        return step
    if r < reach and luck < (p.lose + p.stray) * r:
        return -step
    return 0


@kernel()
def infrared(
    true: Any, rovers: Any, step: int, table: Any, noise: float, counts: Any, volt: float, out: Any
) -> None:
    """What a triangulating infra-red sensor makes of true distances.

    The voltage is linear between the rows of the table, falls as 1/d beyond the last, and is
    disturbed by `noise` times itself times a deviate. A converter turns it into whole counts, and
    the counts' distance is looked up: so what is nearer than the peak is read as farther.

    Args:
        true: Distances (n, b) [m].
        rovers: Key of each rover (n,).
        step: Number of this reading.
        table: Rows distance [m], voltage [V], distances rising (t, 2).
        noise: Standard deviation as a share of the voltage.
        counts: Distance that each count is read as (c,) [m].
        volt: Voltage of the last count [V].
        out: Readings (n, b) [m], written.
    """
    last, top = table.shape[0] - 1, counts.size - 1
    for k in range(true.shape[0]):
        for b in range(true.shape[1]):
            v = voltage(true[k, b], table, last)
            v += noise * v * deviate(rovers[k], step, PER_BEAM * b + 2)
            count = int(np.floor(v / volt * top + 0.5))
            out[k, b] = counts[min(max(count, 0), top)]


@kernel()
def voltage(d: float, table: Any, last: int) -> float:
    """Output [V] at a distance d [m]."""
    if d >= table[last, 0]:
        return table[last, 1] * table[last, 0] / d
    for i in range(1, last + 1):
        if d < table[i, 0]:
            share_ = max(0.0, (d - table[i - 1, 0]) / (table[i, 0] - table[i - 1, 0]))
            return table[i - 1, 1] + share_ * (table[i, 1] - table[i - 1, 1])
    return table[last, 1]


@kernel()
def tilted(attitude: Any, rovers: Any, step: int, bias: float, noise: float, out: Any) -> None:
    """Pitch and roll (n, 2) as an inertial unit tells them: a constant error and one per reading.

    Args:
        attitude: Height, pitch, roll (n, 3).
        rovers: Key of each rover (n,).
        step: Number of this reading, from 1.
        bias: Standard deviation of the constant error [rad].
        noise: Standard deviation of the other [rad].
        out: Pitch, roll (n, 2) [rad], written.
    """
    for k in range(out.shape[0]):
        for a in range(2):
            error = bias * deviate(rovers[k], 0, a) + noise * deviate(rovers[k], step, a)
            out[k, a] = attitude[k, 1 + a] + error
