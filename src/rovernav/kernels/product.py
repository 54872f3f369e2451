"""Matrix products of small networks, with a fixed order of every sum.

Symbols: c = s + a b, s the start (a bias row or zero), k the summed index, j a column.

Each element of c is one chain of fused multiply-adds over ascending k, so its bits depend neither
on the tile it falls into nor on rows beside it, the machine's vectors or its number of cores.
The inner loop keeps a tile of c in registers (Goto and van de Geijn 2008, section 3). Up to layers
of 1,000 units that is no slower than BLAS, which fixes no order.

Matrices lie in flat arrays whose rows are padded to whole vectors of 64 bytes: see `padded`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from llvmlite import binding, ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from ._jit import JIT_DISABLED, kernel
from .arithmetic import fma

VECTOR = 64
"""Bytes in a vector: the widest that processors have; narrower ones take it in parts."""
ROWS = 4
SLIM_ROWS = 8
VECTORS = 4 if binding.get_host_cpu_features().get("avx512f") else 1
"""Size of a tile; its bits do not depend on it."""


class At(NamedTuple):
    """Where the matrices of a product stand in their arrays.

    Attributes:
        c: Index of the first element of c.
        c_row: Distance of its rows.
        a: Index of the first element of a.
        a_row: Distance of its rows.
        a_k: Distance of its columns: a may be read transposed.
        b: Index of the first element of b.
        b_row: Distance of its rows.
        depth: Length of every sum, 1 or more.
        biased: 1 if sums start at the row of b below its last (a bias), 0 if at zero.
    """

    c: int
    c_row: int
    a: int
    a_row: int
    a_k: int
    b: int
    b_row: int
    depth: int
    biased: int


def padded(units: int, itemsize: int) -> int:
    """`units` rounded up to whole vectors; rows of 1 KiB multiples would share cache sets."""
    lanes = VECTOR // itemsize
    wide = -(-units // lanes) * lanes
    return wide + lanes if wide * itemsize % 1024 == 0 else wide


def aligned(size: int, dtype: Any) -> np.ndarray[Any, Any]:
    """Zeros (size,) whose first element begins a vector."""
    bytes_needed = size * np.dtype(dtype).itemsize
    raw = np.zeros(bytes_needed + VECTOR, np.uint8)
    first = -raw.ctypes.data % VECTOR
    return raw[first : first + bytes_needed].view(dtype)


def _tile(rows: int, vectors: int) -> Callable[..., Any]:
    """A function (c, a, b, at) that computes `rows` x `vectors` of c in registers."""
    if JIT_DISABLED:
        return _plain_tile(rows, vectors)

    def typed(context: Any, c: Any, a: Any, b: Any, at: Any) -> Any:
        def build(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            pointers = [
                context.make_array(kind)(context, builder, array).data
                for kind, array in zip(signature.args[:3], args[:3], strict=True)
            ]
            where = At(*cgutils.unpack_tuple(builder, args[3], len(At._fields)))
            _Emitter(builder, c.dtype.bitwidth, pointers, where).emit(rows, vectors)
            return context.get_dummy_value()

        return types.void(c, a, b, at), build

    typed.__name__ = f"tile_{rows}x{vectors}"
    return intrinsic(typed)


class _Emitter:
    """Writes the LLVM instructions of one tile.

    Args:
        builder: Where they go.
        bits: Bits of a number, 32 or 64.
        pointers: Data of c, a, b.
        at: `At`, as LLVM values.
    """

    def __init__(self, builder: Any, bits: int, pointers: list[Any], at: Any) -> None:
        self._builder = builder
        self._c, self._a, self._b = pointers
        self._at = at
        self._lanes = VECTOR * 8 // bits
        self._bytes = bits // 8
        self._vector = ir.VectorType(ir.FloatType() if bits == 32 else ir.DoubleType(), self._lanes)
        self._fma = cgutils.get_or_insert_function(
            builder.module,
            ir.FunctionType(self._vector, [self._vector] * 3),
            f"llvm.fma.v{self._lanes}f{bits}",
        )

    def emit(self, rows: int, vectors: int) -> None:
        """Start every sum, add a row of b after the other, store."""
        builder, at = self._builder, self._at
        tile = [(r, v) for r in range(rows) for v in range(vectors)]
        sums = {rv: cgutils.alloca_once(builder, self._vector) for rv in tile}
        starts = [self._start(v) for v in range(vectors)]
        for r, v in tile:
            builder.store(starts[v], sums[r, v])
        with cgutils.for_range(builder, at.depth) as loop:
            lines = [self._load(self._row_of_b(loop.index, v)) for v in range(vectors)]
            for r in range(rows):
                factor = self._factor(r, loop.index)
                for v in range(vectors):
                    total = builder.load(sums[r, v])
                    builder.store(builder.call(self._fma, [factor, lines[v], total]), sums[r, v])
        for r, v in tile:
            place = self._offset(at.c, (at.c_row, r), v)
            builder.store(builder.load(sums[r, v]), self._pointer(self._c, place), self._bytes)

    def _start(self, v: int) -> Any:
        """The bias row, or zero; row 0 is loaded in its place, for a row must be there."""
        builder, at = self._builder, self._at
        biased = builder.icmp_signed("!=", at.biased, ir.Constant(at.biased.type, 0))
        row = builder.select(biased, at.depth, ir.Constant(at.depth.type, 0))
        bias = self._load(self._row_of_b(row, v))
        zero = ir.Constant(self._vector, [0.0] * self._lanes)
        return builder.select(biased, bias, zero)

    def _row_of_b(self, k: Any, v: int) -> Any:
        at = self._at
        return self._pointer(self._b, self._offset(at.b, (at.b_row, k), v))

    def _factor(self, r: int, k: Any) -> Any:
        """a[r, k] in every lane."""
        builder, at = self._builder, self._at
        place = builder.add(self._offset(at.a, (at.a_row, r), 0), builder.mul(at.a_k, k))
        number = builder.load(builder.gep(self._a, [place]))
        nothing = ir.Constant(self._vector, ir.Undefined)
        first = builder.insert_element(nothing, number, ir.Constant(ir.IntType(32), 0))
        lanes = ir.Constant(ir.VectorType(ir.IntType(32), self._lanes), [0] * self._lanes)
        return builder.shuffle_vector(first, nothing, lanes)

    def _offset(self, start: Any, step: tuple[Any, Any], v: int) -> Any:
        """Start + distance * count + v vectors."""
        builder, (distance, count) = self._builder, step
        count = ir.Constant(distance.type, count) if isinstance(count, int) else count
        row = builder.add(start, builder.mul(distance, count))
        return builder.add(row, ir.Constant(distance.type, v * self._lanes))

    def _pointer(self, data: Any, place: Any) -> Any:
        spot = self._builder.gep(data, [place])
        return self._builder.bitcast(spot, self._vector.as_pointer())

    def _load(self, pointer: Any) -> Any:
        return self._builder.load(pointer, align=self._bytes)


def _plain_tile(rows: int, vectors: int) -> Callable[..., None]:
    """The same in plain Python, for tests without the compiler."""

    def tile(c: Any, a: Any, b: Any, at: At) -> None:
        for r in range(rows):
            for j in range(vectors * VECTOR // c.itemsize):
                total = b[at.b + at.depth * at.b_row + j] if at.biased else c.dtype.type(0)
                for k in range(at.depth):
                    left = a[at.a + r * at.a_row + k * at.a_k]
                    total = fma(left, b[at.b + k * at.b_row + j], total)
                c[at.c + r * at.c_row + j] = total

    return tile


_wide_tile, _wide_row = _tile(ROWS, VECTORS), _tile(1, VECTORS)
_slim_tile, _slim_row = _tile(SLIM_ROWS, 1), _tile(1, 1)


@kernel(inline=True)
def _moved(at: At, row: int, column: int) -> At:
    """`at`, for the part of c that begins at (row, column)."""
    return At(
        at.c + row * at.c_row + column, at.c_row, at.a + row * at.a_row, at.a_row, at.a_k,
        at.b + column, at.b_row, at.depth, at.biased,
    )  # fmt: skip


@kernel()
def product(c: Any, a: Any, b: Any, at: At, rows: int, columns: int) -> None:
    """Write c (rows, columns) = start + a (rows, depth) b (depth, columns).

    Args:
        c: Array that holds the result.
        a: Array that holds the left factor.
        b: Array that holds the right factor, and below it the bias row if there is one.
        at: Where they stand.
        rows: Rows of c.
        columns: Columns of c: whole vectors.
    """
    lanes = VECTOR // c.itemsize
    _touch(c, a, b, at, rows, columns)
    slim = columns - columns % (VECTORS * lanes)
    for j in range(0, slim, VECTORS * lanes):
        for row in range(0, rows - ROWS + 1, ROWS):
            _wide_tile(c, a, b, _moved(at, row, j))
        for row in range(rows - rows % ROWS, rows):
            _wide_row(c, a, b, _moved(at, row, j))
    for j in range(slim, columns, lanes):
        for row in range(0, rows - SLIM_ROWS + 1, SLIM_ROWS):
            _slim_tile(c, a, b, _moved(at, row, j))
        for row in range(rows - rows % SLIM_ROWS, rows):
            _slim_row(c, a, b, _moved(at, row, j))


@kernel(inline=True)
def _touch(c: Any, a: Any, b: Any, at: At, rows: int, columns: int) -> Any:
    """Read the last element of each matrix: tiles are not bounds-checked, this is."""
    last = at.depth - 1
    return (
        c[at.c + (rows - 1) * at.c_row + columns - 1]
        + a[at.a + (rows - 1) * at.a_row + last * at.a_k]
        + b[at.b + (last + at.biased) * at.b_row + columns - 1]
    )
