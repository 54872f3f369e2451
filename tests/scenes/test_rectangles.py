"""The random-rectangle suite: how far the paper's two bits reach."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from rovernav.control import NeuralController
from rovernav.core import Mission, Outcome, map_arrays
from rovernav.learn import trained_paper_network
from rovernav.scenes import draw_rectangles, random_rectangles, rectangle_scene
from rovernav.sim import Drive, Trace, simulate
from tests.bits import assert_same_bits

COUNT = 50_000


def drive(boxes: np.ndarray, record: str = "all", seed: int = 0) -> Trace:
    scene = rectangle_scene(boxes)
    return simulate(
        scene.drive(NeuralController(trained_paper_network())), record=record, seed=seed
    )


@pytest.fixture(scope="module")
def boxes() -> np.ndarray:
    return draw_rectangles(COUNT, np.random.default_rng(0))


@pytest.fixture(scope="module")
def batch(boxes: np.ndarray) -> Trace:
    return drive(boxes[:2000])


def test_rectangles_are_drawn_as_stated(boxes: np.ndarray) -> None:
    x0, y0, x1, y1 = boxes.T
    stated = (((x0 + x1) / 2, 3.0, 8.7), ((x1 - x0) / 2, 0.3, 2.5), (y1, 0.3, 4.5), (-y0, 0.3, 4.5))
    for values, low, high in stated:
        assert low <= values.min() < low + 1e-3
        assert high - 1e-3 < values.max() <= high
        assert values.mean() == pytest.approx((low + high) / 2, abs=0.03)
    assert_array_equal(random_rectangles(7, np.random.default_rng(0)).worlds.boxes, boxes[:7])


def test_shares_of_reached_collided_and_neither(boxes: np.ndarray) -> None:
    outcome = drive(boxes, record="none").outcome
    share = {how: 100 * float(np.mean(outcome == how)) for how in Outcome}
    assert share[Outcome.REACHED] == pytest.approx(45.0, abs=0.7)
    assert share[Outcome.COLLIDED] == pytest.approx(44.9, abs=0.7)
    assert share[Outcome.LEFT_MAP] == pytest.approx(10.0, abs=0.7)
    assert share[Outcome.REACHED] + share[Outcome.COLLIDED] + share[Outcome.LEFT_MAP] == 100.0


def test_a_row_of_a_batch_is_that_rover_alone(batch: Trace, boxes: np.ndarray) -> None:
    driver = NeuralController(trained_paper_network())
    scene = rectangle_scene(boxes[:2000])
    for k in np.random.default_rng(1).choice(2000, 50, replace=False).tolist():
        mission: Mission = map_arrays(scene.mission, lambda array, k=k: array[[k]])
        set_up = Drive(
            worlds=scene.worlds.row(k),
            mission=mission,
            sensors=scene.sensors,
            controller=driver,
            motion=scene.motion,
        )
        alone, steps = simulate(set_up), int(batch.steps[k])
        assert alone.ended() == batch.ended(k)
        assert alone.steps[0] == steps
        assert_same_bits(alone.length[0], batch.length[k])
        assert_same_bits(alone.pose[:, 0], batch.pose[: steps + 1, k])
        assert_same_bits(alone.time[:, 0], batch.time[: steps + 1, k])
        assert_same_bits(alone.commands[:, 0], batch.commands[:steps, k])
        for name, reading in alone.channels.items():
            assert_same_bits(reading[:, 0], batch.channels[name][:steps, k])


def test_the_order_of_a_batch_does_not_matter(batch: Trace, boxes: np.ndarray) -> None:
    order = np.random.default_rng(2).permutation(2000)
    other = drive(boxes[:2000][order], seed=9)
    assert_same_bits(other.pose, batch.pose[:, order])
    assert_same_bits(other.commands, batch.commands[:, order])
    assert_same_bits(other.outcome, batch.outcome[order])
    assert_same_bits(other.length, batch.length[order])


def test_the_same_seed_gives_the_same_trace(batch: Trace, boxes: np.ndarray) -> None:
    assert_same_bits(drive(boxes[:2000]).pose, batch.pose)
