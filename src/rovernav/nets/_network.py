"""The network as a value: topology, activations and parameters."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from ..core import Float, SettingError, ShapeError, suggest, value
from ..kernels import network as kernels
from ._card import Card

ACTIVATIONS = {
    "linear": kernels.LINEAR,
    "sigmoid": kernels.SIGMOID,
    "tanh": kernels.TANH,
    "relu": kernels.RELU,
}
"""Activation names and their kernel codes."""

MAX_LAYERS = 100
MAX_UNITS = 100_000
MAX_PARAMETERS = 50_000_000


@value
class Network:
    """A multi-layer perceptron NN = {I, T, W, A} (Bassil 2012, section 6), immutable.

    Attributes:
        topology: Units per layer, inputs first: (2, 3, 2) is the paper's.
        activations: One name per layer after the inputs.
        parameters: All weights (P,), float64 or float32: layer by layer, unit by unit, a unit's
            incoming weights first and its bias last.
        card: Names, units, codec and origin of the network.
    """

    topology: tuple[int, ...]
    activations: tuple[str, ...]
    parameters: Float
    card: Card = Card()

    def _check(self) -> None:
        check_topology(self.topology)
        check_activations(self.activations, self.topology)
        count = parameter_count(self.topology)
        if self.parameters.shape != (count,):
            raise ShapeError(
                f"a {topology_text(self.topology)} network has {count} parameters, "
                f"got an array of shape {self.parameters.shape}"
            )
        if str(self.parameters.dtype) not in ("float64", "float32"):
            raise ShapeError(f"parameters must be float64 or float32, got {self.parameters.dtype}")
        self.card.check_sizes(self.topology[0], self.topology[-1])

    @classmethod
    def from_matrices(
        cls, matrices: Sequence[Any], activations: Sequence[str], card: Card | None = None
    ) -> Network:
        """A float64 network from one matrix per layer, (units, inputs + 1), bias column last.

        Raises:
            ShapeError: A matrix does not fit the one before it.
        """
        arrays = [np.asarray(matrix, dtype=np.float64) for matrix in matrices]
        for number, array in enumerate(arrays, 1):
            if array.ndim != 2:
                raise ShapeError(
                    f"matrix {number} must have two dimensions, got shape {array.shape}"
                )
        inputs = [a.shape[1] - 1 for a in arrays[:1]]
        topology = (*inputs, *(len(a) for a in arrays))
        for number, (array, inputs) in enumerate(zip(arrays, topology, strict=False), 1):
            if array.shape[1] != inputs + 1:
                raise ShapeError(
                    f"matrix {number} must have {inputs + 1} columns ({inputs} inputs and a bias), "
                    f"got shape {array.shape}"
                )
        return cls(
            topology=topology,
            activations=tuple(activations),
            parameters=np.concatenate([np.empty(0), *(a.ravel() for a in arrays)]),
            card=card or Card(),
        )

    @classmethod
    def seeded(
        cls,
        topology: Sequence[int],
        activations: Sequence[str],
        rng: np.random.Generator,
        *,
        dtype: Any = np.float64,
    ) -> Network:
        """Fresh weights: uniform within +-1/sqrt(inputs) of each layer, biases too.

        That is LeCun's rule up to a constant (LeCun et al. 1998, Efficient BackProp, section 4.6).
        """
        topology = tuple(int(units) for units in topology)
        check_topology(topology)
        layers = [
            rng.uniform(-1.0, 1.0, units * (inputs + 1)) / np.sqrt(inputs)
            for inputs, units in pairwise(topology)
        ]
        return cls(
            topology=topology,
            activations=tuple(activations),
            parameters=np.concatenate(layers).astype(dtype),
        )

    @property
    def layers(self) -> np.ndarray[Any, np.dtype[np.int64]]:
        """Rows of inputs, units, activation code, as the kernels read them."""
        return np.array(self.layer_rows, dtype=np.int64)

    @property
    def layer_rows(self) -> tuple[tuple[int, int, int], ...]:
        """Inputs, units and activation code of each layer."""
        return tuple(
            (inputs, units, ACTIVATIONS[name])
            for inputs, units, name in zip(
                self.topology[:-1], self.topology[1:], self.activations, strict=True
            )
        )

    @property
    def matrices(self) -> list[Float]:
        """Views of the weights, one per layer: (units, inputs + 1), bias column last."""
        out, at = [], 0
        for inputs, units, _ in self.layer_rows:
            size = units * (inputs + 1)
            out.append(self.parameters[at : at + size].reshape(units, inputs + 1))
            at += size
        return out

    def with_parameters(self, parameters: Float) -> Network:
        """The same network with other weights."""
        return Network(
            topology=self.topology,
            activations=self.activations,
            parameters=parameters,
            card=self.card,
        )

    def with_card(self, card: Card) -> Network:
        """The same network with another card."""
        return Network(
            topology=self.topology,
            activations=self.activations,
            parameters=self.parameters,
            card=card,
        )

    def forward(self, x: Any) -> Float:
        """Outputs (n, o) for inputs (n, i); row k has the same bits whatever the batch.

        Raises:
            ShapeError: `x` is not (n, i).
        """
        rows = np.ascontiguousarray(x, dtype=self.parameters.dtype)
        if rows.ndim != 2 or rows.shape[1] != self.topology[0]:
            raise ShapeError(
                f"this network takes inputs of shape (n, {self.topology[0]}), got {rows.shape}"
            )
        out = np.empty((len(rows), self.topology[-1]), self.parameters.dtype)
        kernels.forward(self.layers, self.parameters, rows, out)
        return out


def parse_topology(text: str) -> tuple[int, ...]:
    """``2-3-2`` as (2, 3, 2).

    Raises:
        SettingError: Not whole numbers joined by hyphens, or not a usable network.
    """
    try:
        topology = tuple(int(part) for part in text.split("-"))
    except ValueError:
        raise SettingError(
            f"a topology is written like 2-3-2 (inputs, hidden layers, outputs), got {text!r}"
        ) from None
    check_topology(topology)
    return topology


def topology_text(topology: tuple[int, ...]) -> str:
    """(2, 3, 2) as ``2-3-2``."""
    return "-".join(map(str, topology))


def parameter_count(topology: tuple[int, ...]) -> int:
    """Weights and biases of a network."""
    return sum(u * (i + 1) for i, u in pairwise(topology))


def default_activations(topology: tuple[int, ...], hidden: str = "sigmoid") -> tuple[str, ...]:
    """The paper's mix: `hidden` in every hidden layer, linear outputs."""
    return (hidden,) * (len(topology) - 2) + ("linear",)


def check_topology(topology: tuple[int, ...]) -> None:
    """Raise `SettingError` unless `topology` can be a network."""
    text = topology_text(topology)[:60]
    if len(topology) < 2:
        raise SettingError(f"a network needs at least inputs and outputs, like 2-2, got {text!r}")
    if len(topology) > MAX_LAYERS + 1:
        raise SettingError(f"a network may have {MAX_LAYERS} layers, got {len(topology) - 1}")
    if min(topology) < 1 or max(topology) > MAX_UNITS:
        raise SettingError(f"each layer needs 1 to {MAX_UNITS:,} units, got {text!r}")
    if parameter_count(topology) > MAX_PARAMETERS:
        raise SettingError(
            f"a {text} network has {parameter_count(topology):,} parameters; "
            f"at most {MAX_PARAMETERS:,} are allowed"
        )


def check_activations(activations: tuple[str, ...], topology: tuple[int, ...]) -> None:
    """Raise `SettingError` unless there is one known activation per layer after the inputs."""
    for name in activations:
        if name not in ACTIVATIONS:
            raise SettingError(f"unknown activation {name!r}; {suggest(name, ACTIVATIONS)}")
    if len(activations) != len(topology) - 1:
        raise SettingError(
            f"a {topology_text(topology)} network needs {len(topology) - 1} activations, "
            f"one per layer after the inputs, got {len(activations)}"
        )
