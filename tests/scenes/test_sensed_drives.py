"""Drives by what was sensed, from start to end: holes, rocks, and ground that maps forbid."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np
import pytest

from rovernav.core import Frame, Outcome, build
from rovernav.learn import find_controller, guarded
from rovernav.mapping import LocalMap
from rovernav.rover import Reason, read_rover, standing
from rovernav.scenes import (
    Ground,
    Scenario,
    embodied,
    generate,
    ground_scene,
    nearest_free,
    sensed,
    set_scene,
    strewn,
)
from rovernav.sim import begin, simulate, tick
from rovernav.terrain import Terrain

ROVER = read_rover("research")
CALM = (Outcome.REACHED, Outcome.TIMED_OUT, Outcome.ASTRAY)


def trench(seed: int, *, cell: float = 0.05) -> Terrain:
    """Smooth ground, and a trench 1 m deep, 0.4 m wide and 4 m long across the middle of it."""
    y, x = (np.indices((280, 280)) + 0.5) * cell
    height = 0.02 * np.sin(0.7 * x + seed) * np.cos(0.5 * y)
    height[(x > 7) & (x < 7.4) & (abs(y - 7) < 2)] -= 1.0
    return Terrain(
        frame=Frame(cell=cell, shape=(280, 280)), height=height.astype(np.float32), offset=0.0,
        name="trench", source="a test",
    )  # fmt: skip


def test_a_trench_that_the_eyes_do_not_see_is_driven_round_with_infra_red() -> None:
    ends: dict[str, Counter[str]] = {"stereo": Counter(), "stereo+holes": Counter()}
    for seed in range(3):
        ground = ground_scene(trench(seed), ROVER, (3.0, 7.0 + 0.2 * seed), (11.0, 7.0))
        for sensing, found in ends.items():
            scene = sensed(embodied(ground), sensing)
            for name in ("neural", "planner")[: 2 if "holes" in sensing else 1]:
                driver = guarded(find_controller(name), scene)
                found[simulate(scene.scene.drive(driver), seed=seed).ended().label] += 1
    assert ends["stereo"]["reached"] == 0
    assert ends["stereo+holes"]["reached"] >= 4


def rocky(seed: int, side: float = 24.0, **more: Any) -> Ground:
    """Hills with rocks over 3 % of the ground, a body, and a way from corner to corner."""
    settings: dict[str, Any] = {
        "generate": {
            "name": "hills", "side_m": side, "cell_m": 0.15, "relief_m": 1.5, "craters": 5,
        },
        "rocks": 0.03, "seed": seed, "rover": "research", "body": True, "from": [4, 4],
        "to": [side - 4, side - 4],
    }  # fmt: skip
    asked = build(Scenario, settings, source="this test")
    assert asked.generate is not None
    terrain = strewn(generate(asked.generate, seed=seed), 0.03, seed=seed)
    where = standing(terrain, ROVER)
    ends = {key: [*nearest_free(where, settings[key])] for key in ("from", "to")}
    scene = set_scene(build(Scenario, {**settings, **ends, **more}, source="this test"))
    assert isinstance(scene, Ground)
    return scene


@pytest.mark.parametrize(
    ("sensing", "name"), [("stereo", "planner"), ("stereo+holes", "neural"), ("stereo", "neural")]
)
def test_nobody_enters_what_the_map_forbade_when_it_was_decided(sensing: str, name: str) -> None:
    """Along the commanded arc; on soil without slip that is where the rover goes."""
    scene = rocky(3, sensing=sensing, drift=True)
    drive = scene.scene.drive(guarded(find_controller(name), scene))
    state, seen, held = begin(drive, np.random.default_rng(3)), 0, 0
    while state.rovers.driving.any():
        state = tick(drive, state)
        observation, command = state.observation, state.command
        assert observation is not None
        assert command is not None
        local = observation.map
        assert isinstance(local, LocalMap)
        v, _, w = command.twist[0]
        stood = blocked(local, observation.pose[0])
        for share in np.linspace(0.0, 1.0, 30)[1:]:
            turn = 0.5 * w * share
            chord = v * share * np.sinc(turn / np.pi)
            a = observation.pose[0, 2] + turn
            place = observation.pose[0, :2] + chord * np.array([np.cos(a), np.sin(a)])
            now = blocked(local, place)
            assert not now or stood
            assert not now or verdict(local, place) not in (Reason.STEP, Reason.SLOPE) or v == 0.0
            stood = stood and now
        seen += 1
        held += bool(local.cells.any())
    assert seen > 40
    assert held > 20


def cell_of(local: LocalMap, place: Any) -> tuple[int, int]:
    j, i = np.floor(np.asarray(place)[:2] / local.cell).astype(int) & (local.cells.shape[1] - 1)
    return int(i), int(j)


def blocked(local: LocalMap, place: Any) -> bool:
    return bool(local.cells[0][cell_of(local, place)])


def verdict(local: LocalMap, place: Any) -> int:
    return int(local.ground.reason[0][cell_of(local, place)])


def test_rocks_that_stop_a_rover_are_seen_by_eyes_though_no_fan_marks_them() -> None:
    """Ledges a quarter above the rover's limit, on ground that was seen, are all forbidden."""
    scene = rocky(5, sensing="stereo")
    drive = scene.scene.drive(guarded(find_controller("planner"), scene))
    state = begin(drive, np.random.default_rng(5))
    while state.rovers.driving.any():
        state = tick(drive, state)
        if float(state.rovers.odometry[0]) > 8.0:
            break
    assert state.observation is not None
    local, where, pose = state.observation.map, scene.standing, state.rovers.pose[0]
    rows, columns = np.nonzero(where.step > 1.25 * ROVER.max_step)
    places = [where.frame.centre_of(int(i), int(j)) for i, j in zip(rows, columns, strict=True)]
    found = [
        blocked(local, (x, y))
        for x, y in places
        if np.hypot(x - pose[0], y - pose[1]) < 4.0 and np.isfinite(
            local.ground.height[0][cell_of(local, (x, y))]
        )
    ]  # fmt: skip
    assert len(found) > 10
    assert all(found)


@pytest.mark.long
def test_rovers_arrive_over_rocks_by_whatever_they_see_with() -> None:
    """24 drives each; 21, 19, 21 and 21 arrived when this was written."""
    for sensing, least in (("lidar", 19), ("sonar", 17), ("stereo", 19), ("stereo+holes", 19)):
        ends = Counter[Outcome]()
        for seed in range(24):
            scene = rocky(seed, sensing=sensing)
            driver = guarded(find_controller("neural"), scene)
            ends[simulate(scene.scene.drive(driver), seed=seed, record="none").ended()] += 1
        assert ends[Outcome.REACHED] >= least, (sensing, ends)
        assert sum(count for end, count in ends.items() if end not in CALM) <= 24 - least
