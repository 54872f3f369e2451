"""Whether a sensor keeps its contract: run it over one's own before driving with it."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np

from ..core import (
    F64,
    ContractError,
    Frame,
    Memory,
    Mission,
    RoverState,
    Sensor,
    check_steps,
    map_arrays,
    unchanged,
)
from ._shapes import Shape
from ._world import Grid, Ground, Rocks, Worlds

Place = Callable[[int, np.random.Generator], tuple[Worlds, Mission, RoverState]]
"""Puts n rovers somewhere: their worlds, missions and states."""


def check_sensor(
    sensor: Any, place: Place | None = None, *, rovers: int = 5, steps: int = 3, seed: int = 0
) -> None:
    """Check that a sensor keeps the contract of its role.

    Readings are float64 (n, b). The same seed and memory give the same readings: nothing is kept
    inside. A rover reads the same bits alone as in a batch, whatever the batch's order. Nothing
    that the sensor is given changes.

    Args:
        sensor: What to check.
        place: Makes a place to read at; gentle hills with boxes, discs and rocks where not given.
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
    worlds, mission, state = (place or somewhere)(rovers, rng)
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


def somewhere(n: int, rng: np.random.Generator) -> tuple[Worlds, Mission, RoverState]:
    """Rovers in a world of 20 m with hills, a box, a disc, rocks and forbidden cells."""
    frame = Frame(cell=0.5, shape=(40, 40))
    row, column = np.mgrid[:40, :40] / 6.0
    height = (0.4 * np.sin(row + rng.uniform(0, 6)) * np.cos(column)).astype(np.float32)
    blocked = (rng.random((40, 40)) < 0.02).astype(np.uint8)
    x, y = rng.uniform(3.0, 15.0, 2).tolist()
    worlds = dataclasses.replace(
        Worlds.single(
            [(x, y, x + 2.0, y + 1.0)], grid=Grid(frame=frame, blocked=blocked), rovers=n,
            shapes=[Shape.disc(float(rng.uniform(2, 18)), float(rng.uniform(2, 18)), 0.8)],
            ground=Ground(frame=frame, height=height),
        ),
        rocks=Rocks(
            place=np.column_stack([rng.uniform(1.0, 19.0, (8, 2)), np.full((8, 2), 0.3)]),
            offsets=np.array([0, 8]),
        ),
    )  # fmt: skip
    mission = Mission(
        start=rng.uniform((1.0, 1.0, -3.0), (19.0, 19.0, 3.0), (n, 3)),
        goal=rng.uniform(1.0, 19.0, (n, 2)), goal_radius=0.1, time_limit=9.0,
    )  # fmt: skip
    return worlds, mission, RoverState.at_start(mission)


def _check_reading(reading: Any, n: int, called: str) -> None:
    good = isinstance(reading, np.ndarray) and reading.ndim == 2 and len(reading) == n
    if not (good and reading.dtype == np.float64):
        got = f"{getattr(reading, 'dtype', type(reading).__name__)} {np.shape(reading)}"
        raise ContractError(f"{called}: a reading must be float64 ({n}, b), got {got}")


def _moved(state: RoverState, rng: np.random.Generator) -> RoverState:
    return dataclasses.replace(state, pose=state.pose + rng.normal(0.0, 0.3, state.pose.shape))


def _rows(item: Any, part: Any) -> Any:
    return map_arrays(item, lambda array: array[part])
