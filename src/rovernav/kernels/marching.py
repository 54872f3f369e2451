"""Cost to go over open ground: the eikonal equation |grad u| = f, solved slice by slice.

Fast marching (Sethian 1996) with an untidy queue (Yatziv, Bartesaghi and Sapiro 2006): cells of one
slice of cost are taken in any order, and a cell whose cost falls is taken again. To first order the
result is the one solution of the upwind scheme, whatever the order. The second-order differences of
Sethian (1999) are used where both cells upwind are surely settled and rise towards the cell.

Symbols: f cost of crossing a cell (inf where blocked), u cost from the seeds, a and b the smaller
neighbours along the rows and along the columns. Grids are flat, with a ring of two blocked cells
around: neighbours need no bounds. Lengths are in cells.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ._jit import kernel
from .buckets import Queue, clear, is_empty, pop, push

FULL = -1
"""What `march` returns when its queue has no room left: begin anew with a larger one."""

RING = 2
"""Blocked cells around a grid."""


class March(NamedTuple):
    """How to march.

    Attributes:
        stride: Cells from one row to the next, the ring included.
        slice: Cost that one slice of the queue spans.
        goal: Where to stop, or -1 to go everywhere.
        beyond: How far beyond the cost of the goal to go on, as a share of it.
        second: Whether to use second-order differences.
        limit: Cells are left out whose cost plus `rest` exceeds this.
    """

    stride: int
    slice: float
    goal: int
    beyond: float
    second: bool
    limit: float


@kernel()
def march(f: Any, u: Any, seeds: Any, q: Queue, m: March, rest: Any) -> int:
    """Lower `u` to the cost from the seeds.

    With a goal it ends as soon as u[goal] is sure; other cells then hold upper bounds.

    Args:
        f: Cost of crossing a cell, float32, > 0, inf where blocked; flat, with its ring.
        u: Costs of the seeds, inf elsewhere, float32; changed.
        seeds: Cells to begin with.
        q: A queue; its ring spans more than the largest step.
        m: How to march.
        rest: What is known to come on top of `u`, like `u` itself; or empty. Where it is inf and
            the limit is not, `u` stays as it is.

    Returns:
        Number of cells taken out of the queue, or FULL.
    """
    stride, inverse = m.stride, 1.0 / m.slice
    now = _begin(u, seeds, q, inverse)
    if now == FULL:
        return FULL
    taken = 0
    while not is_empty(q) and now * m.slice <= _end(u, m):
        cell = pop(q, now)
        if cell < 0:
            now += 1
            continue
        here = np.float64(u[cell])
        if int(here * inverse) != now:
            continue  # it was lowered meanwhile, and taken from an earlier slice
        taken += 1
        for k in range(4):
            step = stride if k & 2 else 1
            other = cell - step if k & 1 else cell + step
            old = np.float64(u[other])
            if old > here and f[other] < np.inf:
                if m.second:
                    new = _second(u, other, stride, f[other], (now + 1) * m.slice)
                else:
                    new = _first(u, cell, other, 1 if k & 2 else stride, f[other])
                new = np.float64(np.float32(new))
                if new < old and new + _at(rest, other) <= m.limit:
                    u[other] = new
                    then = int(new * inverse)
                    waits = then != now and old < np.inf and then == int(old * inverse)
                    if not waits and not push(q, then, other):
                        return FULL
    return taken


@kernel()
def _begin(u: Any, seeds: Any, q: Queue, inverse: float) -> int:
    """Put the seeds into the queue; returns the first slice, or FULL."""
    clear(q)
    first = 2**62
    for k in range(seeds.size):
        then = int(u[seeds[k]] * inverse)
        first = min(first, then)
        if not push(q, then, seeds[k]):
            return FULL
    return first


@kernel(inline=True)
def _end(u: Any, m: March) -> float:
    """The cost beyond which nothing is asked for."""
    return (1.0 + m.beyond) * u[m.goal] if m.goal >= 0 else np.inf


@kernel(inline=True)
def _at(rest: Any, cell: int) -> float:
    return np.float64(rest[cell]) if rest.size > 0 else 0.0


@kernel(inline=True)
def _first(u: Any, cell: int, other: int, across: int, cost: float) -> float:
    """Godunov's upwind value of `other`, to first order, once its neighbour `cell` has a value."""
    f = np.float64(cost)
    a = min(np.float64(u[cell]), np.float64(u[other + (other - cell)]))
    b = np.float64(min(u[other - across], u[other + across]))
    gap = a - b
    if abs(gap) >= f or not abs(gap) < np.inf:
        return min(a, b) + f
    return 0.5 * (a + b + np.sqrt(2.0 * f * f - gap * gap))


@kernel(inline=True)
def _axis(u: Any, cell: int, step: int, settled: float) -> tuple[float, float]:
    """Upwind value t and weight w of one axis: (w (u - t))^2 is its share of f^2."""
    near, far = np.float64(u[cell - step]), np.float64(u[cell - 2 * step])
    other = np.float64(u[cell + step])
    if other < near:
        near, far = other, np.float64(u[cell + 2 * step])
    if far <= near and near < settled:
        return (4.0 * near - far) / 3.0, 1.5
    return near, 1.0


@kernel(inline=True)
def _second(u: Any, cell: int, stride: int, cost: float, settled: float) -> float:
    """Upwind value of one cell, to second order where that is possible."""
    f = np.float64(cost)
    a, p = _axis(u, cell, 1, settled)
    b, r = _axis(u, cell, stride, settled)
    alone = min(a + f / p, b + f / r)
    if not (a < np.inf and b < np.inf):
        return alone
    p, r = p * p, r * r
    # p (u - a)^2 + r (u - b)^2 = f^2, the larger root
    mean, gap = (p * a + r * b) / (p + r), a - b
    under = f * f / (p + r) - p * r * gap * gap / ((p + r) * (p + r))
    if under < 0.0:
        return alone
    both = mean + np.sqrt(under)
    return both if both >= max(a, b) else alone
