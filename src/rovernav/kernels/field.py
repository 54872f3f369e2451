"""Random fields that are the same wherever and in whatever pieces they are asked for.

A value at a place depends on a key and on that place alone: nothing is drawn in sequence, and
nothing wraps around. Symbols: key 64 bits, i, j row and column of a node or cell, B the cubic
B-spline. Bits are mixed as in the generator SplitMix64 (G. L. Steele, D. Lea and C. H. Flood, Fast
Splittable Pseudorandom Number Generators, OOPSLA 2014).
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ._jit import kernel

F64: TypeAlias = NDArray[np.float64]

_STEP = np.uint64(0x9E3779B97F4A7C15)
_MIX1, _MIX2 = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
_S30, _S27, _S31, _S16 = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(16)
_LOW = np.uint64(0xFFFF)
_HALF_WIDTH = np.float64(131070.0)  # mean of four numbers of 16 bits, summed
_SPREAD = np.float64(1.7320508075688772 / 65536.0)  # so that the variance is 1


@kernel()
def mixed(word: np.uint64) -> np.uint64:
    """`word` with its bits mixed."""
    word = word + _STEP
    word = (word ^ (word >> _S30)) * _MIX1
    word = (word ^ (word >> _S27)) * _MIX2
    return word ^ (word >> _S31)


@kernel()
def deviate(key: np.uint64, i: int, j: int) -> float:
    """A random number of mean 0 and variance 1, nearly normal, for the node (i, j).

    It is the sum of four uniform ones (Irwin and Hall), within 3.46 of 0.
    """
    word = mixed(mixed(key ^ np.uint64(np.int64(i))) ^ np.uint64(np.int64(j)))
    total = np.float64(0.0)
    for _ in range(4):
        total += np.float64(word & _LOW)
        word = word >> _S16
    return (total - _HALF_WIDTH) * _SPREAD


@kernel()
def add_waves(out: F64, row: int, column: int, pace: float, key: np.uint64, a: float) -> None:
    """Add a smooth random field times `a` to `out` (h, w), whose first cell is (row, column).

    The field is a sum of cubic B-splines around nodes 1 / `pace` cells apart, each with its
    deviate; the nodes are shifted by the key. Its variance over all places is (151/315)^2.
    """
    h, w = out.shape
    shift_y = np.float64(mixed(key ^ _MIX1) >> _S31) / 8589934592.0
    shift_x = np.float64(mixed(key ^ _MIX2) >> _S31) / 8589934592.0
    first = int(np.floor((column + 0.5) * pace + shift_x)) - 1
    last = int(np.floor((column + w - 0.5) * pace + shift_x)) + 3
    nodes = np.empty((4, last - first))
    line = np.empty(last - first)
    held = np.full(4, -(2**62), np.int64)  # the rows of nodes that are in `nodes`
    for i in range(h):
        y = (row + i + 0.5) * pace + shift_y
        below = int(np.floor(y))
        v = y - below
        line[:] = 0.0
        for n in range(4):
            node = below - 1 + n
            slot = node & 3
            if held[slot] != node:
                for k in range(last - first):
                    nodes[slot, k] = deviate(key, node, first + k)
                held[slot] = node
            weight = spline(v, n)
            for k in range(last - first):
                line[k] += weight * nodes[slot, k]
        for j in range(w):
            x = (column + j + 0.5) * pace + shift_x
            left = int(np.floor(x))
            u, at = x - left, left - 1 - first
            here = np.float64(0.0)
            for n in range(4):
                here += spline(u, n) * line[at + n]
            out[i, j] += a * here


@kernel()
def add_grain(out: F64, row: int, column: int, key: np.uint64, a: float) -> None:
    """Add to each cell of `out` (h, w) its own deviate times `a`; the first is (row, column)."""
    h, w = out.shape
    for i in range(h):
        for j in range(w):
            out[i, j] += a * deviate(key, row + i, column + j)


@kernel()
def spline(u: float, n: int) -> float:
    """The weight of node n = 0 ... 3 at a place u = 0 ... 1 between nodes 1 and 2."""
    if n == 0:
        return (1.0 - u) * (1.0 - u) * (1.0 - u) / 6.0
    if n == 1:
        return (4.0 - 6.0 * u * u + 3.0 * u * u * u) / 6.0
    if n == 2:
        return (1.0 + 3.0 * u + 3.0 * u * u - 3.0 * u * u * u) / 6.0
    return u * u * u / 6.0
