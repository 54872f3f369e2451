"""Controllers side by side on the same ground, between the same pairs of points."""

from __future__ import annotations

import dataclasses
import itertools
import math
import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ..core import F64, Controller, Executor, Mission, Outcome, Serial, SettingError, value, wilson
from ..rover import Rover, standing
from ..scenes import Scene, equip, fenced, free_pairs, pair_mission
from ..sim import DriveState, Grid, Trace, Worlds, simulate
from ..terrain import Terrain

GOAL_RADIUS = 0.5
TOGETHER = 20
"""Pairs that a worker drives as one batch: a second or a few of work."""


@value
class Pairs:
    """Start and goal pairs on one terrain, for one rover.

    Attributes:
        scene: All drives as one batch; who drives is open.
        starts: (n, 2) [m].
        goals: (n, 2) [m].
        seed: Where the pairs came from.
    """

    scene: Scene
    starts: F64
    goals: F64
    seed: int


@value
class Score:
    """How one controller did on the pairs.

    Attributes:
        name: Which controller.
        trace: All its drives.
        counts: Drives by outcome.
        reached: Share that reached the goal.
        low: Lower end of its 95 % confidence interval (Wilson).
        high: Upper end.
        detour: Median of driven over straight length, of those that reached; NaN if none did.
        seconds: Time it took [s].
    """

    name: str
    trace: Trace
    counts: Mapping[str, int]
    reached: float
    low: float
    high: float
    detour: float
    seconds: float

    def report(self) -> dict[str, Any]:
        """Plain numbers, without the trace."""
        return {
            "controller": self.name,
            "drives": len(self.trace.outcome),
            "reached": self.reached,
            "low": self.low,
            "high": self.high,
            "outcomes": dict(self.counts),
            "detour": self.detour,
            "seconds": self.seconds,
        }


def draw_pairs(
    terrain: Terrain,
    rover: Rover,
    count: int,
    *,
    seed: int = 0,
    nearest: float | None = None,
    farthest: float | None = None,
) -> Pairs:
    """Solvable pairs whose straight line is blocked, drawn evenly over the free ground.

    Args:
        terrain: The ground; its edge counts as forbidden.
        rover: Who shall drive.
        count: How many pairs.
        seed: Where they come from.
        nearest: Shortest straight line [m]; a sixth of the map's shorter side where not given.
        farthest: Longest straight line [m]; a third of the map's longer side beyond 300 m.

    Raises:
        SettingError: Distances that no pair can have, or the ground has too few such pairs.
    """
    width, height = terrain.frame.extent
    near = min(width, height) / 6.0 if nearest is None else nearest
    far = max(_farthest(max(width, height)), near) if farthest is None else farthest
    if not 0 < near <= far < math.inf:
        raise SettingError(
            f"pairs must lie more than 0 m apart, the nearest no farther than the farthest, "
            f"got {near:g} to {far:g} m"
        )
    grid = Grid(frame=terrain.frame, blocked=fenced(standing(terrain, rover).blocked))
    starts, goals = free_pairs(grid, count, np.random.default_rng(seed), nearest=near, farthest=far)
    sensors, mapper, motion, pace = equip(rover, terrain.frame.cell)
    radius = max(GOAL_RADIUS, 0.25 * terrain.frame.cell)
    scene = Scene(
        name=f"pairs on {terrain.name}",
        worlds=Worlds.single(grid=grid, rovers=count),
        mission=pair_mission(starts, goals, goal_radius=radius, pace=pace),
        sensors=sensors,
        motion=motion,
        mapper=mapper,
    )
    return Pairs(scene=scene, starts=starts, goals=goals, seed=seed)


def score(
    pairs: Pairs,
    name: str,
    controller: Controller,
    *,
    executor: Executor | None = None,
    on_event: Callable[[float], object] | None = None,
) -> Score:
    """Drive every pair with one controller.

    Args:
        pairs: Where to drive.
        name: What to call the controller.
        controller: Who drives.
        executor: Who does the work, some pairs at a time; this thread where not given. It changes
            nothing in the score but `seconds`, because no drive depends on those beside it.
        on_event: Told the share of drives that have ended.
    """
    began = time.perf_counter()
    if executor is None or isinstance(executor, Serial):
        trace = _drive(pairs, controller, on_event)
    else:
        trace = _drive_apart(pairs, controller, executor, on_event)
    reached = trace.outcome == Outcome.REACHED
    straight = np.hypot(*(pairs.goals - pairs.starts).T)
    low, high = wilson(int(reached.sum()), len(reached))
    return Score(
        name=name,
        trace=trace,
        counts={
            o.label: int((trace.outcome == o).sum()) for o in Outcome if (trace.outcome == o).any()
        },
        reached=float(reached.mean()),
        low=low,
        high=high,
        detour=float(np.median((trace.length / straight)[reached])) if reached.any() else math.nan,
        seconds=time.perf_counter() - began,
    )


Told = Callable[[float], object] | None
Ends = dict[str, Any]
"""Arrays of a trace without record: time, pose, outcome, steps, length."""


def _drive(pairs: Pairs, controller: Controller, on_event: Told) -> Trace:
    """All pairs as one batch, in this thread."""

    def watch(state: DriveState) -> None:
        if on_event is not None:
            on_event(1.0 - float(state.rovers.driving.mean()))

    drive = pairs.scene.drive(controller)
    return simulate(drive, seed=pairs.seed, record="none", on_event=watch)


def _drive_apart(pairs: Pairs, controller: Controller, executor: Executor, on_event: Told) -> Trace:
    """The same trace from parts that others drive."""
    mission = pairs.scene.mission
    count = len(mission.start)
    parts = [slice(at, min(at + TOGETHER, count)) for at in range(0, count, TOGETHER)]
    done = itertools.count(1)

    def tell() -> None:
        if on_event is not None:
            on_event(next(done) / len(parts))

    shared = (pairs.scene, controller, pairs.seed)  # the scene is the same for every controller
    ends = list(executor.map(_drive_part, parts, shared=shared, on_done=tell))
    joined: dict[str, Any] = {
        name: np.concatenate([part[name] for part in ends], axis=axis)
        for name, axis in (("time", 1), ("pose", 1), ("outcome", 0), ("steps", 0), ("length", 0))
    }
    return Trace(
        commands=np.empty((0, count, 3)),
        channels={},
        mission=mission,
        seed=pairs.seed,
        settings={},
        **joined,
    )


def _drive_part(shared: tuple[Scene, Controller, int], rows: slice) -> Ends:
    """Drive some of the pairs: a job for an executor."""
    scene, controller, seed = shared
    worlds, mission = scene.worlds, scene.mission
    part = dataclasses.replace(
        scene,
        worlds=dataclasses.replace(worlds, of=worlds.of[rows]),
        mission=Mission(
            start=mission.start[rows],
            goal=mission.goal[rows],
            goal_radius=mission.goal_radius,
            time_limit=mission.time_limit,
        ),
    )
    trace = simulate(part.drive(controller), seed=seed, record="none")
    return {name: getattr(trace, name) for name in ("time", "pose", "outcome", "steps", "length")}


def _farthest(side: float) -> float:
    return side if side <= 300.0 else max(300.0, side / 3.0)
