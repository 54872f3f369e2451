"""Rocks strewn on ground, as many and as large as landers have counted them on Mars.

Symbols: k share of the ground that all rocks cover, D diameter [m], q = 1.79 + 0.152/k [1/m],
F_k(D) = k exp(-q D) share covered by rocks of at least D.
Source: M. Golombek and D. Rapp, Size-frequency distributions of rocks on Mars, J. Geophys. Res.
102 (1997), doi 10.1029/96JE03319; height of half a diameter after the same counts.
"""

from __future__ import annotations

import math

import numpy as np

from ..core import F64, Frame, SettingError, ShapeError, value
from ..kernels import rocks as k
from ._elevation import Terrain
from ._strewn import Class, expected, size_classes, strewn

LEAST, MOST = 0.005, 0.4
"""Range of rock abundance: from almost none to the rockiest ground the law was fitted to."""

MAX_ROCKS = 20_000_000
HEIGHT_TO_DIAMETER = 0.5
CHANNEL = 17
"""Keeps the rocks of a seed apart from its craters."""


@value
class Rocks:
    """Rocks as half ellipsoids on the ground.

    Attributes:
        x: East (n,), local frame [m].
        y: North (n,), local frame [m].
        diameter: (n,) [m].
        height: Above the ground (n,) [m].
    """

    x: F64
    y: F64
    diameter: F64
    height: F64

    def _check(self) -> None:
        shapes = {a.shape for a in (self.x, self.y, self.diameter, self.height)}
        if len(shapes) != 1 or self.x.ndim != 1:
            raise ShapeError(f"rocks need four arrays of one shape (n,), got {sorted(shapes)}")
        for name, sizes in (("diameter", self.diameter), ("height", self.height)):
            if not (np.isfinite(sizes) & (sizes > 0)).all():
                raise ShapeError(f"every rock needs a positive {name} [m]")
        if not (np.isfinite(self.x) & np.isfinite(self.y)).all():
            raise ShapeError("every rock needs finite coordinates [m]")

    def __len__(self) -> int:
        """How many rocks."""
        return len(self.x)


def rock_cover(diameter: float, abundance: float) -> float:
    """Share of the ground covered by rocks of at least `diameter` [m]: F_k(D)."""
    _check_abundance(abundance)
    return abundance * math.exp(-_steepness(abundance) * diameter)


def scatter_rocks(
    frame: Frame,
    abundance: float,
    *,
    smallest: float,
    largest: float,
    rng: np.random.Generator,
) -> Rocks:
    """Rocks between two diameters, strewn evenly at random over a grid.

    The law gives the covered area; the number of rocks on an area A per unit of diameter is
    dN = A k q exp(-q D) / (pi D^2 / 4) dD, a Poisson count. Diameters are drawn from A 4 k q
    exp(-q a) / (pi D^2), which is never below it, and each is kept with probability
    exp(-q (D - a)), a being `smallest`. Overlaps are not avoided.

    Args:
        frame: The ground they lie on.
        abundance: k, share of ground that rocks of all sizes cover: 0.005 to 0.4. Near 0.03 at
            InSight, 0.05 at Spirit's site, 0.19 at Pathfinder's.
        smallest: Smallest diameter [m]; without it the number of rocks has no end.
        largest: Largest diameter [m].
        rng: The only source of chance.

    Raises:
        SettingError: A number out of range, or more than 20 million rocks.
    """
    _check_abundance(abundance)
    _check_sizes(smallest, largest)
    q = _steepness(abundance)
    width, height = frame.extent
    density = 4.0 * abundance * q / math.pi * math.exp(-q * smallest)
    expected = width * height * density * (1.0 / smallest - 1.0 / largest)
    if expected > MAX_ROCKS:
        raise SettingError(
            f"about {expected:.2g} rocks of {smallest:g} m and more would lie on "
            f"{width:g} x {height:g} m, more than {MAX_ROCKS:,}; give a larger smallest diameter"
        )
    u = rng.random((int(rng.poisson(expected)), 4))
    diameter = 1.0 / (1.0 / smallest - u[:, 0] * (1.0 / smallest - 1.0 / largest))
    u = u[u[:, 1] < np.exp(-q * (diameter - smallest))]
    diameter = 1.0 / (1.0 / smallest - u[:, 0] * (1.0 / smallest - 1.0 / largest))
    return Rocks(
        x=np.ascontiguousarray(u[:, 2] * width),
        y=np.ascontiguousarray(u[:, 3] * height),
        diameter=diameter,
        height=HEIGHT_TO_DIAMETER * diameter,
    )


def rock_count(diameter: float, abundance: float) -> float:
    """How many rocks of at least `diameter` [m] lie on a square metre: the integral of dN.

    N(D) = (4 k q / pi) (exp(-q D) / D - q E1(q D)), E1 being the exponential integral.
    """
    from scipy.special import exp1

    q = _steepness(abundance)
    bare = math.exp(-q * diameter) / diameter - q * float(exp1(q * diameter))
    return 4.0 * abundance * q / math.pi * bare


@value
class RockField:
    """Rocks over an endless plane, by the same law as `scatter_rocks`.

    Attributes:
        abundance: Share of the ground that rocks of all sizes cover.
        smallest: Least diameter [m].
        largest: Greatest diameter [m].
    """

    abundance: float
    smallest: float
    largest: float

    def _check(self) -> None:
        _check_abundance(self.abundance)
        _check_sizes(self.smallest, self.largest)

    def classes(self) -> list[Class]:
        """Sizes and tiles."""
        return size_classes(self._count, self.smallest, self.largest)

    @property
    def cover(self) -> float:
        """Share of the ground that rocks of these sizes cover on average."""
        small, large = (rock_cover(d, self.abundance) for d in (self.smallest, self.largest))
        return small - large

    def expected(self, area: float) -> float:
        """How many middles lie on an area [m^2] on average."""
        return expected(self.classes(), area)

    def raise_on(self, out: F64, corner: tuple[float, float], cell: float, seed: int) -> F64:
        """Set the rocks onto `out` (h, w) [m]; returns (n, 4) x, y, diameter [m] and chance.

        A cell rises as in `with_rocks`.
        """
        (x, y), (h, w) = corner, out.shape
        window = (x, y, x + w * cell, y + h * cell)
        rows = strewn(self.classes(), self._count, window, reach=0.5, seed=(seed, CHANNEL))
        columns = ((rows[:, 0] - x) / cell, (rows[:, 1] - y) / cell, rows[:, 2] / (2.0 * cell),
                   HEIGHT_TO_DIAMETER * rows[:, 2])  # fmt: skip
        rise = np.zeros_like(out)
        k.raise_rocks(np.ascontiguousarray(np.column_stack(columns)), rise)
        out += rise
        return rows

    def _count(self, diameter: float) -> float:
        return rock_count(diameter, self.abundance)


def with_rocks(terrain: Terrain, rocks: Rocks) -> Terrain:
    """`terrain` with each rock set onto the ground as half an ellipsoid.

    A cell rises by the highest rock over its centre. The cell that holds a rock's middle rises by
    the whole rock, so rocks smaller than a cell count too: as if the post had hit their top. Cells
    without data stay so; rocks off the grid raise only the cells that they reach.
    """
    cell = terrain.frame.cell
    rise = np.zeros(terrain.frame.shape)
    columns = (rocks.x / cell, rocks.y / cell, rocks.diameter / (2.0 * cell), rocks.height)
    k.raise_rocks(np.ascontiguousarray(np.stack(columns, axis=1)), rise)
    return Terrain(
        frame=terrain.frame,
        height=(terrain.height + rise).astype(np.float32),
        offset=terrain.offset,
        name=f"{terrain.name}-rocks",
        source=f"{terrain.source}; {len(rocks)} rocks",
        plain=terrain.plain,
    )


def _steepness(abundance: float) -> float:
    """q(k) [1/m]."""
    return 1.79 + 0.152 / abundance


def _check_abundance(abundance: float) -> None:
    if not LEAST <= abundance <= MOST:
        percent = "; write 5 % as 0.05" if 1.0 <= abundance <= 100.0 else ""
        raise SettingError(
            f"rock abundance must be a share of the ground from {LEAST} to {MOST}, "
            f"got {abundance:g}{percent}"
        )


def _check_sizes(smallest: float, largest: float) -> None:
    if not smallest > 0.0:
        raise SettingError(
            f"the smallest rock must have a positive diameter, got {smallest:g} m: "
            "towards 0 their number grows without end"
        )
    if not smallest < largest < math.inf:
        raise SettingError(
            f"the largest rock ({largest:g} m) must be finite and larger than the smallest "
            f"({smallest:g} m)"
        )
