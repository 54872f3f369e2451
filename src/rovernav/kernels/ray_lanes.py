"""Sixteen rays marched through a table of free distances together, in the lanes of a vector.

`march` is one loop of whole-number instructions on vectors, written for the compiler's own
language, because no optimiser makes a gather of table entries out of a loop. Under
NUMBA_DISABLE_JIT it is the same loop, ray by ray, in plain Python.

Symbols: m columns gone so far, d distance in columns that the table promises.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from ._jit import JIT_DISABLED

LANES = 32
"""Rays in a vector."""
(
    LOW,
    SLOPE,
    SPREAD,
    PLACE,
    TILES,
    COLUMN,
    ADVANCE,
    CORNER,
    LAST_ROW,
    START,
    STOP,
    LAST,
    GONE,
    ROW,
) = range(14)
"""Rows of a state: the lower side of each ray in its first column, how much it rises by column and
the height of what it touches in a column, all in parts of a row and counted from the row that the
ray begins in; where its table begins; tiles in a column of tiles, times their size; its first
column and the step to the next; the row that it begins in and the last one, as the table counts
rows; the least lower and the largest upper side, which keep it off what lies behind its begin; its
last column and the columns gone; at the end, the blocked row that was met."""
STATE = 14
TILE = 8
"""Side of a tile of the table: 64 entries, a line of the cache."""
MOST = 15
"""The largest distance of an entry: the low half is for a row, the high half for the next one."""
_WORD = ir.IntType(32)
_WORDS = ir.VectorType(_WORD, LANES)
_BYTES = ir.VectorType(ir.IntType(8).as_pointer(), LANES)
_POINTERS = ir.VectorType(_WORD.as_pointer(), LANES)
_MASK = ir.VectorType(ir.IntType(1), LANES)


def _all(number: int) -> Any:
    return ir.Constant(_WORDS, [number] * LANES)


def _typed(_context: Any, table: Any, base: Any, state: Any, at: Any, bits: Any) -> Any:
    """March 16 rays until each has met a blocked entry or gone past its last column."""

    def build(context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        entries, start, rows, first, shift = args
        data = context.make_array(table)(context, builder, entries).data
        data = builder.gep(data, [start])
        numbers = context.make_array(state)(context, builder, rows)
        width = builder.extract_value(numbers.shape, 1)

        def place(row: int) -> Any:
            offset = builder.add(builder.mul(width, width.type(row)), first)
            at_row = builder.gep(numbers.data, [offset])
            return builder.bitcast(at_row, _WORDS.as_pointer())

        ray = [builder.load(place(row), align=4) for row in range(ROW)]
        by = _spread(builder, builder.trunc(shift, _WORD))
        gone, row = _loop(builder, data, ray, by)
        for kept, where in ((gone, GONE), (row, ROW)):
            builder.store(kept, place(where), align=4)
        return context.get_dummy_value()

    return types.void(table, types.int64, state, types.int64, types.int64), build


def _spread(builder: Any, number: Any) -> Any:
    first = builder.insert_element(ir.Constant(_WORDS, ir.Undefined), number, _WORD(0))
    return builder.shuffle_vector(first, first, ir.Constant(_WORDS, [0] * LANES))


def _pick(builder: Any, order: str, a: Any, b: Any) -> Any:
    return builder.select(builder.icmp_signed(order, a, b), a, b)


def _loop(builder: Any, data: Any, ray: list[Any], by: Any) -> tuple[Any, Any]:
    """Columns gone and rows met, once no ray is alive."""
    before = builder.block
    loop, after = builder.append_basic_block("march"), builder.append_basic_block("marched")
    alive_first = builder.icmp_signed("<=", ray[GONE], ray[LAST])
    builder.branch(loop)
    builder.position_at_end(loop)
    gone, alive = builder.phi(_WORDS), builder.phi(_MASK)
    met = builder.phi(_WORDS)
    gone.add_incoming(ray[GONE], before)
    alive.add_incoming(alive_first, before)
    met.add_incoming(_all(0), before)
    low = builder.add(ray[LOW], builder.mul(gone, ray[SLOPE]))
    high = _pick(builder, "<", builder.add(low, ray[SPREAD]), ray[STOP])
    south = builder.ashr(_pick(builder, ">", low, ray[START]), by)
    north = builder.ashr(high, by)
    row_here = _pick(builder, "<", builder.add(south, ray[CORNER]), ray[LAST_ROW])
    row_here = _pick(builder, ">", row_here, _all(0))
    column = builder.add(ray[COLUMN], builder.mul(gone, ray[ADVANCE]))
    entries = _gather(builder, data, _index(builder, ray, column, row_here), alive)
    here = builder.and_(entries, _all(MOST))
    above = builder.and_(builder.lshr(entries, _all(4)), _all(MOST))
    above = builder.select(builder.icmp_signed("==", south, north), _all(MOST), above)
    free = builder.select(alive, _pick(builder, "<", here, above), _all(0))
    # of two blocked rows the one that the ray comes to first
    lower = builder.icmp_signed("==", here, _all(0))
    upper = builder.icmp_signed("==", above, _all(0))
    rising = builder.icmp_signed(">=", ray[SLOPE], _all(0))
    is_lower = builder.select(rising, lower, builder.not_(upper))
    row = builder.select(is_lower, south, north)
    met_now = builder.select(alive, row, met)
    further = builder.add(gone, free)
    goes_on = builder.and_(alive, builder.icmp_signed("!=", free, _all(0)))
    goes_on = builder.and_(goes_on, builder.icmp_signed("<=", further, ray[LAST]))
    gone.add_incoming(further, loop)
    alive.add_incoming(goes_on, loop)
    met.add_incoming(met_now, loop)
    some = builder.bitcast(goes_on, ir.IntType(LANES))
    builder.cbranch(builder.icmp_unsigned("!=", some, some.type(0)), loop, after)
    builder.position_at_end(after)
    return further, met_now


def _index(builder: Any, ray: list[Any], column: Any, row: Any) -> Any:
    """Where the entries of columns and rows are in the table: tile, column and row in it."""
    three, seven, six = _all(3), _all(TILE - 1), _all(6)
    tile = builder.mul(builder.ashr(column, three), ray[TILES])
    tile = builder.add(tile, builder.shl(builder.ashr(row, three), six))
    inside = builder.shl(builder.and_(column, seven), three)
    inside = builder.add(inside, builder.and_(row, seven))
    return builder.add(ray[PLACE], builder.add(tile, inside))


def _gather(builder: Any, data: Any, index: Any, alive: Any) -> Any:
    """Four entries of the table from each index on, as one word; 0 where a ray is not alive."""
    places = _Places(builder.block, data, index)
    builder._insert(places)
    pointers = builder.bitcast(places, _POINTERS)
    typed = ir.FunctionType(_WORDS, [_POINTERS, _WORD, _MASK, _WORDS])
    name = f"llvm.masked.gather.v{LANES}i32.v{LANES}{_WORD.as_pointer().intrinsic_name}"
    gather = builder.module.globals.get(name) or ir.Function(builder.module, typed, name)
    return builder.call(gather, [pointers, _WORD(1), alive, _all(0)])


class _Places(ir.Instruction):
    """The places at 16 offsets [bytes] from one; the builder only knows one offset."""

    def __init__(self, block: Any, data: Any, index: Any) -> None:
        super().__init__(block, _BYTES, "getelementptr", [data, index])

    def descr(self, buf: list[str]) -> None:
        """Write the instruction."""
        data, index = self.operands
        parts = ", ".join(f"{part.type} {part.get_reference()}" for part in (data, index))
        buf.append(f"getelementptr {ir.IntType(8)}, {parts}\n")


def plain_march(table: Any, base: int, state: Any, at: int, bits: int) -> None:
    """The same, ray by ray."""
    entries = table.reshape(-1)
    for k in range(at, at + LANES):
        ray = [int(number) for number in state[:, k]]
        low, slope, spread, place, tiles, column, advance, corner, final = ray[:START]
        start, stop, last, gone, _ = ray[START:]
        while gone <= last:
            here = low + gone * slope
            south, north = max(here, start) >> bits, min(here + spread, stop) >> bits
            i, j = max(0, min(final, south + corner)), column + gone * advance
            inside = (j % TILE) * TILE + i % TILE
            entry = int(entries[base + place + j // TILE * tiles + i // TILE * TILE**2 + inside])
            lower, upper = entry & MOST, MOST if south == north else entry >> 4
            if min(lower, upper) == 0:
                first_is_lower = lower == 0 if slope >= 0 else upper != 0
                state[ROW, k] = south if first_is_lower else north
                break
            gone += min(lower, upper)
        state[GONE, k] = gone


march: Any = plain_march if JIT_DISABLED else intrinsic(_typed)
