"""Losses and exact gradients of a batch, with every buffer allocated once.

Every sum has a fixed order, so the same batch gives the same bits wherever it is computed on one
kind of processor; no BLAS is used.
"""

from __future__ import annotations

from typing import Any, final

import numpy as np

from ..core import Float, SettingError, ShapeError, suggest
from ..kernels import batch, losses
from ._network import Network

LOSSES = {"mse": losses.MSE, "softmax": losses.SOFTMAX, "binary": losses.BINARY}
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
        rows: Rows per batch, 1 or more.
        loss: One of `LOSSES`.

    Attributes:
        gradient: dL/dw (P,) of the last call, in the order of `Network.parameters`.
    """

    def __init__(self, network: Network, rows: int, loss: str) -> None:
        check_loss(loss, network.activations[-1])
        if rows < 1:
            raise ShapeError(f"a batch needs at least one row, got {rows}")
        dtype = network.parameters.dtype
        self._loss = LOSSES[loss]
        self._rows = rows
        self._panel = min(rows, batch.PANEL)
        self._plan = batch.make_plan(network.layer_rows, self._panel, dtype.itemsize)
        self._w, self._g = (batch.make_weights(self._plan, dtype) for _ in range(2))
        self._scratch = batch.make_scratch(self._plan, self._panel, dtype)
        self._parameters: Float = np.empty(len(network.parameters), dtype)
        self.gradient: Float = np.empty(len(network.parameters), dtype)

    def __call__(self, parameters: Float, x: Float, y: Float) -> float:
        """Mean loss of the batch x (rows, i), y (rows, o); `gradient` (P,) then holds dL/dw."""
        if len(x) != self._rows or len(y) != self._rows:
            raise ShapeError(f"this batch has {len(x)} rows, {self._rows} were announced")
        self._parameters[:] = parameters
        batch.pack(self._plan, self._parameters, self._w)
        total = 0.0
        for first in range(0, self._rows, self._panel):
            rows = min(self._panel, self._rows - first)
            batch.inputs(self._plan, self._scratch, rows)[:] = x[first : first + rows]
            self._scratch.y[:rows] = y[first : first + rows]
            part = batch.Part(self._loss, 1.0 / self._rows, int(first > 0), total)
            total = batch.gradient(self._plan, self._w, self._g, self._scratch, part, rows)
        batch.unpack(self._plan, self._g, self.gradient)
        return total / self._rows


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
        ShapeError: `x` or `y` do not fit the network or each other, or there are no rows.
        SettingError: Unknown loss, or a cross-entropy on outputs that are not linear.
    """
    dtype = network.parameters.dtype
    rows, targets = (np.asarray(a, dtype=dtype) for a in (x, y))
    wanted = (rows.shape[:1] + network.topology[:1], rows.shape[:1] + network.topology[-1:])
    if rows.ndim != 2 or (rows.shape, targets.shape) != wanted or not len(rows):
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
