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
NARROW_ROWS = 16
"""Rows of a tile half a vector wide: for layers of few units, which would be padding mostly."""
ZERO, BIAS, ON = 0, 1, 2
"""Where sums start: at zero, at a bias row, or at what c holds (a sum that goes on)."""


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
        start: Where sums start: ZERO, ON, or BIAS, the row of b below its last.
    """

    c: int
    c_row: int
    a: int
    a_row: int
    a_k: int
    b: int
    b_row: int
    depth: int
    start: int


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


def _tile(rows: int, vectors: int, width: int = VECTOR) -> Callable[..., Any]:
    """A function (c, a, b, at) that computes `rows` x `vectors` of c in registers.

    Args:
        rows: Rows of the tile.
        vectors: Vectors in each row.
        width: Bytes of a vector.
    """
    if JIT_DISABLED:
        return _plain_tile(rows, vectors * width)

    def typed(context: Any, c: Any, a: Any, b: Any, at: Any) -> Any:
        def build(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            c_data, a_data, b_data = (
                context.make_array(kind)(context, builder, array).data
                for kind, array in zip(signature.args[:3], args[:3], strict=True)
            )
            where = At(*cgutils.unpack_tuple(builder, args[3], len(At._fields)))
            lanes = width * 8 // c.dtype.bitwidth
            tile = _Emitter(builder.module, c.dtype.bitwidth, lanes).function(rows, vectors)
            begins = (
                builder.gep(c_data, [where.c]), builder.gep(a_data, [where.a]),
                builder.gep(b_data, [where.b]),
            )  # fmt: skip
            steps = (where.c_row, where.a_row, where.a_k, where.b_row, where.depth, where.start)
            builder.call(tile, (*begins, *steps))
            return context.get_dummy_value()

        return types.void(c, a, b, at), build

    typed.__name__ = f"tile_{rows}x{vectors}x{width}"
    return intrinsic(typed)


class _Emitter:
    """Writes the LLVM function of a tile.

    Args:
        module: Where it goes.
        bits: Bits of a number, 32 or 64.
        lanes: Numbers in a vector.
    """

    def __init__(self, module: Any, bits: int, lanes: int) -> None:
        self._module, self._lanes, self._bytes = module, lanes, bits // 8
        self._number = ir.FloatType() if bits == 32 else ir.DoubleType()
        self._vector = ir.VectorType(self._number, lanes)
        self._fma = cgutils.get_or_insert_function(
            module,
            ir.FunctionType(self._vector, [self._vector] * 3),
            f"llvm.fma.v{lanes}f{bits}",
        )

    def function(self, rows: int, vectors: int) -> Any:
        """The function (c, a, b, c_row, a_row, a_k, b_row, depth, start) of this module.

        One of its own, not inlined: among many tiles the compiler runs out of registers.
        """
        name = f"rovernav_tile_{rows}x{vectors}x{self._vector}".replace(" ", "")
        if name in self._module.globals:
            return self._module.globals[name]
        data, index = self._number.as_pointer(), ir.IntType(64)
        kind = ir.FunctionType(ir.VoidType(), [data] * 3 + [index] * 6)
        function = ir.Function(self._module, kind, name)
        function.linkage = "internal"
        function.attributes.add("noinline")
        self._builder = ir.IRBuilder(function.append_basic_block("entry"))
        self._c, self._a, self._b = function.args[:3]
        self._c_row, self._a_row, self._a_k, self._b_row, self._depth, self._start = function.args[
            3:
        ]
        self._emit(rows, vectors)
        self._builder.ret_void()
        return function

    def _emit(self, rows: int, vectors: int) -> None:
        """Start every sum, add a row of b after the other, store."""
        builder = self._builder
        tile = [(r, v) for r in range(rows) for v in range(vectors)]
        sums = {rv: cgutils.alloca_once(builder, self._vector) for rv in tile}
        self._begin(sums)
        a, b = (cgutils.alloca_once_value(builder, start) for start in (self._a, self._b))
        with cgutils.for_range(builder, self._depth):
            left, right = builder.load(a), builder.load(b)
            lines = [self._load(self._moved(right, v * self._lanes)) for v in range(vectors)]
            for r in range(rows):
                factor = self._factor(self._moved(left, r, self._a_row))
                for v in range(vectors):
                    total = builder.load(sums[r, v])
                    builder.store(builder.call(self._fma, [factor, lines[v], total]), sums[r, v])
            builder.store(builder.gep(left, [self._a_k]), a)
            builder.store(builder.gep(right, [self._b_row]), b)
        for (r, v), total in sums.items():
            builder.store(builder.load(total), self._pointer(self._place(r, v)), self._bytes)

    def _begin(self, sums: dict[tuple[int, int], Any]) -> None:
        """Store where every sum starts."""
        builder, start = self._builder, self._start
        is_bias, goes_on = (builder.icmp_signed("==", start, start.type(k)) for k in (BIAS, ON))
        with builder.if_else(goes_on) as (on, new):
            with on:
                for (r, v), total in sums.items():
                    builder.store(self._load(self._place(r, v)), total)
            with new:
                zero = ir.Constant(self._vector, [0.0] * self._lanes)
                depth = builder.select(is_bias, self._depth, start.type(0))  # a row is there
                row = self._moved(self._b, depth, self._b_row)
                for (_, v), total in sums.items():
                    bias = self._load(self._moved(row, v * self._lanes))
                    builder.store(builder.select(is_bias, bias, zero), total)

    def _place(self, r: int, v: int) -> Any:
        return self._moved(self._moved(self._c, r, self._c_row), v * self._lanes)

    def _moved(self, data: Any, count: Any, distance: Any = None) -> Any:
        """`count` numbers, or that many times `distance`, further."""
        count = ir.IntType(64)(count) if isinstance(count, int) else count
        return self._builder.gep(
            data, [count if distance is None else self._builder.mul(count, distance)]
        )

    def _factor(self, place: Any) -> Any:
        """The number there, in every lane."""
        builder = self._builder
        nothing = ir.Constant(self._vector, ir.Undefined)
        first = builder.insert_element(nothing, builder.load(place), ir.Constant(ir.IntType(32), 0))
        lanes = ir.Constant(ir.VectorType(ir.IntType(32), self._lanes), [0] * self._lanes)
        return builder.shuffle_vector(first, nothing, lanes)

    def _pointer(self, place: Any) -> Any:
        return self._builder.bitcast(place, self._vector.as_pointer())

    def _load(self, place: Any) -> Any:
        return self._builder.load(self._pointer(place), align=self._bytes)


def _plain_tile(rows: int, width: int) -> Callable[..., None]:
    """The same in plain Python, for tests without the compiler; `width` is in bytes."""

    def tile(c: Any, a: Any, b: Any, at: At) -> None:
        for r in range(rows):
            for j in range(width // c.itemsize):
                place = at.c + r * at.c_row + j
                bias = b[at.b + at.depth * at.b_row + j] if at.start == BIAS else c.dtype.type(0)
                total = c[place] if at.start == ON else bias
                for k in range(at.depth):
                    left = a[at.a + r * at.a_row + k * at.a_k]
                    total = fma(left, b[at.b + k * at.b_row + j], total)
                c[place] = total

    return tile


_wide_tile, _wide_row = _tile(ROWS, VECTORS), _tile(1, VECTORS)
_slim_tile, _slim_row = _tile(SLIM_ROWS, 1), _tile(1, 1)
_narrow_tile, _narrow_row = _tile(NARROW_ROWS, 1, VECTOR // 2), _tile(1, 1, VECTOR // 2)


@kernel(inline=True)
def _moved(at: At, row: int, column: int) -> At:
    """`at`, for the part of c that begins at (row, column)."""
    return At(
        at.c + row * at.c_row + column, at.c_row, at.a + row * at.a_row, at.a_row, at.a_k,
        at.b + column, at.b_row, at.depth, at.start,
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
        columns: Columns of c; those up to the next half vector are computed too.
    """
    lanes = VECTOR // c.itemsize
    columns += -columns % (lanes // 2)
    _touch(c, a, b, at, rows, columns)
    slim = columns - columns % (VECTORS * lanes)
    narrow = columns - columns % lanes
    for j in range(0, slim, VECTORS * lanes):
        for row in range(0, rows - ROWS + 1, ROWS):
            _wide_tile(c, a, b, _moved(at, row, j))
        for row in range(rows - rows % ROWS, rows):
            _wide_row(c, a, b, _moved(at, row, j))
    for j in range(slim, narrow, lanes):
        for row in range(0, rows - SLIM_ROWS + 1, SLIM_ROWS):
            _slim_tile(c, a, b, _moved(at, row, j))
        for row in range(rows - rows % SLIM_ROWS, rows):
            _slim_row(c, a, b, _moved(at, row, j))
    if narrow < columns:
        for row in range(0, rows - NARROW_ROWS + 1, NARROW_ROWS):
            _narrow_tile(c, a, b, _moved(at, row, narrow))
        for row in range(rows - rows % NARROW_ROWS, rows):
            _narrow_row(c, a, b, _moved(at, row, narrow))


@kernel(inline=True)
def _touch(c: Any, a: Any, b: Any, at: At, rows: int, columns: int) -> Any:
    """Read the last element of each matrix: tiles are not bounds-checked, this is."""
    last = at.depth - 1
    return (
        c[at.c + (rows - 1) * at.c_row + columns - 1]
        + a[at.a + (rows - 1) * at.a_row + last * at.a_k]
        + b[at.b + (last + (at.start == BIAS)) * at.b_row + columns - 1]
    )
