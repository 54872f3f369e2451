"""The forward pass of a multi-layer perceptron.

Symbols: x inputs, s pre-activation, o outputs of all units, w weights.

Weights are flat: layer by layer, unit by unit, a unit's incoming weights first and its bias last.
`layers` has one row per layer: inputs, units, activation code. A unit's sum starts at its bias and
adds its inputs in index order, one fused multiply-add each, so a row's result does not depend on
the batch it is in.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ._jit import kernel
from .arithmetic import fma, relu, sigmoid, tanh

LINEAR, SIGMOID, TANH, RELU = 0, 1, 2, 3


@kernel(inline=True)
def activate(code: int, s: Any) -> Any:
    """The activation `code` of the pre-activation s."""
    if code == SIGMOID:
        return sigmoid(s)
    if code == TANH:
        return tanh(s)
    if code == RELU:
        return relu(s)
    return s


@kernel()
def forward_row(layers: Any, w: Any, o: Any) -> int:
    """Run the input that stands at the start of `o` through the network.

    `o` holds every unit's output, inputs first; the network's outputs are its end.

    Returns:
        Where in `o` the network's outputs begin.
    """
    below, top, at = 0, layers[0, 0], 0
    for layer in range(layers.shape[0]):
        inputs, units, code = layers[layer, 0], layers[layer, 1], layers[layer, 2]
        for unit in range(units):
            s = w[at + inputs]
            for i in range(inputs):
                s = fma(w[at + i], o[below + i], s)
            o[top + unit] = activate(code, s)
            at += inputs + 1
        below = top
        top += units
    return below


@kernel()
def width(layers: Any) -> int:
    """Inputs and units of the whole network: the length of `o`."""
    total = layers[0, 0]
    for layer in range(layers.shape[0]):
        total += layers[layer, 1]
    return total


@kernel()
def forward(layers: Any, w: Any, x: Any, out: Any) -> None:
    """Run x (n, i) through the network, row by row, to out (n, o)."""
    o = np.empty(width(layers), w.dtype)
    for row in range(x.shape[0]):
        for i in range(x.shape[1]):
            o[i] = x[row, i]
        top = forward_row(layers, w, o)
        for k in range(out.shape[1]):
            out[row, k] = o[top + k]


@kernel()
def all_within(layers: Any, w: Any, x: Any, y: Any, tolerance: float) -> bool:
    """Whether every output of every pattern is nearer than `tolerance` to its target."""
    o = np.empty(width(layers), w.dtype)
    for p in range(x.shape[0]):
        for i in range(x.shape[1]):
            o[i] = x[p, i]
        top = forward_row(layers, w, o)
        for k in range(y.shape[1]):
            if not abs(y[p, k] - o[top + k]) < tolerance:
                return False
    return True
