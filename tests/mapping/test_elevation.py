"""The map of heights: as in plain Python, the same in any batch, true where it is sure."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from rovernav.control import SensedPlanner
from rovernav.core import Frame, Mission, Outcome, RoverState, SettingError
from rovernav.kernels import elevation as kernels
from rovernav.mapping import Elevation, ElevationMapper, LocalMap, LocalMapper, Look, aimed, view
from rovernav.rover import Reason, read_rover, standing
from rovernav.sim import (
    DifferentialDrive,
    Drift,
    Drive,
    Ground,
    Odometry,
    Patch,
    RangeFan,
    Worlds,
    simulate,
)
from rovernav.terrain import Terrain
from tests.naive import elevation as naive

ROVER = read_rover("research")
SIDE = 16
LOOK = Look(
    places=np.array([(0.3 * i, 0.3 * j) for i in range(2, 7) for j in range(-4, 5)]),
    far=2.2, mast=0.8, noise=0.004,
)  # fmt: skip


def mission_at(poses: Any) -> Mission:
    start = np.array(poses, float).reshape(-1, 3)
    return Mission(start=start, goal=start[:, :2] + 5.0, goal_radius=0.5, time_limit=9.0)


def held(local: LocalMap, k: int = 0) -> dict[tuple[int, int], tuple[float, ...]]:
    """{cell: (height, variance, top)} of what a map knows."""
    seen = view(local, k)
    low = np.round(np.array(seen.frame.origin)[::-1] / local.cell).astype(int)
    return {
        (int(i + low[0]), int(j + low[1])): tuple(
            float(layer[i, j]) for layer in (seen.height, seen.variance, seen.top)
        )
        for i, j in zip(*np.nonzero(np.isfinite(seen.height)), strict=True)
    }


def close(a: dict[Any, Any], b: dict[Any, Any]) -> None:
    assert a.keys() == b.keys()
    if a:
        assert_allclose([a[key] for key in a], [b[key] for key in a], rtol=1e-4, atol=1e-6)


@pytest.mark.kernels
def test_the_map_is_that_of_plain_python(rng: np.random.Generator) -> None:
    mapper = ElevationMapper(ROVER, LOOK, side=SIDE, cell=0.2)
    pose, fusion = np.array([[0.1, -0.2, 0.3]]), mapper._fusion
    memory, known = mapper.start(mission_at(pose)), dict[Any, Any]()
    for _ in range(5):
        pose = pose + np.column_stack([rng.normal(0, 0.5, (1, 2)), rng.normal(0, 0.5, (1, 1))])
        patch = np.round(rng.normal(0, 0.2, (1, len(LOOK.places))), 2)
        patch[rng.random(patch.shape) < 0.3] = np.nan
        z = float(rng.normal(0, 0.1))
        estimate = np.array([[*pose[0], z, 0.0, 0.0, 0.0]])
        channels = {"patch": patch, "estimate": estimate}
        _, memory = mapper.update(memory, pose, np.array([[9.0, 9.0]]), channels)
        centre = tuple(np.floor(pose[0, [1, 0]] / 0.2).astype(int).tolist())
        known = {at: got for at, got in known.items() if naive.inside(at, centre, SIDE)}
        naive.fused(known, pose[0], z, LOOK.places, patch[0], fusion)
        known = {at: got for at, got in known.items() if naive.inside(at, centre, SIDE)}
        close(held(memory), known)
        _check_verdicts(memory, known, centre, mapper._limits)


def _check_verdicts(memory: LocalMap, known: Any, centre: Any, p: Any) -> None:
    seen = view(memory)
    for i in range(centre[0] - p.around, centre[0] + p.around + 1):
        for j in range(centre[1] - p.around, centre[1] + p.around + 1):
            if not naive.inside((i, j), centre, SIDE):
                continue
            a, b = i - centre[0] + SIDE // 2, j - centre[1] + SIDE // 2
            slope, ledge = naive.slope_at(known, (i, j), p), naive.ledge_at(known, (i, j), p)
            assert seen.slope[a, b] == pytest.approx(slope, abs=1e-4, nan_ok=True)
            assert seen.step[a, b] == pytest.approx(ledge, abs=1e-4, nan_ok=True)
            verdict = int(seen.reason[a, b])
            if slope > math.atan(p.slope) + 1e-4:
                assert verdict == Reason.SLOPE
            elif ledge > p.step + 1e-4:
                assert verdict == Reason.STEP
            elif math.isnan(slope):
                assert verdict == Reason.NO_DATA
            elif slope < math.atan(p.slope) - 1e-4:
                assert verdict in (Reason.FREE, Reason.NEAR)


def test_verdicts_have_the_numbers_of_the_rovers_reasons() -> None:
    ours = kernels.FREE, kernels.UNKNOWN, kernels.STEEP, kernels.LEDGE, kernels.NEAR
    assert ours == (Reason.FREE, Reason.NO_DATA, Reason.SLOPE, Reason.STEP, Reason.NEAR)


def test_a_row_does_not_depend_on_its_batch(rng: np.random.Generator) -> None:
    n, fan = 5, RangeFan(reach=3.0, beams=9)
    mapper = ElevationMapper(ROVER, LOOK, side=32, fan=fan)
    mission = mission_at(rng.normal(0, 3, (n, 3)))
    whole, parts = mapper.start(mission), [mapper.start(mission_at(p)) for p in mission.start]
    pose = mission.start
    for _ in range(4):
        pose = pose + rng.normal(0, 0.3, (n, 3))
        channels = {
            "patch": rng.normal(0, 0.2, (n, len(LOOK.places))),
            "beams": rng.uniform(0.3, 3.0, (n, 9)),
        }
        more, whole = mapper.update(whole, pose, mission.goal, channels)
        for k in range(n):
            part = slice(k, k + 1)
            few = {name: got[part] for name, got in channels.items()}
            own, parts[k] = mapper.update(parts[k], pose[part], mission.goal[part], few)
            for name, got in own.items():
                assert_array_equal(more[name][part], got)
            assert_array_equal(whole.cells[part], parts[k].cells)
            assert_array_equal(whole.ground.height[part], parts[k].ground.height)
            assert_array_equal(whole.ground.reason[part], parts[k].ground.reason)


def hills(rng: np.random.Generator, cell: float = 0.125) -> Terrain:
    y, x = np.indices((160, 160)) * cell
    height = 0.6 * np.sin(0.6 * x) * np.cos(0.5 * y) + rng.normal(0, 0.004, x.shape)
    height[(x > 12) & (x < 12.6) & (y > 4) & (y < 16)] += 1.2  # a wall with steep sides
    return Terrain(
        frame=Frame(cell=cell, shape=(160, 160)), height=height.astype(np.float32), offset=0.0,
        name="hills", source="a test",
    )  # fmt: skip


def looked_around(
    terrain: Terrain, mapper: ElevationMapper, sensor: Patch, drift: Drift | None = None
) -> tuple[LocalMap, np.ndarray]:
    """The map after driving 4 m east and turning about; where the rover is in truth."""
    worlds = Worlds.single(ground=Ground(frame=terrain.frame, height=terrain.height))
    mission = mission_at((6.0, 9.0, 0.0))
    state, rng = RoverState.at_start(mission), np.random.default_rng(3)
    odometry = Odometry(drift or Drift(scale=0.0, walk=0.0, turn=0.0, rise=0.0))
    eyes, own, memory = sensor.start(mission, rng), odometry.start(mission, rng), None
    memory = mapper.start(mission)
    for step in range(60):
        ahead = (0.2, 0.0, 0.0) if 8 <= step < 28 else (0.0, 0.0, 0.2)
        state = dataclasses.replace(state, pose=state.pose + ahead)
        patch, eyes = sensor.read(worlds, state, eyes)
        estimate, own = odometry.read(worlds, state, own)
        channels = {"patch": patch, "estimate": estimate}
        _, memory = mapper.update(memory, estimate[:, :3].copy(), mission.goal, channels)
    return memory, state.pose[0]


def errors(local: LocalMap, terrain: Terrain, start: tuple[float, float]) -> np.ndarray:
    """Map less truth at the known cells, and standard deviations beside (m, 2)."""
    seen = view(local)
    out = []
    base = terrain.elevation_at(np.array([start[0]]), np.array([start[1]]))[0]
    for i, j in zip(*np.nonzero(np.isfinite(seen.height)), strict=True):
        x, y = seen.frame.to_map(*seen.frame.centre_of(int(i), int(j)))
        truth = terrain.elevation_at(np.array([x]), np.array([y]))[0] - base
        out.append((seen.height[i, j] - truth, math.sqrt(seen.variance[i, j])))
    return np.array(out)


def test_the_map_is_the_ground_within_its_own_doubt(rng: np.random.Generator) -> None:
    terrain, sensor = hills(rng), Patch(far=5.0, cell=0.15, mast=1.2, noise=0.003)
    memory, _ = looked_around(terrain, ElevationMapper(ROVER, sensor, cell=0.15), sensor)
    off = errors(memory, terrain, (6.0, 9.0))
    assert len(off) > 2500
    assert abs(np.median(off[:, 0])) < 0.01
    assert (abs(off[:, 0]) < 3.0 * off[:, 1] + 0.05).mean() > 0.95


def test_drift_makes_the_map_less_sure_and_no_less_honest(rng: np.random.Generator) -> None:
    terrain, sensor = hills(rng), Patch(far=5.0, cell=0.15, mast=1.2, noise=0.003)
    mapper = ElevationMapper(ROVER, sensor, cell=0.15)
    known = looked_around(terrain, mapper, sensor)[0]
    drift = Drift(scale=0.02, walk=0.01, turn=0.005, rise=0.05)
    drifting = looked_around(terrain, mapper, sensor, drift)[0]
    assert isinstance(known.ground, Elevation)
    sure, unsure = np.nanmedian(known.ground.variance), np.nanmedian(drifting.ground.variance)
    assert unsure > 1.5 * sure
    off = errors(drifting, terrain, (6.0, 9.0))
    assert (abs(off[:, 0]) < 3.0 * off[:, 1] + 0.1).mean() > 0.9


def test_hazards_are_those_of_the_truth_where_the_ground_was_seen(rng: np.random.Generator) -> None:
    terrain, sensor = hills(rng), Patch(far=5.0, cell=0.1, mast=1.2, noise=0.001)
    mapper = ElevationMapper(ROVER, sensor, cell=0.125, margin=0.0, prudence=1.0)
    memory, _ = looked_around(terrain, mapper, sensor)
    seen, truth = view(memory), standing(terrain, ROVER)
    right = wrong = missed = 0
    for i, j in zip(*np.nonzero(seen.reason != Reason.NO_DATA), strict=True):
        x, y = seen.frame.to_map(*seen.frame.centre_of(int(i), int(j)))
        real = bool(truth.blocked[terrain.frame.cell_of(x, y)])
        ours = bool(seen.blocked[i, j])
        right += real == ours
        wrong += ours and not real
        missed += real and not ours
    assert right > 0.9 * (right + wrong + missed)
    assert (seen.reason == Reason.SLOPE).sum() + (seen.reason == Reason.STEP).sum() > 20
    assert missed < 0.02 * (right + wrong + missed)


def test_unknown_ground_is_free_or_closed_as_asked() -> None:
    patch = {"patch": np.full((1, len(LOOK.places)), np.nan)}
    for closed in (False, True):
        mapper = ElevationMapper(ROVER, LOOK, side=16, closed=closed)
        memory = mapper.start(mission_at((0.0, 0.0, 0.0)))
        _, memory = mapper.update(memory, memory.pose, memory.goal, patch)
        assert (view(memory).blocked == closed).all()
        assert (view(memory).reason == Reason.NO_DATA).all()


def test_beams_mark_what_has_no_height() -> None:
    fan = RangeFan(reach=3.0, beams=9)
    mapper = ElevationMapper(ROVER, LOOK, side=64, cell=0.1, fan=fan)
    memory = mapper.start(mission_at((0.05, 0.05, 0.0)))
    beams = np.full((1, 9), 3.0)
    beams[0, 4] = 1.0
    patch = np.zeros((1, len(LOOK.places)))
    more, memory = mapper.update(memory, memory.pose, memory.goal, {"patch": patch, "beams": beams})
    assert view(memory).blocked.sum() == 1
    assert "beams" not in more
    ahead = mapper.update(
        memory, memory.pose, np.array([[9.0, 0.05]]), {"patch": patch, "beams": beams}
    )[0]
    assert ahead["around"][0, 0] == pytest.approx(1.0, abs=0.1)


def test_a_rover_without_a_fan_looks_at_its_map() -> None:
    mapper = ElevationMapper(ROVER, LOOK, side=64, cell=0.3)
    memory = mapper.start(mission_at((0.0, 0.0, 0.0)))
    patch = np.where(LOOK.places[:, 0] > 1.4, 1.0, 0.0)[None]  # a wall 1.5 m ahead
    more, _ = mapper.update(memory, memory.pose, memory.goal, {"patch": patch})
    assert more["beams"].shape == (1, 49)
    assert more["beams"][0, 24] < 1.8
    assert more["beams"][0, 0] == more["beams"][0, 48] == pytest.approx(mapper.extent)


def test_patches_without_an_estimate_are_laid_where_they_fit(rng: np.random.Generator) -> None:
    mapper = ElevationMapper(ROVER, LOOK, side=32, cell=0.2)
    memory = mapper.start(mission_at((0.0, 0.0, 0.0)))
    pose = np.array([[0.0, 0.0, 0.0]])
    for step in range(6):  # up a slope of 1 in 5, 0.3 m at a time
        pose = np.array([[0.3 * step, 0.0, 0.0]])
        patch = 0.2 * LOOK.places[None, :, 0]
        _, memory = mapper.update(memory, pose, memory.goal, {"patch": patch})
    known = held(memory)
    for (row, column), (height, *_) in known.items():
        assert height == pytest.approx(0.2 * (column + 0.5) * 0.2, abs=0.06), (row, column)


def test_a_planner_drives_by_the_map_around_a_wall(rng: np.random.Generator) -> None:
    terrain, sensor = hills(rng), Patch(far=5.0, cell=0.15, mast=1.2, noise=0.001)
    mission = Mission.between((6.0, 9.0), (16.0, 9.0), goal_radius=0.6, time_limit=300.0)
    blocked = standing(terrain, ROVER)
    drive = Drive(
        worlds=Worlds.single(ground=Ground(frame=terrain.frame, height=terrain.height)),
        mission=mission,
        sensors=(sensor, Odometry(Drift(scale=0.005, walk=0.005, turn=0.002, rise=0.005))),
        controller=SensedPlanner(),
        motion=DifferentialDrive(speed=ROVER.speed, turn_rate=ROVER.turn_rate, period=1.0),
        mapper=ElevationMapper(ROVER, sensor, cell=0.15),
    )
    trace = simulate(drive, seed=1)
    assert trace.ended() is Outcome.REACHED
    cells = [terrain.frame.cell_of(x, y) for x, y in trace.path()]
    assert all(blocked.reason[at] not in (Reason.SLOPE, Reason.STEP) for at in cells)


def test_maps_are_aimed_and_told_apart() -> None:
    mapper = ElevationMapper(ROVER, LOOK, side=16)
    memory = mapper.start(mission_at((0.0, 0.0, 0.0)))
    assert_array_equal(aimed(memory, np.array([[1.0, 2.0]])).goal, [[1.0, 2.0]])
    other = LocalMapper(np.linspace(-1, 1, 3), reach=1.0).start(mission_at((0.0, 0.0, 0.0)))
    with pytest.raises(SettingError, match="this map has no heights"):
        view(other)
    with pytest.raises(SettingError, match="goes on from one of its own"):
        mapper.update(other, other.pose, other.goal, {})
    with pytest.raises(SettingError, match="a side of 8, 16, 32"):
        ElevationMapper(ROVER, LOOK, side=12)
    with pytest.raises(SettingError, match="cell must be above 0 m"):
        ElevationMapper(ROVER, LOOK, cell=-1.0)
