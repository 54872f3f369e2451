"""Where a world lies and how it is turned must not matter."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from rovernav.control import NeuralController
from rovernav.core import Controller, Mission, Outcome
from rovernav.learn import trained_paper_network
from rovernav.scenes import OBSTACLE, A, B, Scene, bassil_scene
from rovernav.sim import Drive, Trace, Worlds, clearance, simulate
from tests.sim.drives import Mirrored

PAPER = bassil_scene()
DRIVER = NeuralController(trained_paper_network())


def drive(scene: Scene, worlds: Worlds, mission: Mission, controller: Controller) -> Trace:
    return simulate(
        Drive(
            worlds=worlds,
            mission=mission,
            sensors=scene.sensors,
            controller=controller,
            motion=scene.motion,
        )
    )


def turn(x: float, y: float, quarters: int) -> tuple[float, float]:
    for _ in range(quarters):
        x, y = -y, x
    return x, y


@settings(max_examples=25)
@given(
    quarters=st.integers(0, 3),
    dx=st.floats(-500.0, 500.0),
    dy=st.floats(-500.0, 500.0),
)
def test_a_turned_and_shifted_world_gives_the_turned_and_shifted_drive(
    quarters: int, dx: float, dy: float
) -> None:
    def put(x: float, y: float) -> tuple[float, float]:
        x, y = turn(x, y, quarters)
        return x + dx, y + dy

    (xa, ya), (xb, yb) = put(*OBSTACLE[:2]), put(*OBSTACLE[2:])
    box = (min(xa, xb), min(ya, yb), max(xa, xb), max(ya, yb))
    bounds = (dx - 20, dy - 20, dx + 20, dy + 20)
    worlds = Worlds.single([box], bounds=bounds)
    mission = Mission.between(put(*A), put(*B), goal_radius=1e-9, time_limit=60.0)
    here = drive(PAPER, PAPER.worlds, PAPER.mission, DRIVER)
    there = drive(PAPER, worlds, mission, DRIVER)
    assert there.ended() is Outcome.REACHED
    assert_allclose(there.path(), [put(x, y) for x, y in here.path()], rtol=0, atol=1e-9)
    assert_allclose(there.commands, here.commands, rtol=0, atol=1e-9)
    gaps = clearance(here.path(), PAPER.worlds), clearance(there.path(), worlds)
    assert gaps[0] == pytest.approx(gaps[1], abs=1e-9)
    heading = there.pose[0, 0, 2] - quarters * math.pi / 2
    assert math.remainder(heading, 2 * math.pi) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("obstacle", ["paper", "mirrored", "none"])
def test_a_mirrored_driver_drives_the_mirrored_way(obstacle: str) -> None:
    scene = bassil_scene(obstacle=obstacle)
    boxes = scene.worlds.boxes[:, [0, 3, 2, 1]] * (1, -1, 1, -1)
    here = drive(scene, scene.worlds, scene.mission, DRIVER)
    worlds = Worlds.single(boxes.tolist(), bounds=(-20, -20, 20, 20))
    there = drive(scene, worlds, scene.mission, Mirrored(DRIVER))
    assert there.ended() is here.ended()
    assert_array_equal(there.pose, here.pose * (1, -1, -1))
    assert_array_equal(there.commands, here.commands * (1, -1, -1))
    for name, reading in here.channels.items():
        assert_array_equal(there.channels[name], reading)
