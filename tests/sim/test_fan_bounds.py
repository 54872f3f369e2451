"""Without noise no range is beyond the true one, and none is short of it."""

from __future__ import annotations

import math

import numpy as np
import shapely
from shapely.geometry import Point, Polygon, box

from rovernav.core import Frame, Mission, RoverState
from rovernav.sim import Grid, Ground, Patch, RangeFan, Shape, Worlds
from tests.naive.elevation import ground_at

CLOSE = 1e-7


def at(poses: np.ndarray) -> tuple[Mission, RoverState]:
    mission = Mission(start=poses, goal=poses[:, :2], goal_radius=0.0, time_limit=1.0)
    return mission, RoverState.at_start(mission)


def test_beams_end_at_the_nearest_of_boxes_shapes_and_cells(rng: np.random.Generator) -> None:
    """Shapely decides: nothing lies on a beam before its reading, and something at its end."""
    low = rng.uniform(0.0, 11.0, (6, 2))
    boxes = np.concatenate([low, low + rng.uniform(0.1, 1.0, (6, 2))], axis=1)
    corners = [rng.uniform(1.0, 11.0, 2) + rng.uniform(-0.6, 0.6, (3, 2)) for _ in range(5)]
    discs = rng.uniform((1.0, 1.0, 0.1), (11.0, 11.0, 0.5), (4, 3))
    blocked = (rng.random((24, 24)) < 0.03).astype(np.uint8)
    shapes = [Shape.polygon(each.tolist()) for each in corners]
    shapes += [Shape.disc(*disc) for disc in discs]
    worlds = Worlds.single(
        boxes.tolist(), rovers=30,
        grid=Grid(frame=Frame(cell=0.5, shape=(24, 24)), blocked=blocked),
        shapes=shapes,
    )  # fmt: skip
    flat = [box(*each) for each in boxes] + [Polygon(each) for each in corners]
    flat += [box(j / 2, i / 2, j / 2 + 0.5, i / 2 + 0.5) for i, j in np.argwhere(blocked)]
    solid = shapely.union_all(flat)
    inner = solid.buffer(-CLOSE)
    shapely.prepare(inner)
    poses = rng.uniform((0.0, 0.0, -3.0), (12.0, 12.0, 3.0), (30, 3))
    fan = RangeFan(reach=5.0, beams=31, view=2.0 * math.pi)
    readings, _ = fan.read(worlds, at(poses)[1], None)
    assert (readings >= 0.0).all()
    assert (readings <= 5.0).all()
    met = 0
    for pose, row in zip(poses, readings, strict=True):
        for angle, far in zip(pose[2] + fan.angles, row, strict=True):
            way = np.array([math.cos(angle), math.sin(angle)])
            before = shapely.linestrings([pose[:2], pose[:2] + max(far - CLOSE, 0.0) * way])
            gaps = [
                shapely.linestrings([pose[:2], pose[:2] + far * way]).distance(Point(x, y)) - r
                for x, y, r in discs
            ]
            if far > CLOSE:
                assert not before.intersects(inner)
                assert min(gaps) > -CLOSE
            if far < 5.0:
                end = Point(pose[:2] + far * way)
                here = [end.distance(Point(x, y)) - r for x, y, r in discs]
                assert min(end.distance(solid), *here) < CLOSE
                met += 1
    assert met > 200


def test_a_patch_without_noise_is_never_farther_or_nearer_than_the_ground(
    rng: np.random.Generator,
) -> None:
    height = np.cumsum(rng.normal(0.0, 0.1, (40, 40)), axis=0).astype(np.float32)
    ground = Ground(frame=Frame(cell=0.25, shape=(40, 40)), height=height)
    eyes = Patch(near=0.4, far=3.0, cell=0.3, noise=0.0, lose=0.0)
    poses = rng.uniform((3.0, 3.0, -3.0), (7.0, 7.0, 3.0), (20, 3))
    mission, state = at(poses)
    seen, _ = eyes.read(Worlds.single(ground=ground, rovers=20), state, eyes.start(mission, rng))
    known = 0
    for pose, row in zip(poses, seen, strict=True):
        base = ground_at(height, 0.25, pose[0], pose[1])
        for place, up in zip(eyes.places, row, strict=True):
            if math.isnan(up):
                continue
            turn = complex(math.cos(pose[2]), math.sin(pose[2])) * complex(*place)
            there = ground_at(height, 0.25, pose[0] + turn.real, pose[1] + turn.imag)
            assert abs(up - (there - base)) < 1e-6
            known += 1
    assert 200 < known < seen.size
