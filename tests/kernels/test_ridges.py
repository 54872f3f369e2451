"""Lines over bilinear ground, against a twin that tries every patch and halves for the root."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rovernav.kernels import ridges as k
from rovernav.kernels.geometry import MISS
from rovernav.kernels.surface import height_at
from tests.naive import ridges as naive

pytestmark = pytest.mark.kernels

Point = tuple[float, float, float]
NEAR = 1e-7
"""How far a line has to pass from the ground for hit or miss to be beyond rounding [m]."""


def ground(heights: np.ndarray, cell: float = 1.0) -> k.GroundArrays:
    layers = np.ascontiguousarray(heights if heights.ndim == 3 else heights[None], np.float32)
    levels = k.levels_of(*layers.shape[1:])
    tops = np.empty((len(layers), levels[-1]), np.float32)
    k.tops_of(layers, levels, tops)
    return k.GroundArrays(heights=layers, cell=cell, tops=tops, levels=levels)


def point(numbers: np.ndarray) -> Point:
    x, y, z = map(float, numbers)
    return x, y, z


def segment(rng: np.random.Generator, h: int, w: int, c: float) -> tuple[Point, Point]:
    """Free ends, ends on lattice lines, along axes, straight down, and through corners."""
    a, b = rng.uniform((-2, -2, -1), (w + 2, h + 2, 4), (2, 3))
    kind = rng.integers(6)
    if kind == 1:
        a[:2], b[:2] = np.round(2 * a[:2]) / 2, np.round(2 * b[:2]) / 2
    elif kind == 2:
        axis = rng.integers(2)
        b[axis] = a[axis]
    elif kind == 3:
        b[:2] = a[:2]
    elif kind == 4:
        corner, way = rng.integers((0, 0), (w, h)) + 0.5, rng.integers(-9, 10, 2) / 2
        a[:2], b[:2] = corner - way, corner + 2 * way
    elif kind == 5:
        b[1] = a[1] + 1e-7 * rng.normal()
    a[:2] *= c
    b[:2] *= c
    return point(a), point(b)


@pytest.mark.parametrize(("h", "w"), [(9, 14), (23, 5), (1, 1), (1, 7), (2, 2), (33, 34)])
def test_ground_is_met_where_trying_every_patch_meets_it(h: int, w: int) -> None:
    rng = np.random.default_rng([h, w])
    for number in range(200 if h * w < 500 else 40):
        c = float(rng.choice([1.0, 0.3, 2.5]))
        heights = rng.normal(0.0, 1.0, (h, w)).astype(np.float32)
        heights[rng.random((h, w)) < 0.05 * (number % 3)] = np.nan
        layer = ground(heights, c)
        a, b = segment(rng, h, w, c)
        got, want = k.first_rise(0, a, b, layer), naive.first_rise(a, b, heights, c)
        if want is None or got == MISS:  # only a graze may be one and not the other
            t = got if want is None else want
            assert want is None or got == MISS
            assert t == MISS or _grazes(a, b, t, layer), (a, b, got, want)
            continue
        if abs(got - want) > 1e-9:
            assert _grazes(a, b, min(got, want), layer), (a, b, got, want)


def _grazes(a: Point, b: Point, t: float, layer: k.GroundArrays) -> bool:
    lower = [(*end[:2], end[2] - NEAR) for end in (a, b)]
    upper = [(*end[:2], end[2] + NEAR) for end in (a, b)]
    first = k.first_rise(0, lower[0], lower[1], layer)
    then = k.first_rise(0, upper[0], upper[1], layer)
    return first <= t + 1e-9 and then >= t - 1e-9


def _without_blocks(layer: k.GroundArrays) -> k.GroundArrays:
    return layer._replace(tops=np.full_like(layer.tops, np.inf))


def test_blocks_change_no_bit() -> None:
    rng = np.random.default_rng(1)
    for _ in range(300):
        h, w = rng.integers(1, 60, 2).tolist()
        rough = rng.choice([0.01, 0.3, 2.0])
        heights = np.cumsum(np.cumsum(rng.normal(0, rough, (h, w)), 0), 1).astype(np.float32)
        layer = ground(heights, 0.5)
        plain = _without_blocks(layer)
        for _ in range(10):
            a, b = segment(rng, h, w, 0.5)
            a, b = (*a[:2], a[2] * 5), (*b[:2], b[2] * 5)
            assert k.first_rise(0, a, b, layer) == k.first_rise(0, a, b, plain), (a, b)


def test_a_line_ends_on_the_surface_that_wheels_stand_on() -> None:
    rng = np.random.default_rng(2)
    heights = rng.normal(0.0, 0.5, (20, 30)).astype(np.float32)
    layer, hits = ground(heights, 0.7), 0
    for _ in range(300):
        a, b = segment(rng, 20, 30, 0.7)
        a, b = (*a[:2], 3.0), (*b[:2], -3.0)
        t = k.first_rise(0, a, b, layer)
        if 0.0 < t <= 1.0:
            x, y, z = (p + t * (q - p) for p, q in zip(a, b, strict=True))
            under = height_at(heights, 0.7, x, y)
            at_the_edge = math.isnan(under) or a[2] + t * (b[2] - a[2]) < under - 1e-9
            hits += not at_the_edge
            assert at_the_edge or abs(under - z) < 1e-6
    assert hits > 100


def test_a_ridge_hides_what_lies_behind() -> None:
    heights = np.zeros((40, 40), np.float32)
    heights[:, 20] = 2.0
    layer, out = ground(heights), np.empty((3, 1))
    eye = np.array([[5.0, 20.0, 1.0], [5.0, 20.0, 1.0], [5.0, 20.0, 9.0]])
    target = np.array([[35.0, 20.0, 0.0], [15.0, 20.0, 0.0], [35.0, 20.0, 0.0]])
    k.in_view(eye, target, np.zeros(3, np.int64), 0.01, layer, out)
    assert out[:, 0].tolist() == [0.0, 1.0, 1.0]
    beams = np.empty((3, 2))
    ways = np.tile([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0]], (3, 1, 1))
    k.rise_fan(eye, ways, np.zeros(3, np.int64), 30.0, layer, beams)
    np.testing.assert_allclose(beams, [[15.0, 1.0], [15.0, 1.0], [30.0, 9.0]], rtol=1e-12)


def test_beams_of_many_worlds_and_eyes_below_the_ground() -> None:
    layer = ground(np.stack([np.zeros((4, 4)), np.full((4, 4), 5.0)]))
    eye, out = np.array([[2.0, 2.0, 1.0]] * 2), np.empty((2, 1))
    ways = np.tile([[1.0, 0.0, 0.0]], (2, 1, 1))
    k.rise_fan(eye, ways, np.array([0, 1]), 10.0, layer, out)
    assert out[:, 0].tolist() == [10.0, 0.0]


@settings(max_examples=60)
@given(quarters=st.integers(1, 3), seed=st.integers(0, 2**32 - 1))
def test_turned_ground_gives_turned_beams(quarters: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    heights = rng.normal(0.0, 1.0, (12, 12)).astype(np.float32)
    a, b = rng.uniform((0, 0, -1), (12, 12, 3), (2, 3))
    here = k.first_rise(0, point(a), point(b), ground(heights))
    for _ in range(quarters):
        heights = np.ascontiguousarray(heights[::-1].T)  # a quarter turn, x to y
        a, b = (np.array([12 - p[1], p[0], p[2]]) for p in (a, b))
    there = k.first_rise(0, point(a), point(b), ground(heights))
    if min(here, there) <= 1.0 and abs(here - there) > 1e-9:
        assert _grazes(point(a), point(b), min(here, there), ground(heights))


ODD = (0.0, -0.0, 4.0, 5e-324, 1e18, -1e100, 1e308, math.inf, -math.inf, math.nan)


def test_no_coordinate_makes_a_walk_hang() -> None:
    layer = ground(np.zeros((5, 6)))
    for ax in ODD:
        for bx in ODD:
            for by in ODD:
                for z in (1.0, -1e300, math.nan):
                    t = k.first_rise(0, (ax, 2.0, z), (bx, by, 0.5), layer)
                    assert t == MISS or 0.0 <= t <= 1.0
