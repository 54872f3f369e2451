"""Whether a metric keeps its contract: run it over one's own before judging with it."""

from __future__ import annotations

import dataclasses
from typing import Any, final

import numpy as np

from ..core import Command, ContractError, Metric, Mission, Observation, map_arrays, unchanged
from ._check import somewhere
from ._motion import DifferentialDrive
from ._simulate import simulate
from ._tick import Drive
from ._trace import Trace
from ._world import Worlds


def check_metric(metric: Any, drives: tuple[Trace, Worlds] | None = None) -> None:
    """Check that a metric keeps the contract of its role.

    It gives float64 values (n,) and bool marks (n,) of which of them mean something; those are
    finite. The same trace gives the same values, a rover's value is the same alone as in a batch,
    and nothing that the metric is given changes. Traces that keep only the ends give an answer too,
    if only that nothing means anything.

    Args:
        metric: What to check.
        drives: A trace with its worlds; six drives over hills, around obstacles, where not given.

    Raises:
        ContractError: It does not keep it; the sentence says which part.
    """
    if not isinstance(metric, Metric):
        raise ContractError(f"{metric!r} is no metric: it needs a name, a unit and compute")
    called = f"metric {metric.name!r}"
    trace, worlds = drives or _driven()
    whole = _computed(metric, trace, worlds, called)
    if _bits(_computed(metric, trace, worlds, called)) != _bits(whole):
        raise ContractError(f"{called}: the same trace gives another value the next time")
    for k in range(len(trace.outcome)):
        alone = _computed(metric, _row(trace, k), worlds.row(k), called)
        if _bits(alone) != _bits((whole[0][k : k + 1], whole[1][k : k + 1])):
            raise ContractError(f"{called}: rover {k} alone gets another value than in a batch")
    _computed(metric, _ends(trace), worlds, called)


def _computed(metric: Metric, trace: Trace, worlds: Worlds, called: str) -> tuple[Any, Any]:
    n = len(trace.outcome)
    with unchanged((trace, worlds), called=called):
        given: Any = metric.compute(trace, worlds)
    if not (isinstance(given, tuple) and len(given) == 2):
        raise ContractError(f"{called}: compute must give values and which of them are valid")
    for array, dtype, what in zip(given, (np.float64, np.bool_), ("values", "marks"), strict=True):
        if not (isinstance(array, np.ndarray) and array.shape == (n,) and array.dtype == dtype):
            got = f"{getattr(array, 'dtype', type(array).__name__)} {np.shape(array)}"
            raise ContractError(f"{called}: {what} must be {np.dtype(dtype)} ({n},), got {got}")
    values, valid = given
    if not np.isfinite(values[valid]).all():
        raise ContractError(f"{called}: a value that is marked as valid is not finite")
    return values, valid


def _bits(found: tuple[Any, Any]) -> tuple[bytes, bytes]:
    """Values that mean something, and the marks."""
    values, valid = found
    return values[valid].tobytes(), valid.tobytes()


def _row(trace: Trace, k: int) -> Trace:
    """The trace of rover k alone."""
    mission = map_arrays(trace.mission, lambda array: array[k : k + 1])
    return dataclasses.replace(
        trace,
        mission=mission,
        channels={name: reading[:, k : k + 1] for name, reading in trace.channels.items()},
        **{name: getattr(trace, name)[:, k : k + 1] for name in ("time", "pose", "commands")},
        **{name: getattr(trace, name)[k : k + 1] for name in ("outcome", "steps", "length")},
        **{
            name: array[:, k : k + 1]
            for name in ("attitude", "slip", "energy")
            if (array := getattr(trace, name)) is not None
        },
    )


def _ends(trace: Trace) -> Trace:
    """The same drives, recorded with their ends alone."""
    last = {name: getattr(trace, name)[-1:] for name in ("time", "pose")}
    return dataclasses.replace(trace, channels={}, commands=trace.commands[:0], **last)


@final
class _Turning:
    """Drives each rover along an arc of its own."""

    def start(self, mission: Mission, rng: np.random.Generator) -> Any:
        return rng.uniform((0.1, 0.0, -0.3), (0.5, 0.0, 0.3), (len(mission.start), 3))

    def act(self, observation: Observation, memory: Any) -> tuple[Command, Any]:
        return Command(twist=memory), memory


def _driven() -> tuple[Trace, Worlds]:
    worlds, mission, _ = somewhere(6, np.random.default_rng(5))
    near = mission.goal.copy()
    near[0] = mission.start[0, :2]  # one is there already
    drive = Drive(
        worlds=worlds, mission=dataclasses.replace(mission, goal=near), sensors=(),
        controller=_Turning(), motion=DifferentialDrive(speed=0.5, turn_rate=0.5, period=0.5),
    )  # fmt: skip
    return simulate(drive, seed=1), worlds
