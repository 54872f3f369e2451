from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from rovernav.core import SettingError, ShapeError
from rovernav.nets import (
    ACTIVATIONS,
    Card,
    Network,
    default_activations,
    parameter_count,
    parse_topology,
    topology_text,
)
from tests.bits import assert_same_bits

FUNCTIONS = {
    "linear": lambda s: s,
    "sigmoid": lambda s: 1 / (1 + np.exp(-s)),
    "tanh": np.tanh,
    "relu": lambda s: np.maximum(s, 0),
}


@st.composite
def networks(draw: st.DrawFn, dtypes: tuple[Any, ...] = (np.float64, np.float32)) -> Network:
    topology = draw(st.lists(st.integers(1, 6), min_size=2, max_size=5))
    layers = len(topology) - 1
    names = draw(st.lists(st.sampled_from(sorted(ACTIVATIONS)), min_size=layers, max_size=layers))
    seed = draw(st.integers(0, 2**32))
    rng = np.random.default_rng(seed)
    return Network.seeded(topology, names, rng, dtype=draw(st.sampled_from(dtypes)))


@given(network=networks(), rows=st.integers(1, 9), seed=st.integers(0, 2**32))
def test_a_row_alone_has_the_same_bits(network: Network, rows: int, seed: int) -> None:
    x = np.random.default_rng(seed).normal(size=(rows, network.topology[0])) * 3
    whole = network.forward(x)
    for k in range(rows):
        assert_same_bits(network.forward(x[k : k + 1])[0], whole[k])
    assert_same_bits(network.forward(x[::-1])[::-1], whole)


@given(network=networks((np.float64,)), seed=st.integers(0, 2**32))
def test_forward_is_the_textbook_formula(network: Network, seed: int) -> None:
    x = np.random.default_rng(seed).normal(size=(5, network.topology[0]))
    o = x
    for matrix, name in zip(network.matrices, network.activations, strict=True):
        o = FUNCTIONS[name](o @ matrix[:, :-1].T + matrix[:, -1])
    assert_allclose(network.forward(x), o, rtol=1e-12, atol=1e-14)


def test_weights_lie_unit_by_unit_with_the_bias_last() -> None:
    w1, w2 = np.arange(9.0).reshape(3, 3), np.arange(9.0, 17.0).reshape(2, 4)
    network = Network.from_matrices([w1, w2], ["sigmoid", "linear"])
    assert network.topology == (2, 3, 2)
    assert network.parameters.tolist() == list(range(17))
    assert_array_equal(network.matrices[0], w1)
    assert_array_equal(network.matrices[1], w2)
    assert network.layer_rows == ((2, 3, 1), (3, 2, 0))
    two = Network.from_matrices([[[10.0, 100.0, 1.0]]], ["linear"])
    assert two.forward([[2.0, 3.0]]).tolist() == [[321.0]]


def test_forward_takes_any_layout_and_leaves_it_alone() -> None:
    network = Network.seeded((2, 3, 2), ("sigmoid", "linear"), np.random.default_rng(0))
    x = np.arange(12.0).reshape(6, 2) / 7
    expected = network.forward(x)
    kept = x.copy()
    for same in (np.asfortranarray(x), x.tolist(), np.repeat(x, 2, axis=0)[::2]):
        assert_same_bits(network.forward(same), expected)
    assert_same_bits(x, kept)
    assert network.forward(np.empty((0, 2))).shape == (0, 2)
    assert network.forward(x.astype(np.float32)).dtype == np.float64


@pytest.mark.parametrize("shape", [(2,), (3, 1), (1, 3), (2, 2, 2)])
def test_inputs_must_fit(shape: tuple[int, ...]) -> None:
    network = Network.seeded((2, 1), ("linear",), np.random.default_rng(0))
    with pytest.raises(ShapeError) as caught:
        network.forward(np.zeros(shape))
    assert str(caught.value) == f"this network takes inputs of shape (n, 2), got {shape}"


def test_seeded_weights(rng: np.random.Generator) -> None:
    network = Network.seeded((16, 100, 4), ("tanh", "linear"), rng)
    for matrix, inputs in zip(network.matrices, (16, 100), strict=True):
        limit = 1 / np.sqrt(inputs)
        assert np.abs(matrix).max() <= limit
        assert np.abs(matrix).max() > 0.98 * limit
        assert_allclose(matrix.std(), limit / np.sqrt(3), rtol=0.05, atol=0)
    again = Network.seeded((16, 100, 4), ("tanh", "linear"), np.random.default_rng(0))
    assert_same_bits(again.parameters, network.parameters)
    short = Network.seeded(
        (16, 100, 4), ("tanh", "linear"), np.random.default_rng(0), dtype=np.float32
    )
    assert_same_bits(short.parameters, network.parameters.astype(np.float32))


def test_a_network_keeps_its_weights() -> None:
    given_array = np.zeros(3)
    network = Network(topology=(2, 1), activations=("linear",), parameters=given_array)
    with pytest.raises(ValueError, match="read-only"):
        network.parameters[0] = 1.0
    with pytest.raises(ValueError, match="read-only"):
        network.matrices[0][0, 0] = 1.0
    assert given_array.flags.writeable
    card = Card(inputs=("a", "b"), seed=3)
    other = network.with_card(card).with_parameters(np.ones(3))
    assert other.card is card
    assert other.parameters.tolist() == [1, 1, 1]
    assert other.topology == network.topology


def make(**changes: Any) -> Network:
    plain: dict[str, Any] = {
        "topology": (2, 3, 2),
        "activations": ("sigmoid", "linear"),
        "parameters": np.zeros(17),
    }
    return Network(**{**plain, **changes})


@pytest.mark.parametrize(
    ("changes", "error", "message"),
    [
        ({"topology": (2,)}, SettingError, "needs at least inputs and outputs, like 2-2, got '2'"),
        ({"topology": ()}, SettingError, "needs at least inputs and outputs, like 2-2, got ''"),
        ({"topology": (1,) * 102}, SettingError, "a network may have 100 layers, got 101"),
        ({"topology": (2, 0, 2)}, SettingError, "1 to 100,000 units, got '2-0-2'"),
        ({"topology": (-2, 3)}, SettingError, "1 to 100,000 units, got '-2-3'"),
        ({"topology": (2, 100_001)}, SettingError, "1 to 100,000 units, got '2-100001'"),
        ({"topology": (10_000, 10_000)}, SettingError, "has 100,010,000 parameters; at most 50,0"),
        ({"activations": ("sigmoid",)}, SettingError,
         "2-3-2 network needs 2 activations, one per layer after the inputs, got 1"),
        ({"activations": ("sigmoid", "sigmiod")}, SettingError,
         "unknown activation 'sigmiod'; did you mean 'sigmoid'? Allowed: linear, relu, sig"),
        ({"parameters": np.zeros(16)}, ShapeError,
         "a 2-3-2 network has 17 parameters, got an array of shape (16,)"),
        ({"parameters": np.zeros((17, 1))}, ShapeError, "got an array of shape (17, 1)"),
        ({"parameters": np.zeros(17, np.float16)}, ShapeError, "or float32, got float16"),
        ({"parameters": np.zeros(17, int)}, ShapeError, "or float32, got int64"),
        ({"parameters": np.zeros(17, ">f8")}, ShapeError, "or float32, got >f8"),
        ({"card": Card(inputs=("x",))}, ShapeError, "1 input names do not fit a network with 2"),
        ({"card": Card(output_units=("m",) * 3)}, ShapeError, "3 output units do not fit a netw"),
    ],
)  # fmt: skip
def test_networks_that_cannot_be(
    changes: dict[str, Any], error: type[Exception], message: str
) -> None:
    with pytest.raises(error) as caught:
        make(**changes)
    assert message in str(caught.value)


def test_matrices_must_follow_each_other() -> None:
    with pytest.raises(ShapeError) as caught:
        Network.from_matrices([np.zeros((3, 3)), np.zeros((2, 3))], ["sigmoid", "linear"])
    assert str(caught.value) == (
        "matrix 2 must have 4 columns (3 inputs and a bias), got shape (2, 3)"
    )
    with pytest.raises(ShapeError, match="matrix 1 must have two dimensions"):
        Network.from_matrices([np.zeros(3)], ["linear"])
    with pytest.raises(SettingError, match="needs at least inputs and outputs"):
        Network.from_matrices([], [])


@given(st.lists(st.integers(1, 999), min_size=2, max_size=6).map(tuple))
def test_topologies_are_read_as_written(topology: tuple[int, ...]) -> None:
    assert parse_topology(topology_text(topology)) == topology
    sizes = [np.zeros((u, i + 1)).size for i, u in pairwise(topology)]
    assert parameter_count(topology) == sum(sizes)


@pytest.mark.parametrize(
    "text", ["", "2", "2-", "-2", "2--2", "2-x", "2x3", "2.0-3", "2-3-", "0-1"]
)
def test_topologies_that_are_none(text: str) -> None:
    with pytest.raises(SettingError, match=r"2-3-2|2-2|1 to 100,000 units"):
        parse_topology(text)


def test_default_activations() -> None:
    assert default_activations((2, 3, 2)) == ("sigmoid", "linear")
    assert default_activations((2, 3, 4, 2), "relu") == ("relu", "relu", "linear")
    assert default_activations((2, 1)) == ("linear",)
