"""Small random networks for kernel tests, as kernels and as the plain-Python twin see them."""

from __future__ import annotations

from typing import Any

import numpy as np

from rovernav.kernels import backprop
from rovernav.nets import Network

CASES = [
    ((1, 1), ("linear",)),
    ((1, 1), ("sigmoid",)),
    ((2, 3, 2), ("sigmoid", "linear")),
    ((2, 3, 2), ("tanh", "tanh")),
    ((2, 3, 2), ("relu", "linear")),
    ((3, 4, 2, 1), ("sigmoid", "tanh", "linear")),
    ((2, 2, 2, 2, 3), ("tanh", "relu", "sigmoid", "sigmoid")),
]
"""Topologies and activations that cover one to four layers and each activation in each place."""


def random_network(case: Any, rng: np.random.Generator, dtype: Any = np.float64) -> Network:
    topology, activations = case
    network = Network.seeded(topology, activations, rng)
    return network.with_parameters((2.0 * network.parameters).astype(dtype))


def as_lists(network: Network, parameters: Any) -> list[Any]:
    """One list of rows for each layer, with NumPy's numbers in them."""
    return [[list(row) for row in m] for m in network.with_parameters(parameters).matrices]


def as_flat(matrices: list[Any]) -> Any:
    return np.array([w for matrix in matrices for row in matrix for w in row])


def scalars(**changes: Any) -> backprop.OnlineSettings:
    """One cyclic epoch of the textbook rule, eta 0.3, without momentum; or something else."""
    plain = backprop.OnlineSettings(0.3, 0.0, backprop.TEXTBOOK, 0.0, -1, 0, 1)
    return plain._replace(**changes)


def run(train: Any, network: Network, x: Any, y: Any, settings: Any) -> tuple[Any, Any, Any]:
    """New weights, last changes, and what the training kernel returned."""
    w, v = network.parameters.copy(), np.zeros(len(network.parameters))
    end = train(network.layers, w, v, x, y, settings, np.empty((0, len(w))))
    return w, v, end
