"""What is kept of a raster of any size: blocks of cells, and over which borders one can pass."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np

from ..core import F32, F64, U8, Bool, Float, Frame, value
from ..rover import Hazards, Reason, Rover, Standing, hazards
from ..terrain import Raster, Terrain, Window
from ._costs import CostMap
from ._ends import Point

BLOCKS = 4_000_000
"""Blocks of a survey at most."""
DEAR = 100.0
"""What a metre of forbidden ground counts where it must be crossed; without data ten times that."""
HARDER = 0.5
"""What a metre costs more in a block where next to nothing is free, as a first guess."""
MEET, JOIN = np.uint8(1), np.uint8(2)
"""Two blocks meet where free cells of theirs do, and join where their largest pieces do."""


@value
class Survey:
    """Blocks of a raster's cells, each judged by all of its cells, as far as they were looked at.

    Where no way leads over blocks that meet, none leads over the cells that were looked at; where
    one leads over blocks that join, one leads over the raster, as far as limits do not depend on
    the direction.

    Attributes:
        block: Cells to a side of a block.
        whole: The raster's own frame.
        source: What the raster is, for reports.
        name: Short name of it.
        seen: Blocks that were looked at (h, w); of others nothing is known.
        heights: Mean heights of the blocks (h, w) [m]; NaN where not seen.
        share: Free cells of each block (h, w), float32, 0 to 1.
        reason: Commonest `Reason` against a block less than half free (h, w), uint8; 0 for others.
        east: Whether a block meets (1) and joins (3) the next one to the east (h, w - 1), uint8.
        north: As `east`, to the north (h - 1, w).
        free: Share of what was looked at that is free, 0 to 1.
        looked: Share of the raster that was looked at, 0 to 1.
    """

    block: int
    whole: Frame
    source: str
    name: str
    seen: Bool
    heights: F64
    share: F32
    reason: U8
    east: U8
    north: U8
    free: float
    looked: float

    @property
    def terrain(self) -> Terrain:
        """Mean heights of the blocks as a terrain.

        Raises:
            InputError: No height at all.
        """
        h, w = self.share.shape
        how = f"{self.source}, {self.block} x {self.block} cells averaged"
        frame = self.whole.part(0, 0, (h, w), self.block)
        return Terrain.from_heights(self.heights, frame, name=self.name, source=how)

    def costs(
        self, *, joined: bool, harder: float = HARDER, learnt: Any = 1.0, hopeful: bool = False
    ) -> CostMap:
        """A map on which one goes from block to block, with a cell for each and each border.

        Its local points are those of the raster less `corner`.

        Args:
            joined: Whether blocks must join, or need only meet.
            harder: What a metre costs more in a block where next to nothing is free.
            learnt: What it costs in each block (h, w) as a share of that, as far as it is known.
            hopeful: Whether blocks that were not looked at count as open, instead of closed.
        """
        h, w = self.share.shape
        bit = JOIN if joined else MEET
        cost = np.full((2 * h - 1, 2 * w - 1), np.inf, np.float32)
        own = np.where(self.share > 0.0, (1.0 + harder * (1.0 - self.share)) * learnt, np.inf)
        east, north = (self.east & bit) > 0, (self.north & bit) > 0
        if hopeful:
            new = ~self.seen
            own[new] = 1.0
            east |= new[:, 1:] | new[:, :-1]
            north |= new[1:] | new[:-1]
        own = own.astype(np.float32)
        cost[::2, ::2] = own
        cost[::2, 1::2] = np.where(east, 0.5 * (own[:, 1:] + own[:, :-1]), np.inf)
        cost[1::2, ::2] = np.where(north, 0.5 * (own[1:] + own[:-1]), np.inf)
        # where four blocks touch, one may cut the corner if all their borders are open
        a, b = cost[:-2:2, 1::2], cost[2::2, 1::2]
        c, d = cost[1::2, :-2:2], cost[1::2, 2::2]
        cost[1::2, 1::2] = 0.25 * (a + b + c + d)
        return CostMap(frame=Frame(cell=0.5 * self.side, shape=cost.shape), cost=cost)

    def forced(self) -> CostMap:
        """As `costs`, but forbidden ground is dear and not closed, so that a way always is."""
        cost = np.empty([2 * n - 1 for n in self.share.shape], np.float32)
        own = 1.0 + DEAR * (1.0 - self.share)
        own[self.reason == Reason.NO_DATA] *= 10.0
        own[~self.seen] = 1.0
        east, north = (self.east & MEET) == 0, (self.north & MEET) == 0
        east &= self.seen[:, 1:] & self.seen[:, :-1]
        north &= self.seen[1:] & self.seen[:-1]
        cost[::2, ::2] = own
        cost[::2, 1::2] = 0.5 * (own[:, 1:] + own[:, :-1]) + DEAR * east
        cost[1::2, ::2] = 0.5 * (own[1:] + own[:-1]) + DEAR * north
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
        terrain = self.terrain
        found = hazards(terrain, rover, soil=soil)
        where = Standing(
            frame=terrain.frame, blocked=(self.seen & (self.share < 0.5)).view(np.uint8),
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


def ground_of(raster: Raster, window: Window, heights: Float) -> Terrain | None:
    """A part of a raster as a terrain; None where it has no height."""
    if np.isnan(heights).all():
        return None
    shape = heights.shape[0], heights.shape[1]
    frame = raster.frame.part(window.row, window.column, shape)
    return Terrain.from_heights(heights, frame, name=raster.name, source=raster.source)
