"""The options of `rovernav terrain`."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter

from ._options import Cell, InFile, Whole

RecipeFile = Annotated[InFile, Parameter(help="RECIPE.yaml, as terrain.json holds it.")]
Size = Annotated[str, Parameter(help="East-west,north-south [m]; default 100,100.")]
FineCell = Annotated[Cell, Parameter(help="Largest side of a fine cell [m].")]
MadeCell = Annotated[Cell, Parameter(help="Side of a cell [m]; default 0.25.")]
Post = Annotated[Cell, Parameter(help="Cell of a file that does not say its own [m].")]
Hurst = Annotated[float, Parameter(help="Hurst exponent of the relief; default 0.8.")]
Slope = Annotated[float, Parameter(help="Rms slope [deg] along --baseline; default 6.")]
Baseline = Annotated[float, Parameter(help="Where --slope holds [m]; default 1.")]
CraterBody = Annotated[str, Parameter(help="Craters as on the moon or mars.")]
Age = Annotated[float, Parameter(help="Age of the cratered surface [Gyr]; default 3.")]
DuneSizes = Annotated[str, Parameter(help="Dunes: WAVELENGTH,HEIGHT [m].")]
Wind = Annotated[
    float,
    Parameter(
        allow_leading_hyphen=True,
        help="Where the wind blows to, clockwise from north [deg]; default 90.",
    ),
]
CliffSizes = Annotated[str, Parameter(help="Plateaus with cliffs: HEIGHT,SPACING [m].")]
PitNumber = Annotated[float, Parameter(help="Collapse pits per square kilometre.")]
RockCover = Annotated[float, Parameter(help="Share of the ground that rocks cover, like 0.05.")]
HoleShare = Annotated[float, Parameter(help="Share of the cells without data.")]
PostHurst = Annotated[
    float, Parameter(help="Hurst exponent below the posts; else the model's own.")
]
PostSlope = Annotated[float, Parameter(help="Rms slope between posts [deg]; else the model's own.")]
BoundsOption = Annotated[
    str,
    Parameter(
        allow_leading_hyphen=True, help="Part W,S,E,N in the file's coordinates; else all of it."
    ),
]
LayerName = Annotated[
    str, Parameter(help="elevation, slope, step or shade; with --rover one of the rover's.")
]
LayerRover = Annotated[
    str, Parameter(help="Judge the ground for this rover: a preset, or a .yaml file.")
]
Factor = Annotated[Whole, Parameter(help="So many cells along a side are averaged to one.")]
