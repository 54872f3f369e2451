"""Losses and exact gradients of a batch, with every buffer allocated once.

Symbols: x inputs, z outputs before the loss, L mean loss over the batch.

Matrix products go through BLAS on the shapes given; for the same bits on every call the trainer
keeps those shapes fixed and lets BLAS use one thread (`learn`). The drive path never comes here.
"""

from __future__ import annotations

from typing import Any, final

import numpy as np

from ..core import Float, SettingError, ShapeError, suggest
from ..kernels import batch as kernels
from ._network import Network

LOSSES = {"mse": kernels.MSE, "softmax": kernels.SOFTMAX, "binary": kernels.BINARY}
"""Loss names and their kernel codes.

- ``mse``: half the squared error summed over outputs, mean over rows.
- ``softmax``: cross-entropy of softmax(z) against a distribution over the outputs.
- ``binary``: cross-entropy of sigmoid(z) against 0..1 for each output, summed over outputs.

The cross-entropies take the network's linear outputs as logits.
"""


@final
class Backward:
    """Loss and gradient of networks of one shape over batches of one size.

    Args:
        network: Fixes topology, activations and precision; its weights are not used.
        rows: Rows per batch.
        loss: One of `LOSSES`.
    """

    def __init__(self, network: Network, rows: int, loss: str) -> None:
        check_loss(loss, network.activations[-1])
        dtype = network.parameters.dtype
        self._layers = network.layer_rows
        self._loss = LOSSES[loss]
        self._rows = rows
        self._losses = np.empty(rows, dtype)
        self._outputs = [np.empty((rows, units), dtype) for _, units, _ in self._layers]
        self._signals = [np.empty((rows, units), dtype) for _, units, _ in self._layers]
        self.gradient: Float = np.empty(len(network.parameters), dtype)
        self._ones = np.ones(rows, dtype)
        self._weights = [np.empty((u, i), dtype) for i, u, _ in self._layers]
        self._changes = [np.empty((u, i), dtype) for i, u, _ in self._layers]

    def __call__(self, parameters: Float, x: Float, y: Float) -> float:
        """Mean loss of the batch x (rows, i), y (rows, o); `gradient` (P,) then holds dL/dw."""
        if len(x) != self._rows or len(y) != self._rows:
            raise ShapeError(f"this batch has {len(x)} rows, {self._rows} were announced")
        views = _views(parameters, self._layers)
        source = x
        for view, weight, out, (_, _, code) in zip(
            views, self._weights, self._outputs, self._layers, strict=True
        ):
            np.copyto(weight, view[:, :-1])
            np.matmul(source, weight.T, out=out)
            kernels.add_and_activate(out, np.ascontiguousarray(view[:, -1]), code)
            source = out
        kernels.loss_signal(self._outputs[-1], y, self._loss, self._signals[-1], self._losses)
        if self._loss == kernels.MSE:
            kernels.times_slope(self._signals[-1], self._outputs[-1], self._layers[-1][2])
        self._back(x)
        return float(np.sum(self._losses, dtype=np.float64) / self._rows)

    def _back(self, x: Float) -> None:
        gradients = _views(self.gradient, self._layers)
        scale = self.gradient.dtype.type(1.0 / self._rows)
        for n in range(len(self._layers) - 1, -1, -1):
            signal = self._signals[n]
            source = self._outputs[n - 1] if n else x
            np.matmul(signal.T, source, out=self._changes[n])
            np.multiply(self._changes[n], scale, out=gradients[n][:, :-1])
            np.multiply(self._ones @ signal, scale, out=gradients[n][:, -1])
            if n:
                below = self._signals[n - 1]
                np.matmul(signal, self._weights[n], out=below)
                kernels.times_slope(below, self._outputs[n - 1], self._layers[n - 1][2])


def gradient(network: Network, x: Any, y: Any, loss: str = "mse") -> tuple[float, Float]:
    """Mean loss of a batch and its gradient by every parameter.

    Args:
        network: The network.
        x: Inputs (n, i).
        y: Targets (n, o).
        loss: ``mse``, ``softmax`` or ``binary``.

    Returns:
        The loss, and dL/dw (P,) in the order of `Network.parameters`.

    Raises:
        ShapeError: `x` or `y` do not fit the network or each other.
        SettingError: Unknown loss, or a cross-entropy on outputs that are not linear.
    """
    dtype = network.parameters.dtype
    rows, targets = (np.ascontiguousarray(a, dtype=dtype) for a in (x, y))
    wanted = (rows.shape[:1] + network.topology[:1], rows.shape[:1] + network.topology[-1:])
    if rows.ndim != 2 or (rows.shape, targets.shape) != wanted:
        raise ShapeError(
            f"inputs (n, {network.topology[0]}) and targets (n, {network.topology[-1]}) are "
            f"needed, got {rows.shape} and {targets.shape}"
        )
    backward = Backward(network, len(rows), loss)
    return backward(network.parameters, rows, targets), backward.gradient


def check_loss(loss: str, output_activation: str) -> None:
    """Raise `SettingError` unless the loss is known and fits the output activation."""
    if loss not in LOSSES:
        raise SettingError(f"unknown loss {loss!r}; {suggest(loss, LOSSES)}")
    if loss != "mse" and output_activation != "linear":
        raise SettingError(
            f"loss {loss!r} takes linear outputs as logits, got {output_activation!r} outputs; "
            f"make the last activation linear"
        )


def _views(flat: Float, layers: tuple[tuple[int, int, int], ...]) -> list[Float]:
    out, at = [], 0
    for inputs, units, _ in layers:
        size = units * (inputs + 1)
        out.append(flat[at : at + size].reshape(units, inputs + 1))
        at += size
    return out
