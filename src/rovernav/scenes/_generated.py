"""Ground that a scenario file asks for: generators by name, each with its settings."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from ..terrain import Terrain, hills

Metres = Annotated[float, Field(allow_inf_nan=False, strict=True)]
MOST_CELLS = 2000
"""Cells along a side of generated ground."""


class Hills(BaseModel):
    """Rolling hills with craters; see `rovernav.terrain.hills`.

    Attributes:
        name: ``hills``.
        side_m: Side of the square ground [m].
        cell_m: Side of a cell [m].
        relief_m: Highest minus lowest height before the craters come [m].
        hurst: Smoothness: 0.5 is jagged, 0.9 smooth.
        craters: How many.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: Literal["hills"] = "hills"
    side_m: Metres = Field(50.0, ge=5, le=1000, title="Side [m]")
    cell_m: Metres = Field(0.2, ge=0.05, le=20, title="Cell [m]")
    relief_m: Metres = Field(5.0, ge=0, le=50, title="Roughness: relief [m]")
    hurst: Metres = Field(0.9, ge=0.3, le=1, title="Smoothness: Hurst exponent")
    craters: int = Field(40, ge=0, le=300, strict=True, title="Craters")

    def make(self, rng: np.random.Generator) -> Terrain:
        """The ground; the same generator's state gives the same ground."""
        cells = min(MOST_CELLS, max(3, round(self.side_m / self.cell_m)))
        return hills(
            rng,
            shape=(cells, cells),
            cell=self.cell_m,
            relief=self.relief_m,
            hurst=self.hurst,
            craters=self.craters,
        )


GENERATORS: dict[str, Callable[..., Any]] = {"hills": Hills}
"""Settings of each kind of generated ground, by the name that a scenario file gives it."""


def generate(settings: Hills, *, seed: int) -> Terrain:
    """The ground that the settings describe; the same seed gives the same ground."""
    return settings.make(np.random.default_rng([seed, 29]))
