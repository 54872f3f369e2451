from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from rovernav.core import ShapeError
from rovernav.nets import ACTIVATIONS, Network, explain

topologies = st.lists(st.integers(1, 6), min_size=2, max_size=5)


def network(topology: Any, seed: int, *, last: str | None = None, dtype: Any = None) -> Network:
    rng = np.random.default_rng(seed)
    names = rng.choice(sorted(ACTIVATIONS), len(topology) - 1).tolist()
    if last is not None:
        names[-1] = last
    return Network.seeded(topology, names, rng, dtype=dtype or np.float64)


@given(topology=topologies, seed=st.integers(0, 999))
def test_contributions_add_up_to_the_outputs(topology: list[int], seed: int) -> None:
    net = network(topology, seed, last="linear")
    x = np.random.default_rng(seed).normal(size=topology[0])
    told = explain(net, x)
    assert told.contributions.shape == (topology[-1], (topology[-2]) + 1)
    assert_allclose(told.contributions.sum(axis=1), net.forward(x[None])[0], rtol=0, atol=1e-9)
    assert_allclose(told.sums, told.outputs, rtol=0, atol=1e-9)
    assert np.array_equal(told.outputs, net.forward(x[None])[0])
    assert [len(each) for each in told.activations] == topology[1:]


@given(topology=topologies, seed=st.integers(0, 999))
def test_sensitivity_is_the_central_difference(topology: list[int], seed: int) -> None:
    net = network(topology, seed)
    x = np.random.default_rng(seed).normal(size=topology[0])
    told = explain(net, x)
    step = 1e-6
    for i in range(topology[0]):
        moved = np.stack([x, x])
        moved[0, i] += step
        moved[1, i] -= step
        above, below = net.forward(moved)
        slope = (above - below) / (2 * step)
        assert_allclose(told.sensitivity[:, i], slope, rtol=1e-5, atol=1e-5)


def test_the_paper_network_at_its_first_pattern() -> None:
    net = Network.from_matrices(
        [
            [[0.17, 0.33, 0.1], [0.3, 0.71, 0.21], [0.15, 0.43, 0.69]],
            [[0.11, 0.03, 0.52, 0.41], [0.93, 0.14, 0.79, 0.66]],
        ],
        ["sigmoid", "linear"],
    )
    told = explain(net, [0, 0])
    hidden = [0.52497919, 0.55230791, 0.66596693]
    assert_allclose(told.activations[0], hidden, rtol=0, atol=1e-8)
    there = [[0.11 * hidden[0], 0.03 * hidden[1], 0.52 * hidden[2], 0.41]]
    assert_allclose(told.contributions[:1], there, rtol=0, atol=1e-8)
    assert_allclose(told.outputs, [0.83061975, 1.75166762], rtol=0, atol=1e-8)


def test_short_floats_are_taken_as_the_doubles_that_they_are() -> None:
    net = network((5, 8, 3), 1, last="linear", dtype=np.float32)
    told = explain(net, np.arange(5) / 5, asked=[2, 0])
    assert_allclose(told.sums, told.outputs, rtol=0, atol=1e-12)
    assert_allclose(told.outputs, net.forward([np.arange(5) / 5])[0], rtol=0, atol=1e-5)
    assert told.asked == (2, 0)
    assert_allclose(told.sensitivity, explain(net, np.arange(5) / 5).sensitivity[[2, 0]])


@pytest.mark.parametrize(
    ("x", "asked", "message"),
    [
        ([1.0], None, "one input of 2 numbers is needed, got (1,)"),
        ([[1.0, 2.0]], None, "one input of 2 numbers is needed, got (1, 2)"),
        ([1.0, 2.0], [2], "this network has outputs 0 to 1, not 2"),
    ],
)
def test_what_does_not_fit_is_refused(x: Any, asked: Any, message: str) -> None:
    with pytest.raises(ShapeError, match=re.escape(message)):
        explain(network((2, 3, 2), 0), x, asked=asked)
