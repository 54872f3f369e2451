"""The neural driver from the command line: drive, compare, teach."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rovernav.bench import wilson
from rovernav.core import Outcome
from rovernav.rover import read_rover, standing
from rovernav.sim import load_trace
from rovernav.terrain import Terrain, hills, read_terrain, scatter_rocks, with_rocks
from tests.cli.runner import run, tell

NEURAL = ("--frame", "local", "--controller", "neural")
ACROSS = ("--from", "4,4.5", "--to", "26,21", *NEURAL)
TINY = """
seed: {seed}
hidden: [8]
rounds: 2
worlds: 1
rovers: 3
side_m: 16.0
steps: 15
epochs: 2
"""


def strewn() -> Terrain:
    """30 m x 24 m of hills with rocks."""
    rng = np.random.default_rng(4)
    ground = hills(rng, shape=(120, 150), cell=0.2, relief=2.0, craters=8)
    rocks = scatter_rocks(ground.frame, 0.05, smallest=0.3, largest=1.5, rng=rng)
    return with_rocks(ground, rocks)


def square() -> np.ndarray[Any, Any]:
    """30 m x 30 m of the same kind, north first, as a file holds them."""
    rng = np.random.default_rng(6)
    ground = hills(rng, shape=(150, 150), cell=0.2, relief=2.0, craters=8)
    rocks = scatter_rocks(ground.frame, 0.05, smallest=0.3, largest=1.5, rng=rng)
    return with_rocks(ground, rocks).height[::-1].astype(np.float32)


def write_geotiff(path: Path, heights: np.ndarray[Any, Any]) -> None:
    import rasterio

    profile: dict[str, Any] = {
        "driver": "GTiff", "count": 1, "dtype": "float32", "crs": "EPSG:32633",
        "height": heights.shape[0], "width": heights.shape[1],
        "transform": rasterio.Affine(0.2, 0.0, 500.0, 0.0, -0.2, 900.0),
    }  # fmt: skip
    with rasterio.open(path, "w", **profile) as file:
        file.write(heights, 1)


def write_raw(folder: Path, heights: np.ndarray[Any, Any]) -> None:
    """meta.json and heights.bin: 16 bits a height."""
    folder.mkdir()
    low, high = float(heights.min()), float(heights.max())
    codes = np.rint((heights - low) / (high - low) * 65535.0)
    (folder / "heights.bin").write_bytes(codes.astype("<u2").tobytes())
    meta = {"grid": 150, "size_m": 30.0, "elev_min_m": low, "elev_max_m": high}
    (folder / "meta.json").write_text(json.dumps(meta))


def path_of(report: dict[str, Any]) -> np.ndarray[Any, Any]:
    return load_trace(Path(report["files"][3])).path()


def farthest_from(path: np.ndarray[Any, Any], other: np.ndarray[Any, Any]) -> float:
    """Largest distance from a point of one path to the nearest point of the other [m]."""
    apart = np.linalg.norm(path[:, None, :] - other[None, :, :], axis=2)
    return float(apart.min(axis=1).max())


def test_it_crosses_rocky_hills_and_draws_what_it_sensed(monkeypatch: pytest.MonkeyPatch) -> None:
    import rovernav.show

    drawn: dict[str, Any] = {}
    draw = rovernav.show.draw_drive

    def watched(*args: Any, **kwargs: Any) -> None:
        drawn.update(kwargs)
        draw(*args, **kwargs)

    monkeypatch.setattr(rovernav.show, "draw_drive", watched)
    report = tell("drive", "rocky-hills-v1")
    assert report["outcome"] == "reached"
    assert report["settings"]["controller"] == "neural"
    assert report["to_goal_m"] <= 0.5
    assert report["closest_m"] > 0.0
    assert Path(report["files"][0]).read_bytes().startswith(b"\x89PNG")

    sensed, where = drawn["sensed"], drawn["standing"]
    assert len(sensed) > 100
    rows, columns = np.nonzero(where.blocked)
    cell = where.frame.cell
    blocked = np.stack([columns + 0.5, rows + 0.5], axis=1) * cell
    gap = np.abs(sensed[::40, None, :] - blocked[None, :, :]).max(axis=2).min(axis=1)
    inside = (sensed[::40] > 1.1 * cell).all(axis=1) & (sensed[::40] < 50.0 - 1.1 * cell).all(
        axis=1
    )
    assert inside.sum() > 10
    assert gap[inside].max() <= 0.5 * cell + 1e-6  # beams end on the sides of forbidden cells


def test_three_files_of_the_same_ground_give_the_same_drive(here: Path) -> None:
    heights = square()
    write_geotiff(here / "ground.tif", heights)
    np.save("ground.npy", heights)
    write_raw(here / "raw", heights)
    files = (("ground.tif",), ("ground.npy", "--cell", "0.2"), ("raw/meta.json",))
    reports = [
        tell("drive", "--terrain", *words, *ACROSS, "--out", f"drive-{k}")
        for k, words in enumerate(files)
    ]
    assert {report["outcome"] for report in reports} == {"reached"}
    exact, same, coarse = map(path_of, reports)
    assert np.array_equal(exact, same)
    assert farthest_from(coarse, exact) < 1.0
    assert farthest_from(exact, coarse) < 1.0
    assert_allclose(reports[0]["start_map"], (504.0, 874.5), rtol=0, atol=1e-9)
    assert_allclose(reports[1]["start_map"], (4.0, 4.5), rtol=0, atol=1e-12)


def test_rocks_lie_where_the_seed_says(here: Path) -> None:
    flat = hills(np.random.default_rng(0), shape=(120, 150), cell=0.2, relief=1.0, craters=0)
    np.save("ground.npy", flat.height[::-1])
    words = ("drive", "--terrain", "ground.npy", "--cell", "0.2", *NEURAL)
    words += ("--from", "3,3", "--to", "26,19", "--rocks", "0.04")
    first, again, other, none = (
        tell(*words, "--seed", "1", "--out", "a"),
        tell(*words, "--seed", "1", "--out", "b"),
        tell(*words, "--seed", "2", "--out", "c"),
        tell(*words[:-2], "--seed", "1", "--out", "d"),
    )
    assert np.array_equal(path_of(first), path_of(again))
    assert first["forbidden_share"] == again["forbidden_share"] > none["forbidden_share"]
    assert first["forbidden_share"] != other["forbidden_share"]
    assert first["settings"]["rocks"] == 0.04
    assert first["settings"]["seed"] == 1


def test_compare_tells_consistent_numbers(here: Path) -> None:
    np.save("ground.npy", strewn().height[::-1])
    words = ("compare", "ground.npy", "--cell", "0.2", "--pairs", "6", "--seed", "3")
    report = tell(*words, "--controllers", "neural,goal-seeker,planner")
    assert set(report) == {"terrain", "rover", "pairs", "seed", "scores"}
    assert (report["terrain"], report["rover"]) == ("ground.npy", "research")
    assert (report["pairs"], report["seed"]) == (6, 3)
    assert [one["controller"] for one in report["scores"]] == ["neural", "goal-seeker", "planner"]
    labels = {outcome.label for outcome in Outcome}
    for one in report["scores"]:
        reached = one["outcomes"].get("reached", 0)
        assert one["drives"] == sum(one["outcomes"].values()) == 6
        assert set(one["outcomes"]) <= labels
        assert "collided" not in one["outcomes"]  # they stop before what they see
        assert one["reached"] == reached / 6
        assert_allclose((one["low"], one["high"]), wilson(reached, 6), rtol=0, atol=0)
        assert one["low"] <= one["reached"] <= one["high"]
        assert one["detour"] is None if reached == 0 else one["detour"] > 0.8
        assert one["seconds"] > 0.0
    neural, seeker, _ = (one["reached"] for one in report["scores"])
    assert neural > seeker


def test_compare_repeats_itself_and_prints_what_it_found(here: Path) -> None:
    np.save("ground.npy", strewn().height[::-1])
    words = ("compare", "ground.npy", "--cell", "0.2", "--pairs", "4", "--controllers", "neural")
    a, b = (tell(*words)["scores"][0] for _ in range(2))
    for one in (a, b):
        one.pop("seconds")
    assert a == b
    said = run(*words)
    assert (said.code, said.err) == (0, "")
    assert f"{a['reached']:.1%}" in said.out
    assert f"{a['low']:.1%} to {a['high']:.1%}" in said.out


def test_what_was_taught_drives(here: Path) -> None:
    (here / "tiny.yaml").write_text(TINY.format(seed=3))
    report = tell("teach", "tiny.yaml", "--out", "taught")
    assert report["files"] == ["taught/driver.safetensors"]
    assert report["rounds"] == len(report["reached_in_practice"]) == 2
    assert report["patterns"] > 0
    assert 0.0 < report["loss"] < np.log(32) + 1.0
    kept = {path.name for path in (here / "taught").iterdir()}
    assert kept == {
        "recipe.json", "round-1.npz", "round-2.npz", "network-1.safetensors",
        "network-2.safetensors", "driver.safetensors",
    }  # fmt: skip

    np.save("ground.npy", strewn().height[::-1])
    words = ("drive", "--terrain", "ground.npy", "--cell", "0.2", "--frame", "local")
    drive = tell(*words, "--from", "4,4.5", "--to", "8,6", "--controller", report["files"][0])
    assert drive["outcome"] in {"reached", "timed_out"}
    assert drive["steps"] > 0
    assert drive["settings"]["rover"] == "research"


def test_teaching_gives_the_same_bits_for_the_same_seed(here: Path) -> None:
    for seed in (3, 4):
        (here / f"tiny-{seed}.yaml").write_text(TINY.format(seed=seed))
    once, again, other = (
        tell("teach", f"tiny-{seed}.yaml", "--out", out)
        for seed, out in ((3, "a"), (3, "b"), (4, "c"))
    )
    assert once["weights_sha256"] == again["weights_sha256"] != other["weights_sha256"]
    assert Path("a/driver.safetensors").read_bytes() == Path("b/driver.safetensors").read_bytes()


def test_a_stopped_teaching_goes_on_to_the_same_bits(here: Path) -> None:
    (here / "tiny.yaml").write_text(TINY.format(seed=3))
    whole = tell("teach", "tiny.yaml", "--out", "taught")
    for name in ("network-1", "network-2", "driver"):
        (here / "taught" / f"{name}.safetensors").unlink()
    (here / "taught" / "round-2.npz").unlink()
    said = run("teach", "tiny.yaml", "--out", "taught")
    assert said.code == 0
    assert "Round 1: its drives were there already" in said.out
    assert "nan" not in said.out
    finished = tell("teach", "tiny.yaml", "--out", "taught")
    assert finished["weights_sha256"] == whole["weights_sha256"]
    assert "All rounds were there already." in run("teach", "tiny.yaml", "--out", "taught").out


def test_the_ground_of_these_tests_is_worth_driving_over(here: Path) -> None:
    np.save("ground.npy", square())
    where = standing(read_terrain("ground.npy", cell=0.2), read_rover("research"))
    assert 0.05 < where.share < 0.6
