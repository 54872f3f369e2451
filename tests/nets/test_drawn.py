from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from rovernav.core import read_only
from rovernav.kernels import draws
from rovernav.nets import Network, default_activations, seeded_parameters
from tests.bits import assert_same_bits

pytestmark = pytest.mark.kernels
SEEDS = [0, 1, 7, 2**16, 2**32 - 1, 2**32, 2**32 + 1, 2**53 + 1, 2**63 - 1]


def one(topology: tuple[int, ...], seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return Network.seeded(topology, default_activations(topology), rng).parameters


@pytest.mark.parametrize("topology", [(1, 1), (2, 3, 2), (5, 7, 3, 1)])
def test_many_seeds_have_the_bits_of_each_alone(topology: tuple[int, ...]) -> None:
    assert_same_bits(seeded_parameters(topology, SEEDS), [one(topology, s) for s in SEEDS])


@given(st.integers(0, 2**63 - 1))
def test_any_seed(seed: int) -> None:
    out = np.empty((1, 4))
    draws.uniform(np.array([seed]), np.ones(4), out)
    assert_same_bits(out[0], np.random.default_rng(seed).uniform(-1.0, 1.0, 4))


@given(st.integers(0, 2**63 - 1), st.integers(0, 2**63 - 1), st.floats(0.0, 1.0))
@example(0, 0, 0.3)
@example(2**32 - 1, 2**32, 0.3)
@example(2**32, 2**32 - 1, 1.0)
@example(2**62 - 1, 2**63 - 1, 0.1)
def test_any_pair_of_a_key_and_a_number(key: int, number: int, spread: float) -> None:
    out = np.empty((1, 2))
    draws.uniform_pairs(key, read_only(np.array([number])), spread, out)
    assert_same_bits(out[0], np.random.default_rng([key, number]).uniform(-spread, spread, 2))


def test_another_generator_in_numpy_is_followed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        np.random, "default_rng", lambda s: np.random.Generator(np.random.MT19937(s))
    )
    assert_same_bits(seeded_parameters((2, 3, 2), [3, 4]), [one((2, 3, 2), s) for s in (3, 4)])


def test_no_seed_at_all() -> None:
    assert seeded_parameters((2, 3, 2), []).shape == (0, 17)
