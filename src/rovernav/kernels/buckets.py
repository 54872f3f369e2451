"""A bucket queue: cells by the slice of cost that they lie in, in no order within a slice.

A search that takes cells slice by slice, and takes a cell again whenever its cost falls, ends with
the same costs as one that takes them one by one. Where a slice is no wider than the smallest step,
no cell is ever taken twice (Dial 1969; Denardo and Fox 1979): a heap without the heap.

A slice is a chain of chunks out of one pool, which is allocated up front and given back chunk by
chunk: re-assigning a growing array inside a kernel costs five times the search. Slices lie in a
ring, so there must be more of them than the largest step spans.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ._jit import kernel

CHUNK = 32
"""Items in a chunk: two cache lines."""


class Queue(NamedTuple):
    """A ring of slices over a pool of chunks.

    Attributes:
        pool: Items, `CHUNK` to a chunk, int32.
        link: For each chunk the next one of its slice, or of the spare ones; -1 ends, int32.
        head: For each slice its first chunk, -1 where it is empty, int32.
        fill: For each slice the items in its first chunk, int32.
        state: First spare chunk or -1; chunks never used yet; items in the queue, int64.
    """

    pool: Any
    link: Any
    head: Any
    fill: Any
    state: Any


def queue(slices: int, room: int) -> Queue:
    """An empty queue.

    Args:
        slices: Slices of the ring, at least; a power of two is taken.
        room: Items that it can surely hold.
    """
    ring = 1 << max(1, int(slices - 1).bit_length())
    chunks = room // CHUNK + min(ring, room) + 2
    return Queue(
        pool=np.empty(chunks * CHUNK, np.int32),
        link=np.empty(chunks, np.int32),
        head=np.full(ring, -1, np.int32),
        fill=np.zeros(ring, np.int32),
        state=np.array([-1, 0, 0]),
    )


@kernel(inline=True)
def clear(q: Queue) -> None:
    """Empty the queue, if a search has left something in it."""
    if q.state[2] > 0:
        q.head[:] = -1
        q.fill[:] = 0
        q.state[0] = -1
        q.state[1] = 0
        q.state[2] = 0


@kernel(inline=True)
def push(q: Queue, slice_: int, item: int) -> bool:
    """Put `item` into a slice (any whole number; the ring wraps); False where the pool is full."""
    b = slice_ & (q.head.size - 1)
    chunk, count = q.head[b], q.fill[b]
    if chunk < 0 or count == CHUNK:
        fresh = q.state[0]
        if fresh >= 0:
            q.state[0] = q.link[fresh]
        else:
            fresh = q.state[1]
            if fresh == q.link.size:
                return False
            q.state[1] = fresh + 1
        q.link[fresh] = chunk
        q.head[b] = fresh
        chunk, count = fresh, 0
    q.pool[chunk * CHUNK + count] = item
    q.fill[b] = count + 1
    q.state[2] += 1
    return True


@kernel(inline=True)
def pop(q: Queue, slice_: int) -> int:
    """Take the last item of a slice; -1 where it is empty."""
    b = slice_ & (q.head.size - 1)
    chunk = q.head[b]
    if chunk < 0:
        return -1
    count = q.fill[b] - 1
    item = q.pool[chunk * CHUNK + count]
    q.state[2] -= 1
    if count > 0:
        q.fill[b] = count
    else:
        q.head[b] = q.link[chunk]
        q.fill[b] = CHUNK
        q.link[chunk] = q.state[0]
        q.state[0] = chunk
    return item


@kernel(inline=True)
def is_empty(q: Queue) -> bool:
    """Whether no item is left in any slice."""
    return q.state[2] == 0
