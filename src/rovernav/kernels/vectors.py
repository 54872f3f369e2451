"""Arithmetic written once and done on whole vectors: by the compiler's own, or by NumPy.

No optimiser puts long straight arithmetic with choices and gathers into vectors by itself. A
function of this kind takes the tools, `Own` or `Plain`, and numbers that know + - * / and
comparisons: eight doubles of the compiler's own, or arrays. There is no fused multiply-add and no
reassociation, so both give the bits of the same formula in a kernel.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir

WIDE = 8
"""Numbers in a vector."""
_REAL, _WORD, _SINGLE = ir.DoubleType(), ir.IntType(32), ir.FloatType()
_REALS, _WORDS, _SINGLES = (ir.VectorType(kind, WIDE) for kind in (_REAL, _WORD, _SINGLE))
_MASK = ir.VectorType(ir.IntType(1), WIDE)


class Vector:
    """Eight numbers, or eight answers, while code for them is built."""

    def __init__(self, own: Own, value: Any) -> None:
        self.own, self.value = own, value

    def _with(self, other: Any, name: str, *, back: bool = False) -> Vector:
        a, b = self.value, self.own.number(other).value
        if back:
            a, b = b, a
        return Vector(self.own, getattr(self.own.builder, name)(a, b))

    def __add__(self, other: Any) -> Vector:
        return self._with(other, "fadd")

    def __sub__(self, other: Any) -> Vector:
        return self._with(other, "fsub")

    def __mul__(self, other: Any) -> Vector:
        return self._with(other, "fmul")

    def __truediv__(self, other: Any) -> Vector:
        return self._with(other, "fdiv")

    def __radd__(self, other: Any) -> Vector:
        return self._with(other, "fadd", back=True)

    def __rsub__(self, other: Any) -> Vector:
        return self._with(other, "fsub", back=True)

    def __rmul__(self, other: Any) -> Vector:
        return self._with(other, "fmul", back=True)

    def __rtruediv__(self, other: Any) -> Vector:
        return self._with(other, "fdiv", back=True)

    def _is(self, order: str, other: Any) -> Vector:
        b = self.own.number(other).value
        return Vector(self.own, self.own.builder.fcmp_ordered(order, self.value, b))

    def __gt__(self, other: Any) -> Vector:
        return self._is(">", other)

    def __ge__(self, other: Any) -> Vector:
        return self._is(">=", other)

    def __lt__(self, other: Any) -> Vector:
        return self._is("<", other)

    def __le__(self, other: Any) -> Vector:
        return self._is("<=", other)

    def __and__(self, other: Vector) -> Vector:
        return Vector(self.own, self.own.builder.and_(self.value, other.value))

    def __or__(self, other: Vector) -> Vector:
        return Vector(self.own, self.own.builder.or_(self.value, other.value))

    def __invert__(self) -> Vector:
        ones = ir.Constant(_MASK, [1] * WIDE)
        return Vector(self.own, self.own.builder.xor(self.value, ones))


class Own:
    """Tools that build code."""

    def __init__(self, context: Any, builder: Any) -> None:
        self.context, self.builder = context, builder

    def number(self, other: Any) -> Vector:
        """A vector as it is, or a number in all places of one."""
        if isinstance(other, Vector):
            return other
        return Vector(self, ir.Constant(_REALS, [float(other)] * WIDE))

    def where(self, answer: Vector, yes: Any, no: Any) -> Vector:
        """`yes` where the answer is yes, else `no`."""
        yes, no = self.number(yes).value, self.number(no).value
        return Vector(self, self.builder.select(answer.value, yes, no))

    def floor(self, a: Vector) -> Vector:
        """The whole number at or below."""
        return self._call("floor", a)

    def root(self, a: Vector) -> Vector:
        """The square root."""
        return self._call("sqrt", a)

    def size(self, a: Vector) -> Vector:
        """Without its sign."""
        return self._call("fabs", a)

    def _call(self, name: str, a: Vector) -> Vector:
        typed, module = ir.FunctionType(_REALS, [_REALS]), self.builder.module
        name = f"llvm.{name}.v{WIDE}f64"
        return Vector(
            self,
            self.builder.call(
                module.globals.get(name) or ir.Function(module, typed, name), [a.value]
            ),
        )

    def row(self, kind: Any, array: Any, row: int, at: Any) -> Any:
        """Where the numbers of a row of a 2D array begin, from a column on."""
        numbers = self.context.make_array(kind)(self.context, self.builder, array)
        width = self.builder.extract_value(numbers.shape, 1)
        offset = self.builder.add(self.builder.mul(width, width.type(row)), at)
        return self.builder.gep(numbers.data, [offset])

    def load(self, place: Any) -> Vector:
        """Eight doubles from there."""
        kind = _REALS.as_pointer()
        return Vector(self, self.builder.load(self.builder.bitcast(place, kind), align=8))

    def every(self, place: Any) -> Vector:
        """The double that is there, in all places."""
        empty = ir.Constant(_REALS, ir.Undefined)
        first = self.builder.insert_element(empty, self.builder.load(place), _WORD(0))
        return Vector(
            self, self.builder.shuffle_vector(first, empty, ir.Constant(_WORDS, [0] * WIDE))
        )

    def store(self, a: Any, place: Any, kind: str = "double") -> None:
        """Write eight numbers to there, as ``double``, ``single`` or ``whole`` ones."""
        value, wide, align = self.number(a).value, _REALS, 8
        if kind == "whole":
            value, wide, align = self.builder.fptosi(value, _WORDS), _WORDS, 4
        elif kind == "single":
            value, wide, align = self.builder.fptrunc(value, _SINGLES), _SINGLES, 4
        self.builder.store(value, self.builder.bitcast(place, wide.as_pointer()), align=align)

    def turned(self, rows: list[Any]) -> list[Vector]:
        """Eight vectors: the first numbers of all given ones, the second ones, and so on."""
        values = [self.number(row).value for row in rows]
        values += [values[0]] * (WIDE - len(values))
        for by in (1, 2, 4):
            lower = [m if m & by == 0 else m - by + WIDE for m in range(WIDE)]
            upper = [m + by if m & by == 0 else m + WIDE for m in range(WIDE)]
            for m in range(WIDE):
                if m & by == 0:
                    a, b = values[m], values[m + by]
                    for at, order in ((m, lower), (m + by, upper)):
                        mask = ir.Constant(_WORDS, order)
                        values[at] = self.builder.shuffle_vector(a, b, mask)
        return [Vector(self, value) for value in values]

    def whole(self, place: Any) -> Any:
        """Eight whole numbers from there, to gather by."""
        kind = _WORDS.as_pointer()
        return self.builder.load(self.builder.bitcast(place, kind), align=4)

    def index(self, a: Vector) -> Any:
        """Whole numbers, to gather by."""
        return self.builder.fptosi(a.value, _WORDS)

    def real(self, index: Any) -> Vector:
        """Whole numbers as doubles."""
        return Vector(self, self.builder.sitofp(index, _REALS))

    def gather(self, place: Any, index: Any) -> Vector:
        """The numbers at these offsets from there, float64 or float32, as doubles."""
        single = place.type.pointee == _SINGLE
        inner = _SINGLES if single else _REALS
        pointers = ir.VectorType(place.type, WIDE)
        places = _Places(self.builder.block, place, index, pointers)
        self.builder._insert(places)
        typed = ir.FunctionType(inner, [pointers, _WORD, _MASK, inner])
        letter = "f32" if single else "f64"
        name = f"llvm.masked.gather.v{WIDE}{letter}.v{WIDE}{place.type.intrinsic_name}"
        gather = self.builder.module.globals.get(name) or ir.Function(
            self.builder.module, typed, name
        )
        on, none = ir.Constant(_MASK, [1] * WIDE), ir.Constant(inner, ir.Undefined)
        got = self.builder.call(gather, [places, _WORD(4 if single else 8), on, none])
        return Vector(self, self.builder.fpext(got, _REALS) if single else got)


class _Places(ir.Instruction):
    """The places of numbers counted from one; the builder only knows one offset."""

    def __init__(self, block: Any, data: Any, index: Any, pointers: Any) -> None:
        super().__init__(block, pointers, "getelementptr", [data, index])

    def descr(self, buf: list[str]) -> None:
        """Write the instruction."""
        data, index = self.operands
        parts = ", ".join(f"{part.type} {part.get_reference()}" for part in (data, index))
        buf.append(f"getelementptr {data.type.pointee}, {parts}\n")


class Plain:
    """The same tools for arrays."""

    where = staticmethod(np.where)
    floor = staticmethod(np.floor)
    root = staticmethod(np.sqrt)
    size = staticmethod(np.abs)

    @staticmethod
    def index(a: Any) -> Any:
        """Whole numbers, to gather by."""
        return a.astype(np.int64)

    @staticmethod
    def real(index: Any) -> Any:
        """Whole numbers as doubles."""
        return index.astype(np.float64)

    @staticmethod
    def gather(place: Any, index: Any) -> Any:
        """The numbers of an array at these indices, as doubles."""
        return place[index].astype(np.float64)


def least(tools: Any, a: Any, b: Any) -> Any:
    """The smaller number; the first of equals, as `min` in a kernel."""
    return tools.where(b < a, b, a)


def most(tools: Any, a: Any, b: Any) -> Any:
    """The larger number; the first of equals, as `max` in a kernel."""
    return tools.where(b > a, b, a)
