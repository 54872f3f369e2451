"""Transposes of small matrices, in blocks that stay in registers.

A block of n x n numbers is loaded as n vectors. Step s = 1, 2, 4, ... below n exchanges, between
rows i and i + s, the numbers whose column lies on the wrong side; after the last step row i is
column i (Eklundh 1972).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from ._jit import JIT_DISABLED, kernel
from .product import VECTOR


def _emit(builder: Any, kind: Any, a: Any, a_row: Any, b: Any, b_row: Any) -> None:
    """Load a block's rows from `a`, exchange, store them to `b`."""
    size = kind.count
    width = VECTOR // size

    def row(start: Any, distance: Any, i: int) -> Any:
        spot = builder.gep(start, [builder.mul(distance, distance.type(i))])
        return builder.bitcast(spot, kind.as_pointer())

    rows = [builder.load(row(a, a_row, i), align=width) for i in range(size)]
    s = 1
    while s < size:
        for i in range(size):
            if i & s:
                continue
            low, high = rows[i], rows[i + s]
            kept = [j if not j & s else size + j - s for j in range(size)]
            moved = [j + s if not j & s else size + j for j in range(size)]
            for place, mask in ((i, kept), (i + s, moved)):
                lanes = ir.Constant(ir.VectorType(ir.IntType(32), size), mask)
                rows[place] = builder.shuffle_vector(low, high, lanes)
        s *= 2
    for i, vector in enumerate(rows):
        builder.store(vector, row(b, b_row, i), align=width)


def _block() -> Callable[..., Any]:
    """A function (a, first, a_row, b, first, b_row) that turns one block."""
    if JIT_DISABLED:
        return _plain_block

    def block(context: Any, a: Any, at: Any, a_row: Any, b: Any, to: Any, b_row: Any) -> Any:
        def build(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            a_kind, _, _, b_kind, _, _ = signature.args
            starts = [
                builder.gep(context.make_array(kind)(context, builder, array).data, [place])
                for kind, array, place in ((a_kind, args[0], args[1]), (b_kind, args[3], args[4]))
            ]
            number = ir.FloatType() if a_kind.dtype.bitwidth == 32 else ir.DoubleType()
            kind = ir.VectorType(number, VECTOR * 8 // a_kind.dtype.bitwidth)
            _emit(builder, kind, starts[0], args[2], starts[1], args[5])
            return context.get_dummy_value()

        index = types.intp
        return types.void(a, index, index, b, index, index), build

    return intrinsic(block)


def _plain_block(a: Any, at: int, a_row: int, b: Any, to: int, b_row: int) -> None:
    """The same in plain Python, for tests without the compiler."""
    size = VECTOR // a.itemsize
    for i in range(size):
        for j in range(size):
            b[to + j * b_row + i] = a[at + i * a_row + j]


_turn_block = _block()


@kernel()
def turn(a: Any, at: int, a_row: int, b: Any, to: int, b_row: int, shape: tuple[int, int]) -> None:
    """Write the matrix a, transposed, to b.

    Args:
        a: Array that holds it, of b's precision.
        at: Index of its first element.
        a_row: Distance of its rows.
        b: Array that receives it.
        to: Index of the first element there.
        b_row: Distance of rows there.
        shape: Rows and columns of a.
    """
    rows, columns = shape
    size = VECTOR // a.itemsize
    whole, wide = rows - rows % size, columns - columns % size
    for i in range(0, whole, size):
        for j in range(0, wide, size):
            _turn_block(a, at + i * a_row + j, a_row, b, to + j * b_row + i, b_row)
    for i in range(rows):
        for j in range(wide if i < whole else 0, columns):
            b[to + j * b_row + i] = a[at + i * a_row + j]
