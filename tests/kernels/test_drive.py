from __future__ import annotations

import cmath
import math
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from rovernav.kernels import drive as k
from rovernav.kernels.geometry import MISS
from tests.naive import geometry as naive

pytestmark = pytest.mark.kernels

N = 40


def poses(rng: np.random.Generator, n: int = N) -> np.ndarray:
    return rng.uniform((-9, -9, -math.pi), (9, 9, math.pi), (n, 3))


def as_complex(rows: Any) -> list[complex]:
    return [complex(row[0], row[1]) for row in rows]


def test_a_goal_is_turned_into_the_rovers_frame(rng: np.random.Generator) -> None:
    pose, goal, out = poses(rng), rng.uniform(-9, 9, (N, 2)), np.empty((N, 2))
    k.goal_in_body(pose, goal, out)
    for p, z, g, got in zip(pose, as_complex(pose), as_complex(goal), as_complex(out), strict=True):
        assert abs(got - (g - z) * cmath.rect(1, -p[2])) < 1e-12


def test_two_axes_move_along_and_across_the_heading(rng: np.random.Generator) -> None:
    pose, twist, out = poses(rng), rng.normal(size=(N, 3)), np.empty((N, 3))
    k.two_axis(pose, twist, 0.25, out)
    for p, z, v, got in zip(
        pose, as_complex(pose), as_complex(twist), as_complex(out), strict=True
    ):
        assert abs(got - (z + 0.25 * v * cmath.rect(1, p[2]))) < 1e-12
    assert_array_equal(out[:, 2], pose[:, 2])


def test_a_differential_drive_follows_its_arc(rng: np.random.Generator) -> None:
    pose, twist = poses(rng, 6), rng.normal(size=(6, 3))
    twist[0, 2] = 0.0
    out, driven = np.empty((6, 3)), np.empty((6, 3))
    k.differential(pose, twist, 0.8, 1.1, 2.5, out, driven)
    v, w = np.clip(twist[:, 0], -0.8, 0.8), np.clip(twist[:, 2], -1.1, 1.1)
    assert_array_equal(driven, np.stack([v, 0 * v, w], axis=1))
    middles = (np.arange(10_000) + 0.5) * 2.5 / 10_000
    for p, got, speed, turn in zip(pose, out, v, w, strict=True):
        way = speed * np.exp(1j * (p[2] + turn * middles)).sum() * 2.5 / 10_000
        assert abs(complex(*got[:2]) - (complex(*p[:2]) + way)) < 1e-6
        assert abs(cmath.rect(1, got[2]) - cmath.rect(1, p[2] + 2.5 * turn)) < 1e-12
        assert -math.pi < got[2] <= math.pi


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("stop", [True, False])
def test_outputs_become_speeds_that_stop_at_a_goal_in_sight(stop: bool, dtype: Any) -> None:
    rng = np.random.default_rng(1)
    outputs = rng.normal(size=(200, 2)).astype(dtype)
    goal, sight = rng.normal(size=(200, 2)), rng.integers(0, 2, (200, 1)).astype(float)
    goal[:20] = 0.8287 * outputs[:20, ::-1].astype(float)  # exactly as far away as the step goes
    out = np.full((200, 3), np.nan)
    k.axis_speeds(outputs, 0.8287, 2.0, goal, sight, stop, out)
    stopped = 0
    for o, g, s, got in zip(outputs.tolist(), goal.tolist(), sight[:, 0], out, strict=True):
        move = [0.8287 * o[0], 0.8287 * o[1]]
        if stop and s == 1.0 and g[0] ** 2 + g[1] ** 2 <= move[0] ** 2 + move[1] ** 2:
            move, stopped = g, stopped + 1
        assert_array_equal(got, [move[0] / 2.0, move[1] / 2.0, 0.0])
    assert stopped > 30 if stop else stopped == 0


def test_channels_stand_side_by_side() -> None:
    out = np.empty((2, 2))
    k.side_by_side(np.array([[1.0, 9.0], [2.0, 9.0]]), np.array([[3.0], [4.0]]), out)
    assert_array_equal(out, [[1.0, 3.0], [2.0, 4.0]])


def world(rng: np.random.Generator, *, grid: bool) -> k.WorldArrays:
    """Three worlds of 0, 2 and 3 boxes; rovers are spread over them; grids of cells of 0.5 m."""
    corner, layers = rng.uniform(-6, 5, (5, 2)), int(rng.choice([1, 3]))
    return k.WorldArrays(
        boxes=np.concatenate([corner, corner + rng.uniform(0.2, 3, (5, 2))], axis=1),
        offsets=np.array([0, 0, 2, 5]),
        of=rng.integers(0, 3, N),
        blocked=(rng.random((layers, 12, 14)) < 0.05).astype(np.uint8) * (grid or np.uint8(0)),
        cell=0.5,
    )


def first(w: k.WorldArrays, rover: int, a: Any, b: Any) -> float:
    boxes = w.boxes[w.offsets[w.of[rover]] : w.offsets[w.of[rover] + 1]].tolist()
    layer = w.blocked[w.of[rover] if len(w.blocked) > 1 else 0]
    boxes += [[0.5 * side for side in cell] for cell in naive.cells(layer)]
    met = [naive.first_box(a[:2], b[:2], box) for box in boxes]
    return float(min((t for t in met if t is not None), default=Fraction(2)))


@pytest.mark.parametrize("grid", [False, True])
def test_contact_and_sight_are_with_ones_own_world(grid: bool, rng: np.random.Generator) -> None:
    for _ in range(5):
        w = world(rng, grid=grid)
        before, after = poses(rng), poses(rng)
        sight = np.empty((N, 1))
        ways = enumerate(zip(before, after, strict=True))
        t = np.array([k.first_contact(i, a[0], a[1], b[0], b[1], w) for i, (a, b) in ways])
        k.clear_sight(before, after[:, :2].copy(), w, sight)
        expected = [first(w, i, a, b) for i, (a, b) in enumerate(zip(before, after, strict=True))]
        assert_allclose(t, expected, rtol=0, atol=1e-12)
        assert_array_equal(sight[:, 0], t == MISS)


def step_of(rng: np.random.Generator) -> k.StepArrays:
    after = poses(rng)
    after[rng.random(N) < 0.1, rng.integers(0, 3)] = np.nan
    return k.StepArrays(
        before=poses(rng), driving=rng.choice(np.array([0, 0, 0, 2, 7], np.int8), N),
        clock=rng.uniform(0, 9, N), way=rng.uniform(0, 9, N), goal=rng.uniform(-3, 3, (N, 2)),
        bounds=np.array([[-6.0, -6.0, 6.0, 6.0], [-3.0, -9.0, 9.0, 3.0], [-9.0, -9.0, 9.0, 9.0]]),
        pose=after, twist=rng.normal(size=(N, 3)), time=rng.uniform(5, 11, N),
        length=np.empty(N), outcome=np.empty(N, np.int8),
    )  # fmt: skip


def outcome_of(step: k.StepArrays, i: int, w: k.WorldArrays) -> tuple[int, Any, float]:
    """How rover i ends, where, and when: reached within 2 m, late from 10 s."""
    before, after = step.before[i], step.pose[i]
    if step.driving[i]:
        return int(step.driving[i]), before, step.clock[i]
    lost = not np.isfinite(after).all()
    went = before if lost else after
    t = float(first(w, i, before, went))
    place = before[:2] + min(1.0, t) * (went - before)[:2]
    low, high = step.bounds[w.of[i], :2], step.bounds[w.of[i], 2:]
    how = 7 if step.time[i] >= 10.0 else 0
    how = 1 if math.dist(place, step.goal[i]) <= 2.0 else how
    how = 6 if lost or (place < low).any() or (place > high).any() else how
    return 2 if t <= 1.0 else how, [*place, went[2]], step.time[i]


@pytest.mark.parametrize("grid", [False, True])
def test_a_step_ends_where_and_as_plain_python_says(grid: bool, rng: np.random.Generator) -> None:
    met: set[int] = set()
    for _ in range(6):
        w, step = world(rng, grid=grid), step_of(rng)
        ends = [outcome_of(step, i, w) for i in range(N)]
        twist = np.where(np.array([how for how, *_ in ends])[:, None] == 0, step.twist, 0.0)
        k.meet(step, w, 2.0, 10.0, (0, 7, 1, 6, 2))
        assert_array_equal(step.outcome, [how for how, *_ in ends])
        assert_allclose(step.pose, [pose for _, pose, _ in ends], rtol=0, atol=1e-12)
        assert_array_equal(step.time, [time for *_, time in ends])
        moved = np.hypot(*(step.pose - step.before).T[:2])
        assert_allclose(step.length, step.way + moved, rtol=0, atol=1e-12)
        assert_array_equal(step.twist, twist)
        met |= set(step.outcome.tolist())
    assert met == {0, 1, 2, 6, 7}


def test_off_line_is_farther_than_the_threshold_from_the_whole_line() -> None:
    rng = np.random.default_rng(2)
    pose, start = rng.integers(-9, 9, (300, 3)) / 2, rng.integers(-9, 9, (300, 3)) / 2
    goal, out = rng.integers(-9, 9, (300, 2)) / 2, np.empty((300, 1))
    k.off_line(pose, start, goal, 0.75, out)
    for p, a, b, got in zip(pose, start, goal, out[:, 0], strict=True):
        (px, py), (ax, ay), (bx, by) = (tuple(map(Fraction, z[:2])) for z in (p, a, b))
        across = (bx - ax) * (py - ay) - (by - ay) * (px - ax)
        length2 = (bx - ax) ** 2 + (by - ay) ** 2
        assert got == (across**2 > Fraction(0.75) ** 2 * length2)


def test_on_the_threshold_is_on_the_line() -> None:
    pose = np.array([[3.0, 0.5, 0.0], [3.0, 0.5 + 1e-12, 0.0], [99.0, -0.6, 0.0], [3.0, -0.5, 0.0]])
    start, goal, out = np.zeros((4, 3)), np.tile([4.0, 0.0], (4, 1)), np.empty((4, 1))
    k.off_line(pose, start, goal, 0.5, out)
    assert_array_equal(out[:, 0], [0, 1, 1, 0])
