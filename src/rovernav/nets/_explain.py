"""Why a network answered what it answered, for one input."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from ..core import F64, ShapeError, value
from ..kernels import network as kernels
from ._gradient import Backward
from ._network import Network


@value
class Explanation:
    """One forward pass taken apart, in double precision.

    Attributes:
        inputs: What the network was given (i,).
        activations: Outputs of the units of each layer after the inputs, the last being `outputs`.
        contributions: What each unit of the last hidden layer, times its weight, adds to each
            output's sum (o, h + 1); the bias stands last. A row adds up to `sums`.
        sums: Pre-activations of the outputs (o,).
        outputs: Outputs (o,).
        sensitivity: How much each asked-for output rises per unit of each input (a, i): the
            derivatives at this input, by back-propagation.
        asked: Which outputs `sensitivity` is about (a,).
    """

    inputs: F64
    activations: tuple[F64, ...]
    contributions: F64
    sums: F64
    outputs: F64
    sensitivity: F64
    asked: tuple[int, ...]


def explain(network: Network, x: Any, *, asked: Sequence[int] | None = None) -> Explanation:
    """Take the forward pass of one input apart.

    What a hidden unit adds to an output is exact: weight times activation, and the bias. Deeper
    layers and inputs act through activations that bend, so there only the derivative at this very
    input is exact; it says nothing about larger changes.

    Args:
        network: Any topology; float32 weights are taken as the doubles that they are.
        x: One input (i,).
        asked: Outputs for which derivatives by the inputs are wanted; all by default.

    Raises:
        ShapeError: `x` does not fit, or an output does not exist.
    """
    inputs = np.array(x, dtype=np.float64)
    if inputs.shape != network.topology[:1]:
        raise ShapeError(
            f"one input of {network.topology[0]} numbers is needed, got {inputs.shape}"
        )
    wanted = tuple(range(network.topology[-1])) if asked is None else tuple(asked)
    for k in wanted:
        if not 0 <= k < network.topology[-1]:
            raise ShapeError(f"this network has outputs 0 to {network.topology[-1] - 1}, not {k}")
    exact = network.with_parameters(network.parameters.astype(np.float64))
    layers = [inputs, *_activations(exact, inputs)]
    below, outputs = layers[-2], layers[-1]
    contributions = exact.matrices[-1] * np.append(below, 1.0)
    return Explanation(
        inputs=inputs,
        activations=tuple(layers[1:]),
        contributions=contributions,
        sums=contributions.sum(axis=1),
        outputs=outputs,
        sensitivity=_sensitivity(exact, inputs, outputs, wanted),
        asked=wanted,
    )


def _activations(network: Network, inputs: F64) -> list[F64]:
    """Outputs of the units of each layer, by the kernel that drives and trains too."""
    layers = network.layers
    units = np.empty(kernels.width(layers))
    units[: len(inputs)] = inputs
    kernels.forward_row(layers, np.ascontiguousarray(network.parameters), units)
    return [units[a:b].copy() for a, b in pairwise(np.cumsum(network.topology))]


def _sensitivity(network: Network, inputs: F64, outputs: F64, asked: tuple[int, ...]) -> F64:
    """D output / d input (a, i), by the backward pass that training uses.

    A target one below an output and equal to the others makes the squared error's derivative by
    that output 1 and by the others 0. The gradient by a first-layer bias is then the derivative by
    that unit's sum, and the first layer's weights carry it on to the inputs.
    """
    backward = Backward(network, 1, "mse")
    first = network.matrices[0]
    rows = np.empty((len(asked), len(inputs)))
    for row, k in enumerate(asked):
        target = outputs.copy()
        target[k] -= 1.0
        backward(network.parameters, inputs[None], target[None])
        by_sum = backward.gradient[: first.size].reshape(first.shape)[:, -1]
        rows[row] = by_sum @ first[:, :-1]
    return rows
