"""A raster of any size judged piece by piece, first where the shortest ways may run."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np

from ..core import F32, F64, U8, Bool, FileError, Frame, InputError
from ..kernels import pooling, resample
from ..rover import Reason, Rover, standing
from ..terrain import Raster, Window
from ._ends import Point
from ._survey import JOIN, MEET, Survey, beyond, block_for, ground_of
from ._zones import Zones

MOST = 10_000_000_000
"""Cells of a raster at most: judging all of them takes some minutes."""
SMALL, EMPTY = 100_000_000, 0.002
"""A file of more cells with fewer bytes a cell than any compression reaches is empty."""
CHUNK = 512
"""Cells along a side of what is judged or not."""
BAND = 2_000_000
"""Cells that are judged at once: it takes some 40 bytes each."""
THREADS = 2
"""Pieces that are judged at a time, beside the one that is read."""
ZONED = len(Reason)
"""The reason that a zone is, beside those of the ground."""
AROUND = 384.0
"""However short a way, so much longer ones count too [cells]."""

Progress = Callable[[float, str], None]


def silent(_share: float, _words: str) -> None:
    """No progress shown."""


class _Run(NamedTuple):
    """What is kept of chunks side by side; `edges` are those of its parts: s, n, w, e."""

    heights: F64
    share: F32
    reason: U8
    east: U8
    north: U8
    edges: tuple[U8, U8, U8, U8]
    free: int


class Lookout:
    """What was judged of a raster so far; more is where it is asked for.

    Every way between two points that is no longer than L lies within the ellipse around them on
    which the distances to both add up to L. So a way of that length that was found within it is
    not undercut by one outside, whatever the ground there is like.

    Attributes:
        found: What was judged.
    """

    def __init__(
        self, raster: Raster, rover: Rover, *, zones: Zones | None = None, block: int | None = None
    ) -> None:
        """Nothing is judged yet.

        Raises:
            FileError: The file is nearly empty, or has more than 10^10 cells.
        """
        _check_size(raster)
        self._raster, self._rover, self._zones = raster, rover, zones
        (h, w), k = raster.frame.shape, block or block_for(raster.frame)
        self._block, self._per = k, max(1, CHUNK // k)
        shape = (-(-h // k), -(-w // k))
        chunks = (-(-shape[0] // self._per), -(-shape[1] // self._per))
        self._done = np.zeros(chunks, bool)
        self._heights = np.full(shape, np.nan)
        self._share, self._reason = np.zeros(shape, np.float32), np.zeros(shape, np.uint8)
        self._east = np.zeros((shape[0], shape[1] - 1), np.uint8)
        self._north = np.zeros((shape[0] - 1, shape[1]), np.uint8)
        self._rows = np.zeros((2, chunks[0], w), np.uint8)  # south and north edges of chunks
        self._columns = np.zeros((2, chunks[1], h), np.uint8)  # west and east edges
        self._free = self._looked = 0
        self.found = self._snapshot()

    @property
    def whole(self) -> bool:
        """Whether nothing is left to judge."""
        return bool(self._done.all())

    def widen(
        self, ends: tuple[Point, Point], reach: float, on_progress: Progress = silent
    ) -> None:
        """Judge where ways between two local points [m] run that are not much longer than straight.

        Args:
            ends: The points.
            reach: How many times as long as the straight line [1]; inf for all of the raster.
            on_progress: Called with the share that is done, and what is done.

        Raises:
            FileError: The file is damaged.
            InputError: All was looked at, and there is no height.
        """
        wanted = self._within(ends, reach) & ~self._done
        runs = list(self._runs(wanted))
        pieces = self._raster.parts(runs, beyond(self._rover, self._raster.frame.cell))
        for n, (window, run) in enumerate(in_turn(self._judged, pieces)):
            self._put(window, run)
            on_progress((n + 1) / len(runs), "judging the ground")
        self._done |= wanted
        if runs:
            self._meet()
            self.found = self._snapshot()
        if self.whole and np.isnan(self._heights).all():
            raise InputError(
                f"{self._raster.source}: every height is missing; check the nodata value"
            )

    def _within(self, ends: tuple[Point, Point], reach: float) -> Bool:
        """Chunks that the ellipse touches."""
        if math.isinf(reach):
            return np.ones(self._done.shape, bool)
        cell, k = self._raster.frame.cell, self._block
        y, x = ((np.arange(n) + 0.5) * (k * cell) for n in self._share.shape)
        far = sum(np.hypot(x - end[0], y[:, None] - end[1]) for end in ends)
        most = reach * math.dist(*ends) + AROUND * cell + 1.5 * k * cell
        rows = np.arange(0, len(y), self._per)
        columns = np.arange(0, len(x), self._per)
        nearest = np.minimum.reduceat(np.minimum.reduceat(far, rows, axis=0), columns, axis=1)
        return nearest <= most

    def _runs(self, wanted: Bool) -> Iterator[Window]:
        """Chunks side by side, from south to north and from west to east."""
        h, w = self._raster.frame.shape
        side = self._per * self._block
        most = max(1, BAND // (side * side))
        for row, chosen in enumerate(wanted):
            first = 0
            while first < len(chosen):
                last = first
                while last < len(chosen) and last - first < most and chosen[last]:
                    last += 1
                if last > first:
                    low, left = row * side, first * side
                    rows, columns = min(side, h - low), min(last * side, w) - left
                    yield Window(row=low, column=left, rows=rows, columns=columns)
                first = max(last, first + 1)

    def _judged(self, part: Any) -> tuple[Window, _Run]:
        """A piece without what lies beyond it."""
        (window, around, heights), k = part, self._block
        ground = ground_of(self._raster, around, heights)
        low, left = window.row - around.row, window.column - around.column
        inner = np.s_[low : low + window.rows, left : left + window.columns]
        h, w = window.rows, window.columns
        if ground is None:
            reason = np.full((h, w), Reason.NO_DATA, np.uint8)
        else:
            reason = np.array(standing(ground, self._rover).reason[inner])
        if self._zones is not None:
            cell = self._raster.frame.cell
            seen = self._zones.seen_from(window.column * cell, window.row * cell)
            kept = seen.forbidden(Frame(cell=cell, shape=(h, w)))
            reason[kept & (reason == Reason.FREE)] = ZONED
        blocks = -(-h // k), -(-w // k)
        parts = np.empty((h, w), np.uint8)
        counts = np.empty((blocks[0] * blocks[1], ZONED + 1), int)
        pooling.parts(reason, k, parts, counts)
        counts, mean = counts.reshape(*blocks, -1), np.empty(blocks)
        resample.block_means(np.ascontiguousarray(heights[inner], np.float64), k, mean)
        share = (counts[:, :, 0] / counts.sum(axis=2)).astype(np.float32)
        common = (counts[:, :, 1:].argmax(axis=2) + 1).astype(np.uint8)
        common[common == ZONED] = Reason.NEAR
        common[share >= 0.5] = Reason.FREE
        return window, _Run(
            heights=mean, share=share, reason=common,
            east=_borders(parts[:, k - 1 : w - 1 : k].T, parts[:, k:w:k].T, k).T,
            north=_borders(parts[k - 1 : h - 1 : k], parts[k:h:k], k),
            edges=(parts[0].copy(), parts[-1].copy(), parts[:, 0].copy(), parts[:, -1].copy()),
            free=int(counts[:, :, 0].sum()),
        )  # fmt: skip

    def _put(self, window: Window, run: _Run) -> None:
        """Keep what a piece is like."""
        k, (h, w) = self._block, run.share.shape
        i, j = window.row // k, window.column // k
        self._heights[i : i + h, j : j + w] = run.heights
        self._share[i : i + h, j : j + w] = run.share
        self._reason[i : i + h, j : j + w] = run.reason
        self._east[i : i + h, j : j + w - 1] = run.east
        self._north[i : i + h - 1, j : j + w] = run.north
        along = slice(window.column, window.column + window.columns)
        self._rows[:, i // self._per, along] = run.edges[:2]
        up = slice(window.row, window.row + window.rows)
        self._columns[0, j // self._per, up] = run.edges[2]
        self._columns[1, (j + w - 1) // self._per, up] = run.edges[3]
        self._free += run.free
        self._looked += window.rows * window.columns

    def _meet(self) -> None:
        """Borders between pieces that were judged each by itself."""
        k, per = self._block, self._per
        rows, columns = self._rows, self._columns
        self._north[per - 1 :: per][: len(rows[0]) - 1] = _borders(rows[1, :-1], rows[0, 1:], k)
        sides = self._east[:, per - 1 :: per][:, : len(columns[0]) - 1]
        sides |= _borders(columns[1, :-1], columns[0, 1:], k).T

    def _snapshot(self) -> Survey:
        h, w = self._share.shape
        seen = np.repeat(np.repeat(self._done, self._per, axis=0), self._per, axis=1)[:h, :w]
        raster = self._raster
        cells = raster.frame.shape[0] * raster.frame.shape[1]
        return Survey(
            block=self._block, whole=raster.frame, source=raster.source, name=raster.name,
            seen=seen, heights=self._heights.copy(), share=self._share.copy(),
            reason=self._reason.copy(), east=self._east.copy(), north=self._north.copy(),
            free=self._free / max(1, self._looked), looked=self._looked / cells,
        )  # fmt: skip


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
    looking = Lookout(raster, rover, zones=zones, block=block)
    looking.widen(((0.0, 0.0), (0.0, 0.0)), math.inf, on_progress)
    return looking.found


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


def in_turn(work: Callable[[Any], Any], items: Iterable[Any]) -> Iterator[Any]:
    """Results in order, a few ahead of each other."""
    with ThreadPoolExecutor(THREADS) as pool:
        waiting: deque[Future[Any]] = deque()
        for item in items:
            waiting.append(pool.submit(work, item))
            if len(waiting) > THREADS:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()


def _borders(one: Any, other: Any, k: int) -> U8:
    """What blocks on either side of borders (n, cells) have in common (n, blocks)."""
    cuts = np.arange(0, one.shape[1], k)
    meet = np.logical_or.reduceat((one > 0) & (other > 0), cuts, axis=1)
    join = np.logical_or.reduceat((one == 2) & (other == 2), cuts, axis=1)
    return meet * MEET + join * JOIN
