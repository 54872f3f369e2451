"""Controllers side by side on the same ground, between the same pairs of points."""

from __future__ import annotations

import dataclasses
import itertools
import math
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ..core import (
    F64,
    Controller,
    Executor,
    Metric,
    Mission,
    Outcome,
    Serial,
    SettingError,
    value,
    wilson,
)
from ..rover import Rover, standing
from ..scenes import Scene, carry, equip, fenced, free_pairs, pair_mission
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
        metrics: Of each metric that was asked for: median, and over how many drives.
    """

    name: str
    trace: Trace
    counts: Mapping[str, int]
    reached: float
    low: float
    high: float
    detour: float
    seconds: float
    metrics: Mapping[str, Mapping[str, Any]] = dataclasses.field(default_factory=dict)

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
            "metrics": {name: dict(found) for name, found in self.metrics.items()},
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


def carrying(pairs: Pairs, names: Sequence[str]) -> Pairs:
    """The same pairs for a rover that carries sensors of installed plug-ins besides.

    Raises:
        RovernavError: As of `rovernav.scenes.carry`.
    """
    return dataclasses.replace(pairs, scene=carry(pairs.scene, names))


def score(
    pairs: Pairs,
    name: str,
    controller: Controller,
    *,
    executor: Executor | None = None,
    on_event: Callable[[float], object] | None = None,
    metrics: Sequence[Metric] = (),
) -> Score:
    """Drive every pair with one controller.

    Args:
        pairs: Where to drive.
        name: What to call the controller.
        controller: Who drives.
        executor: Who does the work, some pairs at a time; this thread where not given. It changes
            nothing in the score but `seconds`, because no drive depends on those beside it.
        on_event: Told the share of drives that have ended.
        metrics: What else to measure; then the paths of all drives are recorded meanwhile.
    """
    began = time.perf_counter()
    if executor is None or isinstance(executor, Serial):
        trace, values = _drive(pairs, controller, on_event, metrics)
    else:
        trace, values = _drive_apart(pairs, controller, executor, on_event, metrics)
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
        metrics={one.name: _median(*values[one.name]) for one in metrics},
    )


def _median(values: Any, valid: Any) -> dict[str, Any]:
    count = int(valid.sum())
    return {"median": float(np.median(values[valid])) if count else None, "drives": count}


Told = Callable[[float], object] | None
Ends = dict[str, Any]
"""Arrays of a trace without record: time, pose, outcome, steps, length."""


Measured = dict[str, tuple[Any, Any]]
"""Values and which of them mean something, by metric."""


def _drive(
    pairs: Pairs, controller: Controller, on_event: Told, metrics: Sequence[Metric]
) -> tuple[Trace, Measured]:
    """All pairs as one batch, in this thread."""

    def watch(state: DriveState) -> None:
        if on_event is not None:
            on_event(1.0 - float(state.rovers.driving.mean()))

    return _measured(pairs.scene, controller, pairs.seed, metrics, watch)


def _measured(
    scene: Scene,
    controller: Controller,
    seed: int,
    metrics: Sequence[Metric],
    watch: Callable[[DriveState], None] | None = None,
) -> tuple[Trace, Measured]:
    record = "path" if metrics else "none"
    trace = simulate(scene.drive(controller), seed=seed, record=record, on_event=watch)
    values = {metric.name: metric.compute(trace, scene.worlds) for metric in metrics}
    last = {name: getattr(trace, name)[-1:] for name in ("time", "pose")}
    return dataclasses.replace(trace, **last), values


def _drive_apart(
    pairs: Pairs,
    controller: Controller,
    executor: Executor,
    on_event: Told,
    metrics: Sequence[Metric],
) -> tuple[Trace, Measured]:
    """The same trace from parts that others drive."""
    mission = pairs.scene.mission
    count = len(mission.start)
    parts = [slice(at, min(at + TOGETHER, count)) for at in range(0, count, TOGETHER)]
    done = itertools.count(1)

    def tell() -> None:
        if on_event is not None:
            on_event(next(done) / len(parts))

    shared = (
        pairs.scene,
        controller,
        pairs.seed,
        tuple(metrics),
    )  # the scene is the same for every controller
    ends = list(executor.map(_drive_part, parts, shared=shared, on_done=tell))
    joined: dict[str, Any] = {
        name: np.concatenate([part[name] for part in ends], axis=axis)
        for name, axis in (("time", 1), ("pose", 1), ("outcome", 0), ("steps", 0), ("length", 0))
    }
    trace = Trace(
        commands=np.empty((0, count, 3)),
        channels={},
        mission=mission,
        seed=pairs.seed,
        settings={},
        **joined,
    )
    values = {one.name: _joined(ends, f"metric:{one.name}") for one in metrics}
    return trace, values


def _joined(ends: Sequence[Ends], key: str) -> tuple[Any, Any]:
    values, valid = (np.concatenate([part[key][i] for part in ends]) for i in (0, 1))
    return values, valid


def _drive_part(shared: tuple[Scene, Controller, int, tuple[Metric, ...]], rows: slice) -> Ends:
    """Drive some of the pairs: a job for an executor."""
    scene, controller, seed, metrics = shared
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
    trace, values = _measured(part, controller, seed, metrics)
    ends = {name: getattr(trace, name) for name in ("time", "pose", "outcome", "steps", "length")}
    return {**ends, **{f"metric:{name}": of for name, of in values.items()}}


def _farthest(side: float) -> float:
    return side if side <= 300.0 else max(300.0, side / 3.0)
