"""What going costs a rover in every direction: one function for planner, table and reasons."""

from __future__ import annotations

import dataclasses
import math
from typing import Any, NamedTuple

import numpy as np

from ..core import F32, F64, U8, Frame, SettingError, ShapeError, suggest, value
from ..kernels import going as k
from ..kernels import traction
from ..rover import Hazards, Reason, Rover, cheapest, drive_table
from ._costs import CostMap


class Kind(NamedTuple):
    """An objective: its number in the kernels, its unit, and the names of its terms."""

    number: int
    unit: str
    terms: tuple[str, ...]


OBJECTIVES = {
    "distance": Kind(k.DISTANCE, "m", ("distance",)),
    "time": Kind(k.TIME, "s", ("level ground", "slope", "weak motors", "slip")),
    "energy": Kind(k.ENERGY, "J", ("rolling", "climbing", "slip", "idle power")),
    "risk": Kind(k.RISK, "1", ("exposure", "near hazards", "slope", "slip", "unmeasured")),
}
"""What a route can be the least of."""

NEAR, SLOPE, SLIP, UNSURE = 4.0, 2.0, 2.0, 1.0
"""Weights of risk: a metre at the edge of a hazard counts 4 more than one in the open, one at the
slope limit 2 more, one at the slip limit 2 more, one on slopes that nobody measured 1 more."""
WIDTH, WIDTH_CELLS = 4.0, 3.0
"""A hazard is near within this many radii of the rover beyond its own, and at least so many
cells."""


@value
class Going:
    """One terrain, one rover, one objective: what going costs in each cell and direction.

    Attributes:
        hazards: The ground judged for the rover.
        rover: Who goes.
        objective: "distance", "time", "energy" or "risk".
        blocked: 1 where its middle must not be (h, w), uint8: hazards and zones.
        near: Nearness of hazards (h, w), float32, from 0 to 1 where the rover would touch one.
        table: What driving costs, of `rover.drive_table`; None where the rover has no motors.
        zones: A `Zones`, part of what is blocked; None without zones.
    """

    hazards: Hazards
    rover: Rover
    objective: str
    blocked: U8
    near: F32
    table: F64 | None = None
    zones: Any = None

    def _check(self) -> None:
        if self.objective not in OBJECTIVES:
            raise SettingError(
                f"unknown objective {self.objective!r}; {suggest(self.objective, OBJECTIVES)}"
            )
        if self.objective == "energy" and self.table is None:
            raise SettingError(
                f"rover {self.rover.name} says nothing of its mass and motors, so energy is not "
                "known; choose another objective, or give its file a section mobility, and wheels"
            )
        if self.blocked.shape != self.frame.shape:
            raise ShapeError(
                f"blocked cells must have the shape {self.frame.shape}, got {self.blocked.shape}"
            )

    @property
    def frame(self) -> Frame:
        """Where the cells lie."""
        return self.hazards.frame

    @property
    def unit(self) -> str:
        """What costs are counted in."""
        return OBJECTIVES[self.objective].unit

    @property
    def terms(self) -> tuple[str, ...]:
        """Names of the terms that a cost is the sum of."""
        names = OBJECTIVES[self.objective].terms
        return names[:1] if self.table is None and self.objective == "time" else names

    @property
    def least(self) -> float:
        """What no metre of map undercuts [unit/m]."""
        if self.objective == "energy" and self.table is not None:
            return cheapest(self.table)[0]
        if self.objective == "time":
            return 1.0 / self.rover.speed if self.table is None else cheapest(self.table)[1]
        return 1.0

    def by(self, objective: str) -> Going:
        """The same ground with another objective."""
        return dataclasses.replace(self, objective=objective)

    def open_ground(self) -> CostMap:
        """Every free cell at a cost of 1 per metre, whatever the direction."""
        return CostMap.of(1.0, self.frame, forbidden=self.blocked)

    def pieces(self, points: Any) -> F64:
        """What each straight piece of a path costs [unit]; inf where a limit forbids it.

        A piece pays each cell's rate for the piece's own direction, times its length there.

        Args:
            points: Local points (k, 2) [m].

        Returns:
            Costs (k-1,).
        """
        cells, room = self._ready(points)
        out = np.empty(max(len(cells) - 1, 0))
        k.pieces(cells, self.packed(), room[0], room[1], out)
        return out * self.frame.cell

    def cost_of(self, points: Any) -> float:
        """What a whole path (k, 2) [m] costs [unit]; see `pieces`."""
        return float(self.pieces(points).sum())

    def split(self, points: Any) -> F64:
        """The terms (k-1, number of `terms`) that the costs of the pieces are the sums of [unit].

        Limits do not count here: forbidden pieces have terms too, as far as their slope is known.
        """
        cells, room = self._ready(points)
        out = np.empty((max(len(cells) - 1, 0), k.TERMS))
        k.split(cells, self.packed(), room[0], room[1], out)
        return out[:, : len(self.terms)] * self.frame.cell

    def _ready(self, points: Any) -> tuple[F64, tuple[Any, F64]]:
        points = np.ascontiguousarray(points, np.float64)
        if points.ndim != 2 or points.shape[1] != 2:
            raise ShapeError(f"a path must have shape (k, 2), got {points.shape}")
        return points / self.frame.cell, room_for(self.frame)

    def packed(self) -> k.Going:
        """As the kernels have it."""
        layers = self.hazards.layers
        table = np.zeros((1, traction.COLUMNS)) if self.table is None else self.table
        rates = np.empty(k.RATES)
        rates[k.PACE] = 1.0 / self.rover.speed
        rates[[k.W_NEAR, k.W_SLOPE, k.W_SLIP, k.W_UNSURE]] = NEAR, SLOPE, SLIP, UNSURE
        mobility = self.rover.mobility
        rates[k.MOST_SLIP] = 1.0 if mobility is None else mobility.max_slip
        rates[k.STEEPEST] = max(np.tan(self.rover.max_slope), 1e-6) ** 2
        table = np.array(table)  # kernels are compiled once, for arrays of one kind
        return k.Going(
            east=layers["east"].values, north=layers["north"].values, near=self.near,
            blocked=self.blocked, table=table, rates=rates,
            kind=OBJECTIVES[self.objective].number, drives=self.table is not None,
        )  # fmt: skip


def room_for(frame: Frame) -> tuple[Any, F64]:
    """Room for all cells that one straight piece can touch."""
    most = 3 * max(frame.shape) + min(frame.shape) + 16
    return np.empty((most, 2), np.int64), np.empty(most)


def going(
    hazards: Hazards,
    rover: Rover,
    *,
    objective: str = "distance",
    soil: Any = None,
    slip: str = "expected",
) -> Going:
    """What going costs `rover` on the ground of `hazards`.

    distance counts metres on the map. time and energy are those of `rover.drive_cost`, by
    direction: uphill, across, slip. risk is the metres, each counted 1 + 4 n + 2 (t / T)^2 +
    2 (s / S)^2 + u times, for nearness n of hazards, gradient t of T allowed, slip s of S allowed
    and u = 1 on slopes that were not measured. Whatever is counted, directions in which pitch,
    roll, tilt or slip exceed the rover's limits are forbidden.

    Args:
        hazards: The ground, judged for this rover.
        rover: Who goes.
        objective: "distance", "time", "energy" or "risk".
        soil: A soil or its name; that of the hazards where not given.
        slip: "low", "expected" or "high": which edge of the band of likely slip to take.

    Raises:
        SettingError: An unknown objective or soil, energy for a rover without motors.
    """
    table = None
    if rover.mobility is not None and rover.chassis is not None:
        table = drive_table(rover, soil or hazards.soil, slip=slip)
    elif soil is not None:
        raise SettingError(
            f"rover {rover.name} says nothing of its mass and motors, so a soil means nothing to "
            "it; leave the soil out"
        )
    beyond = hazards.layers["distance"].values - np.float32(rover.radius)
    width = max(WIDTH * rover.radius, WIDTH_CELLS * hazards.frame.cell)
    near = np.clip(1.0 - beyond / np.float32(width), 0.0, 1.0, dtype=np.float32) ** 2
    return Going(
        hazards=hazards, rover=rover, objective=objective, blocked=hazards.blocked,
        near=np.nan_to_num(near), table=table,
    )  # fmt: skip


def against(ground: Going, point: tuple[float, float]) -> str:
    """What forbids the ground that a local point [m] touches, as the end of a sentence."""
    frame, where = ground.frame, ground.hazards.standing
    steps = (-1e-9, 1e-9)
    places = ((max(0.0, point[0] + a), max(0.0, point[1] + b)) for a in steps for b in steps)
    cells = {frame.cell_of(*place) for place in places}
    blocked = sorted(cell for cell in cells if ground.blocked[cell])
    if not blocked:
        return ""
    cell, rover = blocked[0], ground.rover
    match where.reason[cell]:
        case Reason.NO_DATA:
            words = "the map does not call it free" if where.plain else "a height is missing there"
        case Reason.SLOPE:
            slope, most = math.degrees(where.slope[cell]), math.degrees(rover.max_slope)
            words = f"it is {slope:.1f} deg steep there, and {rover.name} climbs {most:.1f} deg"
        case Reason.STEP:
            words = (
                f"a ledge there is {where.step[cell]:.3g} m high, and {rover.name} climbs "
                f"{rover.max_step:.3g} m"
            )
        case Reason.NEAR:
            words = f"ground within the radius of {rover.name} is forbidden there"
        case _:
            words = "a zone forbids it"
    return f"; {words}"
