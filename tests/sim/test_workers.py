"""However many threads drive a batch, the trace is the same."""

from __future__ import annotations

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
    for workers in (2, 3):
        same(simulate(drive, seed=5, workers=workers), alone)


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


def test_workers_are_counted_from_one() -> None:
    with pytest.raises(SettingError, match="workers must be 1 or more, got 0"):
        simulate(fleet(), workers=0)
