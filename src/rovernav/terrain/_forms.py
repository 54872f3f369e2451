"""Dunes, cliffs and pits: forms of the ground with a size of their own.

Each adds its heights to any window of an endless plane, the same wherever the window begins.
"""

from __future__ import annotations

import math

import numpy as np

from ..core import F64, SettingError, value
from ..kernels import craters as ck
from ..kernels import field as fk
from ._field import SHARE, key_of
from ._strewn import Class, expected, size_classes, strewn

REPOSE = math.radians(34.0)
"""Loose sand does not stand steeper."""
STOSS = 0.65
"""Share of a dune's length that rises with the wind; the lee side is shorter and steeper."""
WARP = 0.35
"""How far crests wander, in wavelengths (rms)."""
DUNES, CLIFFS, PITS = 21, 22, 23
"""Keep the forms of a seed apart."""


@value
class Dunes:
    """Dunes or ripples: long crests across the wind, their lee sides steeper.

    Attributes:
        wavelength: From crest to crest [m].
        height: From trough to crest [m].
        wind: Direction the wind blows to, clockwise from north [rad].
    """

    wavelength: float
    height: float
    wind: float = math.radians(90.0)

    def _check(self) -> None:
        if not (0.0 < self.wavelength <= 1e5 and self.height > 0.0 and math.isfinite(self.wind)):
            raise SettingError(
                f"dunes need a wavelength up to 100000 m, a height above 0 and a wind, got {self}"
            )
        if self.lee > REPOSE:
            most = math.tan(REPOSE) * (1.0 - STOSS) * self.wavelength / 1.5
            raise SettingError(
                f"dunes of {self.height:g} m every {self.wavelength:g} m would stand at "
                f"{math.degrees(self.lee):.0f} deg, more than sand does (34 deg); at most "
                f"{most:.3g} m are possible"
            )

    @property
    def lee(self) -> float:
        """Steepest slope, on the lee side [rad]."""
        return math.atan(1.5 * self.height / ((1.0 - STOSS) * self.wavelength))

    def add_to(self, out: F64, row: int, column: int, cell: float, seed: int) -> None:
        """Add the dunes to `out` (h, w) [m], whose first cell is (row, column)."""
        h, w = out.shape
        warp = np.zeros((h, w))
        key = key_of(seed, DUNES, 0)
        fk.add_waves(warp, row, column, cell / (6.0 * self.wavelength), key, WARP / SHARE)
        x = (column + np.arange(w) + 0.5) * (cell * math.sin(self.wind) / self.wavelength)
        y = (row + np.arange(h) + 0.5) * (cell * math.cos(self.wind) / self.wavelength)
        phase = warp + y[:, None] + x[None, :]
        phase -= np.floor(phase)
        rise = np.where(phase < STOSS, phase / STOSS, (1.0 - phase) / (1.0 - STOSS))
        out += self.height * rise * rise * (3.0 - 2.0 * rise)


@value
class Cliffs:
    """Plateaus with steep edges.

    Attributes:
        height: Of the plateaus over the ground between them [m].
        spacing: Distance over which plateau and ground alternate [m].
        face: Slope of the edges [rad].
    """

    height: float
    spacing: float
    face: float = math.radians(75.0)

    def _check(self) -> None:
        if not (0.0 < self.height <= 1e4 and 0.0 < self.spacing <= 1e5):
            raise SettingError(
                f"cliffs need a height up to 10000 m and a spacing up to 100000 m, got "
                f"{self.height:g} and {self.spacing:g}"
            )
        if not math.radians(30.0) <= self.face <= math.radians(89.0):
            raise SettingError(
                f"the face of a cliff must stand at 30 to 89 deg, got {math.degrees(self.face):g}"
            )

    def add_to(self, out: F64, row: int, column: int, cell: float, seed: int) -> None:
        """Add the plateaus to `out` (h, w) [m], whose first cell is (row, column)."""
        h, w = out.shape
        f = np.zeros((h + 2, w + 2))
        key = key_of(seed, CLIFFS, 0)
        fk.add_waves(f, row - 1, column - 1, 2.0 * cell / self.spacing, key, 1.0)
        east, north = f[1:-1, 2:] - f[1:-1, :-2], f[2:, 1:-1] - f[:-2, 1:-1]
        steep = np.maximum(np.hypot(east, north) / (2.0 * cell), 1e-12)
        away = f[1:-1, 1:-1] / steep  # about the distance from the edge [m]
        width = 1.5 * self.height / math.tan(self.face)  # a smooth step is steepest in its middle
        s = np.clip(away / width + 0.5, 0.0, 1.0)
        out += self.height * s * s * (3.0 - 2.0 * s)


@value
class Pits:
    """Collapse pits: level floors within steep walls.

    Attributes:
        per_km2: How many pits of at least the smallest diameter lie on a square kilometre.
        smallest: Least diameter [m].
        largest: Greatest diameter [m]; their number falls as the diameter to the power -2.
        depth: Depth as a share of the diameter.
        wall: Slope of the walls [rad].
    """

    per_km2: float
    smallest: float
    largest: float
    depth: float = 0.4
    wall: float = math.radians(70.0)

    def _check(self) -> None:
        if not (0.0 < self.per_km2 <= 1e9 and 0.0 < self.smallest < self.largest <= 1e5):
            raise SettingError(
                "pits need a number per km^2 above 0 and 0 < smallest < largest <= 100000 m, got "
                f"{self.per_km2:g}, {self.smallest:g} and {self.largest:g}"
            )
        if not (0.0 < self.depth <= 2.0 and math.radians(30) <= self.wall <= math.radians(89)):
            raise SettingError("pits need a depth of up to 2 diameters and walls of 30 to 89 deg")

    def count(self, diameter: float) -> float:
        """How many of at least `diameter` [m] lie on a square metre."""

        def above(d: float) -> float:
            return d**-2 - self.largest**-2

        return self.per_km2 * 1e-6 * above(diameter) / above(self.smallest)

    def classes(self) -> list[Class]:
        """Sizes and tiles."""
        return size_classes(self.count, self.smallest, self.largest)

    def expected(self, area: float) -> float:
        """How many middles lie on an area [m^2] on average."""
        return expected(self.classes(), area)

    def sink(self, out: F64, corner: tuple[float, float], cell: float, seed: int) -> F64:
        """Lower `out` (h, w) [m] by the pits; returns (n, 4) x, y, diameter [m] and chance."""
        (x, y), (h, w) = corner, out.shape
        window = (x, y, x + w * cell, y + h * cell)
        rows = strewn(self.classes(), self.count, window, reach=0.5, seed=(seed, PITS))
        radius = rows[:, 2] / 2.0
        depth = self.depth * rows[:, 2]
        wall = np.minimum(1.5 * depth / math.tan(self.wall), 0.9 * radius)
        columns = ((rows[:, 0] - x) / cell, (rows[:, 1] - y) / cell, radius / cell, depth,
                   np.maximum(wall / cell, 1e-9))  # fmt: skip
        sunk = np.zeros_like(out)
        ck.sink_pits(np.ascontiguousarray(np.column_stack(columns)), sunk)
        out += sunk
        return rows
