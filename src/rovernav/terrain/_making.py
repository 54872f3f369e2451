"""Ground made to order: relief, craters, dunes, cliffs, pits, rocks and holes, by one seed."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np

from ..core import F64, Frame, SettingError, value
from ..kernels import field as k
from ._craters import Craters
from ._elevation import Terrain
from ._field import OUTER, SHARE, Field, fitted_field, key_of, self_affine_law
from ._forms import Cliffs, Dunes, Pits
from ._raster import MAX_CELLS, Progress, Window
from ._rocks import RockField
from ._strewn import MOST

RELIEF, HOLES = 1, 31
"""Keep the parts of a seed apart."""
STRIP = 4_000_000
"""Cells that are made at a time."""
PATCH = 6.0
"""Half the width of a hole, about [cells]."""


@value
class Relief:
    """Self-affine relief.

    Attributes:
        hurst: Hurst exponent: 0.3 is jagged, 0.95 smooth; Mars has 0.7 to 0.95.
        slope: Root mean square slope along the baseline [rad].
        baseline: Length over which `slope` holds [m].
    """

    hurst: float = 0.8
    slope: float = math.radians(6.0)
    baseline: float = 1.0

    def _check(self) -> None:
        if not 0.2 <= self.hurst <= 0.98:
            raise SettingError(
                f"the Hurst exponent must lie in 0.2 to 0.98, got {self.hurst:g}; 0.8 is usual"
            )
        if not 0.0 <= self.slope <= math.radians(60.0):
            raise SettingError(
                f"the rms slope must lie in 0 to 60 deg, got {math.degrees(self.slope):g}"
            )
        if not 0.0 < self.baseline <= 1e5:
            raise SettingError(f"a baseline must lie in 0 to 100000 m, got {self.baseline:g}")


@value
class Recipe:
    """What ground is made of. Parts that are None are left out.

    Attributes:
        size: East-west and north-south [m].
        cell: Side of a cell [m].
        relief: Self-affine relief.
        craters: Impact craters.
        dunes: Dunes or ripples.
        cliffs: Plateaus with steep edges.
        pits: Collapse pits.
        rocks: Share of the ground that rocks of all sizes cover.
        rock_sizes: Least and greatest diameter of rocks [m].
        holes: Share of the cells without data.
    """

    size: tuple[float, float] = (100.0, 100.0)
    cell: float = 0.25
    relief: Relief = Relief()
    craters: Craters | None = None
    dunes: Dunes | None = None
    cliffs: Cliffs | None = None
    pits: Pits | None = None
    rocks: float | None = None
    rock_sizes: tuple[float, float] | None = None
    holes: float = 0.0

    def _check(self) -> None:
        if not (math.isfinite(self.cell) and self.cell > 0):
            raise SettingError(f"a cell must be a positive number of metres, got {self.cell:g}")
        if not all(3.0 * self.cell <= side <= 1e7 for side in self.size):
            raise SettingError(
                f"ground needs at least 3 x 3 cells of {self.cell:g} m and at most 10000 km, got "
                f"{self.size[0]:g} x {self.size[1]:g} m"
            )
        if not 0.0 <= self.holes <= 0.9:
            raise SettingError(f"the share of holes must lie in 0 to 0.9, got {self.holes:g}")
        self.rock_field()

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return round(self.size[1] / self.cell), round(self.size[0] / self.cell)

    def rock_field(self) -> RockField | None:
        """The rocks: from 0.6 of a cell, at least 0.1 m, to 2 m or eight times that by default."""
        if self.rocks is None:
            return None
        least = max(0.1, 0.6 * self.cell)
        small, large = self.rock_sizes or (least, max(2.0, 8.0 * least))
        return RockField(abundance=self.rocks, smallest=small, largest=large)


@value
class Ground:
    """Ground made by a recipe and a seed; nothing is computed before it is read.

    Any window of it has the same heights, whatever was read before and whatever the size.

    Attributes:
        recipe: What it is made of.
        seed: Where all randomness comes from.
        frame: The whole grid.
    """

    recipe: Recipe
    seed: int
    frame: Frame

    @classmethod
    def made(cls, recipe: Recipe, seed: int) -> Ground:
        """The ground of a recipe.

        Raises:
            SettingError: The seed is below 0, or so many things would lie on it that no memory
                holds them.
        """
        if not 0 <= seed < 2**63:
            raise SettingError(f"a seed must lie in 0 to 2^63 - 1, got {seed}")
        area = recipe.size[0] * recipe.size[1]
        for what, many in (("craters", recipe.craters), ("pits", recipe.pits),
                           ("rocks", recipe.rock_field())):  # fmt: skip
            if many is not None and many.expected(area) > MOST:
                raise SettingError(
                    f"about {many.expected(area):.2g} {what} would lie on {recipe.size[0]:g} x "
                    f"{recipe.size[1]:g} m, more than {MOST:,}; give a larger smallest diameter"
                )
        return cls(recipe=recipe, seed=seed, frame=Frame(cell=recipe.cell, shape=recipe.shape))

    def relief(self) -> Field | None:
        """The self-affine part; None where the slope is 0."""
        r, cell = self.recipe.relief, self.recipe.cell
        if r.slope == 0.0:
            return None
        law = self_affine_law(r.hurst, math.tan(r.slope), r.baseline)
        extent = max(self.recipe.size)
        return fitted_field(
            law, cell, longest=OUTER * extent, farthest=max(extent / 4.0, r.baseline),
            seed=self.seed, channel=RELIEF,
        )  # fmt: skip

    def read(self, window: Window | None = None, *, on_progress: Progress | None = None) -> Terrain:
        """Heights of a window, all of it where not given.

        Raises:
            SettingError: It has more than `MAX_CELLS` cells.
        """
        window = window or Window(
            row=0, column=0, rows=self.frame.shape[0], columns=self.frame.shape[1]
        )
        shape = (window.rows, window.columns)
        if shape[0] * shape[1] > MAX_CELLS:
            raise SettingError(
                f"{shape[1]:,} x {shape[0]:,} cells are more than {MAX_CELLS:,} at a time; give a "
                "larger --cell or a smaller --size"
            )
        heights = np.empty(shape, np.float32)
        field = self.relief()
        base = self._base(field)
        strip = max(1, STRIP // shape[1])
        for first in range(0, shape[0], strip):
            rows = min(strip, shape[0] - first)
            part = dataclasses.replace(window, row=window.row + first, rows=rows)
            heights[first : first + rows] = self._strip(part, field) - base
            if on_progress is not None:
                on_progress((first + rows) / shape[0])
        frame = self.frame.part(window.row, window.column, shape)
        name = f"ground-{self.seed}"
        return Terrain(frame=frame, height=heights, offset=0.0, name=name, source=self.words())

    def parts(self, window: Window) -> dict[str, Any]:
        """The layers of a window by themselves [m], and what lies on it: for measuring."""
        r, corner = self.recipe, self._corner(window)
        out: dict[str, Any] = {}
        empty = (window.rows, window.columns)
        at = (window.row, window.column)
        out["relief"] = np.zeros(empty)
        field = self.relief()
        if field is not None:
            field.add_to(out["relief"], *at)
        for name, form in (("dunes", r.dunes), ("cliffs", r.cliffs)):
            if form is not None:
                out[name] = np.zeros(empty)
                form.add_to(out[name], *at, r.cell, self.seed)
        if r.craters is not None:
            out["craters"] = r.craters.dig(np.zeros(empty), corner, r.cell, self.seed)
        if r.pits is not None:
            out["pits"] = r.pits.sink(np.zeros(empty), corner, r.cell, self.seed)
        rocks = r.rock_field()
        if rocks is not None:
            out["rocks"] = rocks.raise_on(np.zeros(empty), corner, r.cell, self.seed)
        return out

    def words(self) -> str:
        """What it is made of, in a line."""
        r = self.recipe
        said = [f"relief of Hurst exponent {r.relief.hurst:g} and rms slope "
                f"{math.degrees(r.relief.slope):g} deg over {r.relief.baseline:g} m"]  # fmt: skip
        if r.craters is not None:
            said.append(f"craters as on {_BODIES[r.craters.body]} after {r.craters.age:g} Gyr")
        said += [name for name in ("dunes", "cliffs", "pits") if getattr(r, name) is not None]
        if r.rocks is not None:
            said.append(f"rocks over {r.rocks:.1%}")
        return f"generated ground, seed {self.seed}: {', '.join(said)}"

    def _strip(self, window: Window, field: Field | None) -> F64:
        r, corner = self.recipe, self._corner(window)
        at = (window.row, window.column)
        out = np.zeros((window.rows, window.columns))
        if field is not None:
            field.add_to(out, *at)
        for form in (r.dunes, r.cliffs):
            if form is not None:
                form.add_to(out, *at, r.cell, self.seed)
        if r.craters is not None:
            r.craters.dig(out, corner, r.cell, self.seed)
        if r.pits is not None:
            r.pits.sink(out, corner, r.cell, self.seed)
        rocks = r.rock_field()
        if rocks is not None:
            rocks.raise_on(out, corner, r.cell, self.seed)
        if r.holes > 0.0:
            out[self._missing(window)] = np.nan
        return out

    def _missing(self, window: Window) -> Any:
        """Patches that cover about the share asked for."""
        from scipy.special import ndtri

        waves = np.zeros((window.rows, window.columns))
        key = key_of(self.seed, HOLES, 0)
        k.add_waves(waves, window.row, window.column, 1.0 / PATCH, key, 1.0 / SHARE)
        return waves < float(ndtri(self.recipe.holes))

    def _base(self, field: Field | None) -> float:
        """What all heights are lowered by: the first cell lies within a metre above 0."""
        one = np.zeros((1, 1))
        if field is not None:
            field.add_to(one, 0, 0)
        return float(np.floor(one[0, 0]))

    def _corner(self, window: Window) -> tuple[float, float]:
        return window.column * self.recipe.cell, window.row * self.recipe.cell


_BODIES = {"mars": "Mars", "moon": "the Moon"}
