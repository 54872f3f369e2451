"""rovernav, through `simulate`: looking over the ground, deciding, slipping, settling, ending."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
from harness.model import Result, Stopwatch, Trial
from simulate.ours import TurnAway

from . import task


class Slowly(TurnAway):
    """Turns to the freer side, as fast as the rover can."""

    def __init__(self, speed: float, turn: float) -> None:
        self.speed, self.turn = speed, turn

    def act(self, observation: Any, memory: None) -> Any:
        """The command of every rover."""
        from rovernav.core import Command

        beams, half = observation.channel("beams"), task.BEAMS // 2
        twist = np.zeros((len(beams), 3))
        twist[:, 0] = self.speed
        left = beams[:, half:].mean(axis=1) >= beams[:, :half].mean(axis=1)
        twist[:, 2] = np.where(left, self.turn, -self.turn)
        return Command(twist=twist), None


def fleet(rovers: int, setting: task.Setting, *, beams: bool = True) -> Any:
    """So many rovers with bodies that can stand where they begin, on one ground."""
    from rovernav.core import Frame, Mission, RoverState
    from rovernav.rover import read_rover
    from rovernav.sim import Body, Drive, Ground, RangeFan, Worlds

    rover, c = read_rover(setting.rover), setting.cell
    ground = Ground(frame=Frame(cell=c, shape=(task.SIDE, task.SIDE)), height=task.heights(setting))
    body = Body(rover, period=task.PERIOD, spread=0.1)
    few = task.starts(setting, 2 * rovers)

    def mission(start: Any) -> Any:
        goal = np.full((len(start), 2), 1e6)
        return Mission(start=start, goal=goal, goal_radius=1.0, time_limit=task.PERIOD * task.STEPS)

    worlds = Worlds.single(ground=ground, rovers=len(few))
    placed = body.place(worlds, mission(few), RoverState.at_start(mission(few)))
    stands = few[placed.driving][:rovers]
    sensor = RangeFan(reach=task.REACH * c, beams=task.BEAMS, view=task.VIEW, height=setting.eye)
    return Drive(
        worlds=Worlds.single(ground=ground, rovers=len(stands)),
        mission=mission(stands),
        sensors=(sensor,) if beams else (),
        controller=Slowly(rover.speed, 0.5 * rover.turn_rate) if beams else Blind(rover.speed),
        motion=body,
    )


class Blind(TurnAway):
    """Straight on."""

    def __init__(self, speed: float) -> None:
        self.speed = speed

    def act(self, observation: Any, memory: None) -> Any:
        """The command of every rover."""
        from rovernav.core import Command

        twist = np.zeros((len(observation.goal), 3))
        twist[:, 0] = self.speed
        return Command(twist=twist), None


def first_look(drive: Any) -> tuple[Any, Any, Any]:
    """State at the start, as it stands; the first readings; the table is ready after this."""
    from rovernav.core import RoverState

    state = drive.motion.place(drive.worlds, drive.mission, RoverState.at_start(drive.mission))
    seen = np.zeros((len(state.pose), 1))
    for _ in range(3):
        for sensor in drive.sensors:
            seen, _ = sensor.read(drive.worlds, state, None)
    return drive, state, seen


def batch(rovers: int, *, setting: task.Setting, workers: int = 1, beams: bool = True) -> Trial:
    """`task.STEPS` steps of all rovers; only steps of rovers that still drive count."""
    from rovernav.sim import simulate

    drive, _, seen = first_look(fleet(rovers, setting, beams=beams))

    def trial(repeats: int) -> Result:
        watch, steps, trace = Stopwatch(), 0, None
        with watch:
            for _ in range(repeats):
                trace = simulate(drive, record="none", workers=workers)
                steps += int(trace.steps.sum())
        share = steps / repeats / (task.STEPS * len(drive.mission.start))
        note = f"mean reading {seen.mean() / setting.cell:.4f} cells; {100 * share:.1f} % driven"
        check = float(seen.mean() / setting.cell) if beams else float("nan")
        return watch.result(steps, check)._replace(note=note)

    return trial


def beams_alone(rovers: int, *, setting: task.Setting, plain: bool = False) -> Trial:
    """The first fan of all rovers, over and over; by table, or by the plain walk."""
    from rovernav.kernels import ridge_fan, ridge_tops
    from rovernav.sim import _seeing

    drive, state, seen = first_look(fleet(rovers, setting))
    ground, sensor = _seeing.seen(drive.worlds), drive.sensors[0]
    looks = looks_of(drive, state, ground, setting)
    out, none = np.empty_like(seen), ridge_tops.empty_tops(0, 0, 0)
    ridge_fan.ground_fan(looks, sensor.reach, ground, none, out)
    mean = float((np.minimum(out, 1.0) * task.REACH).mean())

    def trial(repeats: int) -> Result:
        watch = Stopwatch()
        with watch:
            for _ in range(repeats):
                if plain:
                    ridge_fan.ground_fan(looks, sensor.reach, ground, none, out)
                else:
                    sensor.read(drive.worlds, state, None)
        return watch.result(repeats * len(seen), mean)._replace(note="beams alone")

    return trial


def looks_of(drive: Any, state: Any, ground: Any, setting: task.Setting) -> Any:
    """Eyes and ways of the rovers as the kernels take them."""
    from rovernav.kernels.ridge_fan import Looks, looks_of

    angles, n = drive.sensors[0].angles, len(state.pose)
    ways = np.stack([np.cos(angles), np.sin(angles)])
    looks = Looks(np.empty((n, 3)), np.empty((n, 2, 3)), ways, np.zeros(n, np.int64))
    looks_of(state.pose, state.attitude, setting.eye, ground, looks)
    return looks


SIX, FOUR = (functools.partial(batch, setting=setting) for setting in (task.SIX, task.FOUR))
SIX_TWO, FOUR_TWO = (functools.partial(each, workers=2) for each in (SIX, FOUR))
SIX_BLIND, FOUR_BLIND = (functools.partial(each, beams=False) for each in (SIX, FOUR))
LOOKING = functools.partial(beams_alone, setting=task.FOUR)
WALKING = functools.partial(beams_alone, setting=task.FOUR, plain=True)
