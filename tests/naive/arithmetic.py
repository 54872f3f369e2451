"""The networks' arithmetic in plain Python: each operation is rounded once, in a fixed order."""

from __future__ import annotations

import functools
import math
from decimal import Decimal, localcontext
from fractions import Fraction
from typing import Any

import numpy as np


def fma(a: Any, b: Any, c: Any) -> Any:
    """a*b + c with one rounding, in the precision of `a`."""
    kind = type(a)
    if not (np.isfinite(a) and np.isfinite(b) and np.isfinite(c)):
        return a * b + c
    exact = Fraction(float(a)) * Fraction(float(b)) + Fraction(float(c))
    if not exact:
        return a * b + c  # only the sign of zero is left to decide
    if kind is np.float32:
        near = np.float32(float(exact))
        around = (np.nextafter(near, kind(-np.inf)), near, np.nextafter(near, kind(np.inf)))
        return min(around, key=lambda x: (abs(_value(x) - exact), x.view(np.int32) & 1))
    try:
        return kind(exact.numerator / exact.denominator)  # Python rounds this correctly
    except OverflowError:
        return kind(math.inf if exact > 0 else -math.inf)


def _value(x: Any) -> Fraction:
    """The number, or for an infinity the power of two that it stands for when rounding."""
    return Fraction(float(x)) if np.isfinite(x) else Fraction(int(np.sign(x)) * 2**128)


@functools.cache
def coefficients(kind: Any) -> list[Any]:
    """ln(2)^i / i! to the degree that `kind` needs."""
    with localcontext(prec=60):
        degree = 12 if kind is np.float64 else 6
        log2 = Decimal(2).ln()
        return [kind(float(log2**i / math.factorial(i))) for i in range(degree + 1)]


def exp2(z: Any) -> Any:
    """2^z, saturating where no normal number follows."""
    kind = type(z)
    limit = kind(1022 if kind is np.float64 else 126)
    z = np.clip(z, -limit, limit)
    if np.isnan(z):
        return z
    k = round(float(z))
    r = z - kind(k)
    c = coefficients(kind)
    pairs = [fma(r, c[i + 1], c[i]) for i in range(0, len(c) - 1, 2)] + [c[-1]]
    r2 = r * r
    a = fma(pairs[1], r2, pairs[0])
    if kind is np.float32:
        return np.ldexp(fma(fma(r2, pairs[3], pairs[2]), r2 * r2, a), k)
    r4 = r2 * r2
    b, top = fma(pairs[3], r2, pairs[2]), fma(pairs[5], r2, pairs[4])
    return np.ldexp(fma(fma(r4, pairs[6], top), r4 * r4, fma(b, r4, a)), k)


def exp(x: Any) -> Any:
    return exp2(x * type(x)(math.log2(math.e)))


def sigmoid(s: Any) -> Any:
    one = type(s)(1)
    return one / (one + exp(-s))


def tanh(s: Any) -> Any:
    one, two = type(s)(1), type(s)(2)
    return one - two / (one + exp(two * s))


def relu(s: Any) -> Any:
    return type(s)(0) if s < 0 else s


def linear(s: Any) -> Any:
    return s
