"""Many trainings of one topology at once: a network in each lane of a vector.

The source of the kernel is generated as in `frozen`, of the same statements; its variables are
`lanes` of many numbers instead of single ones, so that each network ends with the bits that it has
alone. A network that has ended makes room for the next one of the block, so that none waits.

Symbols: w weights and v last changes of all lanes, one row per weight; `state` holds w, v, then
both again as they are after the slice at hand, then eta, momentum and tolerance.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

from . import backprop
from ._jit import OPTIONS, cached, kernel
from .frozen import ARITHMETIC, MAX_WEIGHTS, Layers, forward, update, written
from .lanes import LANES
from .network import forward_row, width

WAITING, TOLERANCE, EPOCHS, DIVERGED = 0, 1, 2, 3
"""What became of a member; the last three are the ends of a training."""
_SLICE = 256
"""Updates of a lane between two looks at whether its weights are still finite."""


class Members(NamedTuple):
    """The networks of a block.

    Attributes:
        w: Weights (m, P), changed in place.
        rates: Eta, momentum and tolerance of each (m, 3).
        seed: Seed of its shuffled order (m,); negative keeps the table's order.
        epoch: Epochs that it did (m,), written.
        stop: Why it ended (m,), written.
        worst: Its largest |error| at the end (m,), written.
    """

    w: Any
    rates: Any
    seed: Any
    epoch: Any
    stop: Any
    worst: Any


class Lanes(NamedTuple):
    """What stands in the lanes between two calls.

    Attributes:
        state: All numbers (4 P + 3, LANES).
        member: Which member (LANES,); -1 is none.
        epoch: Epochs that it has done (LANES,).
        following: The member that comes next (1,).
        table: The patterns in the order of each lane (p (i + o), LANES); empty where all have the
            table's own.
        order: Room for one order (p,).
    """

    state: Any
    member: Any
    epoch: Any
    following: Any
    table: Any
    order: Any


class WideSettings(NamedTuple):
    """Scalars of a call.

    Attributes:
        rule: TEXTBOOK or PAPER.
        evaluates: Whether any member has a tolerance.
        epochs: Epochs of each member at most.
        updates: Updates of a lane after which the call returns.
    """

    rule: int
    evaluates: bool
    epochs: int
    updates: int


@functools.cache
def wide_train(layers: Layers, rule: int, shuffled: bool) -> Callable[..., bool]:
    """The compiled kernel for these layers, this rule, and orders of their own or the table's.

    It is called as ``train(lanes, members, layers, x, y, settings)``, changes lanes and members,
    and returns whether every member has ended. Call it again until it has.
    """
    shape = "x".join(f"{i}_{u}_{code}" for i, u, code in layers)
    name = f"wide_{shape}_{rule}{'_shuffled' if shuffled else ''}"
    module = written(name, "\n".join(_module(layers, rule, shuffled)) + "\n")
    module.advance = cached(module.advance, OPTIONS)
    return cached(module.train, OPTIONS)


def fits(weights: int) -> bool:
    """Whether networks of that many weights are trained in lanes."""
    return weights <= MAX_WEIGHTS


def empty_lanes(weights: int, patterns: int, columns: int) -> Lanes:
    """Lanes with nothing in them.

    Args:
        weights: Weights of a network.
        patterns: Rows of the pattern table.
        columns: Its inputs and targets if each member has an order of its own, otherwise 0.
    """
    return Lanes(
        state=np.zeros((4 * weights + 3, LANES)),
        member=np.full(LANES, -1),
        epoch=np.zeros(LANES, np.int64),
        following=np.zeros(1, np.int64),
        table=np.zeros((patterns * columns, LANES)),
        order=np.zeros(patterns, np.int64),
    )


@kernel()
def mix(lanes: Lanes, members: Members, x: Any, y: Any, done: int) -> None:
    """Write the patterns in the order that each lane has `done` epochs after its present one."""
    columns = x.shape[1] + y.shape[1]
    for lane in range(lanes.member.size):
        member = lanes.member[lane]
        if member < 0:
            continue
        backprop.shuffle(lanes.order, members.seed[member], lanes.epoch[lane] + done)
        at = 0
        for p in lanes.order:
            for i in range(x.shape[1]):
                lanes.table[at + i, lane] = x[p, i]
            for k in range(y.shape[1]):
                lanes.table[at + x.shape[1] + k, lane] = y[p, k]
            at += columns


@kernel()
def epochs_left(lanes: Lanes, members: Members, patterns: int, epochs: int) -> int:
    """Fill empty lanes; epochs that all lanes can do together, or -1 if all are done."""
    left, busy = max(1, _SLICE // patterns), False
    for lane in range(lanes.member.size):
        if lanes.member[lane] < 0 and lanes.following[0] < members.w.shape[0]:
            _fill(lanes, members, lane)
        if lanes.member[lane] >= 0:
            busy = True
            left = min(left, epochs - lanes.epoch[lane])
    return left if busy else -1


@kernel()
def _fill(lanes: Lanes, members: Members, lane: int) -> None:
    member = lanes.following[0]
    lanes.following[0] += 1
    lanes.member[lane], lanes.epoch[lane] = member, 0
    weights = members.w.shape[1]
    for q in range(weights):
        lanes.state[q, lane] = members.w[member, q]
        lanes.state[weights + q, lane] = 0.0
    for n in range(3):
        lanes.state[4 * weights + n, lane] = members.rates[member, n]


@kernel()
def settle(
    lanes: Lanes,
    members: Members,
    layers: Any,
    x: Any,
    y: Any,
    s: WideSettings,
    done: int,
    met: int,
) -> None:
    """Take over what a slice of `done` epochs has given; write down the members that have ended.

    Bit number lane of `met` is set where the tolerance was met after it.
    """
    weights = members.w.shape[1]
    for lane in range(lanes.member.size):
        if lanes.member[lane] >= 0 and not _finite(lanes.state, 2 * weights, weights, lane):
            _diverge(lanes, members, layers, x, y, s, lane)
    for q in range(2 * weights):
        for lane in range(lanes.member.size):
            lanes.state[q, lane] = lanes.state[2 * weights + q, lane]
    for lane in range(lanes.member.size):
        member = lanes.member[lane]
        if member < 0:
            continue
        lanes.epoch[lane] += done
        if (met >> lane) & 1:
            members.stop[member] = TOLERANCE
        elif lanes.epoch[lane] >= s.epochs:
            members.stop[member] = EPOCHS
        else:
            continue
        for q in range(weights):
            members.w[member, q] = lanes.state[q, lane]
        _end(lanes, members, layers, x, y, lane)


@kernel()
def _finite(state: Any, start: int, count: int, lane: int) -> bool:
    zero = 0.0
    for q in range(start, start + count):
        zero += state[q, lane] - state[q, lane]  # NaN for infinity and NaN
    return zero == 0.0


@kernel()
def _diverge(
    lanes: Lanes, members: Members, layers: Any, x: Any, y: Any, s: WideSettings, lane: int
) -> None:
    """Find the last epoch of the slice with finite weights, one by one from the slice's begin."""
    weights, member = members.w.shape[1], lanes.member[lane]
    w, v = np.empty(weights), np.empty(weights)
    for q in range(weights):
        w[q], v[q] = lanes.state[q, lane], lanes.state[weights + q, lane]
    record = np.empty((0, weights))
    while np.isfinite(w).all():
        members.w[member] = w
        settings = backprop.OnlineSettings(
            members.rates[member, 0], members.rates[member, 1], s.rule, 0.0,
            members.seed[member], lanes.epoch[lane], 1,
        )  # fmt: skip
        backprop.train(layers, w, v, x, y, settings, record)
        lanes.epoch[lane] += 1
    lanes.epoch[lane] -= 1
    members.stop[member] = DIVERGED
    _end(lanes, members, layers, x, y, lane)


@kernel()
def _end(lanes: Lanes, members: Members, layers: Any, x: Any, y: Any, lane: int) -> None:
    """Write down epochs and error of the member in the lane, and empty it."""
    member = lanes.member[lane]
    members.epoch[member] = lanes.epoch[lane]
    members.worst[member] = _worst(layers, members.w[member], x, y)
    lanes.member[lane] = -1
    for row in range(lanes.state.shape[0]):
        lanes.state[row, lane] = 0.0


@kernel()
def _worst(layers: Any, w: Any, x: Any, y: Any) -> float:
    """Largest |error| of any output of any pattern; NaN if one is."""
    o, worst = np.empty(width(layers)), 0.0
    for p in range(x.shape[0]):
        for i in range(x.shape[1]):
            o[i] = x[p, i]
        top = forward_row(layers, w, o)
        for k in range(y.shape[1]):
            error = abs(y[p, k] - o[top + k])
            if error > worst or np.isnan(error):
                worst = error
    return worst


def _module(layers: Layers, rule: int, shuffled: bool) -> Iterator[str]:
    weights = sum(units * (inputs + 1) for inputs, units, _ in layers)
    yield ARITHMETIC
    yield "from rovernav.kernels.lanes import load, store, within"
    yield "from rovernav.kernels.wide import epochs_left, mix, settle"
    yield ""
    yield "def advance(lanes, members, x, y, s, epochs):"
    yield "    state, patterns, hard, met, done = lanes.state, x.shape[0], 0, 0, 0"
    for q in range(weights):
        yield f"    w{q} = load(state, {q}); v{q} = load(state, {weights + q})"
    yield f"    eta = load(state, {4 * weights}); mu = load(state, {4 * weights + 1})"
    yield f"    tolerance = load(state, {4 * weights + 2})"
    yield "    while done < epochs:"
    yield "        if s.evaluates:"
    yield from ("            " + line for line in _evaluation(layers))
    if shuffled:
        yield "        mix(lanes, members, x, y, done)"
    yield "        for p in range(patterns):"
    yield from ("            " + line for line in _update(layers, rule, shuffled))
    yield "        done += 1"
    for q in range(weights):
        yield f"    store(state, {2 * weights + q}, w{q}); store(state, {3 * weights + q}, v{q})"
    yield "    return done, met"
    yield ""
    yield "def train(lanes, members, layers, x, y, s):"
    yield "    updates = 0"
    yield "    while updates < s.updates:"
    yield "        epochs = epochs_left(lanes, members, x.shape[0], s.epochs)"
    yield "        if epochs < 0:"
    yield "            return True"
    yield "        done, met = advance(lanes, members, x, y, s, epochs)"
    yield "        settle(lanes, members, layers, x, y, s, done, met)"
    yield "        updates += (done + 1) * x.shape[0]"
    yield "    return False"


def _evaluation(layers: Layers) -> Iterator[str]:
    """Which lanes meet their tolerance: a pattern that all missed last is asked first."""
    yield f"met = {2**LANES - 1}"
    yield "for n in range(patterns):"
    yield "    p = hard + n if hard + n < patterns else hard + n - patterns"
    yield from ("    " + line for line in forward(layers))
    last = len(layers) - 1
    for k in range(layers[last][1]):
        yield f"    met &= within(y[p, {k}] - o{last}_{k}, tolerance)"
    yield "    if met == 0:"
    yield "        hard = p"
    yield "        break"
    yield "if met != 0:"
    yield "    break"


def _update(layers: Layers, rule: int, shuffled: bool) -> Iterator[str]:
    if not shuffled:
        yield from update(layers, rule)
        return
    inputs, outputs = layers[0][0], layers[-1][1]
    yield f"at = p * {inputs + outputs}"
    yield from update(
        layers, rule, "load(lanes.table, at + {i})", f"load(lanes.table, at + {inputs} + {{k}})"
    )
