"""rovernav, through `simulate`: sensing, deciding, moving, meeting, ending."""

from __future__ import annotations

import functools
import os
from typing import Any

import numpy as np
from harness.model import Result, Stopwatch, Trial

from . import task


class TurnAway:
    """Full speed, turning to the side whose nearest reading is the farther one."""

    def start(self, mission: Any, rng: np.random.Generator) -> None:
        """Nothing to remember."""

    def act(self, observation: Any, memory: None) -> Any:
        """The command of every rover."""
        from rovernav.core import Command

        beams, half = observation.channel("beams"), task.BEAMS // 2
        twist = np.zeros((len(beams), 3))
        twist[:, 0] = task.SPEED
        left = beams[:, half:].min(axis=1) >= beams[:, :half].min(axis=1)
        twist[:, 2] = np.where(left, task.TURN, -task.TURN)
        return Command(twist=twist), None


def fleet(rovers: int, grids: int, steps: int) -> Any:
    """So many rovers in as many different worlds as there are grids."""
    from rovernav.core import Frame, Mission
    from rovernav.sim import DifferentialDrive, Drive, Grid, RangeFan, Worlds

    blocked = np.stack([task.grid(seed) for seed in range(grids)])
    of = np.sort(np.arange(rovers) % grids)
    start = np.concatenate(
        [task.starts(blocked[i], int((of == i).sum()), seed=i + 1) for i in range(grids)]
    )
    worlds = Worlds(
        boxes=np.empty((0, 4)),
        offsets=np.zeros(grids + 1, np.int64),
        bounds=np.tile([0.0, 0.0, task.SIDE, task.SIDE], (grids, 1)),
        of=of,
        grid=Grid(frame=Frame(cell=1.0, shape=(task.SIDE, task.SIDE)), blocked=blocked),
    )
    mission = Mission(
        start=start,
        goal=np.full((rovers, 2), 1e6),
        goal_radius=1.0,
        time_limit=task.PERIOD * steps,
    )
    return Drive(
        worlds=worlds,
        mission=mission,
        sensors=(RangeFan(reach=task.REACH, beams=task.BEAMS, view=task.VIEW),),
        controller=TurnAway(),
        motion=DifferentialDrive(speed=task.SPEED, turn_rate=task.TURN, period=task.PERIOD),
    )


def batch(rovers: int, *, grids: int = 1, workers: int = 1) -> Trial:
    """`task.STEPS` steps of all rovers; the table of the grid is ready before the clock starts."""
    from rovernav.core import RoverState
    from rovernav.sim import simulate

    drive = fleet(rovers, grids, task.STEPS)
    for _ in range(3):  # the table is made once it pays
        seen, _ = drive.sensors[0].read(drive.worlds, RoverState.at_start(drive.mission), None)
    before = _resident()

    def trial(repeats: int) -> Result:
        watch = Stopwatch()
        with watch:
            for _ in range(repeats):
                simulate(drive, record="none", workers=workers)
        note = f"{max(0.0, _resident() - before) / rovers / 1024:.1f} KiB more per rover"
        if grids == 1:
            note = f"mean reading {seen.mean():.6f}; {note}"
        return watch.result(repeats * task.STEPS * rovers, float(seen.mean()))._replace(note=note)

    return trial


def lone(steps: int) -> Trial:
    """One rover on open ground that looks, decides and moves; its whole trace is kept."""
    import dataclasses

    from rovernav.sim import simulate

    drive = fleet(1, 1, steps)
    nothing = np.zeros_like(drive.worlds.grid.blocked)
    grid = dataclasses.replace(drive.worlds.grid, blocked=nothing)
    drive = dataclasses.replace(drive, worlds=dataclasses.replace(drive.worlds, grid=grid))

    def trial(repeats: int) -> Result:
        watch, driven = Stopwatch(), 0.0
        with watch:
            for _ in range(repeats):
                driven = float(simulate(drive, seed=1).length[0])
        return watch.result(repeats, round(driven, 6))

    return trial


def _resident() -> float:
    """Resident memory [bytes]; 0 where the system does not tell."""
    try:
        with open("/proc/self/statm") as file:
            return float(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except OSError:
        return 0.0


ONE = functools.partial(batch, grids=1)
MANY = functools.partial(batch, grids=64)
TWO = functools.partial(batch, grids=1, workers=2)
