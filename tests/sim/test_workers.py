"""However many threads drive a batch, the trace is the same."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from rovernav.core import Command, Frame, Mission, Observation, SettingError
from rovernav.sim import (
    DifferentialDrive,
    Drive,
    DriveState,
    Grid,
    NoisyFan,
    RangeFan,
    RangeNoise,
    Trace,
    Worlds,
    simulate,
)
from rovernav.sim._crew import FEW, NEAR, neighbours

N = 150


class TurnAway:
    """Turns to the side where there is more room."""

    def start(self, mission: Mission, rng: np.random.Generator) -> None:
        return

    def act(self, observation: Observation, memory: Any) -> tuple[Command, Any]:
        beams = observation.channel("beams")
        twist = np.zeros((len(beams), 3))
        twist[:, 0], twist[:, 2] = 1.0, beams[:, 5:].sum(axis=1) - beams[:, :4].sum(axis=1)
        return Command(twist=twist), memory


def fleet(*, noisy: bool = False) -> Drive:
    rng = np.random.default_rng(0)
    blocked = (rng.random((3, 60, 60)) < 0.01).astype(np.uint8)
    start = rng.uniform((2, 2, -3), (58, 58, 3), (N, 3))
    worlds = Worlds(
        boxes=np.empty((0, 4)),
        offsets=np.zeros(4, np.int64),
        bounds=np.tile([0.0, 0, 60, 60], (3, 1)),
        of=rng.integers(0, 3, N),
        grid=Grid(frame=Frame(cell=1.0, shape=(60, 60)), blocked=blocked),
    )
    fan = RangeFan(reach=8.0, beams=9)
    noise = RangeNoise(spread=0.05, stray=0.05)
    return Drive(
        worlds=worlds,
        mission=Mission(start=start, goal=start[::-1, :2].copy(), goal_radius=2.0, time_limit=20.0),
        sensors=(NoisyFan(fan, noise) if noisy else fan,),
        controller=TurnAway(),
        motion=DifferentialDrive(speed=1.0, turn_rate=1.0, period=0.5),
    )


def same(one: Trace, other: Trace) -> None:
    for name in ("time", "pose", "commands", "outcome", "steps", "length"):
        assert_array_equal(getattr(one, name), getattr(other, name))
    assert list(one.channels) == list(other.channels)
    for name, reading in one.channels.items():
        assert_array_equal(other.channels[name], reading)


@pytest.mark.parametrize("noisy", [False, True])
def test_threads_change_no_bit(noisy: bool) -> None:
    drive = fleet(noisy=noisy)
    alone = simulate(drive, seed=5)
    assert len(set(alone.outcome.tolist())) >= 2
    assert len(set(alone.steps.tolist())) > 10
    for workers in (2, 3):
        same(simulate(drive, seed=5, workers=workers), alone)
        same(simulate(drive, seed=5, workers=workers, on_event=lambda _: None), alone)


@pytest.mark.parametrize("record", ["path", "none"])
def test_threads_change_nothing_of_what_is_kept(record: str) -> None:
    drive = fleet()
    alone = simulate(drive, seed=5, record=record)
    same(simulate(drive, seed=5, record=record, workers=2), alone)


def test_parts_of_different_length_are_kept_to_the_end_of_the_longest() -> None:
    """The first rovers begin at their goals, so that their parts have ended before they begin."""
    drive = fleet()
    goal = drive.mission.goal.copy()
    goal[:100] = drive.mission.start[:100, :2]
    drive = dataclasses.replace(drive, mission=dataclasses.replace(drive.mission, goal=goal))
    for record in ("all", "path", "none"):
        alone = simulate(drive, seed=5, record=record)
        assert alone.steps[:100].max() == 0 < alone.steps[100:].max()
        same(simulate(drive, seed=5, record=record, workers=2), alone)


def test_rovers_in_many_large_worlds_are_driven_a_few_worlds_at_a_time() -> None:
    """Parts of a batch change no bit either, and a batch in no order stays whole."""
    drive = fleet(noisy=True)
    many = 6 * FEW
    of, rng = np.sort(np.arange(many) % 3), np.random.default_rng(1)
    blocked = np.zeros((3, 700, 700), np.uint8)
    blocked[:, :60, :60] = rng.random((3, 60, 60)) < 0.01
    grid = Grid(frame=Frame(cell=1.0, shape=(700, 700)), blocked=blocked)
    worlds = dataclasses.replace(drive.worlds, of=of, grid=grid)
    assert neighbours(worlds) == int(many * NEAR / blocked.size)
    assert neighbours(drive.worlds) is None
    assert neighbours(dataclasses.replace(worlds, of=of[::-1].copy())) is None
    start = rng.uniform((2, 2, -3), (58, 58, 3), (many, 3))
    goal = start[::-1, :2].copy()
    mission = Mission(start=start, goal=goal, goal_radius=2.0, time_limit=4.0)
    drive = dataclasses.replace(drive, worlds=worlds, mission=mission)
    watched = simulate(drive, seed=3, on_event=lambda _: None)
    for workers in (1, 2):
        same(simulate(drive, seed=3, workers=workers), watched)


def test_a_watcher_sees_the_whole_batch_and_may_end_the_drive() -> None:
    seen: list[DriveState] = []

    def watch(state: DriveState) -> bool:
        seen.append(state)
        return len(seen) < 3

    trace = simulate(fleet(), workers=2, on_event=watch, record="path")
    assert len(trace.pose) == 4
    for state, pose in zip(seen, trace.pose[1:], strict=True):
        assert state.observation is not None
        assert state.command is not None
        assert state.observation.channel("beams").shape == (N, 9)
        assert state.command.twist.shape == (N, 3)
        assert_array_equal(state.rovers.pose, pose)


def test_an_error_in_a_part_is_raised() -> None:
    class Breaks(TurnAway):
        def act(self, observation: Observation, memory: Any) -> tuple[Command, Any]:
            raise ZeroDivisionError

    drive = fleet()
    broken = Drive(
        worlds=drive.worlds,
        mission=drive.mission,
        sensors=drive.sensors,
        controller=Breaks(),
        motion=drive.motion,
    )
    with pytest.raises(ZeroDivisionError):
        simulate(broken, workers=2)


def test_an_error_in_one_part_ends_the_others() -> None:
    """Rovers that nothing stops: without a word from the part that breaks, they would go on."""

    class BreaksOnce(TurnAway):
        def act(self, observation: Observation, memory: Any) -> tuple[Command, Any]:
            if (observation.goal[:, 0] > 1e8).any():
                raise ZeroDivisionError
            return Command(twist=np.zeros((len(observation.goal), 3))), memory

    drive = fleet()
    goal = np.full((N, 2), 30.0)
    goal[-1] = 1e9
    start = np.tile([30.5, 30.5, 0.0], (N, 1))
    endless = Mission(start=start, goal=goal, goal_radius=0.1, time_limit=1e12)
    free = Worlds.single(rovers=N)
    broken = dataclasses.replace(drive, mission=endless, worlds=free, controller=BreaksOnce())
    with pytest.raises(ZeroDivisionError):
        simulate(broken, workers=2, record="none")


def test_workers_are_counted_from_one() -> None:
    with pytest.raises(SettingError, match="workers must be 1 or more, got 0"):
        simulate(fleet(), workers=0)
