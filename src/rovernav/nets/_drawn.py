"""First weights of many networks at once."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from ..core import F64
from ..kernels import draws
from ._network import Network, check_topology, default_activations, parameter_count


def seeded_parameters(topology: tuple[int, ...], seeds: Any) -> F64:
    """The weights (n, P) of ``Network.seeded(topology, ..., default_rng(seed))``, bit for bit.

    Args:
        topology: Units per layer, inputs first.
        seeds: From 0 to 2^63 - 1 (n,).

    Raises:
        SettingError: No usable topology.
    """
    check_topology(topology)
    whole = np.ascontiguousarray(seeds, dtype=np.int64)
    out = np.empty((len(whole), parameter_count(topology)))
    scale = [np.full(units * (inputs + 1), np.sqrt(inputs)) for inputs, units in pairwise(topology)]
    draws.uniform(whole, np.concatenate(scale), out)
    if len(whole) and not np.array_equal(out[0], _one_by_one(topology, whole[0])):
        out[:] = [_one_by_one(topology, seed) for seed in whole]  # a NumPy with another generator
    return out


def _one_by_one(topology: tuple[int, ...], seed: Any) -> F64:
    rng = np.random.default_rng(int(seed))
    return Network.seeded(topology, default_activations(topology), rng).parameters
