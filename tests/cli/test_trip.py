"""`rovernav route` over elevation models."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.cli.runner import run, tell
from tests.plan.slopes import bumpy

LOCAL = ("--frame", "local", "--cell", "1", "--soil", "loose-sand")


@pytest.fixture(scope="module")
def ground(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("ground") / "hills.npy"
    np.save(path, np.flipud(bumpy(5, 40, 0.5)))
    return path


def ask(ground: Path, out: Path, *words: str, code: int = 0) -> dict[str, Any]:
    ends = ("--from", "2,2", "--to", "37,36.5")
    return tell("route", ground, *ends, *LOCAL, "--out", out, *words, code=code)


@pytest.mark.parametrize("objective", ["distance", "time", "energy", "risk"])
def test_json_holds_what_was_planned(ground: Path, tmp_path: Path, objective: str) -> None:
    told = ask(ground, tmp_path, "--objective", objective)
    assert told["status"] == "found"
    assert told["reason"] is None
    assert told["length_m"] >= math.dist((2, 2), (37, 36.5))
    assert told["energy_j"] > 1000.0
    assert told["time_s"] > told["length_m"]
    assert 0.0 < told["max_slope_deg"] < 30.0
    (leg,) = told["legs"]
    assert math.isclose(sum(leg["terms"].values()), told["cost"], rel_tol=1e-9)
    own = {"distance": "length_m", "time": "time_s", "energy": "energy_j"}.get(objective, "cost")
    assert math.isclose(told[own], told["cost"], rel_tol=1e-9)
    assert {Path(name).name for name in told["files"]} == {path.name for path in tmp_path.iterdir()}


def test_files_agree_with_each_other(ground: Path, tmp_path: Path) -> None:
    told = ask(ground, tmp_path, "--objective", "energy", "--via", "24,20")
    line = json.loads((tmp_path / "route.geojson").read_text())["features"]
    assert [f["properties"]["name"] for f in line] == ["route", "route", "start", "stop 1", "goal"]
    assert line[0]["geometry"]["coordinates"][-1] == [24.0, 20.0]
    assert sum(f["properties"]["energy_j"] for f in line[:2]) == told["energy_j"]
    rows = list(csv.DictReader((tmp_path / "profile.csv").read_text().splitlines()))
    assert math.isclose(float(rows[-1]["distance_m"]), told["length_m"], rel_tol=1e-9)
    mean = np.mean([float(row["energy_j_per_m"]) for row in rows])
    assert math.isclose(mean * told["length_m"], told["energy_j"], rel_tol=0.1)
    assert all(float(r["slip_low"]) <= float(r["slip"]) <= float(r["slip_high"]) for r in rows)


def test_best_order_and_the_table_in_words(ground: Path, tmp_path: Path) -> None:
    stops = ("--via", "35,30", "--via", "8,9", "--via", "24,20")
    told = ask(ground, tmp_path, *stops, "--order", "best", "--objective", "time")
    assert told["order"] == [0, 2, 3, 1, 4]
    said = run(
        "route", ground, "--from", "2,2", "--to", "37,36.5", *LOCAL, "--out", tmp_path, *stops
    )
    assert said.code == 0, said.err
    assert "Least distance, leg by leg" in said.out
    assert "energy [kJ]" in said.out


def test_why_here_compares_with_the_straight_line(ground: Path, tmp_path: Path) -> None:
    told = ask(ground, tmp_path, "--objective", "energy", "--why", "20,20")["why"]
    assert told["off"] < 15.0
    assert math.isclose(sum(told["stretch"]["terms"].values()), told["stretch"]["cost"])
    assert told["straight"]["cost"] is None or told["dearer"] >= -1e-6
    assert set(told["per_metre"]) == {"rolling", "climbing", "slip", "idle power"}
    assert told["layers"]["slope"]["unit"] == "rad"
    words = ("--from", "2,2", "--to", "37,36.5", *LOCAL, "--out", tmp_path, "--why", "20,20")
    said = run("route", ground, *words)
    assert "along the route, a metre costs:" in said.out
    assert "straight line in their place" in said.out


def test_no_way_is_an_answer_and_no_error(tmp_path: Path) -> None:
    heights = 0.001 * np.tile(np.arange(60.0), (40, 1))
    heights[:, 28:32] = np.nan
    np.save(tmp_path / "river.npy", heights)
    words = ("route", tmp_path / "river.npy", "--from", "3,20", "--to", "56,20", *LOCAL)
    told = tell(*words, "--out", tmp_path / "o")
    assert told["status"] == "unreachable"
    assert told["length_m"] is told["energy_j"] is told["max_slope_deg"] is None
    assert "ground without data" in told["reason"]
    assert [b["limit"] for b in told["barriers"]] == ["no data"]
    assert 24.0 < told["nearest_off_m"] < 36.0
    assert sorted(p.name for p in (tmp_path / "o").iterdir()) == [
        "route.csv", "route.geojson", "route.png",
    ]  # fmt: skip
    assert "There is no way: " in run(*words, "--out", tmp_path / "o").out
    assert tell(*words, "--out", tmp_path / "o", "--require", "found", code=1)


def test_zones_are_kept_out_of(ground: Path, tmp_path: Path) -> None:
    ring = [[15, 15], [25, 15], [25, 25], [15, 25], [15, 15]]
    zone = tmp_path / "z.geojson"
    zone.write_text(json.dumps({"type": "Polygon", "coordinates": [ring]}))
    free = ask(ground, tmp_path / "o")
    kept = ask(ground, tmp_path / "o", "--avoid", str(zone), "--margin", "2")
    assert kept["length_m"] > free["length_m"]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--objective", "enrgy"), "--objective has no 'enrgy'; did you mean 'energy'?"),
        (("--order", "bets"), "--order has no 'bets'"),
        (("--require", "luck"), "--require has no 'luck'"),
        (("--margin", "3"), "--margin is kept from zones; give --avoid or --keep-in as well"),
        (("--neighbours", "9"), "neighbours must be 8, 16 or 32, got 9"),
        (("--via", "1,x"), "--via must be two numbers X,Y"),
        (("--why", "here"), "--why must be two numbers X,Y"),
        (("--avoid", "none.geojson"), "there is no file none.geojson"),
        (("--soil", "snad"), "snad"),
        (("--rover", "paper-point", "--objective", "energy"), "paper-point says nothing of its"),
        (("--scen", "x.scen"), "--scen goes with a MovingAI .map only"),
    ],
)
def test_options_that_are_refused(
    ground: Path, tmp_path: Path, words: tuple[str, ...], said: str
) -> None:
    told = run(
        "route", ground, "--from", "2,2", "--to", "37,36.5", "--frame", "local", "--cell", "1",
        "--out", tmp_path, *words,
    )  # fmt: skip
    assert told.code == 2
    assert said in told.err
    assert len(told.err.strip().splitlines()) <= 2
    assert not told.out


def test_a_margin_below_0_is_refused(ground: Path, tmp_path: Path) -> None:
    zone = tmp_path / "z.geojson"
    ring = [[15, 15], [25, 15], [25, 25], [15, 25], [15, 15]]
    zone.write_text(json.dumps({"type": "Polygon", "coordinates": [ring]}))
    said = run("route", ground, "--from", "2,2", "--to", "9,9", *LOCAL, "--out", tmp_path,
               "--avoid", zone, "--margin", "-1")  # fmt: skip
    assert said.code == 2
    assert "the margin must be 0 m or more" in said.err


@pytest.mark.data
def test_least_energy_on_jezero(data_dir: Path, tmp_path: Path) -> None:
    words = (
        "route", data_dir / "dem/mars_jezero_hirise", "--frame", "local", "--from", "300,300",
        "--to", "1500,2000", "--rover", "perseverance", "--soil", "loose-sand", "--out", tmp_path,
    )  # fmt: skip
    short, least = (tell(*words, "--objective", name) for name in ("distance", "energy"))
    assert short["status"] == least["status"] == "found"
    assert short["length_m"] <= least["length_m"]
    assert least["energy_j"] <= short["energy_j"] * 1.0005
