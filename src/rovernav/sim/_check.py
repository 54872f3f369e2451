"""Whether a sensor keeps its contract: run it over one's own before driving with it."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np

from ..core import (
    F64,
    ContractError,
    Memory,
    Mission,
    RoverState,
    Sensor,
    check_steps,
    map_arrays,
    unchanged,
)
from ._world import Worlds

Place = Callable[[int, np.random.Generator], tuple[Worlds, Mission, RoverState]]
"""Puts n rovers somewhere: their worlds, missions and states."""


def check_sensor(
    sensor: Any, place: Place, *, rovers: int = 5, steps: int = 3, seed: int = 0
) -> None:
    """Check that a sensor keeps the contract of its role.

    Readings are float64 (n, b). The same seed and memory give the same readings: nothing is kept
    inside. A rover reads the same bits alone as in a batch, whatever the batch's order. Nothing
    that the sensor is given changes.

    Args:
        sensor: What to check.
        place: Makes a place to read at.
        rovers: Rovers in the batch.
        steps: Readings one after the other; the rovers move in between.
        seed: Seed of everything random.

    Raises:
        ContractError: It does not keep it; the sentence says which part.
    """
    if not isinstance(sensor, Sensor):
        raise ContractError(f"{sensor!r} is no sensor: it needs a name, start and read")
    called = f"sensor {sensor.name!r}"
    rng = np.random.default_rng(seed)
    worlds, mission, state = place(rovers, rng)
    states = [_moved(state, rng) for _ in range(steps)]

    def start(part: Any) -> Memory:
        few = _rows(mission, part)
        with unchanged(few, called=called):
            return sensor.start(few, np.random.default_rng(seed))

    def step(number: int, part: Any, memory: Memory) -> tuple[F64, Memory]:
        some = dataclasses.replace(worlds, of=worlds.of[part])
        few = _rows(states[number], part)
        with unchanged((some, few), called=called):
            reading, after = sensor.read(some, few, memory)
        _check_reading(reading, len(part), called)
        return reading, after

    check_steps(start, step, rovers=rovers, steps=steps, called=called)


def _check_reading(reading: Any, n: int, called: str) -> None:
    good = isinstance(reading, np.ndarray) and reading.ndim == 2 and len(reading) == n
    if not (good and reading.dtype == np.float64):
        got = f"{getattr(reading, 'dtype', type(reading).__name__)} {np.shape(reading)}"
        raise ContractError(f"{called}: a reading must be float64 ({n}, b), got {got}")


def _moved(state: RoverState, rng: np.random.Generator) -> RoverState:
    return dataclasses.replace(state, pose=state.pose + rng.normal(0.0, 0.3, state.pose.shape))


def _rows(item: Any, part: Any) -> Any:
    return map_arrays(item, lambda array: array[part])
