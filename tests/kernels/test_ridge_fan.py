"""Fans over heights by table against the plain walk, bit for bit."""

from __future__ import annotations

import math
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

from rovernav.kernels import ridge_fan, ridge_lanes, ridges
from rovernav.kernels import ridge_tops as tops
from rovernav.kernels.geometry import MISS
from tests.kernels.test_ridges import ground

pytestmark = pytest.mark.kernels

ROUND = np.arange(48) * math.pi / 24  # along axes and diagonals too
KINDS = ("rough", "smooth", "flat", "cliff", "holes", "none", "noise", "spike")


def table(layer: ridges.GroundArrays) -> tops.TopArrays:
    g, h, w = layer.heights.shape
    made = tops.empty_tops(g, h, w)
    tops.fill_tops(layer.heights, layer.cell, made)
    return made


NONE = tops.empty_tops(0, 0, 0)


def heights(rng: np.random.Generator, kind: str, h: int, w: int) -> np.ndarray:
    i, j = np.mgrid[0:h, 0:w]
    out = 0.4 * np.sin(0.31 * i + rng.uniform(0, 6)) * np.cos(0.23 * j) + 0.03 * i
    if kind in ("flat", "none"):
        out = np.full((h, w), 3.5)
    elif kind == "cliff":
        out = out + np.where(i + 2 * j > h, 40.0, 0.0)
    elif kind == "noise":
        out = rng.normal(0.0, 2.0, (h, w))
    elif kind != "smooth":
        out = out + rng.normal(0.0, 0.08, (h, w))
    if kind == "holes":
        out[rng.random((h, w)) < 0.1] = np.nan
    elif kind == "none":
        out[:] = np.nan
    elif kind == "spike":
        out[rng.integers(h), rng.integers(w)] = 1e30
    return out.astype(np.float32)


def looks(
    rng: np.random.Generator, field: np.ndarray, n: int, angles: np.ndarray, c: float
) -> ridge_fan.Looks:
    """Eyes over ground, on lattice lines, at the edge and beyond; level, tilted, straight down."""
    h, w = field.shape
    place = rng.uniform((-3.0, -3.0), (w + 3.0, h + 3.0), (n, 2))
    kind = rng.integers(5, size=n)
    place[kind == 1] = np.round(2.0 * place[kind == 1]) / 2.0
    inside = np.clip(place, 0.0, (w - 1.0, h - 1.0)).astype(int)
    base = np.nan_to_num(field[inside[:, 1], inside[:, 0]], nan=0.0)
    eye = np.c_[place * c, base + rng.choice([-0.1, 0.0, 0.05, 0.3, 1.0, 30.0], n)]
    heading = np.where(kind == 2, 0.0, rng.uniform(-4, 4, n))
    pitch, roll = np.where(kind == 2, 0.0, rng.normal(0.0, 0.15, (2, n)))
    pitch[kind == 3] = rng.choice([math.pi / 2, -math.pi / 2, 1.0], (kind == 3).sum())
    cos, sin = np.cos, np.sin
    f = [cos(pitch) * cos(heading), cos(pitch) * sin(heading), sin(pitch)]
    left = [
        -cos(roll) * sin(heading) - sin(roll) * sin(pitch) * cos(heading),
        cos(roll) * cos(heading) - sin(roll) * sin(pitch) * sin(heading),
        sin(roll) * cos(pitch),
    ]
    axes = np.ascontiguousarray(np.stack([np.stack(f, 1), np.stack(left, 1)], 1))
    ways = np.stack([cos(angles), sin(angles)])
    return ridge_fan.Looks(eye, axes, ways, np.zeros(n, np.int64))


def fan(who: ridge_fan.Looks, reach: float, layer: Any, made: Any) -> np.ndarray:
    out = np.full((len(who.eye), who.ways.shape[1]), np.nan)
    ridge_fan.ground_fan(who, reach, layer, made, out)
    return out


def both(who: ridge_fan.Looks, reach: float, layer: ridges.GroundArrays) -> np.ndarray:
    """The fan by table, after it was seen to be that of the plain walk."""
    quick, plain = fan(who, reach, layer, table(layer)), fan(who, reach, layer, NONE)
    differ = quick.view(np.int64) != plain.view(np.int64)
    assert not differ.any(), (np.argwhere(differ)[:4], quick[differ][:4], plain[differ][:4])
    return quick


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("h", "w"), [(1, 1), (1, 9), (2, 2), (13, 7), (40, 63), (90, 71)])
def test_the_table_changes_no_bit(kind: str, h: int, w: int) -> None:
    rng = np.random.default_rng([h, w, KINDS.index(kind)])
    for _ in range(3):
        c = float(rng.choice([1.0, 0.2, 0.3]))
        reach = float(rng.choice([0.02, 3.0, 17.3, 60.0, 1500.0])) * c
        field = heights(rng, kind, h, w)
        both(looks(rng, field, 40, ROUND, c), reach, ground(field, c))
        both(looks(rng, field, 21, rng.uniform(-9, 9, 37), c), reach, ground(field, c))


def test_the_plain_walk_without_a_table_is_the_walk_of_a_line() -> None:
    rng = np.random.default_rng(1)
    field = heights(rng, "rough", 30, 40)
    layer, who = ground(field, 0.5), looks(rng, field, 20, ROUND, 0.5)
    got, met = both(who, 9.0, layer), 0
    for k in range(20):
        for b in range(len(ROUND)):
            end = ridge_fan.end_of(who, k, b, 9.0)
            x, y, z = map(float, who.eye[k])
            want = ridges.first_rise(0, (x, y, z), end, layer)
            assert got[k, b] == want
            met += want <= 1.0
    assert 100 < met < 900


@settings(max_examples=80)
@given(
    kind=st.sampled_from(KINDS),
    seed=st.integers(0, 2**32 - 1),
    reach=st.one_of(st.sampled_from([1e-4, 0.5, 900.0, 5e3]), st.floats(1e-6, 60)),
)
def test_whatever_the_ground_the_table_changes_no_bit(kind: str, seed: int, reach: float) -> None:
    rng = np.random.default_rng(seed)
    h, w = rng.integers(1, 40, 2).tolist()
    field = heights(rng, kind, h, w)
    both(looks(rng, field, 12, ROUND, 1.0), reach, ground(field))


def test_worlds_rovers_alone_and_threads_have_the_same_bits() -> None:
    rng = np.random.default_rng(5)
    fields = np.stack([heights(rng, kind, 50, 60) for kind in ("rough", "cliff", "holes")])
    layer = ground(fields, 0.2)
    who = looks(rng, fields[0], 300, ROUND[:23], 0.2)._replace(of=rng.integers(0, 3, 300))
    made = table(layer)
    whole = both(who, 8.0, layer)
    for k in range(0, 300, 29):
        alone = who._replace(eye=who.eye[k : k + 1], axes=who.axes[k : k + 1], of=who.of[k : k + 1])
        assert_array_equal(fan(alone, 8.0, layer, made)[0], whole[k])
    out = np.full_like(whole, np.nan)
    parts = [slice(0, 150), slice(150, 300)]
    crew = [
        threading.Thread(
            target=ridge_fan.ground_fan,
            args=(
                who._replace(eye=who.eye[part], axes=who.axes[part], of=who.of[part]),
                8.0, layer, made, out[part],
            ),
        )
        for part in parts
    ]  # fmt: skip
    for thread in crew:
        thread.start()
    for thread in crew:
        thread.join()
    assert_array_equal(out, whole)


def test_eyes_that_are_nowhere_see_nothing() -> None:
    odd = (0.0, -0.0, 1e9, -1e300, math.inf, -math.inf, math.nan)
    eye = np.array([(x, y, z) for x in odd for y in odd for z in (1.0, math.nan, 1e300)])
    rng = np.random.default_rng(6)
    field = heights(rng, "rough", 9, 9)
    who = looks(rng, field, len(eye), ROUND, 1.0)._replace(eye=eye)
    got = both(who, 5.0, ground(field))
    assert (got[~np.isfinite(eye).all(axis=1)] == MISS).all()


def test_entries_are_never_below_the_ground_of_their_windows() -> None:
    rng = np.random.default_rng(7)
    for kind in KINDS:
        h, w = 21, 26
        layer = ground(heights(rng, kind, h, w), 1.0)
        made, posts = table(layer), np.pad(layer.heights[0], 1, mode="edge")
        high = np.full((h + 1, w + 1), -np.inf)
        for a in (0, 1):
            for b in (0, 1):
                high = np.fmax(high, posts[a : a + h + 1, b : b + w + 1])
        low, grain = made.low[0], made.grain[0]
        rows, columns = tops.blocks_of(h, w)
        coarse = made.coarse[0].reshape(4, rows, columns).astype(np.int64)
        near = 1e-9 * (abs(low) + 65000 * grain)
        for quarter in range(4):
            for i in range(rows):
                for j in range(columns):
                    entry = coarse[quarter, i, j]
                    top = entry & 0xFFFF
                    for number, count in enumerate(ridge_lanes.LEAPS):
                        code = (entry >> (8 + 8 * number)) & 255 if number else 0
                        told = low + grain * (top + ((code & 15) << (code >> 4)))
                        i0, i1 = (i - count, i) if quarter >= 2 else (i, i + count)
                        j0, j1 = (j - count, j) if quarter % 2 else (j, j + count)
                        part = high[max(2 * i0, 0) : 2 * i1 + 2, max(2 * j0, 0) : 2 * j1 + 2]
                        assert told >= part.max() - near
        fine = made.fine[0, :-1].reshape(2, h + 1, w + 1)
        assert (low + grain * fine[0, :-1] >= np.fmax(high[:-1], high[1:]) - near).all()
        assert (low + grain * fine[1, :, :-1] >= np.fmax(high[:, :-1], high[:, 1:]) - near).all()


def test_lanes_in_plain_python_march_and_judge_the_same() -> None:
    """Without the compiler NumPy does the vectors' work: the same bits as the plain walk."""
    code = (
        "import numpy as np\n"
        "from tests.kernels import test_ridge_fan as t\n"
        "rng = np.random.default_rng(8)\n"
        "for kind in ('rough', 'cliff', 'holes'):\n"
        "    field = t.heights(rng, kind, 14, 17)\n"
        "    t.both(t.looks(rng, field, 6, t.ROUND[::3], 0.5), 6.0, t.ground(field, 0.5))\n"
        "print('same')\n"
    )
    root = Path(__file__).resolve().parents[2]
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=root, capture_output=True, text=True, check=False,
        env={"NUMBA_DISABLE_JIT": "1", "PYTHONPATH": f"{root / 'src'}:{root}", "PATH": ""},
    )  # fmt: skip
    assert done.stdout.strip() == "same", done.stderr[-2000:]


@pytest.mark.long
def test_a_million_beams_have_the_bits_of_the_plain_walk() -> None:
    rng = np.random.default_rng(11)
    for number in range(50):
        h, w = rng.integers(20, 300, 2).tolist()
        field = heights(rng, KINDS[number % len(KINDS)], h, w)
        c = float(rng.choice([1.0, 0.1]))
        reach = float(rng.uniform(1, 90)) * c
        both(looks(rng, field, 420, ROUND + rng.choice([0.0, 0.1]), c), reach, ground(field, c))
