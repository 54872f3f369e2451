from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from rovernav.core import Frame, RovernavError
from rovernav.terrain import add_crater, hills, slope


def made(seed: int = 1, **settings: Any) -> Any:
    given: dict[str, Any] = {"shape": (60, 80), **settings}
    return hills(np.random.default_rng(seed), **given)


def test_a_seed_gives_its_ground_and_no_other() -> None:
    assert_array_equal(made(3).height, made(3).height)
    assert np.abs(made(3).height - made(4).height).max() > 1.0


def test_relief_is_what_was_asked_for() -> None:
    terrain = made(relief=12.0, craters=0, cell=2.0)
    low, high = terrain.span
    assert high - low == pytest.approx(12.0, abs=1e-4)
    assert terrain.frame.extent == (160.0, 120.0)
    assert terrain.finite == 1.0


def test_no_relief_and_no_craters_is_a_plain() -> None:
    assert slope(made(relief=0.0, craters=0)).max() == 0.0


def test_a_larger_hurst_exponent_is_smoother() -> None:
    mean = [float(slope(made(hurst=h, craters=0)).mean()) for h in (0.3, 0.6, 0.9)]
    assert mean[0] > 1.1 * mean[1] > 1.2 * mean[2]


def test_ground_does_not_wrap_around() -> None:
    z = made(craters=0, relief=10.0).height
    across, inside = np.abs(z[:, 0] - z[:, -1]).mean(), np.abs(z[:, 0] - z[:, 1]).mean()
    assert across > 5 * inside


def test_a_crater_has_its_depth_its_rim_and_a_level_far_field() -> None:
    frame = Frame(cell=0.1, shape=(401, 401))
    heights = np.zeros(frame.shape)
    add_crater(heights, frame, (20.05, 20.05), 8.0, depth=1.5)
    row = heights[200]
    assert row.argmin() == 200
    assert row.max() - row.min() == pytest.approx(1.5, abs=0.01)
    assert abs(row[200:].argmax() - 40) <= 1
    assert row.max() == pytest.approx(0.3, abs=0.01)
    assert abs(row[0]) < 0.005
    assert_allclose(heights, heights.T, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"shape": (2, 9)}, r"hills need 3 x 3 to 40 million cells, got shape \(2, 9\)"),
        ({"shape": (10_000, 10_000)}, "hills need 3 x 3 to 40 million cells"),
        ({"relief": -1.0}, "relief must lie in 0 to 10000 m, got -1"),
        ({"relief": np.nan}, "relief must lie in"),
        ({"hurst": 0.0}, "Hurst exponent must lie above 0 and up to 1, got 0.0; 0.9 is smooth"),
        ({"craters": -1}, "number of craters must lie in 0 to 100000, got -1"),
        ({"cell": 0.0}, "a cell must be a positive number of metres, got 0"),
    ],
)
def test_settings_that_give_no_ground(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(RovernavError, match=message):
        made(**settings)
