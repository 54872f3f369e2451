"""Sixteen numbers worked on together: the type of which the wide kernels' variables are.

A `Lanes` value is two vector registers, or four, or eight: what the processor has. Every
operation on it is that of `arithmetic` on each number, correctly rounded, so a lane has the bits
that the same number has alone. Code written for one number, such as the exponential or the
statements of `frozen`, compiles for sixteen as it stands; no optimiser has to find that out.

Under NUMBA_DISABLE_JIT there is one lane, a plain number.
"""

from __future__ import annotations

import operator
from typing import Any

from llvmlite import ir
from numba import types
from numba.core.datamodel import models
from numba.core.imputils import lower_builtin, lower_cast
from numba.core.typeconv.castgraph import Conversion
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, overload, register_model

from . import arithmetic
from ._jit import JIT_DISABLED

LANES = 1 if JIT_DISABLED else 16
"""Numbers in a vector."""


class LanesType(types.Type):
    """`LANES` float64 numbers."""

    def __init__(self) -> None:
        super().__init__(name=f"lanes{LANES}")

    def can_convert_from(self, typingctx: Any, other: Any) -> Any:
        """A single number stands for as many equal ones."""
        return Conversion.safe if other is types.float64 else None


class _Vector(ir.VectorType):
    intrinsic_name = f"v{LANES}f64"


lanes_type = LanesType()
_VECTOR, _DOUBLE = _Vector(ir.DoubleType(), LANES), ir.DoubleType()
_WORDS, _WORD = ir.VectorType(ir.IntType(64), LANES), ir.IntType(64)


@register_model(LanesType)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _VECTOR)


def _all(number: float) -> Any:
    return ir.Constant(_VECTOR, [float(number)] * LANES)


def _words(number: int) -> Any:
    return ir.Constant(_WORDS, [number] * LANES)


def _spread(builder: Any, number: Any) -> Any:
    """A vector of one number, `LANES` times."""
    index = ir.IntType(32)
    first = builder.insert_element(ir.Constant(_VECTOR, ir.Undefined), number, index(0))
    mask = ir.Constant(ir.VectorType(index, LANES), [0] * LANES)
    spread = builder.shuffle_vector(first, first, mask)
    spread.type = _VECTOR
    return spread


@lower_cast(types.Float, LanesType)
def _cast(context: Any, builder: Any, source: Any, _target: Any, number: Any) -> Any:
    return _spread(builder, context.cast(builder, number, source, types.float64))


class _Binary(AbstractTemplate):
    """Lanes with lanes, or with one number."""

    def generic(self, args: Any, kws: Any) -> Any:
        if lanes_type in args and len(args) == 2 and set(args) <= {lanes_type, types.float64}:
            return signature(lanes_type, lanes_type, lanes_type)
        return None


class _Unary(AbstractTemplate):
    def generic(self, args: Any, kws: Any) -> Any:
        return signature(lanes_type, lanes_type) if args == (lanes_type,) else None


_infer: Any = infer_global


def _operator(function: Any, name: str) -> None:
    _infer(function)(type(f"Lanes_{name}", (_Binary,), {}))

    def build(_context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        return getattr(builder, name)(*args)

    lower_builtin(function, LanesType, LanesType)(build)


def _negative(_context: Any, builder: Any, _signature: Any, args: Any) -> Any:
    return builder.fneg(args[0])


for _function, _name in (
    (operator.add, "fadd"),
    (operator.sub, "fsub"),
    (operator.mul, "fmul"),
    (operator.truediv, "fdiv"),
):
    _operator(_function, _name)
_infer(operator.neg)(type("Lanes_neg", (_Unary,), {}))
lower_builtin(operator.neg, LanesType)(_negative)


def _lanewise(name: str, build: Any) -> Any:
    """An intrinsic from lanes to lanes."""

    def typed(context: Any, value: Any) -> Any:
        return lanes_type(lanes_type), lambda _c, builder, _s, args: build(builder, args[0])

    typed.__name__ = name
    return intrinsic(typed)


def _build_clamp(builder: Any, z: Any) -> Any:
    for relation, limit in (("<", -arithmetic.LIMIT64), (">", arithmetic.LIMIT64)):
        beyond = builder.fcmp_ordered(relation, z, _all(limit))
        z = builder.select(beyond, _all(limit), z)
    return z


def _build_power(builder: Any, whole: Any) -> Any:
    bits = builder.add(builder.bitcast(whole, _WORDS), _words(1023))
    return builder.bitcast(builder.shl(bits, _words(52)), _VECTOR)


def _build_relu(builder: Any, s: Any) -> Any:
    return builder.select(builder.fcmp_ordered("<", s, _all(0.0)), _all(0.0), s)


def _build_step(builder: Any, o: Any) -> Any:
    return builder.select(builder.fcmp_ordered(">", o, _all(0.0)), _all(1.0), _all(0.0))


_clamp, _power = _lanewise("_clamp", _build_clamp), _lanewise("_power", _build_power)
_relu, _step = _lanewise("_relu", _build_relu), _lanewise("_step", _build_step)


@overload(arithmetic.clamped)
def _clamped(z):  # pyright: ignore[reportMissingParameterType]
    return (lambda z: _clamp(z)) if z is lanes_type else None


@overload(arithmetic.power_of_two)
def _power_of_two(whole):  # pyright: ignore[reportMissingParameterType]
    return (lambda whole: _power(whole)) if whole is lanes_type else None


@overload(arithmetic.relu)
def _relu_lanes(s):  # pyright: ignore[reportMissingParameterType]
    return (lambda s: _relu(s)) if s is lanes_type else None


@overload(arithmetic.step)
def _step_lanes(o):  # pyright: ignore[reportMissingParameterType]
    return (lambda o: _step(o)) if o is lanes_type else None


def _place(context: Any, builder: Any, kind: Any, array: Any, row: Any) -> Any:
    """Where row number `row` of a C-ordered (n, LANES) array begins."""
    data = context.make_array(kind)(context, builder, array).data
    at = builder.mul(row, _WORD(LANES))
    place = builder.gep(data, [at], source_etype=_DOUBLE)
    return builder.bitcast(place, _VECTOR.as_pointer())


@intrinsic
def _load_lanes(context, array, row):  # pyright: ignore[reportMissingParameterType]
    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        place = _place(context, builder, sig.args[0], *args)
        return builder.load(place, align=8, typ=_VECTOR)

    return lanes_type(array, types.int64), build


@intrinsic
def _store_lanes(context, array, row, value):  # pyright: ignore[reportMissingParameterType]
    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        place = _place(context, builder, sig.args[0], args[0], args[1])
        builder.store(args[2], place, align=8)
        return context.get_dummy_value()

    return types.void(array, types.int64, lanes_type), build


def _mask(builder: Any, flags: Any) -> Any:
    """Bit number lane is set where the lane's flag is."""
    return builder.zext(builder.bitcast(flags, ir.IntType(LANES)), _WORD)


@intrinsic
def _within_lanes(context, error, tolerance):  # pyright: ignore[reportMissingParameterType]
    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        error, tolerance = args
        below = builder.fcmp_ordered("<", error, tolerance)
        above = builder.fcmp_ordered(">", error, builder.fneg(tolerance))
        return _mask(builder, builder.and_(below, above))

    return types.int64(lanes_type, lanes_type), build


def _load_plain(array: Any, row: int) -> Any:
    return array[row, 0]


def _store_plain(array: Any, row: int, value: Any) -> None:
    array[row, 0] = value


def _within_plain(error: Any, tolerance: Any) -> int:
    return int(abs(error) < tolerance)


load: Any = _load_plain if JIT_DISABLED else _load_lanes
"""Row `row` of a C-ordered float64 array (n, LANES); rows are not checked."""
store: Any = _store_plain if JIT_DISABLED else _store_lanes
"""Write lanes to row `row` of a C-ordered float64 array (n, LANES); rows are not checked."""
within: Any = _within_plain if JIT_DISABLED else _within_lanes
"""Bits of the lanes whose |error| is below their tolerance; no number is within anything."""
