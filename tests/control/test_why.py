from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rovernav.control import GoalSeeker, HeadingCodec, NeuralController, SensedPlanner, explain
from rovernav.learn import find_controller, trained_paper_network
from tests.control.observations import one, scanned
from tests.sim.drives import Always

ALL = ("neural", "goal-seeker", "planner")


@pytest.mark.parametrize("name", ALL)
def test_the_told_direction_is_the_one_that_is_steered(name: str, rng: np.random.Generator) -> None:
    controller: Any = find_controller(name)
    seen = scanned(40, rng)
    command, _ = controller.act(seen, None)
    codec = controller.codec
    for k in range(40):
        why = explain(controller, seen, k=k)
        assert np.array_equal(why.command, command.twist[k])
        if why.headings is None:
            continue
        turn = np.clip(why.headings.angle / codec.period, -codec.turn_rate, codec.turn_rate)
        assert_allclose(why.command[2], turn, rtol=0, atol=1e-9)
        assert why.headings.share.sum() == pytest.approx(1.0)
        assert int(np.argmax(why.headings.share)) == why.headings.chosen


def test_a_networks_reason_adds_up(rng: np.random.Generator) -> None:
    controller: Any = find_controller("neural")
    seen = scanned(5, rng)
    for k in range(5):
        why = explain(controller, seen, k=k)
        assert why.network is not None
        assert why.headings is not None
        assert_allclose(why.network.contributions.sum(axis=1), why.network.sums, rtol=0, atol=1e-9)
        assert_allclose(why.network.sums, why.network.outputs, rtol=0, atol=1e-9)
        assert [name for name, _, _ in why.inputs[:2]] == ["free_0", "free_1"]
        assert why.network.sensitivity.shape == (1, 67)
        assert why.network.asked == (why.headings.chosen,)
        assert len(why.output_names) == 32


@pytest.mark.parametrize(
    ("sight", "off", "there"),
    [
        (0.0, 0.0, "blocked. Sensor y: the rover is on the line"),
        (1.0, 1.0, "free. Sensor y: the rover is off the line"),
    ],
)
def test_the_papers_network_says_what_its_two_bits_were(
    sight: float, off: float, there: str
) -> None:
    why = explain(NeuralController(trained_paper_network()), one(sight, off))
    said = " ".join(why.words)
    assert there in said
    assert ("which side" in said) == (sight == 0.0)
    assert why.inputs == (("clear_sight", sight, "1"), ("off_line", off, "1"))
    assert why.output_names == ("motor_x", "motor_y")
    assert why.network is not None
    assert why.network.contributions.shape == (2, 4)
    assert_allclose(why.command[:2], 0.8287 * why.network.outputs, rtol=1e-12)


def test_the_last_step_ends_at_the_goal() -> None:
    why = explain(NeuralController(trained_paper_network()), one(1.0, 0.0, goal=(0.3, 0.1)))
    assert "the step ends at it" in why.words[-1]
    assert_allclose(why.command[:2], [0.3, 0.1])


def test_the_goal_seeker_says_that_it_looks_for_no_way_round(rng: np.random.Generator) -> None:
    why = explain(GoalSeeker(), scanned(1, rng))
    assert "never looks for a way round" in why.words[1]
    assert [name for name, _, _ in why.inputs] == ["goal_forward", "goal_left", "nearest_beam"]


def test_the_planner_says_what_the_straight_way_would_cost() -> None:
    fan = np.linspace(-math.pi / 2, math.pi / 2, 49)
    from rovernav.core import Mission, Observation
    from rovernav.mapping import LocalMapper

    mapper = LocalMapper(fan, reach=6.0)
    goal = np.array([[5.0, 0.0]])
    mission = Mission(start=np.zeros((1, 3)), goal=goal, goal_radius=0.1, time_limit=9.0)
    wall = np.where(np.abs(fan) < 0.5, 2.0 / np.cos(np.clip(fan, -0.5, 0.5)), 6.0)[None]
    more, local = mapper.update(mapper.start(mission), mission.start, goal, {"beams": wall})
    seen = Observation(
        goal=goal, twist=np.zeros((1, 3)), channels={"beams": wall, **more}, map=local
    )
    why = explain(SensedPlanner(), seen)
    assert any(words.startswith("Straight at the goal would cost") for words in why.words)
    assert why.headings is not None
    assert abs(why.headings.angle) > 0.3


def test_a_choice_follows_the_cost_of_turning() -> None:
    codec = HeadingCodec(headings=4, commitment=2.0)
    seen = scanned(1, np.random.default_rng(0))
    behind = np.array([[0.0, 0.1, 3.0, 0.1]])
    reading = codec.read(behind, seen)
    assert reading.headings is not None
    assert any("turning costs 2 per radian" in words for words in reading.words) == (
        reading.headings.chosen != 2
    )


def test_who_cannot_say_why_is_shown_by_the_command() -> None:
    why = explain(Always(1.0, -0.5, 0.1), one(0.0, 0.0))
    assert why.words[0].startswith("Always does not say why; the command is: drive forward at 1.00")
    assert "right at 0.50 m/s" in why.words[0]
    assert "turn left at 6°/s" in why.words[0]
