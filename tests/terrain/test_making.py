"""Made ground: the same for a seed, lazy, and what was asked for by its own measurement."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from rovernav.core import SettingError
from rovernav.terrain import (
    Cliffs,
    Craters,
    Dunes,
    Ground,
    Pits,
    Recipe,
    Relief,
    Window,
    hurst_exponent,
    measured,
    read_recipe,
    recipe_data,
    recipe_of,
    rms_slope,
)  # fmt: skip
from rovernav.terrain import _making as making

ALL = Recipe(
    size=(90.0, 60.0),
    cell=0.3,
    relief=Relief(hurst=0.7, slope=math.radians(5.0), baseline=1.2),
    craters=Craters(body="mars", age=3.0, smallest=2.0, largest=20.0),
    dunes=Dunes(wavelength=6.0, height=0.4, wind=1.0),
    cliffs=Cliffs(height=2.0, spacing=40.0),
    pits=Pits(per_km2=3000.0, smallest=3.0, largest=8.0),
    rocks=0.08,
    holes=0.05,
)


def test_a_seed_gives_its_ground_and_no_other() -> None:
    one, again, other = (Ground.made(ALL, seed).read().height for seed in (1, 1, 2))
    assert_array_equal(one, again)
    assert np.nanmax(np.abs(one - other)) > 0.5
    assert one.shape == (200, 300)


def test_any_window_is_a_part_of_the_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    ground = Ground.made(ALL, 4)
    whole = ground.read()
    part = ground.read(Window(row=37, column=101, rows=60, columns=50))
    assert_array_equal(part.height, whole.height[37:97, 101:151])
    assert part.frame.origin == pytest.approx((101 * 0.3, 37 * 0.3))
    monkeypatch.setattr(making, "STRIP", 900)
    shares: list[float] = []
    assert_array_equal(ground.read(on_progress=shares.append).height, whole.height)
    assert shares[-1] == 1.0


def test_larger_ground_begins_with_the_same_forms() -> None:
    """Craters, rocks and forms do not know where the ground ends; relief does: its longest wave."""
    flat = dataclasses.replace(ALL, relief=Relief(slope=0.0), holes=0.0)
    small = Ground.made(flat, 6).read().height
    large = Ground.made(dataclasses.replace(flat, size=(150.0, 120.0)), 6).read().height
    assert_array_equal(large[:200, :300], small)


@pytest.mark.parametrize("hurst", [0.4, 0.6, 0.8, 0.9])
@pytest.mark.parametrize(("slope", "baseline"), [(3.0, 0.5), (12.0, 2.0)])
def test_relief_has_its_hurst_exponent_and_slope(
    hurst: float, slope: float, baseline: float
) -> None:
    relief = Relief(hurst=hurst, slope=math.radians(slope), baseline=baseline)
    recipe = Recipe(size=(128.0, 128.0), cell=0.5, relief=relief)
    grounds = [Ground.made(recipe, seed).read() for seed in range(6)]
    exponents = [hurst_exponent(ground, (1, 2, 4, 8)) for ground in grounds]
    slopes = [rms_slope(ground, baseline) for ground in grounds]
    assert float(np.mean(exponents)) == pytest.approx(hurst, abs=0.04)
    rms = math.degrees(math.atan(math.sqrt(float(np.mean(np.square(slopes))))))
    assert rms == pytest.approx(slope, rel=0.12)


def test_what_is_measured_is_what_was_asked_for() -> None:
    recipe = dataclasses.replace(ALL, size=(150.0, 150.0))
    found = measured(Ground.made(recipe, 3))
    assert found["area_m2"] == pytest.approx(22_500.0)
    assert found["hurst"]["measured"] == pytest.approx(0.7, abs=0.05)
    assert found["rms_slope_deg"]["measured"] == pytest.approx(5.0, rel=0.1)
    for what in ("craters", "pits"):
        expected = found[what]["expected"]
        assert abs(found[what]["count"] - expected) < 4 * math.sqrt(expected)
    rocks = found["rocks"]
    assert rocks["cover"] == pytest.approx(rocks["asked_cover"], rel=0.15)
    assert found["dunes"]["wavelength_m"] == pytest.approx(6.0, rel=0.1)
    assert found["dunes"]["height_m"] == pytest.approx(0.4, rel=1e-3)
    assert found["cliffs"]["height_m"] == pytest.approx(2.0, rel=1e-6)
    assert found["cliffs"]["steepest_deg"] == pytest.approx(75.0, abs=6.0)
    assert found["holes"]["measured"] == pytest.approx(0.05, abs=0.02)
    assert found["slope_deg"]["p50"] < found["slope_deg"]["p99"]


@pytest.mark.parametrize("share", [0.02, 0.2, 0.6])
def test_holes_cover_about_their_share(share: float) -> None:
    recipe = Recipe(size=(150.0, 150.0), cell=0.5, holes=share)
    shares = [1.0 - Ground.made(recipe, seed).read().finite for seed in range(6)]
    assert float(np.mean(shares)) == pytest.approx(share, rel=0.2)


def test_plain_ground_is_level() -> None:
    ground = Ground.made(Recipe(relief=Relief(slope=0.0)), 0)
    assert ground.relief() is None
    assert ground.read().span == (0.0, 0.0)
    assert "hurst" not in measured(ground)


def test_recipes_as_data_and_back(tmp_path: Path) -> None:
    data = recipe_data(ALL)
    assert data["relief"] == {"hurst": 0.7, "slope_deg": 5.0, "baseline_m": 1.2}
    assert data["rock_sizes_m"] == pytest.approx([0.18, 2.0])
    again = recipe_of(data, source="x")
    assert recipe_data(again) == data
    assert_array_equal(Ground.made(again, 5).read().height, Ground.made(ALL, 5).read().height)
    (tmp_path / "a.yaml").write_text("cell_m: 0.5\ncraters: {body: moon}\n")
    whole = recipe_of(read_recipe(tmp_path / "a.yaml"), source="a.yaml")
    assert whole.craters is not None
    assert (whole.craters.smallest, whole.craters.largest) == (4.0, pytest.approx(100 / 3))


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ({"sice_m": [1, 2]}, "here: unknown key 'sice_m'; did you mean 'size_m'"),
        ({"relief": {"hurst": 3}}, "here: the Hurst exponent must lie in 0.2 to 0.98, got 3"),
        ({"relief": {"baseline_m": 0}}, "here: a baseline must lie in 0 to 100000 m, got 0"),
        ({"relief": {"slope_deg": 80}}, "here: the rms slope must lie in 0 to 60 deg, got 80"),
        ({"cell_m": -1}, "here: a cell must be a positive number of metres, got -1"),
        ({"size_m": [1]}, "here: the key 'size_m.1' is missing; add it"),
        ({"size_m": [float("inf"), 1]}, "here: size_m.0 = inf: input should be a finite number"),
        ({"holes": 1.0}, "here: the share of holes must lie in 0 to 0.9, got 1"),
        ({"dunes": {"height_m": 1.0}}, "here: the key 'dunes.wavelength_m' is missing; add it"),
        ({"rocks": 0.05, "rock_sizes_m": [2, 1]}, "the largest rock .1 m. must be finite and"),
    ],
)
def test_recipes_that_cannot_be(data: dict[str, Any], message: str) -> None:
    with pytest.raises(SettingError, match=message):
        recipe_of(data, source="here")


def test_more_things_than_memory_holds() -> None:
    recipe = dataclasses.replace(ALL, size=(1e5, 1e5), cell=50.0, rock_sizes=(0.1, 2.0))
    with pytest.raises(SettingError, match=r"about .* rocks would lie on 100000 x 100000 m, more"):
        Ground.made(dataclasses.replace(recipe, craters=None, pits=None), 0)
    with pytest.raises(SettingError, match="a seed must lie in 0 to"):
        Ground.made(ALL, -1)
    with pytest.raises(SettingError, match="cells are more than 100,000,000 at a time; give a lar"):
        Ground.made(Recipe(size=(1e4, 1e4), cell=0.5), 0).read()
