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
from .product import At, aligned, padded, product

INPUTS, UNITS, CODE, WEIGHTS, WIDE, OUTPUTS, BELOW, BELOW_WIDE = range(8)
"""Columns of a plan."""


class Scratch(NamedTuple):
    """Buffers for a batch.

    Attributes:
        o: Outputs of all layers, the inputs first, each (rows, padded units).
        d: Signals, laid out like `o`.
        t: One layer's weights or gradient, transposed.
        y: Targets (rows, o).
        one: The number 1 (1,).
    """

    o: Any
    d: Any
    t: Any
    y: Any
    one: Any


def make_plan(layers: tuple[tuple[int, int, int], ...], rows: int, itemsize: int) -> Any:
    """Where each layer's weights and outputs stand: (layers, 8), columns as named above.

    Args:
        layers: Inputs, units, activation code of each layer.
        rows: Most rows of a batch.
        itemsize: Bytes of a number.
    """
    plan: list[tuple[int, ...]] = []
    weights, below, below_wide = 0, 0, padded(layers[0][0], itemsize)
    for inputs, units, code in layers:
        wide, outputs = padded(units, itemsize), below + rows * below_wide
        plan.append((inputs, units, code, weights, wide, outputs, below, below_wide))
        weights += (inputs + 1) * wide
        below, below_wide = outputs, wide
    return np.array(plan, dtype=np.int64)


def make_weights(plan: Any, dtype: Any) -> Any:
    """Zeros (S,) for a network's padded weights, or a number that belongs to each."""
    top = plan[-1]
    return aligned(int(top[WEIGHTS] + (top[INPUTS] + 1) * top[WIDE]), dtype)


def make_scratch(plan: Any, rows: int, dtype: Any) -> Scratch:
    """Buffers for batches of up to `rows` rows."""
    size = int(plan[-1][OUTPUTS] + rows * plan[-1][WIDE])
    turned = int(max(layer[UNITS] * layer[BELOW_WIDE] for layer in plan))
    return Scratch(
        o=aligned(size, dtype),
        d=aligned(size, dtype),
        t=aligned(turned, dtype),
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
            here[WEIGHTS], here[WIDE], here[INPUTS], 1,
        )  # fmt: skip
        product(o, o, w, at, rows, here[WIDE])
        activate_all(o[here[OUTPUTS] : here[OUTPUTS] + rows * here[WIDE]], here[CODE])


@kernel()
def gradient(plan: Any, w: Any, g: Any, scratch: Scratch, loss: int, rows: int) -> float:
    """Fill `g` with dL/dw of the first `rows` rows in `scratch`; return the sum of their losses.

    The signals go from the top layer down; the inputs get none.
    """
    o, d = scratch.o, scratch.d
    forward(plan, w, o, rows)
    total = score(plan, scratch, loss, rows)
    top = plan[-1]
    if loss == MSE:
        ends = top[OUTPUTS], top[OUTPUTS] + rows * top[WIDE]
        times_slope(d[ends[0] : ends[1]], o[ends[0] : ends[1]], top[CODE])
    for layer in range(plan.shape[0] - 1, -1, -1):
        here = plan[layer]
        _weight_gradient(here, scratch, g, rows)
        if layer > 0:
            below, wide = here[BELOW], here[BELOW_WIDE]
            _turn(w[here[WEIGHTS] :], here[WIDE], here[INPUTS], scratch.t, wide, here[UNITS])
            at = At(below, wide, here[OUTPUTS], here[WIDE], 1, 0, wide, here[UNITS], 0)
            product(d, d, scratch.t, at, rows, wide)
            end = below + rows * wide
            times_slope(d[below:end], o[below:end], plan[layer - 1, CODE])
    return total


@kernel()
def score(plan: Any, scratch: Scratch, loss: int, rows: int) -> float:
    """Write the signals of the network's outputs to `d`; return the sum of the rows' losses."""
    first, wide, total = plan[-1, OUTPUTS], plan[-1, WIDE], 0.0
    share = scratch.o.dtype.type(1.0 / rows)
    for row in range(rows):
        z = scratch.o[first + row * wide : first + (row + 1) * wide]
        d = scratch.d[first + row * wide : first + (row + 1) * wide]
        total += loss_signal(z, scratch.y[row], loss, share, d)
    return total


@kernel()
def _weight_gradient(here: Any, scratch: Scratch, g: Any, rows: int) -> None:
    """One layer's part of g: outputs below times signals, summed over the rows; signals alone.

    A layer of few units is computed transposed, where less of each vector is padding.
    """
    inputs, units, wide, below_wide = here[INPUTS], here[UNITS], here[WIDE], here[BELOW_WIDE]
    o, d, t = scratch.o, scratch.d, scratch.t
    first, signals, below = here[WEIGHTS], here[OUTPUTS], here[BELOW]
    if units * below_wide < inputs * wide:
        at = At(0, below_wide, signals, 1, wide, below, below_wide, rows, 0)
        product(t, d, o, at, units, below_wide)
        _turn(t, below_wide, units, g[first : first + inputs * wide], wide, inputs)
    else:
        at = At(first, wide, below, 1, below_wide, signals, wide, rows, 0)
        product(g, o, d, at, inputs, wide)
    at = At(first + inputs * wide, wide, 0, 0, 0, signals, wide, rows, 0)
    product(g, scratch.one, d, at, scratch.one.size, wide)


@kernel()
def _turn(a: Any, a_row: int, rows: int, b: Any, b_row: int, columns: int) -> None:
    """Write the matrix a (rows, columns), transposed, to b (columns, rows); 0 to b's padding."""
    for j in range(columns):
        line = b[j * b_row : (j + 1) * b_row]
        for i in range(rows):
            line[i] = a[i * a_row + j]
        for i in range(rows, line.size):
            line[i] = 0
