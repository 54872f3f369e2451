"""Random fields, strewn things and forms: lazy, seeded, and of the statistics asked for."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from rovernav.core import SettingError
from rovernav.kernels import craters as ck
from rovernav.kernels import field as fk
from rovernav.terrain import Cliffs, Dunes, Pits, RockField, rock_count, rock_cover
from rovernav.terrain._field import SHARE, fitted_field, key_of, self_affine_law
from rovernav.terrain._strewn import size_classes, strewn
from tests.naive import ground as naive

KEY = key_of(3, 1, 2)


@pytest.mark.kernels
@pytest.mark.parametrize("pace", [1.0, 0.3, 0.04])
def test_waves_equal_their_twin(pace: float) -> None:
    out = np.zeros((5, 6))
    with np.errstate(over="ignore"):  # whole numbers that wrap around, without the compiler
        fk.add_waves(out, 7, -11, pace, KEY, 1.0)
    assert_allclose(out, naive.waves(int(KEY), 7, -11, (5, 6), pace), rtol=0, atol=1e-12)


@pytest.mark.kernels
def test_grain_equals_its_twin() -> None:
    out = np.zeros((3, 4))
    with np.errstate(over="ignore"):
        fk.add_grain(out, -2, 5, KEY, 2.0)
    expected = [[2.0 * naive.deviate(int(KEY), -2 + i, 5 + j) for j in range(4)] for i in range(3)]
    assert_allclose(out, expected, rtol=0, atol=1e-12)


@pytest.mark.kernels
def test_craters_and_pits_equal_their_twins(rng: np.random.Generator) -> None:
    table = rng.normal(size=(4, 31))
    rows = np.column_stack([rng.uniform(-2, 14, 9), rng.uniform(-2, 12, 9), rng.uniform(1, 4, 9),
                            rng.uniform(1, 9, 9), rng.uniform(0, 2.9, 9)])  # fmt: skip
    got, finest = np.zeros((9, 11)), 0.1

    def profile(r: float, wear: float) -> float:
        a = int(wear)
        new, old = (float(np.interp(r / finest, np.arange(31), table[n])) for n in (a, a + 1))
        return new + (wear - a) * (old - new)

    ck.dig_craters(rows, table, finest, got)
    assert_allclose(got, naive.cratered(rows, profile, 3.0, (9, 11)), rtol=0, atol=1e-12)
    sunk = np.zeros((9, 11))
    ck.sink_pits(rows, sunk)
    assert_allclose(sunk, naive.sunk(rows, (9, 11)), rtol=0, atol=1e-12)


def test_deviates_are_nearly_normal() -> None:
    out = np.zeros((700, 700))
    fk.add_grain(out, 0, 0, KEY, 1.0)
    assert abs(out.mean()) < 4 / 700
    assert out.var() == pytest.approx(1.0, abs=0.01)
    assert (out**4).mean() == pytest.approx(2.7, abs=0.05)  # of four uniform numbers
    for shifted in (out[1:] * out[:-1], out[:, 1:] * out[:, :-1]):
        assert abs(shifted.mean()) < 4 / 700


@pytest.mark.parametrize("hurst", [0.3, 0.5, 0.7, 0.9])
def test_a_field_has_the_structure_that_it_says(hurst: float) -> None:
    law = self_affine_law(hurst, 0.1, 2.0)
    lags = np.array([1.0, 2.0, 3.0, 5.0, 8.0, 20.0, 40.0])
    fields = [fitted_field(law, 1.0, longest=8192.0, farthest=64.0, seed=seed, channel=1)
              for seed in range(12)]  # fmt: skip
    assert_allclose(fields[0].structure(lags), law(lags), rtol=0.02)
    lags = np.array([1, 2, 3, 5, 8])
    bends = np.zeros(len(lags))  # second differences vary less from seed to seed than first ones
    for field in fields:
        z = np.zeros((200, 200))
        field.add_to(z, 0, 0)
        bends += [np.mean((z[:, : -2 * h] - 2 * z[:, h:-h] + z[:, 2 * h :]) ** 2) for h in lags]
    assert_allclose(bends / len(fields), 4 * law(lags) - law(2 * lags), rtol=0.08)


def test_a_field_has_no_direction() -> None:
    law = self_affine_law(0.6, 0.1, 1.0)
    along, across, aslant = np.zeros(3)
    for seed in range(10):
        z = np.zeros((150, 150))
        fitted_field(law, 1.0, longest=2048, farthest=32, seed=seed, channel=1).add_to(z, 0, 0)
        along += np.mean((z[:, 10:] - z[:, :-10]) ** 2)
        across += np.mean((z[10:] - z[:-10]) ** 2)
        aslant += np.mean((z[7:, 7:] - z[:-7, :-7]) ** 2)
    assert across == pytest.approx(along, rel=0.2)
    assert aslant == pytest.approx((along + across) / 2, rel=0.15)


def test_any_window_of_a_field_is_a_part_of_the_whole() -> None:
    field = fitted_field(self_affine_law(0.8, 0.1, 1.0), 0.5, longest=500, farthest=20, seed=9,
                         channel=1)  # fmt: skip
    whole = np.zeros((90, 120))
    field.add_to(whole, -40, 1000)
    for row, column, shape in ((0, 0, (7, 9)), (50, 33, (40, 1)), (89, 119, (1, 1))):
        part = np.zeros(shape)
        field.add_to(part, row - 40, column + 1000)
        assert_array_equal(part, whole[row : row + shape[0], column : column + shape[1]])


def test_the_mean_square_of_a_spline_is_known() -> None:
    t = (np.arange(20000) + 0.5) / 20000
    weights = np.array([[naive.b3(u + 1 - n) for n in range(4)] for u in t])
    assert (weights**2).sum(axis=1).mean() == pytest.approx(SHARE, rel=1e-6)


def test_strewn_things_do_not_depend_on_the_window() -> None:
    def count(d: float) -> float:
        return 0.01 * d**-2.0

    classes = size_classes(count, 1.0, 9.0)
    whole = strewn(classes, count, (0, 0, 300, 200), reach=2.0, seed=(5, 1))
    part = strewn(classes, count, (100, 50, 140, 90), reach=2.0, seed=(5, 1))
    x, y, far = whole[:, 0], whole[:, 1], 2 * whole[:, 2]
    near = (x > 100 - far) & (x < 140 + far) & (y > 50 - far) & (y < 90 + far)
    assert_array_equal(part, whole[near])
    assert len(whole) != len(strewn(classes, count, (0, 0, 300, 200), reach=2.0, seed=(6, 1)))


def test_strewn_things_have_their_number_and_their_sizes() -> None:
    def count(d: float) -> float:
        return 0.01 * d**-2.0

    classes, area = size_classes(count, 1.0, 9.0), 1e6
    rows = strewn(classes, count, (0, 0, 1000, 1000), reach=0.0, seed=(2, 1))
    for d in (1.0, 1.5, 3.0, 6.0):
        expected = (count(d) - count(9.0)) * area
        assert abs((rows[:, 2] >= d).sum() - expected) < 4 * math.sqrt(expected)
    counts, _, _ = np.histogram2d(rows[:, 0], rows[:, 1], 10)
    spread = float(((counts - counts.mean()) ** 2 / counts.mean()).sum())
    assert 50 < spread < 160  # chi square of 99 degrees


def test_rocks_are_counted_by_the_integral_of_their_law() -> None:
    k, q = 0.08, 1.79 + 0.152 / 0.08
    x = np.linspace(0.3, 40.0, 4_000_001)
    density = k * q * np.exp(-q * x) / (np.pi * x**2 / 4)
    expected = float(((density[1:] + density[:-1]) / 2).sum() * (x[1] - x[0]))
    assert rock_count(0.3, k) == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("abundance", [0.02, 0.07, 0.2])
def test_rocks_cover_what_their_law_says(abundance: float) -> None:
    field = RockField(abundance=abundance, smallest=0.2, largest=3.0)
    rows = field.raise_on(np.zeros((1, 1)), (0.0, 0.0), 400.0, 4)  # all rocks of 400 x 400 m
    rows = rows[(rows[:, 0] >= 0) & (rows[:, 0] < 400) & (rows[:, 1] >= 0) & (rows[:, 1] < 400)]
    for d in (0.2, 0.4, 0.8):
        areas = math.pi / 4 * rows[rows[:, 2] >= d, 2] ** 2
        expected = rock_cover(d, abundance) - rock_cover(3.0, abundance)
        four_sigma = 4 * math.sqrt(float((areas**2).sum())) / 160_000
        assert float(areas.sum()) / 160_000 == pytest.approx(expected, abs=four_sigma)


def test_a_field_of_rocks_has_no_seams() -> None:
    field = RockField(abundance=0.1, smallest=0.3, largest=2.0)
    whole = np.zeros((80, 90))
    field.raise_on(whole, (3.0, -7.0), 0.2, 1)
    part = np.zeros((30, 40))
    field.raise_on(part, (3.0 + 20 * 0.2, -7.0 + 25 * 0.2), 0.2, 1)
    assert_allclose(part, whole[25:55, 20:60], rtol=0, atol=1e-9)
    assert whole.max() > 0.3


@pytest.mark.parametrize("wind", [0.0, 90.0, 210.0])
def test_dunes_have_their_wavelength_height_and_lee(wind: float) -> None:
    dunes = Dunes(wavelength=8.0, height=0.8, wind=math.radians(wind))
    z = np.zeros((400, 400))
    dunes.add_to(z, 0, 0, 0.25, 3)
    assert z.min() == pytest.approx(0.0, abs=1e-3)
    assert z.max() == pytest.approx(0.8, abs=1e-3)
    along = z[:, 200] if wind == 0.0 else z[200]
    crossings = np.count_nonzero(np.diff(np.sign(along - 0.4)) > 0)
    expected = 100.0 / 8.0 * (abs(math.sin(math.radians(wind))) if wind == 210.0 else 1.0)
    assert abs(crossings - expected) <= 2.5
    rise = np.diff(z, axis=0 if wind == 0.0 else 1).ravel() / 0.25
    leeward = rise if wind == 210.0 else -rise
    assert np.quantile(leeward, 0.999) > 1.3 * np.quantile(-leeward, 0.999)  # lee is steeper
    part = np.zeros((20, 30))
    dunes.add_to(part, 100, 150, 0.25, 3)
    assert_array_equal(part, z[100:120, 150:180])


def test_cliffs_have_their_height_and_their_face() -> None:
    cliffs = Cliffs(height=4.0, spacing=60.0, face=math.radians(70.0))
    z = np.zeros((600, 600))
    cliffs.add_to(z, 0, 0, 0.25, 1)
    assert (z.min(), z.max()) == pytest.approx((0.0, 4.0), abs=1e-9)
    assert 0.2 < (z > 2.0).mean() < 0.8
    steep = np.degrees(np.arctan(np.hypot(*np.gradient(z, 0.25))))
    assert np.median(steep[np.abs(z - 2.0) < 0.5]) == pytest.approx(70.0, abs=3.0)
    assert np.mean(steep < 1.0) > 0.8
    part = np.zeros((30, 40))
    cliffs.add_to(part, 100, 200, 0.25, 1)
    assert_allclose(part, z[100:130, 200:240], rtol=0, atol=1e-12)


def test_pits_have_their_number_floor_and_walls() -> None:
    pits = Pits(per_km2=1500.0, smallest=4.0, largest=12.0, depth=0.5, wall=math.radians(75.0))
    z = np.zeros((800, 800))
    rows = pits.sink(z, (0.0, 0.0), 0.25, 2)
    inside = rows[(rows[:, :2] > 0).all(axis=1) & (rows[:, :2] < 200).all(axis=1)]
    expected = pits.expected(200.0**2)
    assert expected == pytest.approx(60.0)
    assert abs(len(inside) - expected) < 4 * math.sqrt(expected)
    assert inside[:, 2].min() >= 4.0
    for x, y, d, _ in inside:
        assert z[int(y / 0.25), int(x / 0.25)] <= -0.5 * d + 1e-9
    assert (z == 0.0).mean() > 0.8
    steep = np.degrees(np.arctan(np.hypot(*np.gradient(z, 0.25))))
    assert 60.0 < steep.max() < 80.0


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Dunes(wavelength=0.0, height=1.0), "dunes need a wavelength"),
        (lambda: Dunes(wavelength=10.0, height=5.0), "would stand at 65 deg, more than sand does"),
        (lambda: Cliffs(height=-1.0, spacing=9.0), "cliffs need a height"),
        (
            lambda: Cliffs(height=1.0, spacing=9.0, face=1.57),
            "the face of a cliff must stand at 30",
        ),
        (lambda: Pits(per_km2=0.0, smallest=1.0, largest=2.0), "pits need a number per km"),
        (lambda: Pits(per_km2=1.0, smallest=3.0, largest=2.0), "0 < smallest < largest"),
        (lambda: Pits(per_km2=1.0, smallest=1.0, largest=2.0, depth=3.0), "up to 2 diameters"),
        (lambda: RockField(abundance=2.0, smallest=0.1, largest=1.0), "rock abundance must be"),
    ],
)
def test_forms_that_cannot_be(make: object, message: str) -> None:
    with pytest.raises(SettingError, match=message):
        make()  # type: ignore[operator]
