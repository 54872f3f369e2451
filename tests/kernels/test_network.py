from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rovernav.kernels import network as kernels
from tests.bits import assert_same_bits
from tests.kernels.nets import CASES, as_lists, random_network
from tests.naive import backprop as naive

pytestmark = pytest.mark.kernels


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("case", CASES)
def test_forward_equals_the_twin(case: Any, dtype: Any, rng: np.random.Generator) -> None:
    network = random_network(case, rng, dtype)
    x = rng.normal(size=(9, network.topology[0])).astype(dtype)
    matrices = as_lists(network, network.parameters)
    expected = [naive.forward(matrices, network.activations, row)[-1] for row in x]
    assert_same_bits(network.forward(x), expected)


def test_forward_of_special_numbers(rng: np.random.Generator) -> None:
    network = random_network(CASES[2], rng)
    x = np.array([[0.0, -0.0], [np.inf, 1.0], [-np.inf, np.inf], [np.nan, 0.0], [1e308, 1e308]])
    matrices = as_lists(network, network.parameters)
    expected = [naive.forward(matrices, network.activations, row)[-1] for row in x]
    assert_same_bits(network.forward(x), expected)


@pytest.mark.parametrize(
    ("targets", "tolerance", "expected"),
    [
        ([0.0, 1.0], 0.1, True),
        ([0.125, 1.0], 0.125, False),
        ([0.125, 1.0], 0.1250001, True),
        ([0.0, 1.2], 0.1, False),
        ([-0.2, 1.0], 0.1, False),
        ([0.0, np.nan], 0.1, False),
        ([0.0, 1.0], 0.0, False),
    ],
)
def test_all_within_is_strict(targets: list[float], tolerance: float, expected: bool) -> None:
    identity = np.array([[1, 1, kernels.LINEAR]])
    x, y = np.array([[0.0], [1.0]]), np.array(targets)[:, None]
    assert kernels.all_within(identity, np.array([1.0, 0.0]), x, y, tolerance) is expected
