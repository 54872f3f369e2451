"""Ground judged for one rover: where it can stand, and layers that say what the ground is like."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from ..core import F32, U8, Frame, SettingError, value
from ..kernels import distance, traction
from ..terrain import Planes, Terrain, planes_over
from ._bound import Bound, bound
from ._model import Rover
from ._settle import surface
from ._soils import Soil
from ._standing import I32, Standing, judged
from ._traction import drive_table
from ._words import WORDS

UPHILL = "straight uphill"
MOST_PROVEN = 4_000_000
"""Poses that `hazards` is ready to prove: some minutes' work."""


@value
class Layer:
    """One number for each cell, which explains itself.

    Attributes:
        name: Short name.
        values: (h, w), float32; NaN where it is not known.
        unit: Of the values; "1" for a share.
        source: Where the formula comes from.
        formula: How the values come about.
        words: What they mean, in a sentence.
    """

    name: str
    values: F32
    unit: str
    source: str
    formula: str
    words: str

    def summary(self) -> dict[str, Any]:
        """Name, unit, words, formula, source, and the spread of the values that are finite."""
        known = self.values[np.isfinite(self.values)]
        at = np.percentile(known, (0, 5, 50, 95, 100)) if known.size else np.full(5, math.nan)
        return {
            **{key: getattr(self, key) for key in ("name", "unit", "words", "formula", "source")},
            "known": known.size / self.values.size,
            **dict(zip(("lowest", "p5", "median", "p95", "highest"), map(float, at), strict=True)),
        }


@value
class Hazards:
    """One terrain judged for one rover.

    Attributes:
        standing: Where it can stand, with the reasons.
        rover: Name of the rover.
        soil: Name of the soil that slip and energy are for; None without a mobility section.
        heading: Direction of travel that directional layers are for [rad]; None for uphill.
        layers: By name.
    """

    standing: Standing
    rover: str
    soil: str | None
    heading: float | None
    layers: Mapping[str, Layer]

    @property
    def frame(self) -> Frame:
        """Where the cells lie."""
        return self.standing.frame

    @property
    def blocked(self) -> U8:
        """1 where the rover's middle must not be (h, w), uint8."""
        return self.standing.blocked

    @property
    def reason(self) -> U8:
        """A `Reason` for each cell (h, w), uint8."""
        return self.standing.reason


def hazards(
    terrain: Terrain,
    rover: Rover,
    *,
    soil: str | Soil | None = None,
    heading: float | None = None,
    turns: int = 0,
    effort: bool = True,
) -> Hazards:
    """Judge a terrain for a rover.

    Layers: `slope`, `east`, `north`, `roughness`, `step`, `distance`; with a mobility section
    `slip` and `energy`; with a heading `pitch` and `roll`; with turns `tilt_bound`,
    `clearance_bound` and `proven`.

    Args:
        terrain: The ground.
        rover: Whose limits count.
        soil: A soil or its name; the rover's own where not given.
        heading: Direction of travel that slip, energy, pitch and roll are for [rad]; uphill, where
            both cost most, if not given.
        turns: Headings, evenly spaced, for which every pose with its middle in a cell is bounded:
            slow, some 30 thousand poses a second, and pointless on cells wider than the rover.
            0 leaves these layers out.
        effort: Whether to give the layers of slip and energy.

    Raises:
        SettingError: A soil for a rover without a mobility section, an unknown one, or turns for
            more than 4 million poses.
    """
    planes = planes_over(terrain, rover.footing)
    where, squared = judged(terrain, rover, planes)
    values: dict[str, F32] = {
        "slope": where.slope,
        "east": planes.east,
        "north": planes.north,
        "roughness": planes.rms,
        "step": where.step,
        "distance": _distance(squared, terrain.frame.cell),
    }
    table_soil = _soil_of(rover, soil)
    if effort and table_soil is not None:
        _slip_and_energy(planes, drive_table(rover, table_soil), heading, values)
    if heading is not None:
        values |= _lean(planes, heading)
    if turns:
        values |= _proof(terrain, rover, turns)
    course = UPHILL if heading is None else f"at a heading of {math.degrees(heading):g} deg"
    over = f"{planes.posts} x {planes.posts} posts of {terrain.frame.cell:.3g} m"
    own = {"footing": over, "wheel": f"{2.0 * rover.wheel_radius:g} m", "course": course}
    layers = {name: _layer(name, grid, own) for name, grid in values.items()}
    return Hazards(
        standing=where,
        rover=rover.name,
        soil=table_soil.name if isinstance(table_soil, Soil) else table_soil,
        heading=heading,
        layers=MappingProxyType(layers),
    )


def _layer(name: str, values: F32, own: Mapping[str, str]) -> Layer:
    unit, words, formula, source = WORDS[name]
    return Layer(
        name=name, values=values, unit=unit, source=source, formula=formula,
        words=words.format(**own),
    )  # fmt: skip


def _distance(squared: I32, cell: float) -> F32:
    """Distances [m], in the room of their squares."""
    out = squared.view(np.float32)
    distance.metres(squared, cell, out)
    return out


def _lean(planes: Planes, heading: float) -> dict[str, F32]:
    out = np.empty((2, *planes.east.shape), np.float32)
    way = (math.cos(heading), math.sin(heading))
    traction.lean(planes.east, planes.north, way, out[0], out[1])
    return {"pitch": out[0], "roll": out[1]}


def _soil_of(rover: Rover, soil: str | Soil | None) -> str | Soil | None:
    """What it is driven over; None where the rover lacks what that would matter to."""
    if soil is not None:
        drive_table(rover, soil)  # refuses what cannot be
        return soil
    return rover.mobility.soil if rover.mobility else None


def _slip_and_energy(planes: Planes, table: Any, heading: float | None, values: Any) -> None:
    """Add both layers."""
    way = (0.0, 0.0) if heading is None else (math.cos(heading), math.sin(heading))
    values["slip"], values["energy"] = np.empty((2, *planes.east.shape), np.float32)
    grids = (values["slip"], values["energy"])
    traction.drive_layer(planes.east, planes.north, way, table, 0, *grids)


def _proof(terrain: Terrain, rover: Rover, turns: int) -> dict[str, F32]:
    """Worst bounds over all headings, for the middle anywhere in each cell."""
    h, w = terrain.frame.shape
    if turns < 1 or turns * h * w > MOST_PROVEN:
        raise SettingError(
            f"bounds at {turns} headings for {h:,} x {w:,} cells are more than {MOST_PROVEN:,} "
            "poses; cut the terrain, or give fewer turns (at least 1)"
        )
    ready, cell = surface(terrain, rover), terrain.frame.cell
    y, x = ((np.indices((h, w)) + 0.5) * cell).reshape(2, -1)
    tilt, gap, safe = np.zeros(h * w), np.full(h * w, np.inf), np.zeros(h * w)
    for n in range(turns):
        rows = np.stack([x, y, np.full(h * w, 2.0 * math.pi * n / turns)], axis=1)
        held: Bound = bound(ready, rows, position=0.5 * cell, heading=min(1.0, math.pi / turns))
        proven = held.safe
        tilt = np.maximum(tilt, np.where(proven, held.tilt, np.nan))
        gap = np.minimum(gap, np.where(proven, held.clearance, np.nan))
        safe += proven
    grids = {"tilt_bound": tilt, "clearance_bound": gap, "proven": safe / turns}
    return {name: grid.reshape(h, w).astype(np.float32) for name, grid in grids.items()}
