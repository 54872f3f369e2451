"""Craters: how many of each size, how deep, and how they wear away.

Symbols: D diameter from rim to rim [m], T age of the surface [Gyr], N(D) craters of at least D per
square metre, kappa topographic diffusivity [m^2/Myr], t age of a crater [Myr], K = kappa t / D^2.

Number. Production: log10 N(D) = sum a_j (log10 D/km)^j per km^2 after 1 Gyr, for the Moon from
10 m up (G. Neukum, B. A. Ivanov and W. K. Hartmann, Space Sci. Rev. 96, 55, 2001) and for Mars from
15 m up (B. A. Ivanov, Space Sci. Rev. 96, 87, 2001), smaller ones by the slope at that end; times
the age by N(1 km) ~ 5.44e-14 (e^(6.93 T) - 1) + 8.38e-4 T (Neukum et al. 2001). Old surfaces hold
no more small craters than equilibrium: N(D) = 10^-1.1 (D/km)^-2 per km^2 (N. J. Trask 1966).

Depth. Fresh craters are 0.2 D deep with a rim 0.036 D high (R. J. Pike, in Impact and Explosion
Cratering, 1977). The bowl is a parabola; outside the rim falls off as (R/r)^3. Age wears them by
diffusion, dh/dt = kappa Laplace h: on the lunar maria kappa is 5.5 m^2/Myr (C. I. Fassett and
B. J. Thomson, J. Geophys. Res. Planets 119, 2255, 2014).
"""

from __future__ import annotations

import functools
import math

import numpy as np

from ..core import F64, SettingError, suggest, value
from ..kernels import craters as k
from ._strewn import Class, expected, size_classes, strewn

BODIES: dict[str, tuple[float, ...]] = {
    "moon": (-3.0876, -3.557528, 0.781027, 1.021521, -0.156012, -0.444058, 0.019977, 0.086850,
             -0.005874, -0.006809, 8.25e-4, 5.54e-5),
    "mars": (-3.384, -3.197, 1.257, 0.7915, -0.4861, -0.3630, 0.1016, 6.756e-2, -1.181e-2,
             -4.753e-3, 6.233e-4, 5.805e-5),
}  # fmt: skip
VALID_KM = {"moon": 0.010, "mars": 0.015}
"""Smallest diameter that the production function was fitted to [km]."""
EQUILIBRIUM = 10.0**-1.1
"""Cumulative craters of 1 km per km^2 in equilibrium, were there no larger ones."""

DEPTH, RIM = 0.2, 0.036
"""Depth from rim to floor and height of the rim of a fresh crater, as shares of its diameter."""
GONE = 0.07
"""A crater worn to this share of its fresh depth is beyond recognition (Fassett and Thomson)."""
REACH = 6.0
"""A crater is felt up to so many radii from its middle."""
WEAR, FINEST = 60, 0.02
"""Entries of the table of wear, and its steps of radius."""
MOST_WORN = 0.3
"""K of the last entry."""


@value
class Craters:
    """A population of craters.

    Attributes:
        body: ``moon`` or ``mars``: whose production function.
        age: Age of the surface [Gyr].
        smallest: Least diameter [m].
        largest: Greatest diameter [m].
        diffusivity: How fast they wear [m^2/Myr]; 0 keeps all of them fresh.
        depth: Depth of fresh ones as a share of the diameter.
    """

    body: str
    age: float
    smallest: float
    largest: float
    diffusivity: float = 5.5
    depth: float = DEPTH

    def _check(self) -> None:
        if self.body not in BODIES:
            raise SettingError(f"craters of {self.body!r} are not known; "
                               f"{suggest(self.body, BODIES)}")  # fmt: skip
        if not 0.0 < self.age <= 4.5:
            raise SettingError(f"the age of a surface must lie in 0 to 4.5 Gyr, got {self.age:g}")
        if not 0.0 < self.smallest < self.largest <= 1e5:
            raise SettingError(
                f"craters need 0 < smallest < largest <= 100000 m, got {self.smallest:g} to "
                f"{self.largest:g} m"
            )
        if not (0.0 <= self.diffusivity <= 1e6 and 0.0 < self.depth <= 0.5):
            raise SettingError(
                "craters need a diffusivity of 0 to 1e6 m^2/Myr and a depth of up to half a "
                f"diameter, got {self.diffusivity:g} and {self.depth:g}"
            )

    def count(self, diameter: float) -> float:
        """N(D): how many of at least `diameter` [m] lie on a square metre."""
        return min(production(self.body, diameter, self.age), equilibrium(diameter))

    def classes(self) -> list[Class]:
        """Sizes and tiles."""
        return size_classes(self.count, self.smallest, self.largest)

    def expected(self, area: float) -> float:
        """How many middles lie on an area [m^2] on average."""
        return expected(self.classes(), area)

    def within(self, window: tuple[float, float, float, float], seed: int) -> F64:
        """(n, 4): x, y, diameter [m] and wear K of the craters felt in a window [m]."""
        rows = strewn(
            self.classes(), self.count, window, reach=0.5 * REACH, seed=(seed, CHANNEL)
        )  # fmt: skip
        rows[:, 3] *= self._oldest(rows[:, 2])
        return rows

    def dig(self, out: F64, corner: tuple[float, float], cell: float, seed: int) -> F64:
        """Add the craters to `out` (h, w) [m]; its corner [m] and cells say where it lies.

        Returns:
            What `within` gives for the window.
        """
        (x, y), (h, w) = corner, out.shape
        rows = self.within((x, y, x + w * cell, y + h * cell), seed)
        wear = np.sqrt(np.minimum(rows[:, 3] / MOST_WORN, 1.0)) * (WEAR - 1)
        columns = ((rows[:, 0] - x) / cell, (rows[:, 1] - y) / cell, rows[:, 2] / (2.0 * cell),
                   rows[:, 2] * self.depth / DEPTH, np.minimum(wear, WEAR - 1.001))  # fmt: skip
        k.dig_craters(np.column_stack(columns), worn_profiles(), FINEST, out)
        return rows

    def _oldest(self, diameter: F64) -> F64:
        """K of the oldest crater of each diameter that can still be seen, or that there is."""
        if self.diffusivity == 0.0:
            return np.zeros_like(diameter)
        return np.minimum(self.diffusivity * self.age * 1000.0 / diameter**2, _last_seen())


CHANNEL = 11
"""Keeps the craters of a seed apart from its rocks."""


def production(body: str, diameter: float, age: float) -> float:
    """Craters of at least `diameter` [m] made on a square metre within `age` [Gyr]."""
    km, valid = diameter / 1000.0, VALID_KM[body]
    x = math.log10(max(km, valid))
    log_n, slope = 0.0, 0.0
    for power, a in enumerate(BODIES[body]):
        log_n += a * x**power
        slope += power * a * x ** (power - 1) if power else 0.0
    if km < valid:
        log_n += slope * math.log10(km / valid)
    return 10.0**log_n * 1e-6 * _grown(age) / _grown(1.0)


def equilibrium(diameter: float) -> float:
    """Most craters of at least `diameter` [m] that a square metre can keep."""
    return EQUILIBRIUM * (diameter / 1000.0) ** -2 * 1e-6


def _grown(age: float) -> float:
    return 5.44e-14 * math.expm1(6.93 * age) + 8.38e-4 * age


@functools.cache
def worn_profiles() -> F64:
    """Profiles (WEAR, places) as shares of the diameter, out to `REACH` radii.

    Row a has K = MOST_WORN (a / (WEAR - 1))^2. The heat equation in rings, implicit in time; far
    outside the profile is brought to zero smoothly.
    """
    from scipy.linalg import solve_banded

    step = FINEST / 2.0  # of the diameter
    r = (np.arange(round(2.0 * REACH / FINEST)) + 0.5) * step  # twice as far as the table goes
    edges = np.arange(len(r) + 1) * step
    flow = edges / step
    flow[[0, -1]] = 0.0
    size = r * step
    h = fresh_profile(np.asarray(2.0 * r, np.float64))
    rows = [h]
    wear = MOST_WORN * (np.arange(WEAR) / (WEAR - 1)) ** 2
    for dk in np.diff(wear):
        part = dk / 20.0
        bands = np.zeros((3, len(r)))
        bands[0, 1:] = -part * flow[1:-1] / size[:-1]
        bands[1] = 1.0 + part * (flow[:-1] + flow[1:]) / size
        bands[2, :-1] = -part * flow[1:-1] / size[1:]
        for _ in range(20):
            h = solve_banded((1, 1), bands, h)
        rows.append(h)
    places = np.arange(round(REACH / FINEST) + 1) * FINEST
    fade = np.clip((REACH - places) / (0.5 * REACH), 0.0, 1.0)
    fade = fade * fade * (3.0 - 2.0 * fade)
    return np.array([np.interp(places / 2.0, r, row) * fade for row in rows])


def fresh_profile(r: F64) -> F64:
    """Height over the old ground, as a share of the diameter, at `r` radii from the middle."""
    bowl = RIM - DEPTH * (1.0 - np.minimum(r, 1.0) ** 2)
    return np.where(r < 1.0, bowl, RIM / np.maximum(r, 1.0) ** 3)


def depth_left(wear: float) -> float:
    """Depth from rim to floor of a crater worn to K, as a share of its fresh depth."""
    table = worn_profiles()
    depths = table.max(axis=1) - table[:, 0]
    at = math.sqrt(min(wear / MOST_WORN, 1.0)) * (WEAR - 1)
    return float(np.interp(at, np.arange(WEAR), depths) / depths[0])


@functools.cache
def _last_seen() -> float:
    """K at which a crater is beyond recognition."""
    grid = MOST_WORN * np.linspace(0.0, 1.0, 601)
    left = np.array([depth_left(wear) for wear in grid.tolist()])
    return float(grid[np.argmax(left < GONE)]) if (left < GONE).any() else MOST_WORN
