"""Wrong elevation models, and recipes of ground that cannot be: cases of the page.

Each has what is wrong, the words typed, the sentence, and what makes its files.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial as of
from typing import Any

from tests.cli import bad_files as bad

ON = "drive --terrain ground.tif --from -5,-8 --to 20,-6.5"
NPY = "drive --terrain ground.npy --from 1,1 --to 9,9"
EXPORT = "terrain export ground.tif --out part.tif"


def nothing() -> None:
    """No file is needed."""


Wrong = tuple[str, str, str, Callable[[], Any]]

PARTS: list[Wrong] = [
    ("missing", ON, "there is no elevation file at ground.tif; check the path", nothing),
    (
        "a web address",
        "inspect https://example.org/yard.tif",
        "FILE must be on this machine, got 'https://example.org/yard.tif'; download it first",
        nothing,
    ),
    (
        "a picture",
        "inspect figure.png",
        "figure.png is a picture; if it is a map of heights, say what its greys mean: --heights "
        "LOW,HIGH and --cell METRES",
        of(bad.picture, "figure.png"),
    ),
    (
        "text",
        ON,
        "ground.tif is not an elevation file: it begins with b'heights'; give a GeoTIFF (.tif), "
        "PDS or ISIS image, ASCII grid (.asc), NumPy array (.npy, .npz), table of numbers (.csv, "
        ".txt), PNG with --heights, a folder with meta.json and heights.bin, or a map (ROS "
        ".yaml, BARN .world)",
        of(bad.raw, "ground.tif", b"heights"),
    ),
    (
        "a table of uneven rows",
        "inspect ground.csv --cell 1",
        "ground.csv is not a grid of numbers (…); give every row as many",
        of(bad.raw, "ground.csv", b"1 2 3\n4 5\n6 7 8\n"),
    ),
    (
        "a pointer to other files",
        ON,
        "ground.tif is a VRT that only points to other files (gdal_translate IN OUT.tif makes "
        "one file); give a GeoTIFF (.tif), …",
        of(bad.raw, "ground.tif", b"<VRTDataset/>"),
    ),
    (
        "cut off",
        ON,
        "ground.tif is a damaged or cut-off GeoTIFF (…); fetch or export it again",
        of(bad.ground, keep=0.5),
    ),
    (
        "an image of three bands",
        ON,
        "ground.tif has 3 bands, so it is an image rather than an elevation model; give a file "
        "with one band (gdal_translate -b 1 IN OUT.tif takes the first)",
        of(bad.ground, count=3),
    ),
    (
        "degrees beyond the pole",
        ON,
        "ground.tif has its middle at (1493, -991), which is no place in its coordinate system "
        "WGS 84; assign the right one (gdal_edit.py -a_srs EPSG:NUMBER FILE)",
        of(bad.ground, crs="EPSG:4326", cells=(50.0, 0.0, 0.0, -50.0)),
    ),
    (
        "heights in an unknown unit",
        ON,
        "ground.tif has heights in 'furlong', not in m, km, cm, mm, ft or us-ft; convert them to "
        "metres first",
        of(bad.ground_in, "furlong"),
    ),
    (
        "rotated",
        ON,
        "ground.tif is rotated or mirrored (geotransform (0.4, 0.3, -7.0, 0.3, -0.4, 9.0)); "
        "turn it north-up first (gdalwarp IN OUT.tif)",
        of(bad.ground, cells=(0.4, 0.3, 0.3, -0.4)),
    ),
    (
        "no height at all",
        ON,
        "GeoTIFF ground.tif: every height is missing; check the file's nodata value",
        of(bad.ground_of, -9999.0),
    ),
    (
        "an infinite height",
        ON,
        "GeoTIFF ground.tif: 2400 heights are infinite; mark missing heights as NaN or as nodata",
        of(bad.ground_of, float("inf")),
    ),
    (
        "heights that mark missing data",
        ON,
        "GeoTIFF ground.tif: heights from -3.4e+38 to -3.4e+38 m go beyond 100 km; if one of "
        "them marks missing data, set it as the file's nodata value",
        of(bad.ground_of, -3.4e38),
    ),
    (
        "a cell that contradicts the file",
        f"{ON} --cell 2",
        "ground.tif has its own cells of 0.5 m; leave --cell out",
        bad.ground,
    ),
    (
        "an array without its cell",
        NPY,
        "ground.npy does not say how large its cells are; give --cell METRES, or cell: METRES in a "
        "scenario",
        of(bad.array, [[0.0] * 9] * 9),
    ),
    (
        "an array of three dimensions",
        f"{NPY} --cell 1",
        "ground.npy holds float64 of shape (1, 9, 9); ground is a two-dimensional array of "
        "whole or floating-point metres",
        of(bad.array, [[[0.0] * 9] * 9]),
    ),
    (
        "an array of Python objects",
        f"{NPY} --cell 1",
        "ground.npy is not a whole NumPy array of numbers (…); write it with numpy.save",
        of(bad.array, [[{}]]),
    ),
    (
        "start off the map",
        "drive --terrain ground.tif --from 100,0 --to 1,2",
        "the start (100, 0) lies off the map, which reaches from (-7, -11) to (23, 9)",
        bad.ground,
    ),
    (
        "goal where the rover cannot stand",
        "drive --terrain ground.tif --from -5,-8 --to 8.5,3",
        "rover paper-point cannot stand at the goal: the slope is 78.8 deg, its limit 20.0 deg;"
        " the nearest place where it can is … m away, (…, …), locally (…, …)",
        bad.ground,
    ),
    (
        "rocks in per cent",
        f"{ON} --rocks 5",
        "rock abundance must be a share of the ground from 0.005 to 0.4, got 5; write 5 % as 0.05",
        bad.ground,
    ),
    (
        "no goal",
        "drive --terrain ground.tif --from -5,-8",
        "--terrain needs --to X,Y as well",
        nothing,
    ),
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

ROUTE = "route ground.tif --from -5,-8 --to 20,-6.5"
CUT = (
    "cut a part out (rovernav terrain export ground.tif --window WEST,SOUTH,EAST,NORTH --out "
    "part.tif), or average (--factor N)"
)

ROUTES: list[Wrong] = [
    (
        "a cut-off elevation model",
        ROUTE,
        "ground.tif is a damaged or cut-off GeoTIFF (…); fetch or export it again",
        of(bad.ground, keep=0.5),
    ),
    (
        "a single height",
        ROUTE,
        "GeoTIFF ground.tif: ground needs at least 3 x 3 heights, got shape (1, 1); give a "
        "two-dimensional grid",
        of(bad.sized, (1, 1)),
    ),
    (
        "a strip of one row",
        ROUTE,
        "GeoTIFF ground.tif: ground needs at least 3 x 3 heights, got shape (1, 1000000); give a "
        "two-dimensional grid",
        of(bad.sized, (1, 1_000_000)),
    ),
    (
        "no height to plan on",
        ROUTE,
        "GeoTIFF ground.tif: every height is missing; check the file's nodata value",
        of(bad.ground_of, float("nan")),
    ),
    (
        "another coordinate system than the file's",
        ROUTE,
        "ground.tif has its middle at (1493, -991), which is no place in its coordinate system "
        "WGS 84; assign the right one (gdal_edit.py -a_srs EPSG:NUMBER FILE)",
        of(bad.ground, crs="EPSG:4326", cells=(50.0, 0.0, 0.0, -50.0)),
    ),
    (
        "a small file that says it is huge",
        ROUTE,
        "ground.tif has 60,000 x 60,000 cells, but only … MB: nearly all of it is empty; " + CUT,
        of(bad.sized, (60_000, 60_000)),
    ),
    (
        "more cells than can be judged",
        ROUTE,
        "ground.tif has 200,000 x 200,000 cells, and a route is planned over at most "
        "10,000,000,000; " + CUT,
        of(bad.sized, (200_000, 200_000)),
    ),
    (
        "layers of more cells than memory holds",
        "inspect ground.tif --rover research",
        "ground.tif has 60,000 x 60,000 cells, and layers are told of at most 30,000,000; " + CUT,
        of(bad.sized, (60_000, 60_000)),
    ),
    (
        "a zone that crosses itself",
        f"{ROUTE} --avoid zone.json",
        "zone.json: zone 1 is no proper polygon: Self-intersection[…]; draw it without crossing "
        "itself",
        of(bad.zone, [[-5, -5], [5, 0], [5, -5], [-5, 0], [-5, -5]]),
    ),
    (
        "a zone elsewhere",
        f"{ROUTE} --avoid zone.json",
        "zone.json: no zone touches the map, which reaches from (-7, -11) to (23, 9); check the "
        "zones' coordinate system",
        of(bad.zone, [[90, 0], [91, 0], [91, 1], [90, 0]]),
    ),
    (
        "a zone whose ring does not close",
        f"{ROUTE} --avoid zone.json",
        "zone.json: a polygon's coordinates are damaged: …",
        of(bad.zone, [[0, 0]]),
    ),
]
