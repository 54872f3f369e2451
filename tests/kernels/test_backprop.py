from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from rovernav.kernels import backprop
from rovernav.learn import RULES
from rovernav.nets import Network
from tests.bits import assert_same_bits
from tests.kernels.nets import CASES, as_flat, as_lists, random_network, run, scalars
from tests.naive import backprop as naive

pytestmark = pytest.mark.kernels


def table(network: Network, rng: np.random.Generator) -> tuple[Any, Any]:
    x = rng.normal(size=(3, network.topology[0]))
    return x, rng.normal(size=(3, network.topology[-1]))


@pytest.mark.parametrize("seed", [None, 7])
@pytest.mark.parametrize("momentum", [0.0, 0.5])
@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("case", CASES)
def test_training_equals_the_twin(
    case: Any, rule: str, momentum: float, seed: int | None, rng: np.random.Generator
) -> None:
    network = random_network(case, rng)
    x, y = table(network, rng)
    rates = {"eta": 0.3, "momentum": momentum, "rule": rule, "tolerance": 0.0, "seed": seed}
    w, v = as_lists(network, network.parameters), as_lists(network, 0 * network.parameters)
    naive.train(w, v, network.activations, x, y, {**rates, "epochs": 3})
    settings = scalars(
        momentum=momentum, rule=RULES[rule], seed=-1 if seed is None else seed, epochs=3
    )
    weights, changes, end = run(backprop.train, network, x, y, settings)
    assert_same_bits(weights, as_flat(w))
    assert_same_bits(changes, as_flat(v))
    assert end == (3, False)


@pytest.mark.parametrize("rule", RULES)
def test_training_stops_where_the_twin_stops(rule: str, rng: np.random.Generator) -> None:
    network = random_network(CASES[2], rng)
    x, y = np.array([[0.0, 1.0], [1.0, 0.0]]), np.array([[0.5, 0.0], [0.0, 0.5]])
    rates = {"eta": 0.3, "momentum": 0.5, "rule": rule, "tolerance": 0.3, "seed": 1}
    w, v = as_lists(network, network.parameters), as_lists(network, 0 * network.parameters)
    done = naive.train(w, v, network.activations, x, y, {**rates, "epochs": 50})
    settings = scalars(momentum=0.5, rule=RULES[rule], tolerance=0.3, seed=1, epochs=50)
    weights, changes, end = run(backprop.train, network, x, y, settings)
    assert 1 < done < 50
    assert end == (done, True)
    assert_same_bits(weights, as_flat(w))
    assert_same_bits(changes, as_flat(v))


def numerical_gradient(network: Network, x: Any, y: Any, step: float = 1e-6) -> Any:
    """Central differences of the half squared error."""

    def loss(parameters: Any) -> float:
        error = y - network.with_parameters(parameters).forward(x[None])[0]
        return 0.5 * float(error @ error)

    w = network.parameters
    moves = step * np.eye(len(w))
    return np.array([(loss(w + move) - loss(w - move)) / (2 * step) for move in moves])


def change_per_eta(network: Network, x: Any, y: Any, rule: str, eta: float) -> Any:
    settings = scalars(eta=eta, rule=RULES[rule])
    w, _, _ = run(backprop.train, network, x[None], y[None], settings)
    return (w - network.parameters) / eta


@pytest.mark.parametrize("case", CASES)
def test_textbook_rule_follows_the_gradient(case: Any, rng: np.random.Generator) -> None:
    network = random_network(case, rng)
    x, y = (row[0] for row in table(network, rng))
    change = change_per_eta(network, x, y, "textbook", 0.25)
    assert_allclose(change, -numerical_gradient(network, x, y), rtol=1e-6, atol=1e-8)


@pytest.mark.parametrize("case", [c for c in CASES if len(c[0]) > 2 and "relu" not in c[1]])
def test_paper_rule_leaves_the_gradient_by_order_eta(case: Any, rng: np.random.Generator) -> None:
    network = random_network(case, rng)
    x, y = (row[0] for row in table(network, rng))
    descent = change_per_eta(network, x, y, "textbook", 2.0**-12)
    etas = [2.0**-k for k in (8, 9, 10)]
    gaps = [change_per_eta(network, x, y, "paper", eta) - descent for eta in etas]
    sizes = np.linalg.norm(gaps, axis=1)
    top = network.topology[-1] * (network.topology[-2] + 1)
    assert sizes[0] > 1e-6
    assert_allclose(sizes[:-1] / sizes[1:], 2.0, rtol=0.02, atol=0)
    assert_allclose(np.array(gaps)[:, -top:], 0.0, rtol=0, atol=1e-9)


def test_record_holds_the_weights_after_each_update(rng: np.random.Generator) -> None:
    network = random_network(CASES[2], rng)
    x, y = table(network, rng)
    w, v = network.parameters.copy(), np.zeros(17)
    record = np.full((6, 17), np.nan)
    backprop.train(network.layers, w, v, x, y, scalars(momentum=0.5, epochs=2), record)
    alone, last = network.parameters.copy(), np.zeros(17)
    for number in range(6):
        p = slice(number % 3, number % 3 + 1)
        settings = scalars(momentum=0.5)
        backprop.train(network.layers, alone, last, x[p], y[p], settings, np.empty((0, 17)))
        assert_same_bits(record[number], alone)
    assert_same_bits(w, alone)


def permutation(count: int, seed: int, epoch: int) -> list[int]:
    order = np.full(count, -1)
    backprop.shuffle(order, seed, epoch)
    return order.tolist()


@pytest.mark.parametrize("seed", [0, 1, 2**62, 2**63 - 1])
@pytest.mark.parametrize("count", [1, 2, 5, 64])
def test_shuffle_equals_the_twin(count: int, seed: int) -> None:
    for epoch in (0, 1, 1000, 10**12):
        assert permutation(count, seed, epoch) == naive.order(count, seed, epoch)


def test_shuffle_favours_no_order() -> None:
    seen = Counter(tuple(permutation(3, 0, epoch)) for epoch in range(600))
    assert len(seen) == 6
    assert_allclose(list(seen.values()), 100, rtol=0, atol=40)  # four standard deviations
    follows = Counter((permutation(3, s, 0)[0], permutation(3, s, 1)[0]) for s in range(450))
    assert_allclose(list(follows.values()), 50, rtol=0, atol=28)
    assert len(follows) == 9


def test_shuffle_depends_on_seed_and_epoch() -> None:
    orders = [permutation(20, seed, epoch) for seed in range(4) for epoch in range(4)]
    assert len({tuple(order) for order in orders}) == 16
    assert_array_equal(np.sort(orders, axis=1), np.tile(np.arange(20), (16, 1)))
