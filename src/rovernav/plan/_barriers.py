"""What stands in the way where there is none: which limit, by how much, and where."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from typing import Any, cast

import numpy as np

from ..core import F32, F64, Bool, value
from ..kernels import traction
from ._costs import CostMap
from ._directed import Search
from ._ends import Point
from ._going import Going
from ._shortest import shortest

STEPS = 14
"""Halvings of the range in which the limit lies that opens a way."""
MOST_SLOPE, MOST_SLIP = math.radians(80.0), 0.999
"""How far limits are tried; nothing drives beyond."""


@value
class Barrier:
    """A limit without which there would be a way.

    Attributes:
        limit: "slope", "step", "no data", "zone", "margin", "pitch", "roll", "tilt", "slip" or
            "slope and step".
        now: What the limit is [unit].
        needed: What it would have to be, to about one part in ten thousand of the range tried
            [unit]; NaN where no number opens a way, only its absence.
        unit: "rad", "m", "1", or empty.
        at: Local point (x, y) [m] on the way that would open, where the limit is hardest; None for
            limits that depend on the direction.
        words: All of it in a sentence, with units for people.
    """

    limit: str
    now: float
    needed: float
    unit: str
    at: Point | None
    words: str


def barriers(ground: Going, start: Point, goal: Point) -> tuple[Barrier, ...]:
    """Each single limit that keeps the goal out of reach, the least raised first; none alone may.

    One limit at a time is lifted while all others hold; where that opens a way, the smallest value
    is sought at which it does. Where no single limit suffices, slope and step are raised together.

    Args:
        ground: What going costs.
        start: Local point [m] on the map.
        goal: Local point [m] on the map.
    """
    frame = ground.frame
    if not (frame.contains(*start) and frame.contains(*goal)):
        return ()
    ends = frame.cell_of(*start), frame.cell_of(*goal)
    if _joined(ground.blocked == 0, *ends):
        found = list(_by_direction(ground, start, goal))
    else:
        found = list(_by_layer(ground, *ends))
        found = found or list(_together(ground, *ends))
    return tuple(sorted(found, key=lambda b: b.needed / b.now if b.now > 0.0 else math.inf))


def _by_layer(ground: Going, first: Any, last: Any) -> Iterator[Barrier]:
    layers = _Layers(ground)
    rover = ground.rover
    for name, grid, now, top in (
        ("slope", layers.grade, rover.max_slope, MOST_SLOPE),
        ("step", layers.step, rover.max_step, 20.0 * max(rover.max_step, 0.05)),
    ):
        # A step counts only where it is steeper than the slope limit: that limit lifts both.
        others = layers.free(without=name, also="step" if name == "slope" else "")
        needed = _threshold(grid, others, (first, last), now, top)
        if needed is not None:
            at = _where(ground, others & (grid <= needed), grid, (first, last))
            unit = "rad" if name == "slope" else "m"
            yield Barrier(
                limit=name, now=now, needed=needed, unit=unit, at=at,
                words=f"a way opens if the {name} limit of {ground.rover.name} rises from "
                f"{unit_words(now, unit)} to {unit_words(needed, unit)}, hardest at "
                f"{place_words(at)}",
            )  # fmt: skip
    others = layers.free(without="no data")
    if _joined(others, first, last):
        at = _where(ground, others, layers.unknown.astype(np.float32), (first, last))
        yield Barrier(
            limit="no data", now=0.0, needed=math.nan, unit="", at=at,
            words=f"a way opens if {_missing(ground)} can be driven, as at {place_words(at)}",
        )  # fmt: skip
    if ground.zones is not None:
        yield from _zones(ground, layers, first, last)


def _zones(ground: Going, layers: _Layers, first: Any, last: Any) -> Iterator[Barrier]:
    others, zones = layers.free(without="zone"), ground.zones
    if not _joined(others, first, last):
        return
    if zones.margin > 0.0 and _joined(
        others & ~zones.forbidden(ground.frame, margin=0.0), first, last
    ):
        low, high = 0.0, zones.margin
        for _ in range(STEPS):
            middle = 0.5 * (low + high)
            if _joined(others & ~zones.forbidden(ground.frame, margin=middle), first, last):
                low = middle
            else:
                high = middle
        yield Barrier(
            limit="margin", now=zones.margin, needed=low, unit="m", at=None,
            words=f"a way opens if the margin around zones falls from {zones.margin:.4g} m to "
            f"{low:.4g} m",
        )  # fmt: skip
        return
    at = _where(ground, others, layers.zoned.astype(np.float32), (first, last))
    yield Barrier(
        limit="zone", now=0.0, needed=math.nan, unit="", at=at,
        words=f"a way opens if the zones are lifted, as at {place_words(at)}",
    )  # fmt: skip


def _together(ground: Going, first: Any, last: Any) -> Iterator[Barrier]:
    """Slope and step raised by one factor, all else kept."""
    layers, rover = _Layers(ground), ground.rover
    ratio = np.maximum(
        layers.slope / np.float32(rover.max_slope),
        layers.step / np.float32(max(rover.max_step, 1e-3)),
    )
    others = layers.free(without="slope", also="step")
    needed = _threshold(ratio, others, (first, last), 1.0, 20.0)
    if needed is not None:
        at = _where(ground, others & (ratio <= needed), ratio, (first, last))
        yield Barrier(
            limit="slope and step", now=1.0, needed=needed, unit="1", at=at,
            words=f"no single limit opens a way; slope and step limits {needed:.4g} times as high "
            f"do together, hardest at {place_words(at)}",
        )  # fmt: skip


def _by_direction(ground: Going, start: Point, goal: Point) -> Iterator[Barrier]:
    if ground.table is None:
        return
    for name, column, to_limit, top in (
        ("slip", traction.MOST_SLIP, lambda s: s, MOST_SLIP),
        ("pitch", traction.MOST_PITCH, math.tan, MOST_SLOPE),
        ("roll", traction.MOST_ROLL, math.tan, MOST_SLOPE),
        ("tilt", traction.MOST_TILT, lambda a: math.tan(a) ** 2, MOST_SLOPE),
    ):
        low = float(ground.table[0, column])
        now = {"slip": low, "tilt": math.atan(math.sqrt(low))}.get(name, math.atan(low))
        if now >= top or not _opens(ground, column, to_limit(top), start, goal):
            continue
        under, over = now, top
        for _ in range(STEPS):
            middle = 0.5 * (under + over)
            if _opens(ground, column, to_limit(middle), start, goal):
                over = middle
            else:
                under = middle
        unit = "1" if name == "slip" else "rad"
        yield Barrier(
            limit=name, now=now, needed=over, unit=unit, at=None,
            words=f"a way opens if the {name} limit of {ground.rover.name} rises from "
            f"{unit_words(now, unit)} to {unit_words(over, unit)}",
        )  # fmt: skip


def _opens(ground: Going, column: int, limit: float, start: Point, goal: Point) -> bool:
    table = np.array(ground.table)
    table[:, column] = limit
    eased = dataclasses.replace(ground, table=table, objective="distance")
    return Search(eased, start).run(goal)[1] >= 0


class _Layers:
    """What blocks, layer by layer, each as far as the rover's body reaches."""

    def __init__(self, ground: Going) -> None:
        standing = ground.hazards.standing
        self._ground = ground
        unknown = np.isnan(standing.slope)
        radius = ground.rover.radius / ground.frame.cell
        self.slope = _reached(np.where(unknown, -np.inf, standing.slope), radius)
        step = np.where(unknown | np.isnan(standing.step), -np.inf, standing.step)
        self.step = _reached(step, radius)
        high = step > ground.rover.max_step
        ledge = np.where(high, np.arctan(np.where(high, step, 0.0) / ground.frame.cell), -np.inf)
        self.grade = _reached(np.maximum(np.where(unknown, -np.inf, standing.slope), ledge), radius)
        self.unknown = _reached(unknown.astype(np.float32), radius) > 0.0
        zones = ground.zones
        self.zoned = (
            np.zeros(ground.frame.shape, bool) if zones is None else zones.forbidden(ground.frame)
        )

    def free(self, *, without: str, also: str = "") -> Bool:
        """Cells that all layers but one or two leave free."""
        ground, skipped = self._ground, (without, also)
        free = np.ones(ground.frame.shape, bool)
        if "slope" not in skipped:
            free &= self.slope <= ground.rover.max_slope
        if "step" not in skipped:
            free &= self.step <= ground.rover.max_step
        if "no data" not in skipped:
            free &= ~self.unknown
        if "zone" not in skipped:
            free &= ~self.zoned
        return free


def _reached(values: Any, radius: float) -> F32:
    """The largest value within a circle [cells] around each cell."""
    values = values.astype(np.float32)
    reach = int(radius * (1.0 + 1e-12))
    if reach < 1:
        return values
    from scipy import ndimage

    i, j = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    disc = i * i + j * j <= radius * radius * (1.0 + 2e-12)
    return cast(Any, ndimage).maximum_filter(values, footprint=disc, mode="nearest")


def _missing(ground: Going) -> str:
    plain = ground.hazards.standing.plain
    return "what is not free on the map" if plain else "ground without data"


def _joined(free: Bool, first: Any, last: Any) -> bool:
    """Whether two cells lie in one piece of free ground."""
    from scipy import ndimage

    if not (free[first] and free[last]):
        return False
    regions, _count = cast(Any, ndimage).label(free)
    return bool(regions[first] == regions[last])


def _threshold(
    grid: Any, others: Bool, ends: tuple[Any, Any], low: float, high: float
) -> float | None:
    """The lowest value at which cells up to it join the ends; None where `high` does not."""
    if not _joined(others & (grid <= high), *ends):
        return None
    for _ in range(STEPS):
        middle = 0.5 * (low + high)
        if _joined(others & (grid <= middle), *ends):
            high = middle
        else:
            low = middle
    return high


def _where(ground: Going, free: Bool, grid: Any, ends: tuple[Any, Any]) -> Point:
    """Where the largest value lies on a way through free cells [m]."""
    frame = ground.frame
    value_ = np.maximum(np.where(np.isfinite(grid), grid, 0.0), 0.0)
    weight = 1.0 + 100.0 * value_ / max(float(value_[free].max()), 1e-9)
    costs = CostMap.of(weight, frame, forbidden=~free)
    points: F64 = shortest(costs, *(frame.centre_of(*end) for end in ends)).points
    cells = [frame.cell_of(*point) for point in points]
    hardest = max(cells, key=lambda cell: grid[cell])
    return frame.centre_of(*hardest)


def unit_words(number: float, unit: str) -> str:
    """A limit with its unit for people."""
    if unit == "rad":
        return f"{math.degrees(number):.2f} deg"
    return f"{number:.0%}" if unit == "1" else f"{number:.4g} {unit}"


def place_words(at: Point) -> str:
    """A local point for people."""
    return f"({at[0]:.6g}, {at[1]:.6g}) m"
