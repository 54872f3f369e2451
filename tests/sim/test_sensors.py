"""Our sensors keep their contract, and the checker notices those that do not."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from rovernav.core import ContractError, Frame, Mission, RoverState, Sensor
from rovernav.sim import ClearSight, Grid, OffLine, RangeFan, Worlds, check_sensor


def place(n: int, rng: np.random.Generator) -> tuple[Worlds, Mission, RoverState]:
    """Rovers among their own boxes on common ground."""
    corner = rng.uniform(1, 8, (n, 2))
    blocked = (rng.random((20, 20)) < 0.03).astype(np.uint8)
    worlds = dataclasses.replace(
        Worlds.one_box_each(np.concatenate([corner, corner + 1], axis=1), bounds=(0, 0, 10, 10)),
        grid=Grid(frame=Frame(cell=0.5, shape=(20, 20)), blocked=blocked),
    )
    start = rng.uniform((0, 0, -3), (10, 10, 3), (n, 3))
    goal = rng.uniform(0, 10, (n, 2))
    mission = Mission(start=start, goal=goal, goal_radius=0.1, time_limit=9.0)
    return worlds, mission, RoverState.at_start(mission)


@pytest.mark.parametrize(
    "sensor", [ClearSight(), OffLine(0.5), RangeFan(reach=4.0, beams=9)], ids=lambda s: s.name
)
def test_our_sensors_keep_their_contract(sensor: Sensor) -> None:
    check_sensor(sensor, place)
    check_sensor(sensor, place, rovers=1, steps=1, seed=3)


def test_readings_are_of_ones_own_world_mission_and_place() -> None:
    worlds = Worlds.one_box_each(np.array([[4.0, -1, 5, 1], [4, 2, 5, 3]]), bounds=(-9, -9, 9, 9))
    mission = Mission(
        start=np.array([[0.0, 0, 1], [0, -2, 1]]),
        goal=np.array([[9.0, 0], [9, -2]]),
        goal_radius=0.1,
        time_limit=9.0,
    )
    state = RoverState.at_start(mission)
    state = dataclasses.replace(state, pose=np.array([[1.0, 0.5, 2], [1.0, -0.5, 2]]))
    rng = np.random.default_rng(0)
    for sensor, expected in ((ClearSight(), [[0.0], [1.0]]), (OffLine(1.0), [[0.0], [1.0]])):
        reading, _ = sensor.read(worlds, state, sensor.start(mission, rng))
        assert_array_equal(reading, expected)


@dataclasses.dataclass
class Broken:
    """A sensor with one fault."""

    fault: Callable[[Broken, np.ndarray, Any], Any]
    name: str = "broken"
    count: Any = dataclasses.field(default_factory=itertools.count)
    seen: float = 0.0

    def start(self, mission: Mission, rng: np.random.Generator) -> Any:
        self.seen = 0.0
        return {"rng": rng, "steps": [0]}

    def read(self, world: Worlds, state: RoverState, memory: Any) -> tuple[Any, Any]:
        return self.fault(self, state.pose, memory), memory


def writes(_: Broken, pose: np.ndarray, memory: Any) -> np.ndarray:
    pose[:, 0] = 7.0
    return pose


def writes_by_force(_: Broken, pose: np.ndarray, memory: Any) -> np.ndarray:
    base = pose if pose.base is None else pose.base
    base.flags.writeable = True
    base += 1.0
    return np.zeros((len(pose), 1))


def remembers(sensor: Broken, pose: np.ndarray, memory: Any) -> np.ndarray:
    sensor.seen = max(sensor.seen, float(abs(pose).max()))
    return np.full((len(pose), 1), sensor.seen)


def counts(_: Broken, pose: np.ndarray, memory: Any) -> np.ndarray:
    memory["steps"][0] += 1
    return np.full((len(pose), 1), float(memory["steps"][0]))


FAULTS = [
    (lambda s, pose, m: np.zeros((len(pose) + 1, 2)), "a reading must be float64 (5, b), got"),
    (lambda s, pose, m: np.zeros(len(pose)), "a reading must be float64 (5, b), got float64 (5,)"),
    (lambda s, pose, m: pose[:, :1] > 0, "a reading must be float64 (5, b), got bool (5, 1)"),
    (lambda s, pose, m: [[0.0]] * len(pose), "a reading must be float64 (5, b), got list (5, 1)"),
    (lambda s, pose, m: np.full((len(pose), 1), float(next(s.count))), "the same memory gives"),
    (lambda s, pose, m: m["rng"].normal(size=(len(pose), 1)), "the same memory gives"),
    (counts, "the same memory gives"),
    (lambda s, pose, m: pose[:, :1] - pose[:, :1].mean(), "rover 0 alone gets another result"),
    (lambda s, pose, m: pose[:, :1] * pose[0, 0], "rover 1 alone gets another result"),
    (writes, "it tries to change what it is given"),
    (remembers, "another drive beside it changes the result"),
    (writes_by_force, "it changes what it is given"),
]


@pytest.mark.parametrize(("fault", "sentence"), FAULTS)
def test_broken_sensors_are_noticed(fault: Any, sentence: str) -> None:
    with pytest.raises(ContractError) as noticed:
        check_sensor(Broken(fault), place)
    assert str(noticed.value).startswith("sensor 'broken': ")
    assert sentence in str(noticed.value)
    assert isinstance(noticed.value, AssertionError)


def test_what_is_no_sensor_is_told_so() -> None:
    with pytest.raises(ContractError, match="is no sensor: it needs a name, start and read"):
        check_sensor(42, place)
