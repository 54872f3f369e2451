"""Networks trained in lanes have the bits of the same networks trained one by one."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rovernav.kernels import wide
from rovernav.kernels._jit import JIT_DISABLED
from rovernav.kernels.lanes import LANES
from rovernav.learn import RULES, OnlineSettings, Patterns, StopReason, train
from rovernav.nets import Network
from tests.bits import assert_same_bits
from tests.kernels.nets import CASES, random_network

pytestmark = pytest.mark.kernels
STOPS = {
    wide.TOLERANCE: StopReason.TOLERANCE,
    wide.EPOCHS: StopReason.EPOCHS,
    wide.DIVERGED: StopReason.DIVERGED,
}
MEMBERS = 5 if JIT_DISABLED else 2 * LANES + 5


def table(network: Network, rng: np.random.Generator, count: int = 3) -> Patterns:
    inputs, outputs = network.topology[0], network.topology[-1]
    return Patterns(
        x=rng.normal(size=(count, inputs)),
        y=0.5 * rng.normal(size=(count, outputs)),
        inputs=tuple(f"i{n}" for n in range(inputs)),
        outputs=tuple(f"o{n}" for n in range(outputs)),
    )


def members(networks: list[Network], rates: Any, shuffled: bool) -> wide.Members:
    count = len(networks)
    return wide.Members(
        w=np.array([network.parameters for network in networks]),
        rates=np.array(rates),
        seed=np.arange(count) * 2**50 + 3 if shuffled else np.full(count, -1),
        epoch=np.zeros(count, np.int64),
        stop=np.zeros(count, np.int8),
        worst=np.zeros(count),
    )


def together(block: wide.Members, like: Network, patterns: Patterns, rule: str, epochs: int,
             updates: int = 10**6) -> int:  # fmt: skip
    """Train a block in lanes; the calls that it took."""
    shuffled = bool((block.seed >= 0).all())
    kernel = wide.wide_train(like.layer_rows, RULES[rule], shuffled)
    columns = patterns.x.shape[1] + patterns.y.shape[1] if shuffled else 0
    lanes = wide.empty_lanes(block.w.shape[1], len(patterns.x), columns)
    evaluates = bool((block.rates[:, 2] > 0).any())
    settings = wide.WideSettings(RULES[rule], evaluates, epochs, updates)
    calls = 1
    while not kernel(lanes, block, like.layers, patterns.x, patterns.y, settings):
        calls += 1
    return calls


def assert_as_alone(networks: list[Network], patterns: Patterns, rule: str, epochs: int,
                    rates: Any, shuffled: bool) -> list[StopReason]:  # fmt: skip
    """Train in lanes and one by one, compare all that comes out; why each ended."""
    block = members(networks, rates, shuffled)
    together(block, networks[0], patterns, rule, epochs)
    for k, network in enumerate(networks):
        eta, momentum, tolerance = rates[k]
        alone = train(network, patterns, OnlineSettings(
            eta=eta, momentum=momentum, tolerance=tolerance, rule=rule, epochs=epochs,
            order="shuffled" if shuffled else "cyclic", seed=k * 2**50 + 3,
        ))  # fmt: skip
        assert (STOPS[int(block.stop[k])], block.epoch[k]) == (alone.stop, alone.epoch)
        assert_same_bits(block.w[k], alone.network.parameters)
        errors = np.abs(patterns.y - alone.network.forward(patterns.x))
        assert_same_bits(block.worst[k], np.max(errors))
    return [STOPS[int(stop)] for stop in block.stop]


def mixed_rates(rng: np.random.Generator, count: int = MEMBERS) -> list[tuple[float, float, float]]:
    """Rates of which some learn, some do not end and some diverge."""
    etas = rng.choice([0.02, 0.1, 0.4, 5.0, 1e200], count)
    momenta = rng.choice([0.0, 0.5, 0.9], count)
    tolerances = rng.choice([0.0, 0.3, 0.6, 9.0], count)
    return list(zip(etas.tolist(), momenta.tolist(), tolerances.tolist(), strict=True))


@pytest.mark.parametrize("shuffled", [False, True])
@pytest.mark.parametrize(
    ("case", "rule"),
    [
        (CASES[2], "paper"),
        (CASES[6], "textbook"),
        *(
            pytest.param(case, rule, marks=pytest.mark.long)
            for case in CASES
            for rule in RULES
            if (case, rule) not in ((CASES[2], "paper"), (CASES[6], "textbook"))
        ),
    ],
)
def test_every_member_has_the_bits_of_its_training_alone(
    case: Any, rule: str, shuffled: bool, rng: np.random.Generator
) -> None:
    networks = [random_network(case, rng) for _ in range(MEMBERS)]
    patterns = table(networks[0], rng)
    assert_as_alone(networks, patterns, rule, 40, mixed_rates(rng), shuffled)


@pytest.mark.long
@pytest.mark.parametrize("draw", range(12))
def test_random_networks_of_up_to_the_largest_size(draw: int) -> None:
    rng = np.random.default_rng(draw)
    names = ["linear", "sigmoid", "tanh", "relu"]
    while True:
        topology = tuple(int(n) for n in rng.integers(1, 8, rng.integers(2, 6)))
        activations = tuple(rng.choice(names, len(topology) - 1).tolist())
        networks = [random_network((topology, activations), rng) for _ in range(MEMBERS)]
        if wide.fits(len(networks[0].parameters)):
            break
    patterns = table(networks[0], rng, int(rng.integers(1, 300)))
    rule = str(rng.choice(list(RULES)))
    assert_as_alone(networks, patterns, rule, 60, mixed_rates(rng), bool(rng.integers(2)))


def test_the_cases_above_end_in_all_ways(rng: np.random.Generator) -> None:
    networks = [random_network(CASES[2], rng) for _ in range(4)]
    rates = [(0.1, 0.5, 1e-9), (0.1, 0.5, 50.0), (1e200, 0.9, 0.1), (0.3, 0.5, 0.6)]
    stops = assert_as_alone(networks, table(networks[0], rng), "paper", 40, rates, False)
    assert stops == [StopReason.EPOCHS, StopReason.TOLERANCE, StopReason.DIVERGED,
                     StopReason.TOLERANCE]  # fmt: skip


@pytest.mark.parametrize("epochs", [0, 1])
def test_no_epoch_and_one(epochs: int, rng: np.random.Generator) -> None:
    networks = [random_network(CASES[2], rng) for _ in range(MEMBERS)]
    rates = mixed_rates(rng)
    assert_as_alone(networks, table(networks[0], rng), "paper", epochs, rates, False)


def test_no_member_and_one(rng: np.random.Generator) -> None:
    network = random_network(CASES[2], rng)
    patterns = table(network, rng)
    empty = wide.Members(np.empty((0, 17)), np.empty((0, 3)), *(np.empty(0, t) for t in "llbd"))
    assert together(empty, network, patterns, "paper", 5) == 1
    assert_as_alone([network], patterns, "paper", 5, [(0.1, 0.0, 0.0)], False)


def test_slices_are_short_and_change_nothing(rng: np.random.Generator) -> None:
    networks = [random_network(CASES[2], rng) for _ in range(MEMBERS)]
    patterns, rates = table(networks[0], rng), mixed_rates(rng)
    whole, sliced = (members(networks, rates, shuffled=False) for _ in range(2))
    assert together(whole, networks[0], patterns, "paper", 200) == 1
    assert together(sliced, networks[0], patterns, "paper", 200, updates=1) > 3
    for one, other in zip(whole, sliced, strict=True):
        assert_same_bits(one, other)
    assert set(whole.stop) <= set(STOPS)


def test_members_diverge_many_epochs_after_a_slice_began(rng: np.random.Generator) -> None:
    """A growth so slow that infinity comes late, in the middle of a slice of many epochs."""
    networks = [random_network(CASES[0], rng) for _ in range(3)]
    one = np.array([[1.0]])
    patterns = Patterns(x=one, y=one, inputs=("i",), outputs=("o",))
    stops = assert_as_alone(networks, patterns, "paper", 900, [(3.0, 0.0, 0.0)] * 3, False)
    assert stops == [StopReason.DIVERGED] * 3


def test_generated_source_is_readable(rng: np.random.Generator) -> None:
    lines = list(wide._module(random_network(CASES[2], rng).layer_rows, 1, True))
    assert "def advance(lanes, members, x, y, s, epochs):" in lines
    assert max(map(len, lines)) <= 100
