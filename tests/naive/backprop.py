"""Bassil's listing in plain Python, for any layers: one matrix each, rows = units, bias last."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import Any

from tests.naive import arithmetic
from tests.naive.arithmetic import fma

Matrix = list[list[Any]]
SLOPES = {
    "sigmoid": lambda o: o * (1.0 - o),
    "tanh": lambda o: fma(-o, o, 1.0),
    "relu": lambda o: 1.0 if o > 0 else 0.0,
    "linear": lambda o: 1.0,
}
WORD = 2**64


def forward(matrices: list[Matrix], activations: Sequence[str], x: Sequence[Any]) -> list[Any]:
    """Outputs of each layer, the inputs first."""
    outs: list[Any] = [list(x)]
    for matrix, name in zip(matrices, activations, strict=True):
        sums: list[Any] = []
        for *weights, s in matrix:
            for w, o in zip(weights, outs[-1], strict=True):
                s = fma(w, o, s)
            sums.append(s)
        outs.append([getattr(arithmetic, name)(s) for s in sums])
    return outs


def update(matrices: list[Matrix], deltas: list[Matrix], activations: Sequence[str],
           x: Any, y: Any, rates: dict[str, Any]) -> None:  # fmt: skip
    """One pattern: change the matrices and the last changes of their weights."""
    eta, momentum, rule = rates["eta"], rates["momentum"], rates["rule"]
    outs = forward(matrices, activations, x)
    errors = [target - o for target, o in zip(y, outs[-1], strict=True)]
    for layer in reversed(range(len(matrices))):
        rises = [SLOPES[activations[layer]](o) for o in outs[layer + 1]]
        d = [rise * error for rise, error in zip(rises, errors, strict=True)]
        g = [(eta * rise) * error for rise, error in zip(rises, errors, strict=True)]
        old = copy.deepcopy(matrices[layer])
        for unit, (weights, last) in enumerate(zip(matrices[layer], deltas[layer], strict=True)):
            for j, source in enumerate([*outs[layer], 1.0]):
                m = momentum * last[j]
                weights[j] = fma(g[unit], source, weights[j] + m)
                last[j] = fma(g[unit], source, m)
        above = old if rule == "textbook" else matrices[layer]
        errors = [d[0] * w for w in above[0][:-1]]
        for k in range(1, len(above)):
            errors = [fma(d[k], w, e) for w, e in zip(above[k][:-1], errors, strict=True)]


def order(count: int, seed: int | None, epoch: int) -> list[int]:
    """Order of the patterns in an epoch: the table's, or Fisher and Yates over splitmix64."""
    places = list(range(count))
    if seed is None:
        return places
    state = (seed * 0x9E3779B97F4A7C15 + epoch) % WORD
    state = (state ^ state >> 31) * 0xD1342543DE82EF95 % WORD
    for i in range(count - 1, 0, -1):
        state = (state + 0x9E3779B97F4A7C15) % WORD
        z = (state ^ state >> 30) * 0xBF58476D1CE4E5B9 % WORD
        z = (z ^ z >> 27) * 0x94D049BB133111EB % WORD
        j = (z ^ z >> 31) % (i + 1)
        places[i], places[j] = places[j], places[i]
    return places


def train(matrices: list[Matrix], deltas: list[Matrix], activations: Sequence[str],
          x: Any, y: Any, rates: dict[str, Any]) -> int:  # fmt: skip
    """Train in place until every error is below the tolerance; the number of epochs done."""
    for done in range(rates["epochs"]):
        ends = [forward(matrices, activations, row)[-1] for row in x]
        if max(abs(y - ends).flat) < rates["tolerance"]:
            return done
        for p in order(len(x), rates["seed"], done):
            update(matrices, deltas, activations, x[p], y[p], rates)
    return rates["epochs"]
