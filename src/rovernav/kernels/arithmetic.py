"""The arithmetic of all networks: one fused multiply-add, one exponential, one tanh.

Symbols: s pre-activation, z = -s log2(e), k the nearest whole number to z, r = z - k.

Every operation is a correctly rounded IEEE 754 one in a fixed order (`fma` is written out, never
left to the compiler), so serial, batched, frozen and vectorised kernels give the same bits, and so
does the plain-Python twin in the tests. The exponential is 2^k times a polynomial in r, evaluated
by Estrin's scheme: degree 12 in float64 (relative error below 3e-16 on [-0.5, 0.5]), degree 6 in
float32 (below 2e-7). Coefficients are Taylor's, ln(2)^i / i! rounded once.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic, overload

from ._jit import JIT_DISABLED, kernel

LOG2E = 1.4426950408889634
_ROUND64 = 6755399441055744.0  # 1.5 * 2^52: adding it rounds to a whole number
_ROUND32 = np.float32(12582912.0)  # 1.5 * 2^23
LIMIT64, _LIMIT32 = 1022.0, np.float32(126.0)  # beyond these 2^z has no normal number

_C0, _C1, _C2, _C3, _C4, _C5, _C6, _C7, _C8, _C9, _C10, _C11, _C12 = (
    float.fromhex(h)
    for h in (
        "0x1.0000000000000p+0",
        "0x1.62e42fefa39efp-1",
        "0x1.ebfbdff82c58fp-3",
        "0x1.c6b08d704a0c0p-5",
        "0x1.3b2ab6fba4e77p-7",
        "0x1.5d87fe78a6731p-10",
        "0x1.430912f86c787p-13",
        "0x1.ffcbfc588b0c7p-17",
        "0x1.62c0223a5c824p-20",
        "0x1.b5253d395e7c4p-24",
        "0x1.e4cf5158b8ecap-28",
        "0x1.e8cac7351bb25p-32",
        "0x1.c3bd650fc2986p-36",
    )
)
_F0, _F1, _F2, _F3, _F4, _F5, _F6 = (np.float32(c) for c in (_C0, _C1, _C2, _C3, _C4, _C5, _C6))
_LOG2E32 = np.float32(LOG2E)
_SINGLE: Any = np.float32
_ZERO, _ONE, _TWO = np.float32(0.0), np.float32(1.0), np.float32(2.0)


def _bits(name: str, source: Any, target: Any, llvm: Any) -> Any:
    """An intrinsic that reads the bits of a `source` number as a `target` number."""

    def typed(context: Any, value: Any) -> Any:
        def build(_context: Any, builder: Any, _signature: Any, args: Any) -> Any:
            return builder.bitcast(args[0], llvm)

        return target(source), build

    typed.__name__ = name
    return intrinsic(typed)


def _fma_typed(context: Any, a: Any, b: Any, c: Any) -> Any:
    """a*b + c by the processor's own instruction."""

    def build(_context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        kind = args[0].type  # a number or a vector of numbers
        function = ir.FunctionType(kind, [kind] * 3)
        return builder.call(builder.module.declare_intrinsic("llvm.fma", [kind], function), args)

    return a(a, a, a), build


def _fma_plain(a: Any, b: Any, c: Any) -> Any:
    """a*b + c in fractions, rounded once."""
    kind: Any = np.float32 if isinstance(a, _SINGLE) else np.float64
    with np.errstate(all="ignore"):
        if not (np.isfinite(a) and np.isfinite(b) and np.isfinite(c)):
            return kind(a) * kind(b) + kind(c)
        exact = Fraction(float(a)) * Fraction(float(b)) + Fraction(float(c))
        return kind(_nearest(exact, np.finfo(kind)) if exact else a * b + c)


def _nearest(exact: Fraction, kind: Any) -> float:
    """The float of that kind (a `numpy.finfo`) nearest to `exact`."""
    size = abs(exact.numerator).bit_length() - exact.denominator.bit_length()
    size -= abs(exact) < Fraction(2) ** size  # 2^size is the last power of two below |exact|
    unit = Fraction(2) ** (max(size, int(kind.minexp)) - int(kind.nmant))
    try:
        near = float(round(abs(exact) / unit) * unit)  # ties go to even
    except OverflowError:
        near = math.inf
    return near if exact > 0 else -near


if JIT_DISABLED:
    fma: Any = _fma_plain
    _as_int64: Any = lambda x: int(np.float64(x).view(np.int64))  # noqa: E731
    _as_float64: Any = lambda k: float(np.uint64(k % 2**64).view(np.float64))  # noqa: E731
    _as_int32: Any = lambda x: np.float32(x).view(np.int32)  # noqa: E731
    _as_float32: Any = lambda k: np.int32(k).view(np.float32)  # noqa: E731
else:
    fma = intrinsic(_fma_typed)
    _as_int64 = _bits("_as_int64", types.float64, types.int64, ir.IntType(64))
    _as_float64 = _bits("_as_float64", types.int64, types.float64, ir.DoubleType())
    _as_int32 = _bits("_as_int32", types.float32, types.int32, ir.IntType(32))
    _as_float32 = _bits("_as_float32", types.int32, types.float32, ir.FloatType())


def clamped(z: Any) -> Any:
    """`z`, no nearer to infinity than 2^z is to a normal number; NaN stays NaN."""
    return -LIMIT64 if z < -LIMIT64 else (LIMIT64 if z > LIMIT64 else z)


def power_of_two(whole: Any) -> Any:
    """2^k, from k + 1.5 * 2^52."""
    return _as_float64((_as_int64(whole) + 1023) << 52)


@kernel(inline=True)
def _exp2_64(z: Any) -> Any:
    """2^z for finite z; the ends saturate at 2^-1022 and 2^1022; NaN stays NaN."""
    z = clamped(z)
    whole = z + _ROUND64
    r = z - (whole - _ROUND64)
    r2 = r * r
    r4 = r2 * r2
    r8 = r4 * r4
    a = fma(fma(r, _C3, _C2), r2, fma(r, _C1, _C0))
    b = fma(fma(r, _C7, _C6), r2, fma(r, _C5, _C4))
    c = fma(r4, _C12, fma(fma(r, _C11, _C10), r2, fma(r, _C9, _C8)))
    return power_of_two(whole) * fma(c, r8, fma(b, r4, a))


@kernel(inline=True)
def _exp2_32(z: Any) -> Any:
    """2^z in float32; the ends saturate at 2^-126 and 2^126."""
    z = -_LIMIT32 if z < -_LIMIT32 else z
    z = _LIMIT32 if z > _LIMIT32 else z
    whole = z + _ROUND32
    r = z - (whole - _ROUND32)
    r2 = r * r
    a = fma(fma(r, _F3, _F2), r2, fma(r, _F1, _F0))
    b = fma(r2, _F6, fma(r, _F5, _F4))
    power = _as_float32(np.int32((_as_int32(whole) + np.int32(127)) << np.int32(23)))
    return power * fma(b, r2 * r2, a)


def exp(x: Any) -> Any:
    """e^x in the precision of `x`; saturates instead of overflowing."""
    return _exp2_32(x * _LOG2E32) if isinstance(x, _SINGLE) else _exp2_64(x * LOG2E)


def sigmoid(s: Any) -> Any:
    """1 / (1 + e^-s) in the precision of `s`."""
    if isinstance(s, _SINGLE):
        return _ONE / (_ONE + _exp2_32(-s * _LOG2E32))
    return 1.0 / (1.0 + _exp2_64(-s * LOG2E))


def tanh(s: Any) -> Any:
    """1 - 2 / (e^2s + 1) in the precision of `s`; absolute error of a few rounding units."""
    if isinstance(s, _SINGLE):
        return _ONE - _TWO / (_ONE + _exp2_32(_TWO * s * _LOG2E32))
    return 1.0 - 2.0 / (1.0 + _exp2_64(2.0 * s * LOG2E))


def relu(s: Any) -> Any:
    """The positive part of `s`, in its precision; NaN stays NaN."""
    if isinstance(s, _SINGLE):
        return _ZERO if s < _ZERO else s
    return 0.0 if s < 0.0 else s


def step(o: Any) -> Any:
    """1 above 0, otherwise 0: the slope of `relu` from its output."""
    return 1.0 if o > 0.0 else 0.0


# Numba compares argument names with annotations, so the overloads have none.
@overload(exp)
def _exp(x):  # pyright: ignore[reportMissingParameterType]
    if x is types.float32:
        return lambda x: _exp2_32(x * _LOG2E32)
    return lambda x: _exp2_64(x * LOG2E)


@overload(sigmoid)
def _sigmoid(s):  # pyright: ignore[reportMissingParameterType]
    if s is types.float32:
        return lambda s: _ONE / (_ONE + _exp2_32(-s * _LOG2E32))
    return lambda s: 1.0 / (1.0 + _exp2_64(-s * LOG2E))


@overload(relu)
def _relu(s):  # pyright: ignore[reportMissingParameterType]
    if s is types.float32:
        return lambda s: _ZERO if s < _ZERO else s
    return (lambda s: 0.0 if s < 0.0 else s) if isinstance(s, types.Number) else None


@overload(tanh)
def _tanh(s):  # pyright: ignore[reportMissingParameterType]
    if s is types.float32:
        return lambda s: _ONE - _TWO / (_ONE + _exp2_32(_TWO * s * _LOG2E32))
    return lambda s: 1.0 - 2.0 / (1.0 + _exp2_64(2.0 * s * LOG2E))


@overload(clamped)
def _clamped(z):  # pyright: ignore[reportMissingParameterType]
    if z is types.float64:
        return lambda z: -LIMIT64 if z < -LIMIT64 else (LIMIT64 if z > LIMIT64 else z)
    return None


@overload(power_of_two)
def _power_of_two(whole):  # pyright: ignore[reportMissingParameterType]
    if whole is types.float64:
        return lambda whole: _as_float64((_as_int64(whole) + 1023) << 52)
    return None


@overload(step)
def _step(o):  # pyright: ignore[reportMissingParameterType]
    return (lambda o: 1.0 if o > 0.0 else 0.0) if o is types.float64 else None
