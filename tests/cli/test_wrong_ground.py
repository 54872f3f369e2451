"""Wrong ground, rovers and recipes given to the neural driver: what the other table leaves out.

Like tests/cli/test_wrong_input.py: exit code 2, nothing on standard output, one sentence.
"""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Callable
from functools import partial as of
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from tests.cli import bad_files as bad
from tests.cli.runner import run, write_ground


class Case(NamedTuple):
    wrong: str
    words: str
    sentence: str  # … stands for anything
    make: Callable[[], Any]


def heights(values: Any = 0.0, *, holes: float | None = None) -> None:
    """ground.npy of 60 x 60 heights; `holes` fills a square of 10 x 10 in the middle."""
    ground = np.zeros((60, 60)) + values
    if holes is not None:
        ground[25:35, 25:35] = holes
    np.save("ground.npy", ground)


def raw_heights(*, drop: str = "", more: int = 0, **changes: Any) -> None:
    """meta.json and heights.bin of 20 x 20 heights."""
    meta = {"grid": 20, "size_m": 10.0, "elev_min_m": 0.0, "elev_max_m": 1.0} | changes
    meta.pop(drop, None)
    Path("meta.json").write_text(json.dumps(meta))
    Path("heights.bin").write_bytes(bytes(2 * 20 * 20 + more))


def small_geotiff() -> None:
    """A GeoTIFF of one height."""
    import rasterio

    profile: dict[str, Any] = {
        "driver": "GTiff", "count": 1, "dtype": "float32", "width": 1, "height": 1,
        "transform": rasterio.Affine(0.5, 0.0, 0.0, 0.0, -0.5, 0.5),
    }  # fmt: skip
    with rasterio.open("ground.tif", "w", **profile) as file:
        file.write(np.ones((1, 1), np.float32), 1)


def rover(**changes: str) -> None:
    heights()
    keys = {
        "drive": "differential", "length_m": "0.5", "width_m": "0.4", "wheel_radius_m": "0.075",
        "speed_m_s": "0.3", "turn_rate_deg_s": "40.0", "track_m": "0.34",
    } | changes  # fmt: skip
    bad.rover(**keys)


def driver(**codec: Any) -> None:
    """A network file with a codec of headings, or of another name."""
    heights()
    bad.network(topology=(67, 8, 32), codec={"name": "headings"} | codec)


def recipe(text: str) -> None:
    Path("tiny.yaml").write_text(text)


def taught_before() -> None:
    """A folder with rounds of one recipe, and another recipe."""
    recipe("seed: 1\n")
    Path("done").mkdir()
    Path("done/recipe.json").write_text('{"seed":2}')


NPY = "drive --terrain ground.npy --cell 0.2 --frame local --from 1,1 --to 11,11"
ON, ROVER = f"{NPY} --controller neural", f"{NPY} --controller neural --rover rover.yaml"
MIDDLE = ON.replace("1,1 ", "6,6 ")
FILE, RAW = f"{NPY} --controller net.safetensors", "drive --terrain meta.json --from 1,1 --to 9,9"
COMPARE, TEACH = "compare ground.npy --cell 0.2", "teach tiny.yaml"

CASES = [
    Case("a GeoTIFF of one height", "inspect ground.tif",
         "GeoTIFF ground.tif: ground needs at least 3 x 3 heights, got shape (1, 1); …",
         small_geotiff),
    Case("floating-point NaN everywhere in a GeoTIFF", "compare ground.tif",
         "GeoTIFF ground.tif: every height is missing; check the file's nodata value",
         of(bad.ground_of, float("nan"))),
    Case("a cut-off GeoTIFF to compare on", "compare ground.tif",
         "ground.tif is a damaged or cut-off GeoTIFF (…); fetch or export it again",
         of(bad.ground, keep=0.4)),
    Case("an array of one dimension", ON,
         "ground.npy holds float64 of shape (5,); ground is a two-dimensional array of whole or "
         "floating-point metres", of(bad.array, [0.0] * 5)),
    Case("an array of complex numbers", ON,
         "ground.npy holds complex128 of shape (60, 60); …", of(heights, 1j)),
    Case("an array with infinite heights", ON,
         "NumPy array ground.npy: 100 heights are infinite; mark missing heights as NaN or as "
         "nodata", of(heights, holes=float("inf"))),
    Case("a cell that is no number", ON.replace("0.2", "nan"),
         "--cell must be a positive number of metres, got 'nan'", heights),
    Case("a cell below 0", f"{COMPARE.replace('0.2', '-1')}",
         "--cell must be a positive number of metres, got '-1'", heights),
    Case("a cell larger than a planet", ON.replace("0.2", "1e300"),
         "the options: cell = 1e+300: input should be less than or equal to 1000000", heights),
    Case("start in a hole of the data", MIDDLE,
         "rover research cannot stand at the start: the terrain has no data there; the "
         "nearest place where it can is … m away, (…, …)", of(heights, holes=float("nan"))),
    Case("start on a slope", ON, "rover research cannot stand at the start: the slope is … deg, "
         "its limit 20.0 deg; it can stand nowhere on this ground; choose another rover",
         of(heights, np.arange(60.0))),
    Case("start too near a block", MIDDLE.replace("6,6", "4.8,6"),
         "rover research cannot stand at the start: …; the nearest place where it can is … m away, "
         "(…, …)",
         of(heights, holes=2.0)),
    Case("goal off the map", ON.replace("11,11", "50,11"),
         "the goal (50, 11) lies off the map, which reaches from (0, 0) to (12, 12)", heights),
    Case("goal a pixel beyond the last", ON.replace("local", "pixel").replace("11,11", "60,5"),
         "the goal (12.1, 10.9) lies off the map, which reaches from (0, 0) to (12, 12)", heights),
    Case("meta.json without a key", RAW, "meta.json: the key 'size_m' is missing; add it",
         of(raw_heights, drop="size_m")),
    Case("meta.json with NaN", RAW,
         "meta.json: elev_max_m = nan: input should be a finite number",
         of(raw_heights, elev_max_m=float("nan"))),
    Case("meta.json with its heights upside down", RAW,
         "meta.json: …: elev_max_m must not be below elev_min_m", of(raw_heights, elev_max_m=-1.0)),
    Case("meta.json whose bounds disagree", RAW,
         "meta.json: …: bounds_proj spans 5 m, size_m 10 m",
         of(raw_heights, bounds_proj=[0, 0, 5, 5])),
    Case("meta.json that is cut off", RAW, "meta.json is not JSON (…); fetch or write it again",
         of(bad.raw, "meta.json", b'{"grid": 20,')),
    Case("heights.bin too short", RAW,
         "heights.bin has 794 bytes, but 20 x 20 heights of two bytes need 800; fetch it again or"
         " correct 'grid' in meta.json", of(raw_heights, more=-6)),
    Case("heights.bin of another grid", RAW,
         "heights.bin has 800 bytes, but 30 x 30 heights of two bytes need 1,800; …",
         of(raw_heights, grid=30)),
    Case("a folder without meta.json", "compare .",
         "there is no elevation file at meta.json; check the path", heights),
    Case("a cell for heights that have one", f"{RAW} --cell 1",
         "meta.json has its own cells of 0.5 m; leave --cell out", raw_heights),
    Case("no rocks", f"{ON} --rocks 0",
         "rock abundance must be a share of the ground from 0.005 to 0.4, got 0", heights),
    Case("rocks nearly everywhere", f"{ON} --rocks 0.9",
         "rock abundance must be a share of the ground from 0.005 to 0.4, got 0.9", heights),
    Case("rocks that are no number", f"{ON} --rocks nan",
         "rock abundance must be a share of the ground from 0.005 to 0.4, got nan", heights),
    Case("rocks in a named scenario", "drive rocky-hills-v1 --rocks 0.05",
         "--rocks does not go with the named scenario rocky-hills-v1", heights),
    Case("rocks beside a scenario file", "drive drive.yaml --rocks 0.05",
         "--rocks does not go with a scenario file; write it there", bad.scenario),
    Case("a rover of negative width", ROVER,
         "rover.yaml: rover mine: width must lie in 0 to 20 m, got -0.4",
         of(rover, width_m="-0.4")),
    Case("a rover that climbs walls", ROVER,
         "rover.yaml: rover mine: max_slope must lie in 0 to 89 deg, got 95",
         of(rover, max_slope_deg="95.0")),
    Case("a differential rover that cannot turn", ROVER,
         "rover.yaml: rover mine: a differential rover needs a positive track and turn rate; set "
         "both", of(rover, turn_rate_deg_s="0.0")),
    Case("a rover that hovers", ROVER,
         "rover.yaml: drive = 'hover': input should be 'differential' or 'two-axis'",
         of(rover, drive="hover")),
    Case("a misspelt key of a rover", ROVER,
         "rover.yaml: unknown key 'turn_rate_degs'; did you mean 'turn_rate_deg_s'? Allowed: …",
         of(rover, turn_rate_degs="1.0")),
    Case("the neural driver in the paper's rover", f"{ON} --rover paper-point",
         "the controller needs the sensor 'around', which this rover does not carry; it carries: "
         "clear_sight, off_line", heights),
    Case("the planner in the paper's rover", f"{NPY} --controller planner --rover paper-point",
         "the planner on sensed ground needs a rover with a local map", heights),
    Case("the paper's network in a research rover", f"{NPY} --controller bassil --rover research",
         "the controller needs the sensor 'clear_sight', which this rover does not carry; it "
         "carries: around, beams, reach", heights),
    Case("nobody named to drive a research rover", f"{NPY} --rover research",
         "rover research is not for the paper's network, which drives where no other is named; "
         "add --controller neural, goal-seeker or planner", heights),
    Case("a misspelt controller", f"{NPY} --controller neurl",
         "there is no controller 'neurl' and no such network file; did you mean 'neural'? "
         "Allowed: bassil, goal-seeker, neural, planner.", heights),
    Case("an unknown codec", FILE,
         "net.safetensors: unknown codec 'heddings'; did you mean 'headings'? Allowed: bassil, "
         "headings.", of(driver, name="heddings")),
    Case("an unknown parameter of the codec", FILE,
         "net.safetensors: codec headings: unknown parameter 'margins'; did you mean 'margin'? "
         "Allowed: …", of(driver, margins=0.1)),
    Case("text for a speed in the codec", FILE,
         "net.safetensors: codec headings: speed must be above 0, got 'fast'",
         of(driver, speed="fast")),
    Case("a negative margin in the codec", FILE,
         "net.safetensors: codec headings: margin must be 0 or above, got -1.0",
         of(driver, margin=-1.0)),
    Case("text for the commitment in the codec", FILE,
         "net.safetensors: codec headings: commitment must be 0 or above, got 'much'",
         of(driver, commitment="much")),
    Case("half a ray in the codec", FILE,
         "net.safetensors: codec headings: rays must be a whole number from 4 to 4096, got 64.5",
         of(driver, rays=64.5)),
    Case("more headings than the network has", FILE,
         "net.safetensors: codec headings needs a network with 67 inputs and 16 outputs, got "
         "67-8-32", of(driver, headings=16)),
    Case("no ground to compare on", "compare", "TERRAIN is missing; name it after the command",
         heights),
    Case("no pairs", f"{COMPARE} --pairs 0", "--pairs must be from 1 to 10000, got 0", heights),
    Case("half a pair", f"{COMPARE} --pairs 1.5", "--pairs must be a whole number, got '1.5'",
         heights),
    Case("open ground", f"{COMPARE} --pairs 5",
         "found 0 of 5 start and goal pairs 2 to 12 m apart with a blocked straight line; the "
         "ground may be too open or too closed", heights),
    Case("ground without a free place", COMPARE,
         "found 0 of 50 start and goal pairs 2 to 12 m apart …",
         of(heights, 5.0 * np.arange(60.0))),
    Case("pairs nearer than nearest", f"{COMPARE} --nearest 5 --farthest 2",
         "pairs must lie more than 0 m apart, the nearest no farther than the farthest, got 5 to 2"
         " m", heights),
    Case("a distance that is no number", f"{COMPARE} --nearest nan",
         "pairs must lie more than 0 m apart, the nearest no farther than the farthest, got nan …",
         heights),
    Case("nobody to compare", f"{COMPARE} --controllers ,",
         "--controllers names nobody; give one or more, like neural,goal-seeker", heights),
    Case("a misspelt controller to compare", f"{COMPARE} --controllers neural,plannr",
         "there is no controller 'plannr' and no such network file; did you mean 'planner'? "
         "Allowed: …", heights),
    Case("no recipe", "teach", "RECIPE is missing; name it after the command", heights),
    Case("no recipe of that name", "teach headings-v2",
         "there is no recipe 'headings-v2' and no such file; did you mean 'headings-v1'? Allowed:"
         " headings-v1.", heights),
    Case("a misspelt key of a recipe", TEACH,
         "tiny.yaml: unknown key 'sead'; did you mean 'seed'? Allowed: …", of(recipe, "sead: 1\n")),
    Case("no rounds", TEACH,
         "tiny.yaml: rounds = 0: input should be greater than or equal to 1",
         of(recipe, "rounds: 0\n")),
    Case("a rate that is no number", TEACH,
         "tiny.yaml: eta = nan: input should be a finite number", of(recipe, "eta: .nan\n")),
    Case("a practice world smaller than its cells", TEACH,
         "tiny.yaml: cell_m = 5.0: a side of 1 m must have 20 to 2,000 cells",
         of(recipe, "side_m: 1.0\ncell_m: 5.0\n")),
    Case("a practice world that no memory holds", TEACH,
         "tiny.yaml: cell_m = 0.2: a side of 10000 m must have 20 to 2,000 cells",
         of(recipe, "side_m: 10000.0\n")),
    Case("a rover that cannot be taught", TEACH,
         "rover paper-point has no differential drive; teach one that has",
         of(recipe, "rover: paper-point\n")),
    Case("an empty recipe", TEACH, "tiny.yaml must hold 'key: value' lines, got nothing",
         of(recipe, "")),
    Case("the folder of another recipe", f"{TEACH} --out done",
         "done holds rounds of another recipe; name another folder", taught_before),
    Case("a file where rounds should go", f"{TEACH} --out tiny.yaml",
         "--out tiny.yaml is a file or lies below one; name a folder", of(recipe, "seed: 1\n")),
    Case("no real terrain there", "demo --data nowhere",
         "--data nowhere has no …; name the folder that holds it", heights),
]  # fmt: skip


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.wrong)
def test_one_sentence_says_what_is_wrong(case: Case) -> None:
    case.make()
    said = run(*shlex.split(case.words))
    assert (said.code, said.out) == (2, "")
    first, *hint = said.err.splitlines()
    pattern = re.escape(f"error: {case.sentence}").replace("…", ".+")
    assert re.fullmatch(pattern, first), first
    assert all(line.startswith("See: rovernav") for line in hint)
    assert len(hint) <= 1
    assert "Traceback" not in said.err


def test_no_case_stands_twice() -> None:
    assert len({case.wrong for case in CASES}) == len(CASES)


def test_wrong_ground_leaves_nothing_behind(here: Path) -> None:
    write_ground(here / "ground.tif")
    before = set(here.iterdir())
    assert run(*shlex.split("drive --terrain ground.tif --from 100,0 --to 1,2")).code == 2
    assert set(here.iterdir()) == before
