"""Uniform numbers of many seeds: those of ``numpy.random.default_rng(seed)``, without its start-up.

NumPy takes some 20 us to make one generator, as long as training a small network takes. Here a
seed takes a fraction of one. The seed sequence is O'Neill's ``seed_seq_fe128`` (2015, "Developing a
seed_seq alternative"), the generator her PCG64 XSL-RR (2014, HMC-CS-2014-0905), both as NumPy has
them.

Symbols: h hash constant, pool the four mixed words, (s1, s0) high and low half of the 128-bit
state, (c1, c0) of the increment.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ._jit import kernel

_WORD: Any = np.uint64
_MASK, _HALF, _ONE = _WORD(0xFFFFFFFF), _WORD(32), _WORD(1)
_SIXTEEN, _ELEVEN, _WHOLE = _WORD(16), _WORD(11), _WORD(64)
_A, _MULT_A = _WORD(0x43B0D7E5), _WORD(0x931E8875)
_B, _MULT_B = _WORD(0x8B51F9DD), _WORD(0x58F38DED)
_MIX_L, _MIX_R = _WORD(0xCA01F9DD), _WORD(0x4973F715)
_HIGH, _LOW = _WORD(0x2360ED051FC65DA4), _WORD(0x4385DF649FCCF645)


@kernel()
def uniform(seeds: Any, scale: Any, out: Any) -> None:
    """Write ``default_rng(seed).uniform(-1, 1, n) / scale`` of each seed.

    Args:
        seeds: From 0 to 2^63 - 1 (m,).
        scale: Divisor of each number (n,).
        out: (m, n), written.
    """
    pool = np.empty(4, np.uint64)
    for row in range(seeds.size):
        seed = _WORD(seeds[row])
        pool[0], pool[1], pool[2], pool[3] = seed & _MASK, seed >> _HALF, _WORD(0), _WORD(0)
        s1, s0, c1, c0 = _begun(pool)
        for n in range(scale.size):
            s1, s0 = _next(s1, s0, c1, c0)
            out[row, n] = (-1.0 + 2.0 * _share(s1, s0)) / scale[n]


@kernel()
def uniform_pairs(key: int, numbers: Any, spread: float, out: Any) -> None:
    """Write ``default_rng([key, number]).uniform(-spread, spread, n)`` of each number.

    Args:
        key: From 0 to 2^63 - 1.
        numbers: From 0 to 2^63 - 1 (m,).
        spread: Largest number.
        out: (m, n), written.
    """
    pool, wide = np.empty(4, np.uint64), spread - -spread
    for row in range(numbers.size):
        count = _halves(_WORD(key), 0, pool)
        count = _halves(_WORD(numbers[row]), count, pool)
        pool[count:] = _WORD(0)
        s1, s0, c1, c0 = _begun(pool)
        for n in range(out.shape[1]):
            s1, s0 = _next(s1, s0, c1, c0)
            out[row, n] = -spread + wide * _share(s1, s0)


@kernel()
def _halves(number: Any, at: int, pool: Any) -> int:
    """Write a number's halves from place `at` on, no second one that is 0; the next place."""
    pool[at] = number & _MASK
    if number >> _HALF == _WORD(0):
        return at + 1
    pool[at + 1] = number >> _HALF
    return at + 2


@kernel()
def _begun(pool: Any) -> Any:
    """State and increment of the generator of a seed, whose halves are in the pool."""
    words = np.empty(4, np.uint64)
    _spread(pool)
    _words(pool, words)
    c1 = (words[2] << _ONE) | (words[3] >> _WORD(63))
    c0 = (words[3] << _ONE) | _ONE
    s1, s0 = _plus(c1, c0, words[0], words[1])  # one step from 0 gives the increment
    s1, s0 = _next(s1, s0, c1, c0)
    return s1, s0, c1, c0


@kernel(inline=True)
def _share(s1: Any, s0: Any) -> float:
    """What a state is worth: a number from 0 to below 1."""
    turn, folded = s1 >> _WORD(58), s1 ^ s0
    bits = (folded >> turn) | (folded << ((_WHOLE - turn) & _WORD(63)))
    return np.float64(bits >> _ELEVEN) * 2.0**-53


@kernel()
def _spread(pool: Any) -> None:
    """Mix the halves of a seed over the pool that they lie in."""
    h = _A
    for i in range(4):
        half = pool[i] ^ h
        h = (h * _MULT_A) & _MASK
        half = (half * h) & _MASK
        pool[i] = half ^ (half >> _SIXTEEN)
    for source in range(4):
        for target in range(4):
            if source != target:
                word = pool[source] ^ h
                h = (h * _MULT_A) & _MASK
                word = (word * h) & _MASK
                word ^= word >> _SIXTEEN
                word = (_MIX_L * pool[target] - _MIX_R * word) & _MASK
                pool[target] = word ^ (word >> _SIXTEEN)


@kernel()
def _words(pool: Any, words: Any) -> None:
    """The generator's four starting words, from the pool."""
    h = _B
    for i in range(8):
        half = pool[i & 3] ^ h
        h = (h * _MULT_B) & _MASK
        half = (half * h) & _MASK
        half ^= half >> _SIXTEEN
        words[i >> 1] = half if i & 1 == 0 else words[i >> 1] | (half << _HALF)


@kernel(inline=True)
def _next(s1: Any, s0: Any, c1: Any, c0: Any) -> Any:
    """The state after (s1, s0): multiplied and incremented modulo 2^128."""
    high = _upper(s0, _LOW) + s0 * _HIGH + s1 * _LOW
    return _plus(high, s0 * _LOW, c1, c0)


@kernel(inline=True)
def _plus(a1: Any, a0: Any, b1: Any, b0: Any) -> Any:
    """A sum modulo 2^128."""
    low = a0 + b0
    return a1 + b1 + (_ONE if low < a0 else _WORD(0)), low


@kernel(inline=True)
def _upper(a: Any, b: Any) -> Any:
    """The upper 64 bits of a product of two words."""
    a1, a0, b1, b0 = a >> _HALF, a & _MASK, b >> _HALF, b & _MASK
    middle = a1 * b0 + ((a0 * b0) >> _HALF)
    other = a0 * b1 + (middle & _MASK)
    return a1 * b1 + (middle >> _HALF) + (other >> _HALF)
