"""Back-propagation of a batch: the mean loss and its exact gradient.

Symbols: w weights, g = dL/dw of the mean loss L, o outputs, d signals dL/dz of the sums z.

While a network is trained its weights stand layer by layer as an (inputs + 1, units) matrix, the
bias row last, rows padded (see `product`); padding is zero and stays zero. A layer's outputs in
float32 or float64 have the bits of `network.forward`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ._jit import kernel
from .losses import MSE, activate_all, loss_signal, times_slope
from .product import BIAS, ON, ZERO, At, aligned, padded, product
from .turn import turn

INPUTS, UNITS, CODE, WEIGHTS, WIDE, OUTPUTS, BELOW, BELOW_WIDE, TURNED = range(9)
"""Columns of a plan."""
PANEL = 256
"""Rows that are computed together, so that all that belongs to them stays in a core's cache."""


class Scratch(NamedTuple):
    """Buffers for a panel of rows.

    Attributes:
        o: Outputs of all layers, the inputs first, each (rows, padded units).
        d: Signals, laid out like `o`.
        t: Weights of all layers, transposed.
        u: Gradients of narrow layers, transposed, laid out like `t`; panels add to them.
        y: Targets (rows, o).
        one: The number 1 (1,).
    """

    o: Any
    d: Any
    t: Any
    u: Any
    y: Any
    one: Any


class Part(NamedTuple):
    """What a panel of rows is part of.

    Attributes:
        loss: Code of the loss.
        share: Weight of a row in the mean: 1 / rows of the batch.
        on: 0 for the first panel; 1 for those that go on with its gradient, in the same buffers.
        total: Sum of the losses of the rows before.
    """

    loss: int
    share: float
    on: int
    total: float


def make_plan(layers: tuple[tuple[int, int, int], ...], rows: int, itemsize: int) -> Any:
    """Where each layer's weights and outputs stand: (layers, 9), columns as named above.

    Args:
        layers: Inputs, units, activation code of each layer.
        rows: Most rows of a panel.
        itemsize: Bytes of a number.
    """
    plan: list[tuple[int, ...]] = []
    weights, turned, below, below_wide = 0, 0, 0, padded(layers[0][0], itemsize)
    for inputs, units, code in layers:
        wide, outputs = padded(units, itemsize), below + rows * below_wide
        plan.append((inputs, units, code, weights, wide, outputs, below, below_wide, turned))
        weights, turned = weights + (inputs + 1) * wide, turned + units * below_wide
        below, below_wide = outputs, wide
    return np.array(plan, dtype=np.int64)


def make_weights(plan: Any, dtype: Any) -> Any:
    """Zeros (S,) for a network's padded weights, or a number that belongs to each."""
    top = plan[-1]
    return aligned(int(top[WEIGHTS] + (top[INPUTS] + 1) * top[WIDE]), dtype)


def make_scratch(plan: Any, rows: int, dtype: Any) -> Scratch:
    """Buffers for panels of up to `rows` rows."""
    size = int(plan[-1][OUTPUTS] + rows * plan[-1][WIDE])
    turned = int(plan[-1][TURNED] + plan[-1][UNITS] * plan[-1][BELOW_WIDE])
    return Scratch(
        o=aligned(size, dtype),
        d=aligned(size, dtype),
        t=aligned(turned, dtype),
        u=aligned(turned, dtype),
        y=np.zeros((rows, int(plan[-1][UNITS])), dtype),
        one=np.ones(1, dtype),
    )


def inputs(plan: Any, scratch: Scratch, rows: int) -> Any:
    """A view (rows, i) of the place where a batch's inputs stand."""
    wide = plan[0, BELOW_WIDE]
    return scratch.o[: rows * wide].reshape(rows, wide)[:, : plan[0, INPUTS]]


@kernel()
def pack(plan: Any, flat: Any, w: Any) -> None:
    """Copy weights, in the order of `network`, to their padded places in `w`."""
    at = 0
    for layer in range(plan.shape[0]):
        first, wide = plan[layer, WEIGHTS], plan[layer, WIDE]
        for unit in range(plan[layer, UNITS]):
            for i in range(plan[layer, INPUTS] + 1):
                w[first + i * wide + unit] = flat[at]
                at += 1


@kernel()
def unpack(plan: Any, w: Any, flat: Any) -> None:
    """The reverse of `pack`."""
    at = 0
    for layer in range(plan.shape[0]):
        first, wide = plan[layer, WEIGHTS], plan[layer, WIDE]
        for unit in range(plan[layer, UNITS]):
            for i in range(plan[layer, INPUTS] + 1):
                flat[at] = w[first + i * wide + unit]
                at += 1


@kernel()
def forward(plan: Any, w: Any, o: Any, rows: int) -> None:
    """Fill the outputs `o` of all layers from the inputs that stand at its start."""
    for layer in range(plan.shape[0]):
        here = plan[layer]
        at = At(
            here[OUTPUTS], here[WIDE], here[BELOW], here[BELOW_WIDE], 1,
            here[WEIGHTS], here[WIDE], here[INPUTS], BIAS,
        )  # fmt: skip
        product(o, o, w, at, rows, here[UNITS])
        activate_all(o[here[OUTPUTS] : here[OUTPUTS] + rows * here[WIDE]], here[CODE])


@kernel()
def gradient(plan: Any, w: Any, g: Any, scratch: Scratch, part: Part, rows: int) -> float:
    """Write or add to `g` what the first `rows` rows in `scratch` contribute to dL/dw.

    The signals go from the top layer down; the inputs get none.

    Returns:
        The sum of the losses, ``part.total`` included.
    """
    o, d = scratch.o, scratch.d
    if not part.on:
        _turn_weights(plan, w, scratch.t)
    forward(plan, w, o, rows)
    total = score(plan, scratch, part, rows)
    for layer in range(plan.shape[0] - 1, -1, -1):
        here = plan[layer]
        first, wide = here[OUTPUTS], here[WIDE]
        if layer < plan.shape[0] - 1:
            above = plan[layer + 1]
            at = At(
                first, wide, above[OUTPUTS], above[WIDE], 1,
                above[TURNED], wide, above[UNITS], ZERO,
            )  # fmt: skip
            product(d, d, scratch.t, at, rows, here[UNITS])
        if layer < plan.shape[0] - 1 or part.loss == MSE:
            times_slope(d[first : first + rows * wide], o[first : first + rows * wide], here[CODE])
        _weight_gradient(here, scratch, g, part.on, rows)
    return total


@kernel()
def score(plan: Any, scratch: Scratch, part: Part, rows: int) -> float:
    """Write the signals of the network's outputs to `d`; return the sum of the losses so far."""
    first, wide, total = plan[-1, OUTPUTS], plan[-1, WIDE], part.total
    share = scratch.o.dtype.type(part.share)
    for row in range(rows):
        z = scratch.o[first + row * wide : first + (row + 1) * wide]
        d = scratch.d[first + row * wide : first + (row + 1) * wide]
        total += loss_signal(z, scratch.y[row], part.loss, share, d)
    return total


@kernel()
def _turn_weights(plan: Any, w: Any, t: Any) -> None:
    for layer in range(1, plan.shape[0]):
        here = plan[layer]
        shape = here[INPUTS], here[UNITS]
        turn(w, here[WEIGHTS], here[WIDE], t, here[TURNED], here[BELOW_WIDE], shape)


@kernel()
def _weight_gradient(here: Any, scratch: Scratch, g: Any, on: int, rows: int) -> None:
    """One layer's part of g: outputs below times signals, summed over the rows; signals alone.

    A layer of few units is computed transposed, where less of each vector is padding.
    """
    inputs, units, wide, below_wide = here[INPUTS], here[UNITS], here[WIDE], here[BELOW_WIDE]
    o, d, u, turned = scratch.o, scratch.d, scratch.u, here[TURNED]
    first, signals, below = here[WEIGHTS], here[OUTPUTS], here[BELOW]
    start = ON if on else ZERO
    if units * below_wide < inputs * wide:
        at = At(turned, below_wide, signals, 1, wide, below, below_wide, rows, start)
        product(u, d, o, at, units, inputs)
        turn(u, turned, below_wide, g, first, wide, (units, inputs))
    else:
        at = At(first, wide, below, 1, below_wide, signals, wide, rows, start)
        product(g, o, d, at, inputs, units)
    at = At(first + inputs * wide, wide, 0, 0, 0, signals, wide, rows, start)
    product(g, scratch.one, d, at, scratch.one.size, units)
