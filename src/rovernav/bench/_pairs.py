"""Controllers side by side on the same ground, between the same pairs of points."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ..core import F64, Controller, Outcome, SettingError, value, wilson
from ..rover import Rover, standing
from ..scenes import Scene, equip, fenced, free_pairs, pair_mission
from ..sim import DriveState, Grid, Trace, Worlds, simulate
from ..terrain import Terrain

GOAL_RADIUS = 0.5


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
    on_event: Callable[[float], object] | None = None,
) -> Score:
    """Drive every pair with one controller.

    Args:
        pairs: Where to drive.
        name: What to call the controller.
        controller: Who drives.
        on_event: Told the share of drives that have ended.
    """
    began = time.perf_counter()

    def watch(state: DriveState) -> None:
        if on_event is not None:
            on_event(1.0 - float(state.rovers.driving.mean()))

    trace = simulate(
        pairs.scene.drive(controller),
        seed=pairs.seed,
        record="none",
        on_event=watch,
    )
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


def _farthest(side: float) -> float:
    return side if side <= 300.0 else max(300.0, side / 3.0)
