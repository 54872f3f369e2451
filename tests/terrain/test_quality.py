"""The quality report: what it must see, and what it must not take for noise."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.ndimage import gaussian_filter

from rovernav.terrain import Dunes, Ground, Quality, Recipe, Relief, open_raster, quality
from rovernav.terrain import _quality as q
from rovernav.terrain._roughness import second_structure, self_affine
from tests.terrain.ground import ground, plane, rough, write_tiff

SIDE = 160


def relief(seed: int, hurst: float, slope: float = 5.0) -> np.ndarray:
    rise = Relief(hurst=hurst, slope=math.radians(slope), baseline=1.0)
    recipe = Recipe(size=(SIDE, SIDE), cell=1.0, relief=rise)
    return Ground.made(recipe, seed).read().height.astype(np.float64)


def noise(seed: int, rms: float, reach: float = 0.0) -> np.ndarray:
    white = np.random.default_rng(seed).standard_normal((SIDE, SIDE))
    smooth = gaussian_filter(white, reach) if reach else white
    return smooth * (rms / smooth.std())


@pytest.mark.parametrize("hurst", [0.5, 0.65, 0.8, 0.95])
@pytest.mark.parametrize("slope", [1.0, 15.0])
def test_natural_ground_is_not_noisy(hurst: float, slope: float) -> None:
    for seed in range(4):
        found = quality(ground(relief(seed, hurst, slope)))
        assert not found.noisy
        assert found.noise_share < 0.4
        assert found.flags == ()


@pytest.mark.parametrize("hurst", [0.6, 0.8, 0.95])
def test_noise_between_posts_is_found_and_measured(hurst: float) -> None:
    for seed in range(3):
        clean = relief(seed, hurst)  # 0.087 m from post to post
        for rms in (0.2, 0.5):
            found = quality(ground(clean + noise(seed, rms)))
            assert found.noisy
            assert found.noise == pytest.approx(rms, rel=0.1)
            assert found.noise_slope == pytest.approx(math.atan(rms * math.sqrt(2.0)), rel=0.15)
        assert "noisy: " in found.flags[-1]


@pytest.mark.parametrize("reach", [1.0, 1.5])
def test_noise_that_neighbours_share_is_found(reach: float) -> None:
    for seed in range(3):
        assert quality(ground(relief(seed, 0.8, 3.0) + noise(seed, 0.5, reach))).noisy


def test_noise_too_small_to_matter_is_not_flagged() -> None:
    flat = ground(noise(1, 0.002))
    found = quality(flat)
    assert found.noise_share > 0.9
    assert found.noise == pytest.approx(0.002, rel=0.1)
    assert not found.noisy


@pytest.mark.parametrize("wind", [0.0, 30.0, 45.0, 80.0])
@pytest.mark.parametrize("wavelength", [5.0, 8.0, 20.0])
def test_dunes_are_no_noise(wind: float, wavelength: float) -> None:
    recipe = Recipe(size=(SIDE, SIDE), cell=1.0, relief=Relief(slope=math.radians(1.0)),
                    dunes=Dunes(wavelength=wavelength, height=0.1 * wavelength,
                                wind=math.radians(wind)))  # fmt: skip
    assert not quality(Ground.made(recipe, 2).read()).noisy


@pytest.mark.parametrize("step", [0.02, 0.25, 1.0])
def test_steps_of_rounding(step: float) -> None:
    heights = np.round(relief(3, 0.8, 10.0) / step) * step
    found = quality(ground(heights))
    assert found.step == pytest.approx(step, rel=1e-3)
    assert found.step_slope == pytest.approx(math.atan(step / math.sqrt(6.0)), rel=1e-3)
    assert found.stepped is (step > 0.1)
    flagged = any(flag.startswith("rounded: heights come in steps of") for flag in found.flags)
    assert flagged is found.stepped
    assert quality(ground(relief(3, 0.8, 10.0))).step == 0.0


def test_rounding_is_judged_on_the_posts_of_the_file(tmp_path: Path) -> None:
    import rasterio

    whole, place = np.round(relief(1, 0.8, 10.0)), rasterio.Affine(1e-5, 0, 10, 0, -1e-5, 45)
    path = write_tiff(tmp_path / "a.tif", whole.astype(np.int16), crs="EPSG:4326", transform=place)
    raster = open_raster(path)
    assert raster.resampled
    assert quality(raster).step == pytest.approx(1.0, rel=1e-6)
    assert quality(raster).stepped
    assert quality(raster.read()).step == 0.0  # between posts nothing is round any more


def test_holes_are_counted() -> None:
    heights = relief(1, 0.8)
    heights[:40, :40] = np.nan
    found = quality(ground(heights))
    assert found.holes == pytest.approx(1 / 16)
    assert found.flags == ("holes: 6.2% of the posts have no data",)
    heights[:] = 1.0
    heights[0, 0] = np.nan
    assert quality(ground(heights)).flags == ("holes: less than 0.1% of the posts have no data",)


def test_a_large_file_is_sampled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(q, "PIECE", 40)
    path = write_tiff(tmp_path / "a.tif", relief(1, 0.8) + noise(1, 0.3))
    found = quality(open_raster(path))
    assert (found.sampled, found.posts) == (True, 9 * 40 * 40)
    assert found.noisy
    assert found.report()["noisy"] is True


@pytest.mark.parametrize("heights", [np.zeros((3, 3)), np.ones((50, 60)), rough(
    np.random.default_rng(0), (30, 30), 0.9)])  # fmt: skip
def test_little_or_level_ground_says_nothing(heights: np.ndarray) -> None:
    found = quality(ground(heights))
    assert isinstance(found, Quality)
    assert not found.noisy
    assert not found.stepped


def test_second_differences_do_not_see_a_plane() -> None:
    d = second_structure([plane(0.3, -0.2, shape=(40, 50)).height], (1, 4))
    assert_allclose(d, 0.0, atol=1e-10)
    hurst, square = self_affine([relief(4, 0.7) + 0.5 * np.arange(SIDE)], (1, 2, 4, 8))
    assert hurst == pytest.approx(0.7, abs=0.06)
    assert math.sqrt(square) == pytest.approx(math.tan(math.radians(5.0)), rel=0.08)
