"""Workers that meet: a barrier between threads inside compiled code, and a hint to the memory.

Python's own barrier takes tens of microseconds, a whole mini-batch a hundred. Here who waits first
spins, then gives the processor away each time it looks, so more workers than processors go on too.

Why nothing is read half-written: who arrives adds to ARRIVED with acquire and release, the last
one releases a new ROUND, and who waits acquires it. So all that any worker wrote before `meet` is
seen by every worker after it (the happens-before of C++11, 31.4), and the compiler moves no read
or write across.
"""

from __future__ import annotations

import ctypes
import threading
import time
from typing import Any, NamedTuple

import numpy as np
from llvmlite import binding, ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from ._jit import JIT_DISABLED, kernel

ARRIVED, ROUND, GIVEN_UP = 0, 8, 16
"""Places on a board, each on a line of memory of its own."""
SPINS = 10_000
"""Looks before a waiting worker gives its processor away: some 10 microseconds."""
_YIELD = "rovernav_yield"
_pointer, _int = ir.IntType(8).as_pointer(), ir.IntType(32)


class Team(NamedTuple):
    """Who works, seen by one of them.

    Attributes:
        me: Number of this worker; the first is 0.
        workers: How many there are.
        board: Where they meet, from `make_board`; one for all.
    """

    me: int
    workers: int
    board: Any


def make_board() -> Any:
    """A board for workers to meet at."""
    return np.zeros(24, np.int64)


def give_up(board: Any) -> None:
    """Make everybody who waits at the board, or comes to it, go home."""
    board[GIVEN_UP] = 1


def _add_typed(context: Any, board: Any, place: Any, number: Any) -> Any:
    """The number at the place before `number` was added to it, in one piece."""

    def build(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        spot = _spot(context, builder, signature, args)
        return builder.atomic_rmw("add", spot, args[2], "acq_rel")

    return types.int64(board, types.intp, types.int64), build


def _load_typed(context: Any, board: Any, place: Any) -> Any:
    """The number at the place, and all that was written before it."""

    def build(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        spot = _spot(context, builder, signature, args)
        return builder.load_atomic(spot, "acquire", 8)

    return types.int64(board, types.intp), build


def _store_typed(context: Any, board: Any, place: Any, number: Any) -> Any:
    """Write the number, after all that was written before it."""

    def build(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        spot = _spot(context, builder, signature, args)
        builder.store_atomic(args[2], spot, "release", 8)
        return context.get_dummy_value()

    return types.void(board, types.intp, types.int64), build


def _spot(context: Any, builder: Any, signature: Any, args: Any) -> Any:
    array = context.make_array(signature.args[0])(context, builder, args[0])
    return builder.gep(array.data, [args[1]])


def _yield_typed(context: Any) -> Any:
    """Let another thread have this processor."""

    def build(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        kind = ir.FunctionType(_int, [])
        builder.call(cgutils.get_or_insert_function(builder.module, kind, _YIELD), [])
        return context.get_dummy_value()

    return types.void(), build


def _prefetch_typed(context: Any, array: Any, place: Any) -> Any:
    """Ask for the line of memory that holds the element at `place` of a flat or C-ordered array."""

    def build(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        spot = builder.bitcast(_spot(context, builder, signature, args), _pointer)
        kind = ir.FunctionType(ir.VoidType(), [_pointer, _int, _int, _int])
        ask = cgutils.get_or_insert_function(builder.module, kind, "llvm.prefetch.p0")
        builder.call(ask, [spot, _int(0), _int(2), _int(1)])  # to read, into the second cache, data
        return context.get_dummy_value()

    return types.void(array, types.intp), build


_lock = threading.Lock()


def _plain_add(board: Any, place: int, number: int) -> int:
    with _lock:
        before = int(board[place])
        board[place] = before + number
    return before


def _plain_store(board: Any, place: int, number: int) -> None:
    with _lock:
        board[place] = number


if JIT_DISABLED:
    _add: Any = _plain_add
    _load: Any = lambda board, place: int(board[place])  # noqa: E731
    _store: Any = _plain_store
    _yield: Any = lambda: time.sleep(0)  # noqa: E731
    prefetch: Any = lambda array, place: None  # noqa: E731
else:
    _add, _load, _store = intrinsic(_add_typed), intrinsic(_load_typed), intrinsic(_store_typed)
    _yield, prefetch = intrinsic(_yield_typed), intrinsic(_prefetch_typed)
    # Cached code finds the function by this name, so every process has to say where it is.
    binding.add_symbol(
        _YIELD, ctypes.cast(ctypes.CDLL(None).sched_yield, ctypes.c_void_p).value or 0
    )


@kernel()
def meet(team: Team) -> bool:
    """Wait until the whole team is here; False if somebody gave up, and then for good."""
    board = team.board
    if team.workers > 1:
        before = _load(board, ROUND)
        if _add(board, ARRIVED, 1) == team.workers - 1:
            _store(board, ARRIVED, 0)
            _store(board, ROUND, before + 1)
        looks = 0
        while _load(board, ROUND) == before:
            if _load(board, GIVEN_UP) != 0:
                return False
            looks += 1
            if looks > SPINS:
                _yield()
    return _load(board, GIVEN_UP) == 0
