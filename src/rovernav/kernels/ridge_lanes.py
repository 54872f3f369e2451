"""Beams over heights marched through a table of highest ground together, in lanes of a vector.

`march` is one loop on vectors, written for the compiler's own language, because no optimiser makes
a gather of table entries out of a loop; see `ray_lanes`. Under NUMBA_DISABLE_JIT it is the same
loop, beam by beam, in plain Python.

An entry of the coarse table tells how high the ground is at most in three windows that begin at a
block of `BLOCK` x `BLOCK` patches and are `LEAPS` blocks long: the low 16 bits for the first, then
8 bits each for how much higher it is in the second and in the third, as s 2^e with s in the low
half and e in the high one. One of the fine table tells it of two patches side by side, across the
columns of beams that run along x or, in a second part, along y. All count grains.

Symbols: m columns gone so far, z height of the beam [grains].
"""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from ._jit import JIT_DISABLED

LANES = 32
"""Beams in a vector."""
BLOCK, LEAPS = 2, (1, 3, 8)
"""Patches on a side of a block; blocks that the windows of an entry are long."""
SLOPE, LOW, CORNER, LAST_ROW, COLUMN, TURN, QUARTER, UP, LAST, GONE, MET, BEAM = range(12)
"""Rows of a state: how much a beam rises across its columns in each of these, and the place where
it enters the first one, in parts of a row and counted from the row there; that row; the last row;
the first column, and the step to the next; the quadrant it goes to; all bits where the main axis is
y, else 0; the last column and the columns gone; at the end, whether the ground may be too high (all
bits) or not (0); and which beam it is."""
STATE = 12
Z, RISE, DROP = range(3)
"""Rows of heights: of the beam where it enters its first column; what it rises in each column; and
the same where it sinks, else 0."""
HEIGHTS = 3
COARSE, FINE, ACROSS, QUADRANT, WIDE, PART, BITS, FEW = range(8)
"""What all beams have in common: where the coarse table and the fine one of their grid begin,
blocks in a row, entries of a quadrant, entries in a row and in a part of the fine one; parts of a
row are 2^-`BITS`; and how many beams are too few to go on."""
COMMON = 8
_WORD, _REAL, _HALF = ir.IntType(32), ir.FloatType(), ir.IntType(16)
_WORDS, _REALS = ir.VectorType(_WORD, LANES), ir.VectorType(_REAL, LANES)
_POINTERS = ir.VectorType(_WORD.as_pointer(), LANES)
_MASK = ir.VectorType(ir.IntType(1), LANES)


def _all(number: int) -> Any:
    return ir.Constant(_WORDS, [number] * LANES)


def _typed(
    _context: Any, coarse: Any, fine: Any, common: Any, state: Any, heights: Any, at: Any
) -> Any:
    """March `LANES` beams from column `at` of a state until no more than a few still go on."""

    def build(context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        blocks, patches, numbers, rows, reals, first = args
        data = context.make_array(common)(context, builder, numbers).data
        known = [builder.load(builder.gep(data, [first.type(row)])) for row in range(COMMON)]
        tables = []
        for kind, array, row in ((coarse, blocks, COARSE), (fine, patches, FINE)):
            entries = context.make_array(kind)(context, builder, array).data
            tables.append(builder.gep(entries, [known[row]]))

        def places(kind: Any, array: Any, vector: Any) -> Any:
            numbers = context.make_array(kind)(context, builder, array)
            width = builder.extract_value(numbers.shape, 1)

            def place(row: int) -> Any:
                offset = builder.add(builder.mul(width, width.type(row)), first)
                return builder.bitcast(builder.gep(numbers.data, [offset]), vector.as_pointer())

            return place

        place, real = places(state, rows, _WORDS), places(heights, reals, _REALS)
        beam = [builder.load(place(row), align=4) for row in range(GONE + 1)]
        z = [builder.load(real(row), align=4) for row in range(HEIGHTS)]
        plan = [_spread(builder, builder.trunc(number, _WORD)) for number in known]
        few = builder.trunc(known[FEW], _WORD)
        gone, met = _loop(builder, tables, beam, z, plan, few)
        for kept, row in ((gone, GONE), (met, MET)):
            builder.store(kept, place(row), align=4)
        return context.get_dummy_value()

    return types.void(coarse, fine, common, state, heights, types.int64), build


def _spread(builder: Any, number: Any) -> Any:
    first = builder.insert_element(ir.Constant(_WORDS, ir.Undefined), number, _WORD(0))
    return builder.shuffle_vector(first, first, ir.Constant(_WORDS, [0] * LANES))


def _pick(builder: Any, order: str, a: Any, b: Any) -> Any:
    return builder.select(builder.icmp_signed(order, a, b), a, b)


def _loop(
    builder: Any, tables: list[Any], beam: list[Any], z: list[Any], plan: list[Any], few: Any
) -> tuple[Any, Any]:
    """Columns gone, and whether the ground may be too high, once few beams are alive."""
    up = builder.icmp_signed("!=", beam[UP], _all(0))
    quarter = builder.mul(beam[QUARTER], plan[QUADRANT])
    part = builder.and_(beam[UP], plan[PART])
    down, back = (builder.ashr(beam[row], _all(31)) for row in (SLOPE, TURN))
    before = builder.block
    loop, after = builder.append_basic_block("march"), builder.append_basic_block("marched")
    alive_first = builder.icmp_signed("<=", beam[GONE], beam[LAST])
    builder.branch(loop)
    builder.position_at_end(loop)
    gone, alive, met = builder.phi(_WORDS), builder.phi(_MASK), builder.phi(_WORDS)
    gone.add_incoming(beam[GONE], before)
    alive.add_incoming(alive_first, before)
    met.add_incoming(_all(0), before)
    low = builder.add(beam[LOW], builder.mul(gone, beam[SLOPE]))
    row = builder.add(builder.ashr(low, plan[BITS]), beam[CORNER])
    column = builder.add(beam[COLUMN], builder.mul(gone, beam[TURN]))
    here = builder.fadd(z[Z], builder.fmul(builder.sitofp(gone, _REALS), z[RISE]))

    def held(row: Any) -> Any:
        return _pick(builder, ">", _pick(builder, "<", row, beam[LAST_ROW]), _all(0))

    half = _all(BLOCK.bit_length() - 1)
    i, j = builder.ashr(held(row), half), builder.ashr(column, half)
    found = _entries(builder, tables[0], up, (i, j, plan[ACROSS], quarter), alive)
    leap = _leap(builder, here, z[DROP], found)
    # a block that was entered before counts from where it begins
    into = builder.and_(builder.xor(column, back), _all(BLOCK - 1))
    some = builder.icmp_signed("!=", leap, _all(0))
    low_ground = builder.and_(alive, builder.not_(some))
    nearest = (held(builder.add(row, down)), column, plan[WIDE], part)
    found = builder.and_(_entries(builder, tables[1], up, nearest, low_ground), _all(0xFFFF))
    one = builder.select(_above(builder, here, z[DROP], 1, found), _all(1), _all(0))
    leap = builder.select(some, builder.sub(leap, into), one)
    some = builder.icmp_signed("!=", leap, _all(0))
    further = builder.add(gone, builder.select(alive, leap, _all(0)))
    met_now = builder.or_(met, builder.sext(builder.and_(alive, builder.not_(some)), _WORDS))
    goes_on = builder.and_(
        builder.and_(alive, some), builder.icmp_signed("<=", further, beam[LAST])
    )
    gone.add_incoming(further, loop)
    alive.add_incoming(goes_on, loop)
    met.add_incoming(met_now, loop)
    left = builder.ctpop(builder.bitcast(goes_on, ir.IntType(LANES)))
    builder.cbranch(builder.icmp_unsigned(">", left, few), loop, after)
    builder.position_at_end(after)
    return further, met_now


def _leap(builder: Any, here: Any, drop: Any, found: Any) -> Any:
    """Columns of the longest window of an entry that a beam stays above; 0 if of none."""
    top, leap = builder.and_(found, _all(0xFFFF)), _all(0)
    for number, blocks in enumerate(LEAPS):
        high = top
        if number:
            code = builder.lshr(found, _all(8 + 8 * number))
            by_two = builder.and_(builder.lshr(code, _all(4)), _all(15))
            high = builder.add(top, builder.shl(builder.and_(code, _all(15)), by_two))
        above = _above(builder, here, drop, BLOCK * blocks, high)
        leap = builder.select(above, _all(BLOCK * blocks), leap)
    return leap


def _above(builder: Any, here: Any, drop: Any, columns: int, high: Any) -> Any:
    """Whether a beam stays above a height for so many columns."""
    sunk = builder.fmul(drop, ir.Constant(_REALS, [float(columns)] * LANES))
    return builder.fcmp_ordered(">", builder.fadd(here, sunk), builder.sitofp(high, _REALS))


def _entries(builder: Any, table: Any, up: Any, where: Any, alive: Any) -> Any:
    """Words from the entries of a table at rows and columns on; 0 where a beam is not alive."""
    row, column, wide, first = where
    i, j = builder.select(up, column, row), builder.select(up, row, column)
    index = builder.add(first, builder.add(builder.mul(i, wide), j))
    half = table.type.pointee == _HALF
    places = _Places(builder.block, table, index)
    builder._insert(places)
    places = builder.bitcast(places, _POINTERS)
    typed = ir.FunctionType(_WORDS, [_POINTERS, _WORD, _MASK, _WORDS])
    name = f"llvm.masked.gather.v{LANES}i32.v{LANES}{_WORD.as_pointer().intrinsic_name}"
    gather = builder.module.globals.get(name) or ir.Function(builder.module, typed, name)
    return builder.call(gather, [places, _WORD(2 if half else 4), alive, _all(0)])


class _Places(ir.Instruction):
    """The places of entries counted from one; the builder only knows one offset."""

    def __init__(self, block: Any, data: Any, index: Any) -> None:
        kind = ir.VectorType(data.type, LANES)
        super().__init__(block, kind, "getelementptr", [data, index])

    def descr(self, buf: list[str]) -> None:
        """Write the instruction."""
        data, index = self.operands
        parts = ", ".join(f"{part.type} {part.get_reference()}" for part in (data, index))
        buf.append(f"getelementptr {data.type.pointee}, {parts}\n")


def plain_march(coarse: Any, fine: Any, common: Any, state: Any, heights: Any, at: int) -> None:
    """The same, all lanes at once in NumPy."""
    beam, z = state[:, at : at + LANES], heights[:, at : at + LANES]
    blocks, patches = coarse.reshape(-1)[common[COARSE] :], fine.reshape(-1)[common[FINE] :]
    alive, up, on = beam[GONE] <= beam[LAST], beam[UP] != 0, beam[TURN] > 0
    part, beam[MET] = np.where(up, common[PART], 0), 0

    def entries(table: Any, row: Any, column: Any, wide: int, first: Any) -> Any:
        index = first + np.where(up, column * wide + row, row * wide + column)
        return np.where(alive, table[np.where(alive, index, 0)], 0).astype(np.int64)

    def above(columns: int, high: Any) -> Any:
        return here + z[DROP] * np.float32(columns) > high.astype(np.float32)

    while True:
        row = ((beam[LOW] + beam[GONE] * beam[SLOPE]) >> common[BITS]) + beam[CORNER]
        column = beam[COLUMN] + beam[GONE] * beam[TURN]
        here = z[Z] + beam[GONE].astype(np.float32) * z[RISE]
        held = np.maximum(np.minimum(row, beam[LAST_ROW]), 0)
        quarter = beam[QUARTER] * common[QUADRANT]
        found = entries(blocks, held // BLOCK, column // BLOCK, common[ACROSS], quarter)
        top, leap = found & 0xFFFF, np.zeros(LANES, np.int64)
        for number, count in enumerate(LEAPS):
            code = (found >> (8 + 8 * number)) & 255 if number else np.zeros_like(found)
            leap[above(BLOCK * count, top + ((code & 15) << (code >> 4)))] = BLOCK * count
        into = np.where(on, column % BLOCK, BLOCK - 1 - column % BLOCK)
        below = np.maximum(np.minimum(row + np.where(beam[SLOPE] < 0, -1, 0), beam[LAST_ROW]), 0)
        near = above(1, entries(patches, below, column, common[WIDE], part)).astype(np.int64)
        leap = np.where(leap > 0, leap - into, near)
        beam[MET] |= np.where(alive & (leap == 0), -1, 0).astype(np.int32)
        beam[GONE] += np.where(alive, leap, 0).astype(np.int32)
        alive = alive & (leap > 0) & (beam[GONE] <= beam[LAST])
        if alive.sum() <= common[FEW]:
            return


march: Any = plain_march if JIT_DISABLED else intrinsic(_typed)
"""March `LANES` beams of a state until no more than a few of them still go on."""
