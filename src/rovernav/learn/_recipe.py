"""Recipes of imitation: everything that makes a neural driver, in YAML."""

from __future__ import annotations

from importlib import resources
from pathlib import Path
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, ValidationInfo, field_validator

from ..core import FileError, build, read_yaml, suggest

Count = Annotated[int, Field(ge=1, le=100_000)]
Metres = Annotated[float, Field(gt=0, le=10_000, allow_inf_nan=False)]


class Recipe(BaseModel):
    """How a driver is taught.

    Attributes:
        seed: Of worlds, missions, initial weights and order; the same seed gives the same bits.
        rover: Preset or rover file: a differential rover.
        hidden: Units of the hidden layers, tanh.
        rounds: In the first the teacher drives, in the others the student; the teacher always says
            what it would have done (DAgger: Ross, Gordon and Bagnell 2011).
        worlds: Generated worlds in each round.
        rovers: Drives in each world.
        side_m: Side of a world [m].
        cell_m: Cell of a world [m]; 20 to 2,000 cells make a side.
        steps: Steps of a drive at most.
        every: In rounds driven by the student, every n-th step becomes a pattern.
        epochs: Epochs over all patterns so far after each round, twice as many after the last.
        batch: Patterns per update.
        eta: Learning rate of Adam, falling to 0 along a cosine within each round.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    seed: Annotated[int, Field(ge=0, lt=2**63)] = 0
    rover: str = "research"
    hidden: Annotated[tuple[Count, ...], Field(min_length=1, max_length=8)] = (96, 64)
    rounds: Annotated[int, Field(ge=1, le=100)] = 4
    worlds: Count = 14
    rovers: Count = 16
    side_m: Metres = 40.0
    cell_m: Annotated[Metres, Field(validate_default=True)] = 0.2
    steps: Count = 150
    every: Count = 3
    epochs: Count = 16
    batch: Count = 256
    eta: Annotated[float, Field(gt=0, le=1, allow_inf_nan=False)] = 0.001

    @field_validator("cell_m")
    @classmethod
    def _fits_side(cls, cell: float, info: ValidationInfo) -> float:
        side = info.data.get("side_m", cell)
        if "side_m" in info.data and not 20 <= round(side / cell) <= 2000:
            raise ValueError(f"a side of {side:g} m must have 20 to 2,000 cells")
        return cell


def read_recipe(name: str) -> Recipe:
    """A recipe file, or one that comes with the package.

    Raises:
        FileError: No such file or recipe, or not YAML.
        SettingError: An unknown key or a value that is not allowed.
    """
    if name in recipes():
        with resources.as_file(
            resources.files("rovernav.learn") / "recipes" / f"{name}.yaml"
        ) as path:
            return build(Recipe, read_yaml(path, what="recipe"), source=name)
    path = Path(name)
    if not path.exists():
        raise FileError(f"there is no recipe {name!r} and no such file; {suggest(name, recipes())}")
    return build(Recipe, read_yaml(path, what="recipe"), source=name)


def recipes() -> list[str]:
    """Names of the recipes that come with the package."""
    folder = resources.files("rovernav.learn") / "recipes"
    return sorted(item.name[:-5] for item in folder.iterdir() if item.name.endswith(".yaml"))
