"""`rovernav terrain make | refine | export`, and what `inspect` says about ground."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rovernav.cli._terrain import LAYERS, TERRAIN
from rovernav.terrain import read_terrain, slope
from tests.cli.runner import run, tell, write_ground


def test_make_writes_ground_a_picture_and_its_statistics(here: Path) -> None:
    words = ("--seed", "4", "--size", "40,30", "--craters", "moon", "--rocks", "0.06", "--dunes",
             "5,0.3", "--wind", "-20", "--holes", "0.02")  # fmt: skip
    report = tell("terrain", "make", *words, "--out", "made")
    assert {path.name for path in Path("made").iterdir()} == {
        "terrain.tif", "terrain.png", "terrain.json",
    }  # fmt: skip
    assert json.loads(Path("made/terrain.json").read_text()) == report
    assert report["seed"] == 4
    assert report["recipe"]["dunes"]["wind_deg"] == pytest.approx(-20.0)
    assert report["measured"]["dunes"]["wavelength_m"] == pytest.approx(5.0, rel=0.15)
    terrain = read_terrain("made/terrain.tif")
    assert terrain.frame.shape == (120, 160)
    import rasterio

    with rasterio.open("made/terrain.tif") as data:
        assert json.loads(data.tags()["ROVERNAV_RECIPE"]) == report["recipe"]
        assert data.tags()["ROVERNAV_SEED"] == "4"


def test_made_ground_can_be_made_again_from_its_recipe(here: Path) -> None:
    tell("terrain", "make", "--seed", "2", "--size", "20,20", "--rocks", "0.05", "--out", "a")
    recipe = json.loads(Path("a/terrain.json").read_text())["recipe"]
    Path("again.yaml").write_text(json.dumps(recipe))  # JSON is YAML
    tell("terrain", "make", "again.yaml", "--seed", "2", "--out", "b")
    one, two = (read_terrain(f"{name}/terrain.tif").height for name in "ab")
    np.testing.assert_array_equal(one, two)
    changed = tell("terrain", "make", "again.yaml", "--hurst", "0.5", "--out", "c")
    assert changed["recipe"]["relief"]["hurst"] == 0.5
    assert changed["recipe"]["rocks"] == 0.05


def test_make_says_what_was_asked_and_what_came_of_it(here: Path) -> None:
    said = run("terrain", "make", "--size", "30,30", "--cliffs", "2,20", "--pits", "5000",
               "--craters", "mars", "--rocks", "0.1", "--holes", "0.1")  # fmt: skip
    assert (said.code, said.err) == (0, "")
    for word in ("Hurst exponent", "asked 0.8", "craters", "expected", "rocks", "cliffs", "pits",
                 "without data", "rovernav-terrain/terrain.tif"):  # fmt: skip
        assert word in said.out
    assert max(map(len, said.out.splitlines()[2:])) <= 80


def test_refine_keeps_the_ground_and_adds_to_it(here: Path) -> None:
    write_ground(here / "ground.tif")
    words = ("terrain", "refine", "ground.tif", "--cell", "0.1", "--window=-4,-9,1,-6")
    report = tell(*words, "--rocks", "0.05", "--seed", "3", "--out", "fine")
    assert (report["columns"], report["rows"]) == (50, 30)
    assert report["refined"]["cells_per_post"] == 5
    fine = read_terrain("fine/terrain.tif")
    assert fine.frame.to_map(0.0, 0.0) == pytest.approx((-4.0, -9.0))
    coarse = read_terrain("ground.tif", bounds=(-4.0, -9.0, 1.0, -6.0))
    heights = fine.height.astype(np.float64) + fine.offset
    means = heights.reshape(6, 5, 10, 5).mean(axis=(1, 3))
    np.testing.assert_allclose(means, coarse.height + coarse.offset, rtol=0, atol=1e-5)
    said = run(*words, "--hurst", "0.7", "--slope", "5", "--out", "fine")
    assert said.code == 0
    assert "50 x 30 of 0.1 m, 5 to a post" in said.out
    assert "rms slope at posts   5.00 deg over 0.5 m" in said.out


@pytest.mark.parametrize("layer", LAYERS)
def test_export_of_each_layer(here: Path, layer: str) -> None:
    write_ground(here / "ground.tif")
    terrain = read_terrain("ground.tif")
    for ending in ("tif", "png", "npy"):
        out = f"{layer}.{ending}"
        report = tell("terrain", "export", "ground.tif", "--layer", layer, "--out", out)
        assert (report["layer"], report["columns"], report["rows"]) == (layer, 60, 40)
        assert Path(out).stat().st_size > 100
    import rasterio

    with rasterio.open(f"{layer}.tif") as data:
        assert data.transform == rasterio.Affine(0.5, 0.0, -7.0, 0.0, -0.5, 9.0)
        assert data.crs.to_epsg() == 32633
        assert data.units == (LAYERS[layer][0].replace("rad", "deg"),)
        values = data.read(1)
    np.testing.assert_allclose(values, np.load(f"{layer}.npy"), rtol=1e-6)
    if layer == "slope":
        np.testing.assert_allclose(values[::-1], np.degrees(slope(terrain)), rtol=1e-6)


def test_export_of_a_layer_judged_for_a_rover(here: Path) -> None:
    write_ground(here / "ground.tif")
    words = ("terrain", "export", "ground.tif", "--rover", "research", "--layer")
    for layer in ("slope", "roughness"):
        report = tell(*words, layer, "--out", f"{layer}.tif")
        assert report["formula"]
    import rasterio

    with rasterio.open("slope.tif") as data:
        assert data.units == ("deg",)
        assert data.tags()["ROVERNAV_FORMULA"]
    said = run(*words, "slop", "--out", "a.tif")
    assert said.err.startswith("error: there is no layer 'slop'; did you mean 'slope'?")


def test_export_of_a_part_and_of_averages(here: Path) -> None:
    write_ground(here / "ground.tif")
    report = tell("terrain", "export", "ground.tif", "--window=-7,0,3,9", "--factor", "3",
                  "--out", "part.tif")  # fmt: skip
    assert (report["columns"], report["rows"], report["cell_m"]) == (7, 6, 1.5)
    part = read_terrain("part.tif")
    assert part.frame.origin == (-7.0, 0.0)
    whole = read_terrain("ground.tif")
    first = (whole.height + whole.offset)[22:25, :3].mean()
    assert part.height[0, 0] + part.offset == pytest.approx(float(first), abs=1e-5)


def test_the_group_and_its_commands_have_help() -> None:
    for words in (("terrain",), ("terrain", "--help"), ("help", "terrain")):
        said = run(*words)
        assert (said.code, said.err) == (0, "")
        assert all(f"│ {name} " in said.out for name in TERRAIN)
    for name in TERRAIN:
        said = run("terrain", name, "--help")
        assert said.code == 0
        assert f"Example: rovernav terrain {name}" in said.out
        assert max(map(len, said.out.splitlines())) <= 80
    said = run("terrain", "make", "--hurts", "1")
    assert said.err.splitlines()[-1] == "See: rovernav terrain make --help"


def test_inspect_warns_of_noise_rounding_and_holes(here: Path) -> None:
    tell("terrain", "make", "--size", "80,80", "--cell", "0.5", "--out", "made")
    clean = read_terrain("made/terrain.tif")
    assert tell("inspect", "made/terrain.tif")["quality"]["flags"] == []
    assert "beware" not in run("inspect", "made/terrain.tif").out
    heights = clean.height[::-1].astype(np.float64)
    heights = np.round(heights + np.random.default_rng(1).normal(0, 0.5, heights.shape), 1)
    heights[:20, :20] = np.nan
    np.save("bad.npy", heights)
    report = tell("inspect", "bad.npy", "--cell", "0.5")
    assert report["quality"]["noisy"]
    assert report["quality"]["stepped"]
    assert report["quality"]["noise_m"] == pytest.approx(0.5, rel=0.1)
    assert report["with_data"] == pytest.approx(1 - 400 / 160**2)
    out = run("inspect", "bad.npy", "--cell", "0.5").out
    for word in ("beware", "holes: 1.6%", "rounded: heights come in steps of 0.1 m", "noisy: "):
        assert word in out


def test_inspect_a_resampled_model(here: Path) -> None:
    import rasterio

    place = rasterio.Affine(1e-4, 0, 10, 0, -1e-4, 60)
    profile: dict[str, Any] = {
        "driver": "GTiff", "count": 1, "dtype": "float32", "width": 30, "height": 20,
        "crs": "EPSG:4326", "transform": place,
    }  # fmt: skip
    with rasterio.open("a.tif", "w", **profile) as file:
        file.write(np.random.default_rng(0).random((20, 30), np.float32), 1)
    report = tell("inspect", "a.tif")
    assert report["posts"] == [30, 20]
    assert report["resampled"]
    assert report["cell_m"] == pytest.approx(11.132 * math.cos(math.radians(59.999)), rel=3e-3)
    said = run("inspect", "a.tif").out
    assert "  posts of the file      30 x 20" in said
    assert "  note                   in degrees: resampled to square cells in true" in said


def test_inspect_a_map(here: Path) -> None:
    Path("map.pgm").write_bytes(b"P5 4 3 255\n" + bytes([0, 254, 254, 205] * 3))
    Path("map.yaml").write_text("image: map.pgm\nresolution: 0.1\norigin: [1, 2, 0]\n")
    report = tell("inspect", "map.yaml")
    assert (report["kind"], report["blocked"], report["unknown"]) == ("map", 0.5, 0.25)
    assert "  blocked or unknown  50.00%" in run("inspect", "map.yaml").out
