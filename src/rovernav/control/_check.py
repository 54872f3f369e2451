"""Whether a controller keeps its contract: run it over one's own before driving with it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..core import (
    F64,
    ContractError,
    Controller,
    Memory,
    Mission,
    Observation,
    check_steps,
    map_arrays,
    unchanged,
)
from ..mapping import LocalMapper
from ..sim import RangeFan

Observe = Callable[[int, np.random.Generator], Observation]
"""Makes up what n rovers see."""


def check_controller(
    controller: Any,
    observe: Observe | None = None,
    *,
    rovers: int = 5,
    steps: int = 3,
    seed: int = 0,
) -> None:
    """Check that a controller keeps the contract of its role.

    Commands are finite float64 twists (n, 3). The same seed and memory give the same commands:
    nothing is kept inside. A rover gets the same bits alone as in a batch, whatever the batch's
    order. Nothing that the controller is given changes.

    Args:
        controller: What to check.
        observe: Makes up observations with the channels that the controller needs; where not
            given, what a range fan, the paper's two sensors and a local map might say.
        rovers: Rovers in the batch.
        steps: Observations one after the other.
        seed: Seed of everything random.

    Raises:
        ContractError: It does not keep it; the sentence says which part.
    """
    called = f"controller {type(controller).__name__}"
    if not isinstance(controller, Controller):
        raise ContractError(f"{called} is no controller: it needs start and act")
    rng = np.random.default_rng(seed)
    mission = Mission(
        start=rng.uniform(-3.0, 3.0, (rovers, 3)),
        goal=rng.uniform(-9.0, 9.0, (rovers, 2)),
        goal_radius=0.1,
        time_limit=100.0,
    )
    seen = [(observe or anything)(rovers, rng) for _ in range(steps)]

    def start(part: Any) -> Memory:
        few = _rows(mission, part)
        with unchanged(few, called=called):
            return controller.start(few, np.random.default_rng(seed))

    def step(number: int, part: Any, memory: Memory) -> tuple[F64, Memory]:
        few = _rows(seen[number], part)
        with unchanged(few, called=called):
            command, after = controller.act(few, memory)
        _check_twist(command.twist, len(part), called)
        return command.twist, after

    check_steps(start, step, rovers=rovers, steps=steps, called=called)


def anything(n: int, rng: np.random.Generator) -> Observation:
    """What n rovers might see: beams that met something or nothing, and the local map of them."""
    fan = RangeFan(reach=6.0)
    pose = rng.uniform((0.0, 0.0, -3.0), (30.0, 30.0, 3.0), (n, 3))
    goal = rng.uniform(0.0, 30.0, (n, 2))
    mission = Mission(start=pose, goal=goal, goal_radius=0.1, time_limit=9.0)
    mapper = LocalMapper(fan.angles, reach=fan.reach)
    beams = np.minimum(rng.uniform(0.3, 9.0, (n, len(fan.angles))), fan.reach)
    more, local = mapper.update(mapper.start(mission), pose, goal, {"beams": beams})
    bits = {name: rng.integers(0, 2, (n, 1)).astype(np.float64) for name in _BITS}
    return Observation(
        goal=rng.normal(0.0, 9.0, (n, 2)), twist=rng.normal(0.0, 0.2, (n, 3)),
        channels={"beams": beams, **bits, **more}, map=local, pose=pose,
    )  # fmt: skip


_BITS = ("clear_sight", "off_line")


def _check_twist(twist: Any, n: int, called: str) -> None:
    if not (isinstance(twist, np.ndarray) and twist.shape == (n, 3) and twist.dtype == np.float64):
        got = f"{getattr(twist, 'dtype', type(twist).__name__)} {np.shape(twist)}"
        raise ContractError(f"{called}: a command's twist must be float64 ({n}, 3), got {got}")
    if not np.isfinite(twist).all():
        raise ContractError(f"{called}: a command is not finite")


def _rows(item: Any, part: Any) -> Any:
    return map_arrays(item, lambda array: array[part])
