"""Infra-red that looks down: drops that the eyes do not see get onto the map."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from rovernav.core import Frame, Mission, RoverState
from rovernav.mapping import ElevationMapper, LocalMap, view
from rovernav.rover import Reason, read_rover
from rovernav.sim import CURVES, Ground, HoleSensor, Patch, Tilt, Worlds
from tests.mapping.test_elevation import LOOK, close, held, mission_at
from tests.naive import elevation as naive

ROVER = read_rover("research")
ROWS = (math.radians(40.0), math.radians(60.0))
SIDE = 32


def sensor(**changes: Any) -> HoleSensor:
    settings: dict[str, Any] = {"ahead": 0.25, "height": 0.6, "down": ROWS}
    return HoleSensor(**{**settings, **changes})


@pytest.mark.kernels
def test_drops_are_taken_in_as_in_plain_python(rng: np.random.Generator) -> None:
    mapper = ElevationMapper(ROVER, LOOK, holes=sensor(), side=SIDE, cell=0.2)
    down, fusion, fell = mapper._down, mapper._fusion, 0
    for _ in range(40):
        pose = np.array([[*rng.normal(0, 1, 2), rng.uniform(-3, 3)]])
        patch = np.round(rng.normal(0, 0.03, (1, len(LOOK.places))), 2)
        patch[rng.random(patch.shape) < 0.6] = np.nan
        z, lean = float(rng.normal(0, 0.1)), rng.normal(0, 0.1, (1, 2))
        readings = np.round(rng.choice([0.8, 0.95, 1.2, 1.35, 1.5], (1, 6)), 3)
        channels: dict[str, Any] = {
            "patch": patch, "estimate": np.array([[*pose[0], z, 0.0, 0.0, 0.0]]), "tilt": lean,
            "down": readings,
        }  # fmt: skip
        start = mapper.start(mission_at(pose))
        _, memory = mapper.update(start, pose, np.array([[9.0, 9.0]]), channels)
        centre = tuple(np.floor(pose[0, [1, 0]] / 0.2).astype(int).tolist())
        known: dict[Any, Any] = {}
        naive.fused(known, pose[0], z, LOOK.places, patch[0], fusion)
        known = {at: got for at, got in known.items() if naive.inside(at, centre, SIDE)}
        before = len(known)
        naive.dropped(known, (*pose[0], z), lean[0], readings[0], down, fusion)
        fell += len(known) - before
        close(held(memory), known)
    assert fell > 100


def look(
    height: np.ndarray, mapper: ElevationMapper, sensors: tuple[Any, ...], pose: Any
) -> LocalMap:
    """The map after one look from a place on ground with posts every 5 cm."""
    frame = Frame(cell=0.05, shape=height.shape)
    worlds = Worlds.single(ground=Ground(frame=frame, height=height.astype(np.float32)))
    mission = mission_at(pose)
    state = RoverState.at_start(mission)
    channels = {
        each.name: each.read(worlds, state, each.start(mission, np.random.default_rng(1)))[0]
        for each in sensors
    }
    return mapper.update(mapper.start(mission), mission.start, mission.goal, channels)[1]


def in_front(local: LocalMap, x: float, y: float) -> tuple[int, int]:
    """Verdict, and whether the map blocks the place."""
    seen = view(local)
    (x0, y0), c = seen.frame.origin, seen.frame.cell
    i, j = int((y - y0) / c), int((x - x0) / c)
    return int(seen.reason[i, j]), int(seen.blocked[i, j])


def test_a_trench_that_hides_its_depth_from_the_eyes_is_forbidden() -> None:
    height = np.zeros((160, 160))
    height[:, 100:106] = -1.0  # 5.0 to 5.3 m east
    eyes, infra = Patch(far=4.0, cell=0.05, mast=0.6, near=0.4), sensor()
    pose = (4.15, 4.0, 0.0)
    blind = look(height, ElevationMapper(ROVER, eyes), (eyes,), pose)
    assert not blind.cells.any()
    mapper = ElevationMapper(ROVER, eyes, holes=infra)
    told = look(height, mapper, (eyes, infra, Tilt()), pose)
    across = [in_front(told, x, 4.0) for x in np.arange(4.95, 5.35, 0.05)]
    assert {Reason.STEP, Reason.SLOPE} & {verdict for verdict, _ in across}
    assert all(blocked for _, blocked in across)
    assert in_front(told, 4.75, 4.0) == (Reason.NEAR, 1)
    level = look(np.zeros((160, 160)), mapper, (eyes, infra, Tilt()), pose)
    assert not level.cells.any()


@pytest.mark.parametrize("slope", [-14.0, 14.0])
def test_ground_that_only_slopes_is_no_drop(slope: float) -> None:
    """Level ground that goes over into a slope within the rover's limit of 20 deg."""
    x = (np.arange(160) + 0.5) * 0.05
    height = np.tile(np.tan(np.radians(slope)) * np.maximum(x - 4.6, 0.0), (160, 1))
    eyes, infra = Patch(far=4.0, cell=0.05, mast=0.6, near=0.4, lose=0.4), sensor()
    mapper = ElevationMapper(ROVER, eyes, holes=infra)
    for at in (3.8, 4.2, 4.4):
        told = look(height, mapper, (eyes, infra, Tilt()), (at, 4.0, 0.0))
        assert not told.cells.any()


def test_the_doubt_of_a_reading_covers_what_is_read(rng: np.random.Generator) -> None:
    """Readings lie within three of their own standard deviations, from 0.2 m to the reach."""
    for name, curve in CURVES.items():
        table = curve.doubt()
        assert (np.diff(table[:, 0]) > 0).all()
        assert (table[:, 1] > 0).all()
        down = HoleSensor(name, across=(0.0,), height=0.5 * curve.reach, down=math.radians(80))
        frame = Frame(cell=1.0, shape=(9, 9))
        for far in np.linspace(0.3, 0.9, 7) * curve.reach:
            rise = 0.5 * curve.reach - far * math.sin(math.radians(80))
            height = np.full((9, 9), rise, np.float32)
            height[:, :4] = 0.0  # the rover's own ground, so that the rest lies higher or lower
            worlds = Worlds.single(ground=Ground(frame=frame, height=height), rovers=200)
            start = np.tile([4.2, 4.5, 0.0], (200, 1))
            mission = Mission(start=start, goal=start[:, :2], goal_radius=0.0, time_limit=1.0)
            read, _ = down.read(worlds, RoverState.at_start(mission), down.start(mission, rng))
            base = float(np.interp(4.2, [3.5, 4.5], [0.0, rise]))
            true = (0.5 * curve.reach + base - rise) / math.sin(math.radians(80))
            doubt = np.interp(read[:, 0], *table.T)
            seen = read[:, 0] < curve.reach
            assert (np.abs(read[seen, 0] - true) <= 3.5 * doubt[seen]).mean() > 0.98
