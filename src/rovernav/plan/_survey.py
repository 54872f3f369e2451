"""A raster of any size judged once, band by band, and kept as blocks of cells."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np

from ..core import F32, F64, U8, FileError, Float, Frame, InputError, value
from ..kernels import pooling, resample
from ..rover import Hazards, Reason, Rover, Standing, hazards, standing
from ..terrain import Raster, Terrain, Window
from ._costs import CostMap
from ._ends import Point
from ._zones import Zones

BLOCKS = 4_000_000
"""Blocks of a survey at most."""
MOST = 10_000_000_000
"""Cells of a raster at most: judging them takes some minutes."""
SMALL, EMPTY = 100_000_000, 0.002
"""A file of more cells with fewer bytes a cell than any compression reaches is empty."""
BAND = 4_000_000
"""Cells of a band: judging it takes some 40 bytes each."""
THREADS = 2
"""Bands that are judged at a time, beside the one that is read."""
ZONED = len(Reason)
"""The reason that a zone is, beside those of the ground."""
HARDER = 0.5
"""What a metre costs more in a block where next to nothing is free, as a first guess."""
MEET, JOIN = np.uint8(1), np.uint8(2)
"""Two blocks meet where free cells of theirs do, and join where their largest pieces do."""

Progress = Callable[[float, str], None]


def silent(_share: float, _words: str) -> None:
    """No progress shown."""


@value
class Survey:
    """Blocks of a raster's cells, each judged by all of its cells.

    Where no way leads over blocks that meet, none leads over the raster; where one leads over
    blocks that join, one leads over the raster, as far as limits do not depend on the direction.

    Attributes:
        block: Cells to a side of a block.
        whole: The raster's own frame.
        terrain: Mean heights of the blocks.
        share: Free cells of each block (h, w), float32, 0 to 1.
        reason: Commonest `Reason` against a block less than half free (h, w), uint8; 0 for others.
        east: Whether a block meets (1) and joins (3) the next one to the east (h, w - 1), uint8.
        north: As `east`, to the north (h - 1, w).
        free: Share of the raster that is free, 0 to 1.
    """

    block: int
    whole: Frame
    terrain: Terrain
    share: F32
    reason: U8
    east: U8
    north: U8
    free: float

    def costs(self, *, joined: bool, harder: float = HARDER, known: Any = 1.0) -> CostMap:
        """A map on which one goes from block to block, with a cell for each and each border.

        Its local points are those of the raster less `corner`.

        Args:
            joined: Whether blocks must join, or need only meet.
            harder: What a metre costs more in a block where next to nothing is free.
            known: What it costs in each block (h, w) as a share of that, as far as it is known.
        """
        h, w = self.share.shape
        bit = JOIN if joined else MEET
        cost = np.full((2 * h - 1, 2 * w - 1), np.inf, np.float32)
        own = np.where(self.share > 0.0, (1.0 + harder * (1.0 - self.share)) * known, np.inf)
        cost[::2, ::2] = own
        cost[::2, 1::2] = np.where(self.east & bit, 0.5 * (own[:, 1:] + own[:, :-1]), np.inf)
        cost[1::2, ::2] = np.where(self.north & bit, 0.5 * (own[1:] + own[:-1]), np.inf)
        # where four blocks touch, one may cut the corner if all their borders are open
        a, b = cost[:-2:2, 1::2], cost[2::2, 1::2]
        c, d = cost[1::2, :-2:2], cost[1::2, 2::2]
        cost[1::2, 1::2] = 0.25 * (a + b + c + d)
        return CostMap(frame=Frame(cell=0.5 * self.side, shape=cost.shape), cost=cost)

    @property
    def side(self) -> float:
        """Side of a block [m]."""
        return self.block * self.whole.cell

    @property
    def corner(self) -> float:
        """Local x and y of the south-west corner of the map of `costs` [m]."""
        return 0.25 * self.side

    def place(self, x: float, y: float) -> tuple[int, int]:
        """Row and column of the block of a local point [m]."""
        row, column = self.whole.cell_of(x, y)
        return row // self.block, column // self.block

    def middle(self, x: float, y: float) -> Point:
        """Middle of the block of a local point, on the map of `costs` [m]."""
        row, column = self.place(x, y)
        return (column + 0.25) * self.side, (row + 0.25) * self.side

    def narrowed(self, window: Window, *, joined: bool) -> Survey:
        """The same where blocks in a window that have proved not to be passed no longer count.

        Where some of them meet without joining, they no longer meet; otherwise those with forbidden
        cells no longer join either.

        Args:
            window: Where no way was found.
            joined: Whether it was sought over blocks that join.
        """
        low, left = window.row // self.block, window.column // self.block
        top = -(-(window.row + window.rows) // self.block)
        right = -(-(window.column + window.columns) // self.block)
        east, north = np.array(self.east), np.array(self.north)
        parts = east[low:top, left : right - 1], north[low : top - 1, left:right]
        if not joined and any((part == MEET).any() for part in parts):
            for part in parts:
                part[part == MEET] = 0
        else:
            mixed = self.share[low:top, left:right] < 1.0
            parts[0][mixed[:, 1:] | mixed[:, :-1]] = 0
            parts[1][mixed[1:] | mixed[:-1]] = 0
        return dataclasses.replace(self, east=east, north=north)

    def judged(self, rover: Rover, soil: Any = None) -> Hazards:
        """Layers of the blocks' mean heights; where a rover can stand is told by the cells."""
        found = hazards(self.terrain, rover, soil=soil)
        where = Standing(
            frame=self.terrain.frame, blocked=(self.share < 0.5).view(np.uint8),
            reason=self.reason, slope=found.standing.slope, step=found.standing.step,
        )  # fmt: skip
        return dataclasses.replace(found, standing=where)


def beyond(rover: Rover, cell: float) -> int:
    """Cells around a piece of ground that matter to where in it a rover can stand."""
    reach = 0.5 * rover.footing + 2.0 * rover.wheel_radius + rover.radius
    return math.ceil(reach / cell) + 3


def block_for(frame: Frame) -> int:
    """Cells to a side of a block, so that a survey has at most `BLOCKS`."""
    return max(4, math.ceil(math.sqrt(frame.shape[0] * frame.shape[1] / BLOCKS)))


class _Band(NamedTuple):
    """What is kept of a band."""

    heights: F64
    counts: Any
    east: U8
    north: U8
    first: U8
    last: U8


def survey(
    raster: Raster,
    rover: Rover,
    *,
    zones: Zones | None = None,
    block: int | None = None,
    on_progress: Progress = silent,
) -> Survey:
    """Judge all cells of a raster for a rover, in memory that does not grow with the raster.

    Args:
        raster: The ground.
        rover: Whose limits count.
        zones: What to keep out of and to stay within, in the raster's local metres.
        block: Cells to a side of a block.
        on_progress: Called with the share that is done, and what is done.

    Raises:
        FileError: The file is damaged, nearly empty, or has more than 10^10 cells.
        InputError: No height at all, or one that cannot be.
    """
    _check_size(raster)
    (h, w), frame = raster.frame.shape, raster.frame
    k = block or block_for(frame)
    rows = max(1, BAND // (w * k)) * k
    found: list[_Band] = []
    bands = raster.bands(rows, beyond(rover, frame.cell))
    for band in _in_turn(lambda part: _judged(raster, rover, zones, (rows, k), part), bands):
        found.append(band)
        on_progress(0.6 * len(found) * rows / h, "judging the ground")
    return _joined(raster, k, found)


def _check_size(raster: Raster) -> None:
    """Whether judging every cell makes sense."""
    h, w = raster.frame.shape
    told = f"{raster.path} has {w:,} x {h:,} cells"
    do = (
        f"cut a part out (rovernav terrain export {raster.path.name} --window "
        "WEST,SOUTH,EAST,NORTH --out part.tif), or average (--factor N)"
    )
    if h * w > MOST:
        raise FileError(f"{told}, and a route is planned over at most {MOST:,}; {do}")
    held = raster.path.stat().st_size
    if h * w > SMALL and held < EMPTY * h * w:
        raise FileError(f"{told}, but only {held / 1e6:.1f} MB: nearly all of it is empty; {do}")


def _in_turn(work: Callable[[Any], _Band], items: Iterator[Any]) -> Iterator[_Band]:
    """Results in order, a few ahead of each other."""
    with ThreadPoolExecutor(THREADS) as pool:
        waiting: deque[Future[_Band]] = deque()
        for item in items:
            waiting.append(pool.submit(work, item))
            if len(waiting) > THREADS:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()


def ground_of(raster: Raster, window: Window, heights: Float) -> Terrain | None:
    """A part of a raster as a terrain; None where it has no height."""
    if np.isnan(heights).all():
        return None
    shape = heights.shape[0], heights.shape[1]
    frame = raster.frame.part(window.row, window.column, shape)
    return Terrain.from_heights(heights, frame, name=raster.name, source=raster.source)


def _judged(
    raster: Raster, rover: Rover, zones: Zones | None, size: tuple[int, int], part: Any
) -> _Band:
    """A band without what lies beyond it."""
    (first, window, heights), (rows, k) = part, size
    ground = ground_of(raster, window, heights)
    inner = slice(first - window.row, min(first - window.row + rows, window.rows))
    if ground is None:
        reason = np.full(heights.shape, Reason.NO_DATA, np.uint8)[inner]
    else:
        reason = np.array(standing(ground, rover).reason[inner])
    h, w = reason.shape
    if zones is not None:
        cell = raster.frame.cell
        frame = Frame(cell=cell, shape=(h, w))
        kept = zones.seen_from(0.0, first * cell).forbidden(frame)
        reason[kept & (reason == Reason.FREE)] = ZONED
    blocks = -(-h // k), -(-w // k)
    parts, counts = np.empty((h, w), np.uint8), np.empty((blocks[0] * blocks[1], ZONED + 1), int)
    pooling.parts(reason, k, parts, counts)
    mean = np.empty(blocks)
    resample.block_means(np.ascontiguousarray(heights[inner], np.float64), k, mean)
    return _Band(
        heights=mean, counts=counts.reshape(*blocks, -1),
        east=_borders(parts[:, k - 1 : w - 1 : k].T, parts[:, k:w:k].T, k).T,
        north=_borders(parts[k - 1 : h - 1 : k], parts[k:h:k], k),
        first=parts[0].copy(), last=parts[-1].copy(),
    )  # fmt: skip


def _borders(one: Any, other: Any, k: int) -> U8:
    """What blocks on either side of borders (n, cells) have in common (n, blocks)."""
    cuts = np.arange(0, one.shape[1], k)
    meet = np.logical_or.reduceat((one > 0) & (other > 0), cuts, axis=1)
    join = np.logical_or.reduceat((one == 2) & (other == 2), cuts, axis=1)
    return meet * MEET + join * JOIN


def _joined(raster: Raster, k: int, found: list[_Band]) -> Survey:
    """The survey that bands from south to north make."""
    north = [found[0].north]
    for below, above in itertools.pairwise(found):
        north += [_borders(below.last[None], above.first[None], k), above.north]
    counts = np.concatenate([band.counts for band in found])
    every, free = counts.sum(axis=2), counts[:, :, 0]
    share = (free / every).astype(np.float32)
    reason = (counts[:, :, 1:].argmax(axis=2) + 1).astype(np.uint8)
    reason[reason == ZONED] = Reason.NEAR
    reason[share >= 0.5] = Reason.FREE
    heights = np.concatenate([band.heights for band in found])
    if np.isnan(heights).all():
        raise InputError(f"{raster.source}: every height is missing; check the nodata value")
    frame = raster.frame.part(0, 0, (share.shape[0], share.shape[1]), k)
    terrain = Terrain.from_heights(
        heights, frame, name=raster.name, source=f"{raster.source}, {k} x {k} cells averaged"
    )
    return Survey(
        block=k, whole=raster.frame, terrain=terrain, share=share, reason=reason,
        east=np.concatenate([band.east for band in found]), north=np.concatenate(north),
        free=float(free.sum() / every.sum()),
    )  # fmt: skip
