"""The work of a sweep: a block of members, trained in lanes where the network is small enough."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from ..core import F64
from ..kernels import wide
from ..nets import Network, seeded_parameters
from ._online import RULES, SLICE, Training, train
from ._patterns import Patterns
from ._progress import StopReason
from ._sweep_settings import SweepSettings

ROW = np.dtype([("epochs", "<i8"), ("max_error", "<f8"), ("stop", "<i1")])
"""What is kept of a member: epochs done, largest |error| at the end, why it ended."""
Rows: TypeAlias = np.ndarray[Any, Any]

STOPS = {
    wide.TOLERANCE: StopReason.TOLERANCE,
    wide.EPOCHS: StopReason.EPOCHS,
    wide.DIVERGED: StopReason.DIVERGED,
}
"""Why a member ended, by the number in its row."""
_CODES = {reason: code for code, reason in STOPS.items()}
SMALLEST, USUAL, LARGEST = 32, 1024, 4096
"""Members of a block."""
_MANY = 10**5
"""Sweeps with more members have larger blocks: the last members of a block work alone."""
_SHORT, _LONG = 3 * 10**7, 4 * 10**9
"""Changes of single weights in a block: some ten milliseconds, and some two seconds, of work."""


class Brake:
    """Tells the jobs of this process to end; in another process it does nothing."""

    def __init__(self) -> None:
        self._pulled = threading.Event()

    def __reduce__(self) -> Any:
        return Brake, ()

    def pull(self) -> None:
        """End all jobs at their next slice."""
        self._pulled.set()

    def check(self, *_: object) -> None:
        """Raise `KeyboardInterrupt` in a job that shall end."""
        if self._pulled.is_set():
            raise KeyboardInterrupt


class Shared(NamedTuple):
    """What all blocks of a sweep share."""

    patterns: Patterns
    settings: SweepSettings
    brake: Brake


def block_size(settings: SweepSettings, patterns: Patterns) -> int:
    """Members of a block: fewer where each takes long, so that little is lost by a crash."""
    weights = len(settings.network(0).parameters)
    each = max(1, settings.epochs * len(patterns.x) * weights)
    if settings.tolerance > 0.0:
        wanted = USUAL if settings.members <= _MANY else LARGEST
    else:  # all members take as long: short blocks keep every worker busy to the end
        wanted = min(LARGEST, _SHORT // each)
    return max(SMALLEST, min(wanted, _LONG // each))


def sweep_block(shared: Shared, item: tuple[int, int]) -> Rows:
    """Train the members from ``item[0]`` to before ``item[1]``; a row of each."""
    return train_numbers(shared, np.arange(*item))[0]


def train_members(
    patterns: Patterns, settings: SweepSettings, numbers: Sequence[int]
) -> list[Training]:
    """Train some members of a sweep, with the bits that they have in it.

    Args:
        patterns: What they learn.
        settings: The sweep.
        numbers: Which members.

    Returns:
        Their ends, in order; last changes are not kept.
    """
    rows, weights = train_numbers(Shared(patterns, settings, Brake()), np.array(numbers, np.int64))
    out: list[Training] = []
    for number, row, w in zip(numbers, rows, weights, strict=True):
        ended = Training.fresh(settings.network(number).with_parameters(w))
        out.append(
            Training(
                network=ended.network,
                deltas=ended.deltas,
                epoch=int(row["epochs"]),
                updates=int(row["epochs"]) * len(patterns.x),
                stop=STOPS[int(row["stop"])],
            )
        )
    return out


def train_numbers(shared: Shared, numbers: Any) -> tuple[Rows, F64]:
    """Rows and weights (n, P) of the members with these numbers."""
    settings = shared.settings
    weights = seeded_parameters(settings.topology, settings.first_seed + numbers % settings.seeds)
    if wide.fits(weights.shape[1]):
        return _in_lanes(shared, numbers, weights)
    return _one_by_one(shared, numbers, weights)


def _in_lanes(shared: Shared, numbers: Any, weights: F64) -> tuple[Rows, F64]:
    patterns, settings, brake = shared
    shuffled, rule = settings.order == "shuffled", RULES[settings.rule]
    like = settings.network(0)
    kernel = wide.wide_train(like.layer_rows, rule, shuffled)
    members = _members(settings, numbers, weights, shuffled)
    columns = patterns.x.shape[1] + patterns.y.shape[1] if shuffled else 0
    lanes = wide.empty_lanes(weights.shape[1], len(patterns.x), columns)
    slices = max(1, SLICE // max(17, weights.shape[1]))
    scalars = wide.WideSettings(rule, settings.tolerance > 0.0, settings.epochs, slices)
    while not kernel(lanes, members, like.layers, patterns.x, patterns.y, scalars):
        brake.check()
    rows = np.empty(len(numbers), ROW)
    rows["epochs"], rows["max_error"] = members.epoch, members.worst
    rows["stop"] = members.stop
    return rows, members.w


def _members(settings: SweepSettings, numbers: Any, weights: F64, shuffled: bool) -> wide.Members:
    count = len(numbers)
    rates = np.empty((count, 3))
    eta, momentum = np.divmod(numbers // settings.seeds, len(settings.momenta))
    rates[:, 0], rates[:, 1] = np.array(settings.etas)[eta], np.array(settings.momenta)[momentum]
    rates[:, 2] = settings.tolerance
    return wide.Members(
        w=weights,
        rates=rates,
        seed=settings.first_seed + numbers % settings.seeds if shuffled else np.full(count, -1),
        epoch=np.zeros(count, np.int64),
        stop=np.zeros(count, np.int8),
        worst=np.zeros(count),
    )


def _one_by_one(shared: Shared, numbers: Any, weights: F64) -> tuple[Rows, F64]:
    """Networks that are too large for lanes: the serial engine, one after the other."""
    patterns, settings, brake = shared
    rows = np.empty(len(numbers), ROW)
    like = settings.network(0)
    for place, number in enumerate(numbers):
        start: Network = like.with_parameters(weights[place])
        ended = train(start, patterns, settings.online(int(number)), on_step=brake.check)
        if ended.stop is StopReason.INTERRUPTED:
            raise KeyboardInterrupt
        weights[place] = ended.network.parameters
        errors = np.abs(patterns.y - ended.network.forward(patterns.x))
        rows[place] = (ended.epoch, np.max(errors), _CODES[ended.stop or StopReason.EPOCHS])
    return rows, weights
