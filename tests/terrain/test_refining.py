"""Refined ground: means kept, no seams, the statistics that are stated, bounded memory."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from rovernav.core import SettingError
from rovernav.kernels import refine as k
from rovernav.terrain import (
    Ground,
    Recipe,
    Refined,
    Relief,
    Terrain,
    Window,
    open_raster,
    refine,
    rock_cover,
    slope,
)  # fmt: skip
from rovernav.terrain import _refining as refining
from rovernav.terrain._refining import _bump
from tests.terrain.ground import ground, plane, rough, write_tiff


def coarse(seed: int = 1, hurst: float = 0.8, cell: float = 2.0, side: int = 40) -> Terrain:
    recipe = Recipe(size=(side * cell, side * cell), cell=cell,
                    relief=Relief(hurst=hurst, slope=math.radians(6.0), baseline=cell))  # fmt: skip
    return Ground.made(recipe, seed).read()


def means(fine: Refined, window: Window) -> np.ndarray:
    """Means over coarse cells of a window that holds whole ones."""
    n = fine.n
    heights = fine.heights(window)
    return heights.reshape(window.rows // n, n, window.columns // n, n).mean(axis=(1, 3))


@pytest.mark.parametrize("rocks", [None, 0.1])
@pytest.mark.parametrize("cell", [0.1, 0.3, 2.0])
def test_means_over_posts_stay_what_they_are(cell: float, rocks: float | None) -> None:
    model = coarse()
    fine = refine(model, cell, seed=2, rocks=rocks)
    n = fine.n
    window = Window(row=3 * n, column=5 * n, rows=10 * n, columns=8 * n)
    expected = model.height[3:13, 5:13].astype(np.float64) + model.offset
    assert_allclose(means(fine, window), expected, rtol=0, atol=1e-9)
    short = fine.read(window)
    blocks = (short.height.astype(np.float64) + short.offset).reshape(10, n, 8, n)
    assert_allclose(blocks.mean(axis=(1, 3)), expected, rtol=0, atol=1e-6)


@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    row=st.integers(0, 700), column=st.integers(0, 700), rows=st.integers(1, 60),
    columns=st.integers(1, 60), missing=st.booleans(),
)  # fmt: skip
def test_any_window_is_a_part_of_the_whole(
    row: int, column: int, rows: int, columns: int, missing: bool
) -> None:
    fine, whole = WHOLE[missing]
    part = fine.read(Window(row=row, column=column, rows=rows, columns=columns))
    assert_array_equal(part.height, whole.height[row : row + rows, column : column + columns])
    assert part.offset == whole.offset


def _whole(missing: bool) -> tuple[Refined, Terrain]:
    heights = coarse().height.astype(np.float64)
    if missing:
        heights[10:14, 20:33] = np.nan
        heights[rough(np.random.default_rng(3), heights.shape, 0.03) != 0] += 0.0
        heights[np.isnan(rough(np.random.default_rng(3), heights.shape, 0.03))] = np.nan
    fine = refine(ground(heights, cell=2.0), 0.1, seed=4, rocks=0.05)
    return fine, fine.read()


WHOLE = {missing: _whole(missing) for missing in (False, True)}


def test_strips_do_not_show(monkeypatch: pytest.MonkeyPatch) -> None:
    fine, whole = WHOLE[True]
    window = Window(row=33, column=41, rows=200, columns=150)
    monkeypatch.setattr(refining, "STRIP", 4000)
    shares: list[float] = []
    part = fine.read(window, on_progress=shares.append)
    assert_array_equal(part.height, whole.height[33:233, 41:191])
    assert len(shares) > 3
    assert shares[-1] == 1.0


def test_a_raster_and_a_window_of_it_give_the_same_ground(tmp_path: Path) -> None:
    rows = coarse(side=60).height[::-1]
    raster = open_raster(write_tiff(tmp_path / "a.tif", rows))
    fine = refine(raster, 0.25, seed=3)
    window = fine.window(140.0, 4920.0, 160.0, 4930.0)
    assert (window.rows, window.columns) == (40, 80)
    part = fine.read(window)
    assert part.frame.origin == pytest.approx((140.0, 4920.0))
    whole = fine.read()
    at = (slice(window.row, window.row + 40), slice(window.column, window.column + 80))
    assert_array_equal(part.height, whole.height[at])


def test_holes_stay_holes_and_nothing_else_becomes_one() -> None:
    fine, whole = WHOLE[True]
    n = fine.n
    expected = np.isnan(np.kron(np.asarray(fine.coarse.height), np.ones((n, n))))  # type: ignore[union-attr]
    assert_array_equal(np.isnan(whole.height), expected)
    beside = whole.height[9 * n : 10 * n, 22 * n : 30 * n]  # north of it begins a hole
    assert np.isfinite(beside).all()
    assert np.degrees(np.nanmax(slope(whole))) < 80


def test_other_seeds_give_other_ground() -> None:
    window = Window(row=0, column=0, rows=90, columns=90)
    one, two = (refine(coarse(), 0.1, seed=seed, rocks=0.05).read(window).height for seed in (1, 2))
    assert np.abs(one - two).max() > 0.05


@pytest.mark.parametrize("hurst", [0.6, 0.75, 0.9])
def test_the_spectrum_of_the_posts_goes_on_below_them(hurst: float) -> None:
    """S(h) = S(L) (h/L)^2H at lags below a post, within a fifth in rms."""
    ratios = []
    for seed in range(3):
        model = coarse(seed, hurst, cell=4.0, side=60)
        fine = refine(model, 0.25, seed=seed)
        assert fine.hurst == pytest.approx(hurst, abs=0.1)
        z = fine.heights(Window(row=320, column=320, rows=320, columns=320))
        for lag in (1, 2, 4, 8):
            bend = z[:, : -2 * lag] - 2 * z[:, lag:-lag] + z[:, 2 * lag :]
            s = (fine.post_slope * 4.0) ** 2 * (lag * 0.25 / 4.0) ** (2 * fine.hurst)
            ratios.append(math.sqrt(np.mean(bend**2) / (s * (4 - 2 ** (2 * fine.hurst)))))
    assert np.mean(ratios) == pytest.approx(1.0, abs=0.2)
    assert min(ratios) > 0.6
    assert max(ratios) < 1.5


def test_statistics_are_stated() -> None:
    fine = refine(coarse(), 0.1, seed=2, rocks=0.06)
    said = fine.statistics()
    assert (said["post_m"], said["cell_m"], said["cells_per_post"]) == (2.0, 0.1, 20)
    assert said["rock_sizes_m"] == [0.2, 2.0]
    assert said["rock_cover"] == pytest.approx(rock_cover(0.2, 0.06) - rock_cover(2.0, 0.06))
    assert 0.5 < said["hurst"] < 0.95
    assert said["rms_slope_deg_at_posts"] == pytest.approx(6.0, rel=0.2)
    assert "rocks over 6.0%, seed 2" in fine.words()


def test_rocks_cover_what_their_law_says() -> None:
    flat = plane(0.0, 0.0, shape=(60, 60), cell=2.0)
    with_rocks = refine(flat, 0.1, seed=1, rocks=0.2, hurst=0.8, slope=0.0).heights(
        Window(row=0, column=0, rows=1200, columns=1200)
    )
    blocks = with_rocks.reshape(60, 20, 60, 20).swapaxes(1, 2).reshape(3600, 400)
    low = np.median(blocks, axis=1)[:, None]
    cover = (blocks > low + 0.04).mean()
    expected = rock_cover(0.2, 0.2) - rock_cover(2.0, 0.2)
    assert cover == pytest.approx(expected, rel=0.2)


def test_noise_between_posts_is_not_carried_on() -> None:
    model = coarse(side=90)
    noisy = ground(model.height + np.random.default_rng(1).normal(0, 0.6, model.frame.shape), 2.0)
    sound, spoilt = (refine(terrain, 0.2) for terrain in (model, noisy))
    own = math.sqrt(2.0) * 0.6 / 2.0  # the slope that noise alone would claim
    assert spoilt.post_slope < 0.6 * own
    assert spoilt.hurst > 0.45
    assert sound.hurst == pytest.approx(0.8, abs=0.1)


def test_own_exponent_and_slope() -> None:
    fine = refine(coarse(), 0.2, hurst=0.5, slope=math.radians(10.0))
    assert (fine.hurst, fine.post_slope) == (0.5, pytest.approx(math.tan(math.radians(10.0))))
    level = refine(plane(0.0, 0.0, shape=(9, 9)), 0.1, hurst=0.8, slope=0.0)
    assert level.relief is None
    assert level.read().span == (0.0, 0.0)


def test_a_smooth_hill_stays_smooth() -> None:
    i, j = np.indices((30, 30))
    hill = ground(3.0 * np.exp(-((i - 15.0) ** 2 + (j - 15.0) ** 2) / 60.0), cell=1.0)
    fine = refine(hill, 0.1, hurst=0.8, slope=0.0)
    z = fine.heights(Window(row=50, column=50, rows=200, columns=200))
    y, x = (np.indices((200, 200)) + 50.5) / 10.0 - 0.5
    exact = 3.0 * np.exp(-((y - 15.0) ** 2 + (x - 15.0) ** 2) / 60.0)
    assert np.abs(z - exact).max() < 0.01
    assert np.abs(np.diff(z, 2)).max() < 0.003  # no creases between blocks


@pytest.mark.kernels
@pytest.mark.parametrize("n", [1, 4])
def test_smooth_is_exact_on_planes_and_keeps_means(n: int) -> None:
    i, j = np.indices((12, 13)) - 4.0
    z = 0.3 * j - 0.2 * i
    out = np.empty((5 * n, 6 * n))
    k.smooth(z, n, 4, out)
    y, x = (np.indices(out.shape) + 0.5) / n - 0.5
    assert_allclose(out, 0.3 * x - 0.2 * y, rtol=0, atol=1e-12)
    known = np.random.default_rng(n).normal(size=(5, 6))
    known[2, 3] = np.nan
    k.keep_means(known, n, _bump(n), out)
    assert_allclose(out.reshape(5, n, 6, n).mean(axis=(1, 3)), known, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"cell": 3.0}, r"--cell must lie above 0 and up to the posts of 2 m, got 3"),
        ({"cell": math.nan}, "--cell must lie above 0"),
        ({"cell": 1e-5}, "200,000 fine cells along a post are more than 10,000; give a larger"),
        ({"hurst": 1.5}, "the Hurst exponent must lie in 0.2 to 0.98, got 1.5"),
        ({"slope": 2.0}, "the rms slope must lie in 0 to 60 deg"),
        ({"rocks": 3.0}, "rock abundance must be a share of the ground .* write 5 % as 0.05"),
    ],
)
def test_settings_that_cannot_be(settings: dict[str, float], message: str) -> None:
    given = {"cell": 0.2, **settings}
    with pytest.raises(SettingError, match=message):
        refine(coarse(side=12), given.pop("cell"), **given)  # type: ignore[arg-type]


def test_ground_and_windows_that_cannot_be() -> None:
    with pytest.raises(SettingError, match="its roughness cannot be measured"):
        refine(plane(0.0, 0.0), 0.1)
    fine = refine(coarse(side=12), 0.1)
    with pytest.raises(SettingError, match="leaves the fine grid of 240 x 240 cells"):
        fine.read(Window(row=200, column=0, rows=41, columns=3))
    with pytest.raises(SettingError, match="the window lies off the map; rovernav inspect shows"):
        fine.window(90.0, 90.0, 99.0, 99.0)
    with pytest.raises(SettingError, match="a window is written west, south, east, north"):
        fine.window(9.0, 9.0, 0.0, 10.0)
    with pytest.raises(SettingError, match="fine cells are more than 100,000,000 at a time"):
        refine(coarse(side=120), 0.01).read()


@pytest.mark.data
def test_jezero_at_ten_centimetres(data_dir: Path) -> None:
    raster = open_raster(data_dir / "dem/mars_jezero_hirise")
    fine = refine(raster, 0.1, seed=7, rocks=0.05)
    n = fine.n
    assert fine.frame.cell <= 0.1
    window = Window(row=500 * n, column=400 * n, rows=4 * n, columns=6 * n)
    expected = raster.heights(Window(row=500, column=400, rows=4, columns=6))
    assert_allclose(means(fine, window), expected, rtol=0, atol=1e-6)
    x, y = fine.frame.centre_of(500 * n, 400 * n)
    assert fine.frame.to_map(x, y) == pytest.approx(raster.frame.to_map(x, y), abs=1e-6)
