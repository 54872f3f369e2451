from __future__ import annotations

import math

import numpy as np
import pytest

from rovernav.core import Mission, SettingError
from rovernav.kernels import fan
from rovernav.mapping import LocalMapper, bearing
from tests.naive.local_map import marks, near

ANGLES = np.linspace(-math.pi / 2, math.pi / 2, 9)


def start(x: float = 0.0, y: float = 0.0) -> Mission:
    return Mission.between((x, y), (x + 5.0, y), goal_radius=0.5, time_limit=10.0)


def held(cells: np.ndarray, centre: np.ndarray) -> set[tuple[int, int]]:
    side = cells.shape[1]
    window = np.empty((side, side), np.uint8)
    fan.window(cells, centre, 0, window)
    low = centre[0] - side // 2
    return {(int(i + low[0]), int(j + low[1])) for i, j in zip(*np.nonzero(window), strict=True)}


@pytest.mark.kernels
def test_the_map_is_a_set_of_cells_that_forgets_what_lies_beyond_its_edge(
    rng: np.random.Generator,
) -> None:
    mapper = LocalMapper(ANGLES, reach=3.0, rays=8, side=16, memory=1.0)
    memory, known = mapper.start(start()), set[tuple[int, int]]()
    pose = np.array([[0.0, 0.0, 0.0]])
    for _ in range(60):
        pose = pose + np.column_stack([rng.normal(0, 0.5, (1, 2)), rng.normal(0, 0.4, (1, 1))])
        beams = np.minimum(rng.uniform(0.2, 4.0, (1, 9)), 3.0)
        _, memory = mapper.update(memory, pose, np.array([[5.0, 0.0]]), {"beams": beams})
        seen = marks(
            tuple(pose[0].tolist()), ANGLES.tolist(), beams[0].tolist(),
            reach=3.0, cell=mapper.cell, join=4.0 * mapper.cell,
        )  # fmt: skip
        centre = (math.floor(pose[0, 1] / mapper.cell), math.floor(pose[0, 0] / mapper.cell))
        known = near(known, centre, 16) | near(seen, centre, 16)
        assert held(memory.cells, memory.centre) == known


@pytest.mark.kernels
def test_rays_start_at_the_goals_direction_and_go_left() -> None:
    mapper = LocalMapper(ANGLES, reach=4.0, rays=4, side=64, memory=1.0)
    mission = Mission.between((0.0, 0.0), (0.0, 9.0), goal_radius=0.5, time_limit=9.0)
    beams = np.full((1, 9), 4.0)
    beams[0, 4] = 2.0  # straight ahead, which is north, where the goal is
    channels, _ = mapper.update(
        mapper.start(mission), mission.start, mission.goal, {"beams": beams}
    )
    around = channels["around"][0]
    assert around[0] == pytest.approx(2.0, abs=mapper.cell)
    np.testing.assert_allclose(around[1:], channels["reach"][0, 0], atol=mapper.cell)
    channels, _ = mapper.update(
        mapper.start(mission), mission.start, np.array([[9.0, 0.0]]), {"beams": beams}
    )
    assert channels["around"][0].argmin() == 1  # the goal is east: north is a quarter to the left


def test_a_row_does_not_depend_on_its_batch(rng: np.random.Generator) -> None:
    mapper = LocalMapper(ANGLES, reach=3.0, side=32)
    n = 7
    mission = Mission(
        start=rng.normal(0, 3, (n, 3)),
        goal=rng.normal(0, 9, (n, 2)),
        goal_radius=1.0,
        time_limit=9.0,
    )
    beams = np.minimum(rng.uniform(0.1, 4.0, (n, 9)), 3.0)
    whole, memory = mapper.update(
        mapper.start(mission), mission.start, mission.goal, {"beams": beams}
    )
    for k in range(n):
        one = Mission(
            start=mission.start[k : k + 1], goal=mission.goal[k : k + 1],
            goal_radius=1.0, time_limit=9.0,
        )  # fmt: skip
        row, alone = mapper.update(
            mapper.start(one), one.start, one.goal, {"beams": beams[k : k + 1]}
        )
        np.testing.assert_array_equal(row["around"][0], whole["around"][k])
        np.testing.assert_array_equal(alone.cells[0], memory.cells[k])


def test_an_update_does_not_change_the_map_it_was_given() -> None:
    mapper = LocalMapper(ANGLES, reach=3.0)
    mission = start()
    before = mapper.start(mission)
    mapper.update(before, mission.start, mission.goal, {"beams": np.full((1, 9), 1.0)})
    assert not before.cells.any()


def test_bearing() -> None:
    pose, goal = np.zeros((2, 3)), np.array([[0.0, 2.0], [-3.0, 0.0]])
    np.testing.assert_allclose(bearing(pose, goal), [math.pi / 2, math.pi])


def test_a_side_that_is_no_power_of_two_is_refused() -> None:
    with pytest.raises(SettingError, match="a local map needs a side of 8, 16, 32"):
        LocalMapper(ANGLES, reach=3.0, side=48)
