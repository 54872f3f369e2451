"""Activations, their slopes and the losses, over a batch.

Symbols: z outputs before the loss, y targets, o outputs, d = dL/dz of the mean loss L.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ._jit import kernel
from .arithmetic import exp, relu, sigmoid, tanh
from .network import RELU, SIGMOID, TANH

MSE, SOFTMAX, BINARY = 0, 1, 2


@kernel()
def activate_all(z: Any, code: int) -> None:
    """Apply the activation to every element of z, in place."""
    if code == SIGMOID:
        for k in range(z.size):
            z[k] = sigmoid(z[k])
    elif code == TANH:
        for k in range(z.size):
            z[k] = tanh(z[k])
    elif code == RELU:
        for k in range(z.size):
            z[k] = relu(z[k])


@kernel()
def times_slope(d: Any, o: Any, code: int) -> None:
    """Multiply d by the derivative of the activation at its outputs o, in place."""
    one = o.dtype.type(1.0)
    if code == SIGMOID:
        for k in range(d.size):
            d[k] *= o[k] * (one - o[k])
    elif code == TANH:
        for k in range(d.size):
            d[k] *= one - o[k] * o[k]
    elif code == RELU:
        zero = o.dtype.type(0.0)
        for k in range(d.size):
            d[k] = zero if o[k] <= zero else d[k]


@kernel(inline=True)
def loss_signal(z: Any, y: Any, loss: int, share: Any, d: Any) -> float:
    """Write `share` times one row's dL/dz to the first elements of d, and return its loss.

    Softmax subtracts the row's largest logit first; the binary loss is
    max(z, 0) - y z + log(1 + e^-|z|), so neither overflows.
    """
    if loss == MSE:
        total = _squared(z, y, d)
    elif loss == SOFTMAX:
        total = _softmax(z, y, d)
    else:
        total = _binary(z, y, d)
    for k in range(y.size):
        d[k] *= share
    return total


@kernel(inline=True)
def _squared(z: Any, y: Any, d: Any) -> float:
    total = 0.0
    for k in range(y.size):
        d[k] = z[k] - y[k]
        total += 0.5 * float(d[k]) * float(d[k])
    return total


@kernel(inline=True)
def _softmax(z: Any, y: Any, d: Any) -> float:
    zero = z.dtype.type(0.0)
    peak, mass, weight = z[0], zero, zero
    for k in range(y.size):
        peak = z[k] if z[k] > peak else peak
    for k in range(y.size):
        d[k] = exp(z[k] - peak)
        mass += d[k]
        weight += y[k]
    log_mass = np.log(float(mass)) + float(peak)
    total = 0.0
    for k in range(y.size):
        total += float(y[k]) * (log_mass - float(z[k]))
        d[k] = weight * d[k] / mass - y[k]
    return total


@kernel(inline=True)
def _binary(z: Any, y: Any, d: Any) -> float:
    total = 0.0
    for k in range(y.size):
        s = float(z[k])
        total += relu(s) - float(y[k]) * s + np.log(1.0 + exp(-abs(s)))
        d[k] = sigmoid(z[k]) - y[k]
    return total
