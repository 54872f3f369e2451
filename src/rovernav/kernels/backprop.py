"""Online back-propagation: one pattern, one update (Bassil 2012, section 6.2 and its listing).

Symbols: e = target - output, d error signal of a unit, g = eta d, v last change of each weight
(the listing's delta), m = mu v, o outputs of all units. Weights are laid out as in `network`.

A weight's change is D = mu v + eta d o_source; the weight gains D and v becomes D. Rule PAPER
sums a hidden unit's error over the ALREADY UPDATED weights above it, as the listing does; rule
TEXTBOOK over the old ones, which makes it the exact gradient of the half squared error.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ._jit import kernel
from .arithmetic import fma
from .network import RELU, SIGMOID, TANH, all_within, forward_row, width

TEXTBOOK, PAPER = 0, 1


class OnlineSettings(NamedTuple):
    """Scalars of a training slice.

    Attributes:
        eta: Learning rate.
        momentum: Share of the last change that is repeated.
        rule: TEXTBOOK or PAPER.
        tolerance: Stop before an epoch once every error is nearer to 0 than this; 0 never stops.
        seed: Seed of the shuffled order; negative keeps the table's order.
        epoch: Epochs done before this slice; the shuffle of an epoch depends on its number alone.
        epochs: Epochs to do at most.
    """

    eta: float
    momentum: float
    rule: int
    tolerance: float
    seed: int
    epoch: int
    epochs: int


@kernel(inline=True)
def slope_at(code: int, o: Any) -> Any:
    """Derivative of the activation `code`, from the unit's output o."""
    if code == SIGMOID:
        return o * (1.0 - o)
    if code == TANH:
        return fma(-o, o, 1.0)
    if code == RELU:
        return 1.0 if o > 0.0 else 0.0
    return 1.0


@kernel()
def shuffle(order: Any, seed: int, epoch: int) -> None:
    """Fill `order` with the permutation of epoch number `epoch` (Fisher-Yates over splitmix64)."""
    for i in range(order.size):
        order[i] = i
    state = np.uint64(seed) * np.uint64(0x9E3779B97F4A7C15) + np.uint64(epoch)
    state = (state ^ (state >> np.uint64(31))) * np.uint64(0xD1342543DE82EF95)
    for i in range(order.size - 1, 0, -1):
        state += np.uint64(0x9E3779B97F4A7C15)
        z = (state ^ (state >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        z = z ^ (z >> np.uint64(31))
        j = np.int64(z % np.uint64(i + 1))
        order[i], order[j] = order[j], order[i]


@kernel()
def update(layers: Any, w: Any, v: Any, y: Any, o: Any, s: OnlineSettings) -> None:
    """Change the weights `w` and their last changes `v` for one pattern.

    Args:
        layers: Rows of inputs, units, activation code.
        w: Weights (P,), changed.
        v: Last changes (P,), changed.
        y: Target (k,).
        o: Scratch (3, inputs + units): outputs (the input stands at their start), d, g.
        s: Rates and rule.
    """
    top = forward_row(layers, w, o[0])
    last = layers.shape[0] - 1
    for k in range(layers[last, 1]):
        _signal(layers[last, 2], o, top + k, y[k] - o[0, top + k], s.eta)
    at = w.size
    for layer in range(last, -1, -1):
        inputs, units = layers[layer, 0], layers[layer, 1]
        at -= units * (inputs + 1)
        if layer > 0 and s.rule == TEXTBOOK:
            _back(layers[layer - 1, 2], w, at, o, top, units, inputs, s.eta)
        _change(w, v, at, o, top, units, inputs, s.momentum)
        if layer > 0 and s.rule == PAPER:
            _back(layers[layer - 1, 2], w, at, o, top, units, inputs, s.eta)
        top -= inputs


@kernel(inline=True)
def _signal(code: int, o: Any, unit: int, error: float, eta: float) -> None:
    """Error signal d and step g of a unit from its summed error."""
    rise = slope_at(code, o[0, unit])
    o[1, unit] = rise * error
    o[2, unit] = (eta * rise) * error


@kernel()
def _back(
    code: int, w: Any, at: int, o: Any, top: int, units: int, inputs: int, eta: float
) -> None:
    """Signals of the `inputs` units below `top`, from the `units` above through w[at:]."""
    for i in range(inputs):
        error = o[1, top] * w[at + i]
        for k in range(1, units):
            error = fma(o[1, top + k], w[at + k * (inputs + 1) + i], error)
        _signal(code, o, top - inputs + i, error, eta)


@kernel()
def _change(
    w: Any, v: Any, at: int, o: Any, top: int, units: int, inputs: int, momentum: float
) -> None:
    """Change the weights w[at:] of one layer by the steps g of its units."""
    for unit in range(units):
        g = o[2, top + unit]
        for i in range(inputs):
            m = momentum * v[at]
            source = o[0, top - inputs + i]
            w[at] = fma(g, source, w[at] + m)
            v[at] = fma(g, source, m)
            at += 1
        m = momentum * v[at]
        w[at] = (w[at] + m) + g
        v[at] = m + g
        at += 1


@kernel()
def train(
    layers: Any, w: Any, v: Any, x: Any, y: Any, s: OnlineSettings, record: Any
) -> tuple[int, bool]:
    """Train for up to ``s.epochs`` epochs; weights `w` and last changes `v` are changed in place.

    Args:
        layers: Rows of inputs, units, activation code.
        w: Weights (P,).
        v: Last changes (P,).
        x: Inputs (p, i).
        y: Targets (p, k).
        s: Rates, rule, tolerance, order, length.
        record: Weights after every update (updates, P), or (0, P) to record nothing.

    Returns:
        Epochs done, and whether the tolerance was met before the next one.
    """
    o = np.empty((3, width(layers)))
    order = np.arange(x.shape[0])
    row = 0
    for done in range(s.epochs):
        if s.tolerance > 0.0 and all_within(layers, w, x, y, s.tolerance):
            return done, True
        if s.seed >= 0:
            shuffle(order, s.seed, s.epoch + done)
        for p in order:
            for i in range(x.shape[1]):
                o[0, i] = x[p, i]
            update(layers, w, v, y[p], o, s)
            if row < record.shape[0]:
                record[row] = w
                row += 1
    return s.epochs, False


@kernel()
def train_part(
    layers: Any, w: Any, v: Any, x: Any, y: Any, s: OnlineSettings, first: int, record: Any
) -> None:
    """Train on a part of epoch ``s.epoch``: as many patterns as `record` has rows, from `first` on.

    The weights have the same bits as `train` leaves after those patterns.

    Args:
        layers: Rows of inputs, units, activation code.
        w: Weights (P,), changed.
        v: Last changes (P,), changed.
        x: Inputs (p, i).
        y: Targets (p, k).
        s: Rates, rule, order.
        first: Patterns of this epoch that are done.
        record: Receives the weights after every update (m, P).
    """
    o = np.empty((3, width(layers)))
    order = np.arange(x.shape[0])
    if s.seed >= 0:
        shuffle(order, s.seed, s.epoch)
    for row in range(record.shape[0]):
        p = order[first + row]
        for i in range(x.shape[1]):
            o[0, i] = x[p, i]
        update(layers, w, v, y[p], o, s)
        record[row] = w
