"""Recipes of ground as plain data: files, options and reports, with units in the names."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from ..core import SettingError, build, read_yaml, suggest
from ._craters import DEPTH, Craters
from ._forms import Cliffs, Dunes, Pits
from ._making import Recipe, Relief


def read_recipe(path: str | Path) -> dict[str, Any]:
    """The keys of a recipe file (YAML); `recipe_of` makes a recipe of them.

    Raises:
        FileError: It cannot be read or is not YAML.
    """
    return read_yaml(Path(path), what="recipe of ground")


def recipe_of(data: dict[str, Any], *, source: str) -> Recipe:
    """A recipe from plain data, as `recipe_data` gives it; all keys may be left out.

    Raises:
        SettingError: An unknown key, or a value that is not allowed; `source` is named.
    """
    from pydantic import BaseModel, ConfigDict, Field

    class Strict(BaseModel):
        """No unknown keys, no NaN."""

        model_config = ConfigDict(extra="forbid", allow_inf_nan=False)

    class ReliefKeys(Strict):
        """`Relief`."""

        hurst: float = 0.8
        slope_deg: float = 6.0
        baseline_m: float = 1.0

    class CraterKeys(Strict):
        """`Craters`."""

        body: str = "moon"
        age_gyr: float = 3.0
        smallest_m: float | None = None
        largest_m: float | None = None
        diffusivity_m2_myr: float = 5.5
        depth: float = DEPTH

    class DuneKeys(Strict):
        """`Dunes`."""

        wavelength_m: float
        height_m: float
        wind_deg: float = 90.0

    class CliffKeys(Strict):
        """`Cliffs`."""

        height_m: float
        spacing_m: float
        face_deg: float = 75.0

    class PitKeys(Strict):
        """`Pits`."""

        per_km2: float
        smallest_m: float | None = None
        largest_m: float | None = None
        depth: float = 0.4
        wall_deg: float = 70.0

    class Keys(Strict):
        """`Recipe`."""

        size_m: tuple[float, float] = (100.0, 100.0)
        cell_m: float = 0.25
        relief: ReliefKeys = Field(default_factory=ReliefKeys)
        craters: CraterKeys | None = None
        dunes: DuneKeys | None = None
        cliffs: CliffKeys | None = None
        pits: PitKeys | None = None
        rocks: float | None = None
        rock_sizes_m: tuple[float, float] | None = None
        holes: float = 0.0

    for key in data:
        if key not in Keys.model_fields:
            raise SettingError(f"{source}: unknown key {key!r}; {suggest(key, Keys.model_fields)}")
    keys = build(Keys, data, source=source)
    try:
        return _recipe(keys)
    except SettingError as error:
        raise SettingError(f"{source}: {error}") from None


def _recipe(keys: Any) -> Recipe:
    rise, craters, dunes, cliffs, pits = (
        keys.relief, keys.craters, keys.dunes, keys.cliffs, keys.pits,
    )  # fmt: skip
    least, most = 8.0 * keys.cell_m, max(min(keys.size_m) / 3.0, 24.0 * keys.cell_m)
    return Recipe(
        size=keys.size_m,
        cell=keys.cell_m,
        relief=Relief(
            hurst=rise.hurst, slope=math.radians(rise.slope_deg), baseline=rise.baseline_m
        ),
        craters=None if craters is None else Craters(
            body=craters.body, age=craters.age_gyr, smallest=_or(craters.smallest_m, least),
            largest=_or(craters.largest_m, most), diffusivity=craters.diffusivity_m2_myr,
            depth=craters.depth,
        ),
        dunes=None if dunes is None else Dunes(
            wavelength=dunes.wavelength_m, height=dunes.height_m, wind=math.radians(dunes.wind_deg)
        ),
        cliffs=None if cliffs is None else Cliffs(
            height=cliffs.height_m, spacing=cliffs.spacing_m, face=math.radians(cliffs.face_deg)
        ),
        pits=None if pits is None else Pits(
            per_km2=pits.per_km2, smallest=_or(pits.smallest_m, least),
            largest=_or(pits.largest_m, 3.0 * _or(pits.smallest_m, least)), depth=pits.depth,
            wall=math.radians(pits.wall_deg),
        ),
        rocks=keys.rocks,
        rock_sizes=keys.rock_sizes_m,
        holes=keys.holes,
    )  # fmt: skip


def recipe_data(recipe: Recipe) -> dict[str, Any]:
    """A recipe as plain data, everything written out: what `recipe_of` reads."""
    r = recipe
    data: dict[str, Any] = {
        "size_m": list(r.size),
        "cell_m": r.cell,
        "relief": {"hurst": r.relief.hurst, "slope_deg": _deg(r.relief.slope),
                   "baseline_m": r.relief.baseline},
    }  # fmt: skip
    if r.craters is not None:
        c = r.craters
        data["craters"] = {"body": c.body, "age_gyr": c.age, "smallest_m": c.smallest,
                           "largest_m": c.largest, "diffusivity_m2_myr": c.diffusivity,
                           "depth": c.depth}  # fmt: skip
    if r.dunes is not None:
        data["dunes"] = {"wavelength_m": r.dunes.wavelength, "height_m": r.dunes.height,
                         "wind_deg": _deg(r.dunes.wind)}  # fmt: skip
    if r.cliffs is not None:
        data["cliffs"] = {"height_m": r.cliffs.height, "spacing_m": r.cliffs.spacing,
                          "face_deg": _deg(r.cliffs.face)}  # fmt: skip
    if r.pits is not None:
        p = r.pits
        data["pits"] = {"per_km2": p.per_km2, "smallest_m": p.smallest, "largest_m": p.largest,
                        "depth": p.depth, "wall_deg": _deg(p.wall)}  # fmt: skip
    rocks = r.rock_field()
    if rocks is not None:
        data |= {"rocks": rocks.abundance, "rock_sizes_m": [rocks.smallest, rocks.largest]}
    if r.holes > 0.0:
        data["holes"] = r.holes
    return data


def _or(item: float | None, usual: float) -> float:
    return usual if item is None else item


def _deg(angle: float) -> float:
    return round(math.degrees(angle), 12)
