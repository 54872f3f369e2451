"""Back-propagation of a batch and its optimisers in plain Python: loops, math.exp, no arrays.

A network is one matrix per layer, a list of rows; a row is a unit's weights, its bias last.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

Matrix = list[list[float]]

ACTIVATIONS: dict[str, Callable[[float], float]] = {
    "linear": lambda s: s,
    "sigmoid": lambda s: 1 / (1 + math.exp(-s)),
    "tanh": math.tanh,
    "relu": lambda s: max(s, 0.0),
}
SLOPES: dict[str, Callable[[float], float]] = {
    "linear": lambda s: 1.0,
    "sigmoid": lambda s: math.exp(-s) / (1 + math.exp(-s)) ** 2,
    "tanh": lambda s: 1 / math.cosh(s) ** 2,
    "relu": lambda s: 1.0 if s > 0 else 0.0,
}


def loss(kind: str, z: Sequence[float], y: Sequence[float]) -> float:
    """The loss of one row."""
    if kind == "mse":
        return sum((a - b) ** 2 for a, b in zip(z, y, strict=True)) / 2
    if kind == "softmax":
        mass = sum(math.exp(a) for a in z)
        return -sum(b * math.log(math.exp(a) / mass) for a, b in zip(z, y, strict=True))
    chances = [1 / (1 + math.exp(-a)) for a in z]
    return -sum(
        b * math.log(p) + (1 - b) * math.log(1 - p) for p, b in zip(chances, y, strict=True)
    )


def slope_of_loss(kind: str, z: Sequence[float], y: Sequence[float]) -> list[float]:
    """The derivative of `loss` by each output."""
    if kind == "mse":
        return [a - b for a, b in zip(z, y, strict=True)]
    if kind == "softmax":
        mass = sum(math.exp(a) for a in z)
        return [sum(y) * math.exp(a) / mass - b for a, b in zip(z, y, strict=True)]
    return [1 / (1 + math.exp(-a)) - b for a, b in zip(z, y, strict=True)]


def mean_gradient(
    matrices: list[Matrix], names: Sequence[str], x: Matrix, y: Matrix, kind: str
) -> tuple[float, list[Matrix]]:
    """Mean loss of the rows, and its derivative by every weight."""
    total = 0.0
    change = [[[0.0] * len(row) for row in matrix] for matrix in matrices]
    for one, wanted in zip(x, y, strict=True):
        total += _add_row(matrices, names, one, wanted, kind, change)
    count = len(x)
    return total / count, [[[g / count for g in row] for row in matrix] for matrix in change]


def sharded_gradient(
    matrices: list[Matrix], names: Sequence[str], x: Matrix, y: Matrix, kind: str, shards: int
) -> tuple[float, list[Matrix]]:
    """The same from shards: each summed by itself, then the sums added in their order."""
    count = len(x)
    total, change = 0.0, [[[0.0] * len(row) for row in matrix] for matrix in matrices]
    for shard in range(shards):
        first, last = count * shard // shards, count * (shard + 1) // shards
        if first == last:
            continue
        mean, part = mean_gradient(matrices, names, x[first:last], y[first:last], kind)
        share = (last - first) / count
        total += share * mean
        for mine, more in zip(change, part, strict=True):
            for row, added in zip(mine, more, strict=True):
                for k, g in enumerate(added):
                    row[k] += share * g
    return total, change


def _add_row(matrices, names, one, wanted, kind, change) -> float:
    outs, sums = [list(one)], []
    for matrix, name in zip(matrices, names, strict=True):
        source = [*outs[-1], 1.0]
        sums.append([sum(w * o for w, o in zip(row, source, strict=True)) for row in matrix])
        outs.append([ACTIVATIONS[name](s) for s in sums[-1]])
    back = slope_of_loss(kind, outs[-1], wanted)
    for layer in reversed(range(len(matrices))):
        signals = [b * SLOPES[names[layer]](s) for b, s in zip(back, sums[layer], strict=True)]
        for unit, d in enumerate(signals):
            for j, o in enumerate([*outs[layer], 1.0]):
                change[layer][unit][j] += d * o
        back = [
            sum(d * row[j] for d, row in zip(signals, matrices[layer], strict=True))
            for j in range(len(outs[layer]))
        ]
    return loss(kind, outs[-1], wanted)


def sgd(w: list[float], v: list[float], g: Sequence[float], eta: float, momentum: float) -> None:
    """One step with momentum, in place: v is each weight's last change."""
    for k in range(len(w)):
        v[k] = momentum * v[k] - eta * g[k]
        w[k] += v[k]


def adam(w: list[float], moments: Matrix, g: Sequence[float], eta: float, t: int) -> None:
    """Step t = 1, 2, ... of Kingma and Ba's algorithm 1, in place."""
    m, v = moments
    for k in range(len(w)):
        m[k] = 0.9 * m[k] + 0.1 * g[k]
        v[k] = 0.999 * v[k] + 0.001 * g[k] ** 2
        w[k] -= eta * (m[k] / (1 - 0.9**t)) / (math.sqrt(v[k] / (1 - 0.999**t)) + 1e-8)
