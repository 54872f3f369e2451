from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import label

from rovernav.core import Frame, SettingError
from rovernav.kernels import geometry
from rovernav.rover import read_rover
from rovernav.scenes import fenced, free_pairs, named_scene, practice_grid, practice_task
from rovernav.sim import Grid


def wall_with_a_gap() -> Grid:
    blocked = np.zeros((40, 40), np.uint8)
    blocked[:36, 20] = 1
    return Grid(frame=Frame(cell=0.5, shape=(40, 40)), blocked=blocked)


def test_pairs_are_free_connected_far_enough_and_blocked(rng: np.random.Generator) -> None:
    grid = wall_with_a_gap()
    starts, goals = free_pairs(grid, 50, rng, nearest=4.0, farthest=15.0)
    far = np.hypot(*(goals - starts).T)
    assert ((far >= 4.0) & (far <= 15.0)).all()
    region = np.asarray(label(grid.blocked == 0)[0])  # pyright: ignore[reportIndexIssue]
    for a, b in zip(starts, goals, strict=True):
        cells = [tuple((p[::-1] // 0.5).astype(int)) for p in (a, b)]
        assert region[cells[0]] == region[cells[1]] > 0
        (ax, ay), (bx, by) = (a / 0.5).tolist(), (b / 0.5).tolist()
        t = geometry.first_cell(ax, ay, bx, by, grid.blocked)
        assert t <= 1.0


def test_small_full_worlds_are_drawn_until_one_has_a_task() -> None:
    """Of this seed, more than a hundred have none."""
    rng, rover = np.random.default_rng(0), read_rover("research")
    grid, start, goal = practice_task(rng, rover, side=14.0, cell=0.5, nearest=3.0, farthest=8.0)
    assert grid.blocked.mean() <= 0.4
    assert 3.0 <= np.hypot(*(goal - start[:2])) <= 8.0


def test_worlds_that_can_have_no_task_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rovernav.scenes._practice.MOST_CELLS", 1.0)  # a hundred will do
    rng, rover = np.random.default_rng(0), read_rover("research")
    with pytest.raises(SettingError, match="worlds of 4 m have no tasks 3 to 4 m long"):
        practice_task(rng, rover, side=4.0, cell=0.5, nearest=3.0, farthest=4.0)


def test_the_same_seed_gives_the_same_pairs() -> None:
    def draw() -> tuple[np.ndarray, np.ndarray]:
        rng = np.random.default_rng(3)
        return free_pairs(wall_with_a_gap(), 5, rng, nearest=4.0, farthest=15.0)

    np.testing.assert_array_equal(np.hstack(draw()), np.hstack(draw()))


def test_open_ground_has_no_such_pairs(rng: np.random.Generator) -> None:
    grid = Grid(frame=Frame(cell=1.0, shape=(20, 20)), blocked=np.zeros((20, 20), np.uint8))
    with pytest.raises(SettingError, match="found 0 of 3 start and goal pairs 2 to 9 m apart"):
        free_pairs(grid, 3, rng, nearest=2.0, farthest=9.0)


def test_ground_on_two_sides_of_a_wall_is_not_solvable(rng: np.random.Generator) -> None:
    blocked = np.zeros((20, 20), np.uint8)
    blocked[:, 10] = 1
    grid = Grid(frame=Frame(cell=1.0, shape=(20, 20)), blocked=blocked)
    with pytest.raises(SettingError, match="found 0 of 3"):
        free_pairs(grid, 3, rng, nearest=2.0, farthest=19.0)


def test_a_fence_forbids_the_edge_and_nothing_else() -> None:
    inside = np.zeros((4, 5), np.uint8)
    out = fenced(inside)
    assert out.sum() == 14
    assert not out[1:-1, 1:-1].any()
    assert not inside.any()


def test_practice_worlds_are_varied_and_repeatable() -> None:
    rover = read_rover("research")

    def make(k: int) -> np.ndarray:
        rng = np.random.default_rng([7, k])
        return practice_grid(rng, rover, side=20.0, cell=0.2).blocked

    shares = [float(make(k).mean()) for k in range(8)]
    assert len(set(shares)) == 8
    assert max(shares) > 0.15
    assert make(0).shape == (100, 100)
    np.testing.assert_array_equal(make(3), make(3))


def test_rocky_hills_ask_for_a_detour() -> None:
    ground = named_scene("rocky-hills-v1", seed=1)
    assert ground.rover.name == "research"  # pyright: ignore[reportAttributeAccessIssue]
    assert 0.05 < ground.standing.share < 0.5  # pyright: ignore[reportAttributeAccessIssue]
