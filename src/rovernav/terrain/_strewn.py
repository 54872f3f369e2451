"""Things strewn over an endless plane, of which any window can be had by itself.

The plane is cut into square tiles for each range of sizes; what lies in a tile depends on the seed
and the tile alone. So a window always holds the same things, whatever was asked for before.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ..core import F64

PER_TILE = 50.0
"""Things that a tile holds on average, where the largest of them allow it."""
MOST = 5_000_000
"""More things than this in one window are refused."""

Count = Callable[[float], float]
"""How many things of at least a size lie on a square metre."""


class Class(NamedTuple):
    """Things of a range of sizes.

    Attributes:
        smallest: Least size [m].
        largest: Greatest size [m].
        density: How many lie on a square metre.
        tile: Side of a tile [m].
    """

    smallest: float
    largest: float
    density: float
    tile: float


def size_classes(count: Count, smallest: float, largest: float) -> list[Class]:
    """The range of sizes cut into octaves, each with its tiles."""
    steps = max(1, math.ceil(math.log2(largest / smallest) - 1e-9))
    edges = np.geomspace(smallest, largest, steps + 1)
    out: list[Class] = []
    for low, high in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        density = max(0.0, count(low) - count(high))
        if density > 0.0:
            tile = max(4.0 * high, math.sqrt(PER_TILE / density))
            out.append(Class(low, high, density, tile))
    return out


def expected(classes: Sequence[Class], area: float) -> float:
    """How many things lie on an area [m^2] on average."""
    return area * sum(one.density for one in classes)


def strewn(
    classes: Sequence[Class],
    count: Count,
    window: tuple[float, float, float, float],
    *,
    reach: float,
    seed: Sequence[int],
) -> F64:
    """The things whose middle lies within `reach` sizes of a window, always in the same order.

    Args:
        classes: Sizes and tiles.
        count: The law of sizes; within a class it is drawn from by inversion.
        window: West, south, east, north [m].
        reach: How far a thing is felt, in its sizes.
        seed: Numbers of 0 or more that set all of it.

    Returns:
        (n, 4): x, y, size [m] and a random number of 0 to 1; larger classes first.
    """
    found = [np.empty((0, 4))]
    for number, one in reversed(list(enumerate(classes))):
        margin = reach * one.largest
        west, south = (math.floor((edge - margin) / one.tile) for edge in window[:2])
        east, north = (math.floor((edge + margin) / one.tile) for edge in window[2:])
        sizes, shares = _inverse(count, one)
        for i in range(south, north + 1):
            for j in range(west, east + 1):
                words = [*seed, number, *(2 * abs(n) + (n < 0) for n in (i, j))]
                rng = np.random.default_rng(words)
                u = rng.random((int(rng.poisson(one.density * one.tile**2)), 4))
                x, y = (j + u[:, 0]) * one.tile, (i + u[:, 1]) * one.tile
                size = np.interp(u[:, 2], shares, sizes)
                near = (x > window[0] - reach * size) & (x < window[2] + reach * size)
                near &= (y > window[1] - reach * size) & (y < window[3] + reach * size)
                found.append(np.column_stack([x, y, size, u[:, 3]])[near])
    return np.ascontiguousarray(np.concatenate(found))


def _inverse(count: Count, one: Class) -> tuple[F64, F64]:
    """Sizes, and the share of a class that is at most so large."""
    sizes = np.geomspace(one.smallest, one.largest, 65)
    above = np.array([count(size) for size in sizes.tolist()])
    return sizes, (above[0] - above) / (above[0] - above[-1])
