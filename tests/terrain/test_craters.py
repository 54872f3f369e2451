"""Craters against the papers: numbers by age and size, depth by wear."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from rovernav.core import SettingError
from rovernav.terrain import Craters
from rovernav.terrain._craters import (
    DEPTH,
    FINEST,
    MOST_WORN,
    RIM,
    WEAR,
    depth_left,
    equilibrium,
    fresh_profile,
    production,
    worn_profiles,
)  # fmt: skip


@pytest.mark.parametrize(("body", "a0"), [("moon", -3.0876), ("mars", -3.384)])
def test_production_of_craters_of_a_kilometre(body: str, a0: float) -> None:
    """At 1 km all terms of the polynomial but the first vanish: 10^a0 per km^2 after 1 Gyr."""
    assert production(body, 1000.0, 1.0) == pytest.approx(10**a0 * 1e-6, rel=1e-12)


def test_production_by_age_is_the_published_chronology() -> None:
    """N(1 km) = 5.44e-14 (e^(6.93 T) - 1) + 8.38e-4 T, which a0 is at 1 Gyr (Neukum 2001)."""
    for age in (0.1, 1.0, 3.0, 3.8, 4.0):
        published = 5.44e-14 * (math.exp(6.93 * age) - 1) + 8.38e-4 * age
        assert production("moon", 1000.0, age) * 1e6 == pytest.approx(published, rel=0.03)


def test_production_has_no_jump_where_the_law_ends() -> None:
    for body, end in (("moon", 10.0), ("mars", 15.0)):
        below, above = (production(body, end * f, 1.0) for f in (0.999, 1.001))
        assert below == pytest.approx(above, rel=0.01)
        sizes = np.geomspace(0.5, 1e5, 200)
        counts = [production(body, d, 1.0) for d in sizes]
        assert (np.diff(counts) < 0).all()


def test_old_ground_is_in_equilibrium_below_some_size() -> None:
    """10^10.9 D^-2 per 10^6 km^2, D in metres (Trask 1966)."""
    assert equilibrium(20.0) * 1e12 == pytest.approx(10**10.9 / 400.0, rel=1e-9)
    old = Craters(body="moon", age=3.5, smallest=2.0, largest=1000.0)
    assert old.count(10.0) == equilibrium(10.0)
    assert old.count(900.0) == production("moon", 900.0, 3.5)
    young = Craters(body="moon", age=0.001, smallest=10.0, largest=1000.0)
    assert young.count(10.0) == production("moon", 10.0, 0.001)


def test_fresh_craters_have_their_depth_and_rim() -> None:
    r: Any = np.array([0.0, 0.5, 1.0, 2.0])
    assert_allclose(fresh_profile(r), [RIM - DEPTH, RIM - 0.75 * DEPTH, RIM, RIM / 8], rtol=1e-12)
    table = worn_profiles()
    assert table.shape == (WEAR, 301)
    places: Any = np.arange(301) * FINEST
    assert_allclose(table[0, places < 3], fresh_profile(places)[places < 3], atol=4e-3)
    assert_array_equal(table[:, -1], 0.0)


def test_wear_is_that_of_the_lunar_maria() -> None:
    """5.5 m^2/Myr over 3 Gyr leave 7 % of 300 m craters, and 52 % of 1 km (Fassett 2014).

    Ours keep 62 % of the larger: the paper's fresh crater has a sharper rim than a parabola's.
    """
    kappa_t = 5.5 * 3000.0
    assert depth_left(kappa_t / 300.0**2) == pytest.approx(0.07, abs=0.01)
    assert depth_left(kappa_t / 1000.0**2) == pytest.approx(0.52, abs=0.12)
    left = [depth_left(wear) for wear in np.linspace(0.0, MOST_WORN, 40).tolist()]
    assert left[0] == 1.0
    assert (np.diff(left) < 0).all()


def test_wear_is_the_heat_equation() -> None:
    """In the middle: the mean of the fresh profile under a Gaussian of variance 2 kappa t."""
    table = worn_profiles()
    r: Any = (np.arange(4000) + 0.5) * 0.002  # diameters
    for row in (10, 25, 40):
        k = MOST_WORN * (row / (WEAR - 1)) ** 2
        kernel = np.exp(-(r**2) / (4 * k)) / (4 * math.pi * k)
        expected = float((fresh_profile(2 * r) * kernel * 2 * math.pi * r).sum() * 0.002)
        assert table[row, 0] == pytest.approx(expected, abs=1.5e-3)


def test_craters_are_as_many_as_expected_and_as_deep() -> None:
    craters = Craters(body="mars", age=3.0, smallest=8.0, largest=100.0)
    z = np.zeros((500, 500))
    rows = craters.dig(z, (0.0, 0.0), 1.0, 3)
    inside = rows[(rows[:, :2] > 0).all(axis=1) & (rows[:, :2] < 500).all(axis=1)]
    for d in (8.0, 12.0, 20.0):
        expected = (craters.count(d) - craters.count(100.0)) * 250_000
        assert abs((inside[:, 2] >= d).sum() - expected) < 4 * math.sqrt(expected)
    assert (rows[:, 3] >= 0).all()
    part = np.zeros((60, 70))
    craters.dig(part, (200.0, 130.0), 1.0, 3)
    assert_allclose(part, z[130:190, 200:270], rtol=0, atol=1e-9)


def test_one_crater_by_itself() -> None:
    fresh = Craters(body="moon", age=0.01, smallest=40.0, largest=41.0, diffusivity=0.0, depth=0.2)
    z = np.zeros((4000, 4000))
    for seed in range(200):
        rows = fresh.within((0.0, 0.0, 1000.0, 1000.0), seed)
        if len(rows) == 1 and (rows[0, :2] > 200).all() and (rows[0, :2] < 800).all():
            fresh.dig(z, (0.0, 0.0), 0.25, seed)
            x, y, d, wear = rows[0]
            assert wear == 0.0
            floor = z[int(y / 0.25), int(x / 0.25)]
            assert z.max() - floor == pytest.approx(0.2 * d, rel=0.03)
            assert z.max() == pytest.approx(0.036 * d, rel=0.1)
            return
    pytest.fail("no seed has one crater")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"body": "mras"}, "craters of 'mras' are not known; did you mean 'mars'"),
        ({"age": 0.0}, "the age of a surface must lie in 0 to 4.5 Gyr, got 0"),
        ({"smallest": 50.0}, "craters need 0 < smallest < largest"),
        ({"depth": 0.9}, "a depth of up to half a diameter"),
    ],
)
def test_craters_that_cannot_be(changes: dict[str, object], message: str) -> None:
    given: dict[str, object] = {"body": "mars", "age": 1.0, "smallest": 5.0, "largest": 50.0}
    with pytest.raises(SettingError, match=message):
        Craters(**{**given, **changes})  # type: ignore[arg-type]
