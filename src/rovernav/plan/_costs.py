"""What going costs: a cost per metre for every cell, and where one must not go."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core import F32, F64, Bool, Frame, InputError, ShapeError, value
from ..kernels import polyline


@value
class CostMap:
    """The cost of going one metre in each cell of a grid.

    Attributes:
        frame: Where the cells lie.
        cost: Cost of one metre (h, w), float32 [unit/m], > 0; inf where it is forbidden to go.
        unit: What a route over it is counted in: "m", "s", "J", or a name of your own.
        least: Smallest cost of the cells that are not forbidden; inf where there are none.
        most: Largest such cost.
    """

    frame: Frame
    cost: F32
    unit: str = "m"
    least: float = 0.0
    most: float = 0.0

    def _check(self) -> None:
        if self.cost.dtype != np.float32 or self.cost.shape != self.frame.shape:
            raise ShapeError(
                f"costs must be float32 of the frame's shape {self.frame.shape}, got "
                f"{self.cost.dtype} of shape {self.cost.shape}; use CostMap.of"
            )
        if not self.cost.flags.c_contiguous:
            contiguous = np.ascontiguousarray(self.cost)
            contiguous.flags.writeable = False
            object.__setattr__(self, "cost", contiguous)
        least, most, wrong = polyline.span(self.cost)
        if wrong >= 0:
            row, column = divmod(wrong, self.frame.shape[1])
            got = self.cost[row, column]
            raise InputError(
                f"the cost of row {row}, column {column} is {got:g}; every cost must be above 0, "
                "or inf where it is forbidden to go"
            )
        object.__setattr__(self, "least", least)
        object.__setattr__(self, "most", most)

    @classmethod
    def of(
        cls,
        cost: Any,
        frame: Frame | None = None,
        *,
        forbidden: Any = None,
        cell: float = 1.0,
        unit: str = "m",
    ) -> CostMap:
        """A cost map from any array of numbers.

        Args:
            cost: Cost of one metre (h, w), or one number for all cells; NaN and inf forbid.
            frame: Where the cells lie; by default `cell` metres each, with no coordinates.
            forbidden: Where one must not go (h, w), true or not zero; or None.
            cell: Side of a cell where no frame is given [m].
            unit: What a route is counted in.

        Raises:
            ShapeError: Not two-dimensional, or not of the frame's shape.
            InputError: A cost is 0 or below.
        """
        shape = frame.shape if frame is not None else np.shape(forbidden)
        own = np.array(cost, np.float32, ndmin=2)
        if own.shape == (1, 1) and np.ndim(cost) == 0 and shape:
            own = np.full(shape, own[0, 0], np.float32)
        if own.ndim != 2 or own.size == 0:
            raise ShapeError(f"costs must be a grid of rows and columns, got shape {own.shape}")
        own[np.isnan(own)] = np.inf
        if forbidden is not None:
            mask = np.asarray(forbidden)
            if mask.shape != own.shape:
                raise ShapeError(
                    f"forbidden cells have shape {mask.shape}, the costs {own.shape}; "
                    "they must be equal"
                )
            own[mask.astype(bool)] = np.inf
        if frame is None:
            frame = Frame(cell=cell, shape=(own.shape[0], own.shape[1]))
        return cls(frame=frame, cost=own, unit=unit)

    @property
    def forbidden(self) -> Bool:
        """Where one must not go (h, w)."""
        return np.isinf(self.cost)

    def pieces(self, points: Any) -> F64:
        """What each straight piece of a path costs [unit], by the line integral of the cost.

        Every planner here and every peer in the benchmarks is judged by this. Forbidden cells are
        closed: a piece that touches one costs inf, as does one that leaves the grid.

        Args:
            points: Local points (k, 2) [m].

        Returns:
            Costs (k-1,).
        """
        points = np.ascontiguousarray(points, np.float64)
        if points.ndim != 2 or points.shape[1] != 2:
            raise ShapeError(f"a path must have shape (k, 2), got {points.shape}")
        out = np.empty(max(len(points) - 1, 0))
        polyline.pieces(points / self.frame.cell, self.cost, out)
        return out * self.frame.cell

    def cost_of(self, points: Any) -> float:
        """What a whole path (k, 2) [m] costs [unit]; see `pieces`."""
        return float(self.pieces(points).sum())
