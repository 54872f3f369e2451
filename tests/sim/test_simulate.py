"""The one loop: folding, watching, recording, and what it refuses."""

from __future__ import annotations

import dataclasses
import math
import re
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from rovernav.control import NeuralController
from rovernav.core import Mission, Outcome, RoverState, SettingError, ShapeError
from rovernav.learn import trained_paper_network
from rovernav.scenes import bassil_scene, random_rectangles
from rovernav.sim import (
    ClearSight,
    Drive,
    DriveState,
    OffLine,
    Trace,
    TwoAxis,
    Worlds,
    begin,
    simulate,
    tick,
)
from tests.sim.drives import Always, drive, mission


def bassil() -> Drive:
    return bassil_scene().drive(NeuralController(trained_paper_network()))


def batch(count: int = 40) -> Drive:
    scene = random_rectangles(count, np.random.default_rng(0))
    return scene.drive(NeuralController(trained_paper_network()))


def fields(trace: Trace) -> dict[str, Any]:
    names = ("time", "pose", "commands", "outcome", "steps", "length", "seed")
    return {**{name: getattr(trace, name) for name in names}, **trace.channels}


def assert_same(a: Trace, b: Trace) -> None:
    assert list(fields(a)) == list(fields(b))
    for name, item in fields(a).items():
        assert_array_equal(item, fields(b)[name], err_msg=name)


def test_folding_tick_by_hand_is_simulate() -> None:
    set_up = batch()
    trace = simulate(set_up)
    states = [begin(set_up, np.random.default_rng(0))]
    while states[-1].rovers.driving.any():
        states.append(tick(set_up, states[-1]))
    assert_array_equal(trace.pose, [s.rovers.pose for s in states])
    assert_array_equal(trace.time, [s.rovers.time for s in states])
    assert_array_equal(trace.commands, [s.command.twist for s in states[1:] if s.command])
    for name, reading in trace.channels.items():
        seen = [s.observation.channel(name) for s in states[1:] if s.observation]
        assert_array_equal(reading, seen)
    assert_array_equal(trace.length, states[-1].rovers.odometry)
    assert_array_equal(trace.outcome, states[-1].rovers.outcome)
    driving = np.array([s.rovers.driving for s in states])
    assert_array_equal(trace.steps, driving.sum(0))


def test_a_state_can_be_gone_on_from_more_than_once() -> None:
    set_up = bassil()
    middle = begin(set_up, np.random.default_rng(0))
    for _ in range(6):
        middle = tick(set_up, middle)
    first, second = tick(set_up, middle), tick(set_up, middle)
    assert_array_equal(first.rovers.pose, second.rovers.pose)
    assert_array_equal(first.rovers.pose, simulate(set_up).pose[7])


def test_a_rover_moves_while_it_drives_and_senses_where_it_stands() -> None:
    trace = simulate(bassil())
    x, y = trace.pose[:-1, 0, :2].T
    assert_array_equal(trace.channels["off_line"][:, 0, 0], abs(y) > 0.41435)
    assert_array_equal(trace.time[:, 0], np.arange(16))
    assert (np.diff(x) > 0).all()


def test_watchers_see_every_step_and_change_nothing() -> None:
    times: list[float] = []

    def watch(state: DriveState) -> None:
        times.append(float(state.rovers.time[0]))
        for array in (state.rovers.pose, state.rovers.outcome):
            with pytest.raises(ValueError, match="read-only"):
                array[0] = 0
        with pytest.raises(dataclasses.FrozenInstanceError):
            state.rovers = state.rovers  # type: ignore[misc]
        assert state.observation is not None
        with pytest.raises(ValueError, match="read-only"):
            state.observation.channel("off_line")[0] = 1.0
        with pytest.raises(TypeError):
            state.observation.channels["off_line"] = np.ones((1, 1))  # type: ignore[index]

    assert_same(simulate(bassil(), on_event=watch), simulate(bassil()))
    assert times == list(range(1, 16))


def test_a_watcher_can_end_a_drive_early() -> None:
    trace = simulate(bassil(), on_event=lambda state: float(state.rovers.time[0]) < 4)
    assert trace.ended() is Outcome.DRIVING
    assert trace.steps[0] == 4
    assert_array_equal(trace.path(), simulate(bassil()).path()[:5])


def test_records_keep_as_much_as_they_say() -> None:
    whole, path, ends = (simulate(batch(), record=r) for r in ("all", "path", "none"))
    for part in (path, ends):
        assert_array_equal(part.outcome, whole.outcome)
        assert_array_equal(part.steps, whole.steps)
        assert_array_equal(part.length, whole.length)
        assert part.commands.shape == (0, 40, 3)
        assert dict(part.channels) == {}
    assert_array_equal(path.pose, whole.pose)
    assert_array_equal(ends.pose, whole.pose[-1:])
    assert_array_equal(ends.path(3), whole.path(3)[-1:])
    assert whole.commands.shape == (len(whole.time) - 1, 40, 3)
    with pytest.raises(SettingError, match=r"unknown record 'paths'; did you mean 'path'\?"):
        simulate(bassil(), record="paths")


def test_seed_and_settings_travel_in_the_trace() -> None:
    trace = simulate(bassil(), seed=5, settings={"scenario": "bassil-v1"})
    assert (trace.seed, trace.settings) == (5, {"scenario": "bassil-v1"})
    assert_array_equal(trace.pose, simulate(bassil(), seed=6).pose)


def test_no_rovers_are_a_drive_too() -> None:
    trace = simulate(drive(Always(1.0, 0.0, 0.0), starts=[]))
    assert trace.pose.shape == (1, 0, 3)
    assert trace.outcome.shape == (0,)


def test_a_missing_sensor_is_named() -> None:
    set_up = dataclasses.replace(bassil(), sensors=(ClearSight(),))
    with pytest.raises(ShapeError) as missing:
        simulate(set_up)
    assert str(missing.value) == (
        "the controller needs the sensor 'off_line', which this rover does not carry; "
        "it carries: clear_sight"
    )


def test_two_sensors_of_one_name_are_refused() -> None:
    with pytest.raises(SettingError, match="needs a name of its own, got off_line, off_line"):
        drive(Always(0.0, 0.0, 0.0), sensors=(OffLine(1.0), OffLine(2.0)))


def test_missions_and_worlds_must_be_for_as_many_rovers() -> None:
    with pytest.raises(ShapeError, match="2 missions need as many rovers in worlds, got 1"):
        drive(
            Always(0.0, 0.0, 0.0), mission=mission([[0, 0, 0]] * 2, (1, 1), limit=1.0),
            worlds=Worlds.single(),
        )  # fmt: skip


@pytest.mark.parametrize("number", [math.nan, math.inf, -1.0])
@pytest.mark.parametrize("what", ["goal_radius", "time_limit"])
def test_a_mission_that_might_never_end_is_refused(what: str, number: float) -> None:
    with pytest.raises(SettingError, match=f"a mission's {what.replace('_', ' ')} must be 0 or a"):
        dataclasses.replace(mission([[0, 0, 0]], (1, 1), limit=1.0), **{what: number})


class Odd:
    """A sensor that reads for too few rovers."""

    name = "odd"

    def start(self, mission: Mission, rng: np.random.Generator) -> None:
        return

    def read(self, world: Worlds, state: RoverState, memory: None) -> tuple[Any, None]:
        return np.zeros((1, 4)), None


def test_parts_that_answer_for_too_few_rovers_are_refused() -> None:
    two = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]
    message = "readings of the sensor 'odd' must have shape (2, b), got (1, 4)"
    with pytest.raises(ShapeError, match=re.escape(message)):
        simulate(drive(Always(0.0, 0.0, 0.0), starts=two, sensors=(Odd(),)))

    class Short:
        def start(self, mission: Mission, rng: np.random.Generator) -> None:
            return

        def act(self, observation: Any, memory: None) -> Any:
            return Always(1.0, 0.0, 0.0).act(dataclasses.replace(observation, goal=[0]), None)

    with pytest.raises(ShapeError, match=re.escape("commands must have shape (2, 3), got (1, 3)")):
        simulate(drive(Short(), starts=two))


@pytest.mark.parametrize("period", [0.0, -1.0, float("nan"), float("inf")])
def test_a_period_is_a_positive_time(period: float) -> None:
    with pytest.raises(SettingError, match="the period must be above 0 s"):
        TwoAxis(period)


@pytest.mark.parametrize("threshold", [-0.1, float("nan"), float("inf")])
def test_a_threshold_is_a_distance(threshold: float) -> None:
    with pytest.raises(SettingError, match="the threshold must be 0 m or more"):
        OffLine(threshold)
