"""Wrong parts of elevation models, and recipes of ground that cannot be: cases of the page.

Each has what is wrong, the words typed, the sentence, and what makes its files.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial as of
from typing import Any

from tests.cli import bad_files as bad

EXPORT = "terrain export ground.tif --out part.tif"


def nothing() -> None:
    """No file is needed."""


Wrong = tuple[str, str, str, Callable[[], Any]]

PARTS: list[Wrong] = [
    (
        "a part that is inside out",
        f"{EXPORT} --window 9,0,1,5",
        "a window is written west, south, east, north and spans an area, got 9,0,1,5",
        bad.ground,
    ),
    (
        "a part off the map",
        f"{EXPORT} --window 90,0,99,5",
        "the window lies off the map, which reaches from (-7, -11) to (23, 9)",
        bad.ground,
    ),
    (
        "three numbers for a part",
        f"{EXPORT} --window 1,2,3",
        "--window must be 4 numbers with commas between, got '1,2,3'",
        bad.ground,
    ),
    (
        "a layer that is none",
        f"{EXPORT} --layer slop",
        "there is no layer 'slop'; did you mean 'slope'? Allowed: elevation, shade, slope, step.",
        bad.ground,
    ),
    (
        "an unknown file to export to",
        "terrain export ground.tif --out a.jpg",
        "--out must end in .tif, .png or .npy, got 'a.jpg'",
        bad.ground,
    ),
    (
        "an average over nothing",
        f"{EXPORT} --factor 0",
        "--factor must be a whole number of 1 or more, got 0",
        bad.ground,
    ),
    (
        "fine cells larger than posts",
        "terrain refine ground.tif --cell 2",
        "--cell must lie above 0 and up to the posts of 0.5 m, got 2",
        bad.ground,
    ),
    (
        "too many fine cells",
        "terrain refine ground.tif --cell 0.001",
        "30,000 x 20,000 fine cells are more than 100,000,000 at a time; read a part with "
        "--window WEST,SOUTH,EAST,NORTH or give a larger --cell",
        bad.ground,
    ),
]

MADE_WRONG: list[Wrong] = [
    (
        "too jagged",
        "terrain make --hurst 0",
        "the options: the Hurst exponent must lie in 0.2 to 0.98, got 0; 0.8 is usual",
        nothing,
    ),
    (
        "a slope that is no number",
        "terrain make --slope nan",
        "the options: relief.slope_deg = nan: input should be a finite number",
        nothing,
    ),
    (
        "one side",
        "terrain make --size 50",
        "--size must be 2 numbers with commas between, got '50'",
        nothing,
    ),
    (
        "fewer than three cells",
        "terrain make --size 5,5 --cell 5",
        "the options: ground needs at least 3 x 3 cells of 5 m and at most 10000 km, got 5 x 5 m",
        nothing,
    ),
    (
        "more than memory holds",
        "terrain make --size 1e5,1e5 --cell 0.1",
        "1,000,000 x 1,000,000 cells are more than 100,000,000 at a time; give a larger --cell or"
        " a smaller --size",
        nothing,
    ),
    (
        "craters of nowhere",
        "terrain make --craters pluto",
        "the options: craters of 'pluto' are not known; Allowed: mars, moon.",
        nothing,
    ),
    (
        "older than the planets",
        "terrain make --craters mars --age 5",
        "the options: the age of a surface must lie in 0 to 4.5 Gyr, got 5",
        nothing,
    ),
    (
        "dunes that would slide",
        "terrain make --dunes 6,5",
        "the options: dunes of 5 m every 6 m would stand at 74 deg, more than sand does (34 deg);"
        " at most 0.944 m are possible",
        nothing,
    ),
    (
        "rocks in per cent",
        "terrain make --rocks 5",
        "the options: rock abundance must be a share of the ground from 0.005 to 0.4, got 5; "
        "write 5 % as 0.05",
        nothing,
    ),
    (
        "a misspelt key",
        "terrain make ground.yaml",
        "ground.yaml: unknown key 'releif'; did you mean 'relief'? Allowed: …",
        of(bad.raw, "ground.yaml", b"releif: {hurst: 0.5}\n"),
    ),
    (
        "a misspelt key of a part",
        "terrain make ground.yaml",
        "ground.yaml: unknown key 'relief.hirst'; did you mean 'hurst'? Allowed: …",
        of(bad.raw, "ground.yaml", b"relief: {hirst: 0.5}\n"),
    ),
    (
        "an unknown command",
        "terrain mak",
        "there is no command 'mak'; did you mean 'make'? Allowed: export, make, refine.",
        nothing,
    ),
]
