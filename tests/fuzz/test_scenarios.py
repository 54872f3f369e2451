"""Whatever a scenario, a controller or a world holds: a drive, or one sentence of ours."""

from __future__ import annotations

import copy
import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from rovernav.core import Command, Frame, Mission, Observation, Outcome, RovernavError
from rovernav.learn import find_controller, routed
from rovernav.mapping import ElevationMapper, LocalMapper
from rovernav.rover import read_rover
from rovernav.scenes import Ground as Place
from rovernav.scenes import read_scenario, set_scene
from rovernav.sim import (
    LIDAR,
    Body,
    Drive,
    DriveState,
    Grid,
    Ground,
    HoleSensor,
    NoisyFan,
    Odometry,
    Patch,
    RangeFan,
    Worlds,
    simulate,
)
from tests.sim.bodies import CARS

PLAIN: dict[str, Any] = {
    "generate": {"name": "hills", "side_m": 8.0, "cell_m": 0.2, "relief_m": 0.4, "craters": 0},
    "from": [2, 2], "to": [6, 6], "frame": "local", "rover": "research",
    "controller": "goal-seeker", "time_limit_s": 4.0,
}  # fmt: skip
LIKELY: dict[str, list[Any]] = {
    "body": [True], "soil": ["loose-sand", "crust", None], "slip_spread": [0, 0.5, 1],
    "sensing": ["ideal", "lidar", "sonar", "stereo"], "drift": [True, False], "route": ["plan"],
    "controller": ["goal-seeker", "planner", "neural", "bassil"], "rocks": [1e-9, 0.02, 0.9],
    "rover": ["research", "perseverance", "sojourner", "paper-point"],
    "time_limit_s": [1e-9, 0.001, 1, 6], "seed": [0, 2**63 - 1],
    "boxes": [[[3, 3, 4, 4]], [[-1e4, -1e4, 1e4, 1e4]], [[4, 4, 4, 4]]],
    "circles": [[[4, 5, 0.3]], [[4, 5, 1e-9]], [[2, 2, 0.1]]],
    "polygons": [[[[4, 4], [5, 4], [4, 5]]], [[[4, 4]] * 3], [[[3, 3], [5, 5], [5, 3], [3, 5]]]],
    "from": [[0, 0], [8, 8], [0.01, 0.01], [6, 6]],
    "to": [[2, 2], [2.0000001, 2], [8, 8], [-5, 2], [1e9, 1e9]],
    "generate": [
        {"name": "hills", "side_m": 1.0, "cell_m": 1.0},
        {"name": "hills", "side_m": 4.0, "cell_m": 0.25, "relief_m": 0, "craters": 0},
        {"name": "hills", "side_m": 8.0, "cell_m": 0.5, "relief_m": 9.0},
        {"name": "hills", "side_m": 12.0, "cell_m": 0.15, "relief_m": 0.3, "craters": 1},
    ],
}  # fmt: skip
ODD: list[Any] = [
    None, True, False, "", 0, -1, 0.5, 1e-300, 1e300, math.inf, -math.inf, math.nan, "x" * 300,
    "\0", "../..", "/dev/zero", "/dev/null", [], [[]], {}, {"a": 1}, [1, 2], [1, "a"],
    [math.nan, 1], 2**63, 10**30, "plan", "nan", [0, 0], [7.999, 0.001],
]  # fmt: skip
KEYS = ("carry", "cell", "frame", "heights", "south_first", "terrain")
"""Keys that only odd values are tried for."""


def drive(data: dict[str, Any], folder: Path, steps: int) -> Outcome:
    """Read, set and drive a scenario as the command line does."""
    path = folder / "s.yaml"
    path.write_text(yaml.safe_dump(data), encoding="utf-8")
    scenario = read_scenario(path)
    scene, left = set_scene(scenario), [steps]
    driver = find_controller(scenario.controller)
    if scenario.route is not None:
        driver = routed(driver, scene, scenario.route)
    inner = scene.scene if isinstance(scene, Place) else scene

    def watch(_: DriveState) -> bool:
        left[0] -= 1
        return left[0] > 0

    return simulate(inner.drive(driver), seed=scenario.seed, on_event=watch).ended()


def spoilt(rng: np.random.Generator) -> dict[str, Any]:
    """A scenario with some keys that may be and some that may not."""
    data = copy.deepcopy(PLAIN)
    if rng.random() < 0.6:
        data["body"] = True
    for key in rng.choice([*LIKELY, *LIKELY, *KEYS], rng.integers(1, 5)).tolist():
        from_likely = key in LIKELY and rng.random() < 0.85
        values = LIKELY[key] if from_likely else ODD
        data[key] = copy.deepcopy(values[int(rng.integers(len(values)))])  # no aliases
    return data


@pytest.mark.parametrize("count", [150, pytest.param(1500, marks=pytest.mark.long)])
def test_a_scenario_is_driven_or_refused_in_a_sentence(count: int, tmp_path: Path) -> None:
    rng, driven, refused = np.random.default_rng(count), 0, 0
    for _ in range(count):
        data = spoilt(rng)
        try:
            drive(data, tmp_path, 6)
            driven += 1
        except RovernavError as error:
            if not str(error) or "\n" in str(error):
                raise
            refused += 1
        except Exception as error:
            raise AssertionError(data) from error
    assert driven > count / 25, (driven, refused)
    assert refused > count / 25, (driven, refused)


class Hostile:
    """Commands what no rover can do; row k by its number."""

    WORDS = (math.nan, math.inf, -math.inf, 1e308, -1e308, 5e-324, -0.0)

    def start(self, mission: Mission, rng: np.random.Generator) -> Any:
        return mission.number

    def act(self, observation: Observation, memory: Any) -> tuple[Command, Any]:
        twist = np.zeros((len(memory), 3))
        for row, number in enumerate(memory.tolist()):
            twist[row, number % 3] = self.WORDS[number // 3 % len(self.WORDS)]
        return Command(twist=twist), memory


def full(rover: Any, worlds: Worlds, mission: Mission) -> Drive:
    """All sensors, a map and a body."""
    eyes = Patch(near=0.3, far=1.5, cell=0.25)
    fan = NoisyFan(RangeFan(reach=2.0, beams=9), LIDAR)
    return Drive(
        worlds=worlds, mission=mission, sensors=(fan, eyes, HoleSensor(), Odometry()),
        mapper=ElevationMapper(rover, eyes, fan=fan, side=16), controller=Hostile(),
        motion=Body(rover, period=0.5),
    )  # fmt: skip


@pytest.mark.parametrize("name", CARS)
def test_commands_that_nobody_can_follow(name: str) -> None:
    """No pose becomes NaN; a speed beyond all limits is held within them."""
    n, ground = 21, Ground(frame=Frame(cell=0.2, shape=(60, 60)), height=np.zeros((60, 60), "f4"))
    mission = Mission(
        start=np.tile([6.0, 6.0, 0.3], (n, 1)), goal=np.full((n, 2), 50.0), goal_radius=0.1,
        time_limit=2.0,
    )  # fmt: skip
    trace = simulate(full(CARS[name], Worlds.single(ground=ground, rovers=n), mission))
    for k in range(n):
        word = Hostile.WORDS[k // 3 % 7]
        assert np.isfinite(trace.pose[:, k]).all()
        if not math.isfinite(word):
            assert trace.ended(k) is Outcome.LEFT_MAP
        else:
            assert trace.ended(k) is Outcome.TIMED_OUT
        assert trace.length[k] <= 2.0 * (0.6 + 0.8) + 1e-9
    assert trace.energy is not None
    assert np.isfinite(trace.energy).all()


@pytest.mark.parametrize("shape", [(1, 1), (1, 5), (5, 1), (2, 2), (9, 9)])
@pytest.mark.parametrize("missing", [False, True])
def test_ground_that_is_smaller_than_the_rover(shape: tuple[int, int], missing: bool) -> None:
    height = np.full(shape, np.nan if missing else 0.0, np.float32)
    frame = Frame(cell=0.2, shape=shape)
    starts = np.array([(0.1, 0.1, 0.0), (0.0, 0.0, 2.0), (-5.0, 0.1, 0.0), (1e9, -1e9, 1.0)])
    mission = Mission(start=starts, goal=starts[:, :2] + 30.0, goal_radius=0.1, time_limit=2.0)
    grid = Grid(frame=frame, blocked=np.ones(shape, np.uint8))
    for rover in (CARS["skid"], CARS["crab"]):
        for grids in (None, grid):
            worlds = Worlds.single(ground=Ground(frame=frame, height=height), grid=grids, rovers=4)
            trace = simulate(full(rover, worlds, mission))
            assert set(trace.outcome.tolist()) <= {Outcome.LEFT_MAP, Outcome.COLLIDED}
            assert (trace.steps == 0).all()


@pytest.mark.parametrize("far", [0.0, 1e-300, 1e15, 1e300])
def test_goals_anywhere(far: float) -> None:
    rover, fan = read_rover("research"), RangeFan(reach=2.0, beams=9)
    ground = Ground(frame=Frame(cell=0.2, shape=(40, 40)), height=np.zeros((40, 40), np.float32))
    mission = Mission(
        start=np.array([[4.0, 4.0, 0.0]]), goal=np.array([[4.0 + far, 4.0 - far]]),
        goal_radius=0.1, time_limit=2.0,
    )  # fmt: skip
    for name in ("goal-seeker", "planner", "neural"):
        mapper = LocalMapper(fan.angles, reach=2.0)
        whole = dataclasses.replace(
            full(rover, Worlds.single(ground=ground), mission), mapper=mapper,
            sensors=(fan,), controller=find_controller(name),
        )  # fmt: skip
        trace = simulate(whole)
        assert trace.ended() is (Outcome.REACHED if far < 0.05 else Outcome.TIMED_OUT)
        assert np.isfinite(trace.pose).all()
