"""Every number that the project states about the seed paper's test case."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from rovernav.control import NeuralController
from rovernav.core import Outcome, SettingError
from rovernav.learn import literal_pass, paper_network, paper_training, train, trained_paper_network
from rovernav.nets import Network
from rovernav.scenes import OBSTACLE, PAPER_POINTS, STEP, A, B, bassil_scene, scenario_names
from rovernav.sim import OffLine, Trace, clearance, path_length, simulate

NAMES = ("bassil-v1", "bassil-replay-v1")


def drive(name: str, network: Network | None = None, obstacle: str = "paper") -> Trace:
    driver = NeuralController(network or trained_paper_network(name))
    return simulate(bassil_scene(name, obstacle=obstacle).drive(driver))


@pytest.fixture(scope="module")
def v1() -> Trace:
    return drive("bassil-v1")


@pytest.fixture(scope="module")
def replay() -> Trace:
    return drive("bassil-replay-v1")


def test_v1_reaches_b_in_15_steps_without_a_collision(v1: Trace) -> None:
    assert v1.ended() is Outcome.REACHED
    assert v1.steps[0] == 15
    assert_allclose(v1.path()[-1], B, rtol=0, atol=1e-9)
    assert v1.time[-1, 0] == 15.0


def test_v1_is_as_near_to_the_papers_points_as_stated(v1: Trace) -> None:
    path = v1.path()
    assert_allclose(path[0], (0.0, 0.0), rtol=0, atol=0)
    assert_allclose(path[1], PAPER_POINTS["first"], rtol=0, atol=0.01)
    assert path[:, 1].argmax() == 7
    assert_allclose(path[7], PAPER_POINTS["apex"], rtol=0, atol=0.15)
    assert np.linalg.norm(path[14] - B) < 0.16


def test_v1_measures_what_was_measured(v1: Trace) -> None:
    path = v1.path()
    assert_allclose(path[1], (0.8290, 0.8369), rtol=0, atol=1e-3)
    assert_allclose(path[7], (5.8005, 5.7915), rtol=0, atol=1e-3)
    assert_allclose(path[14], (11.602, 0.017), rtol=0, atol=1e-3)


def test_v1_goes_7_steps_up_and_7_down_and_cuts_the_last(v1: Trace) -> None:
    climb = np.diff(v1.path()[:, 1])
    assert (climb[:7] > 0.8).all()
    assert (climb[7:14] < -0.8).all()
    assert abs(climb[14]) < 0.02


def test_v1_meets_its_patterns_as_often_as_stated(v1: Trace) -> None:
    sight, off = v1.channels["clear_sight"][:, 0, 0], v1.channels["off_line"][:, 0, 0]
    met = [f"{int(x)}{int(y)}" for x, y in zip(sight, off, strict=True)]
    assert met == ["00"] + 6 * ["01"] + 7 * ["11"] + ["10"]


def test_v1_stays_clear_of_the_obstacle(v1: Trace) -> None:
    gap = clearance(v1.path(), bassil_scene().worlds)
    assert gap >= 0.30
    assert gap == pytest.approx(0.343, abs=1e-3)


def test_v1_odometer_shows_the_length_of_the_path(v1: Trace) -> None:
    assert v1.length[0] == pytest.approx(path_length(v1.path()), abs=1e-12)


@pytest.mark.parametrize(("name", "epochs"), [("bassil-v1", 215), ("bassil-replay-v1", 402)])
def test_training_takes_the_stated_epochs(name: str, epochs: int) -> None:
    assert train(*paper_training(name)).epoch == epochs


def test_replay_gives_back_its_six_numbers(replay: Trace) -> None:
    path = replay.path()
    assert replay.ended() is Outcome.REACHED
    assert replay.steps[0] == 14
    assert path[:, 1].argmax() == 7
    for step, measured in ((1, (0.8281, 0.8297)), (7, (5.6725, 5.8970)), (14, (11.728, 0.002))):
        assert_allclose(path[step], measured, rtol=0, atol=1e-3)
    for step, printed in ((1, "first"), (7, "apex"), (14, "end")):
        assert_allclose(path[step], PAPER_POINTS[printed], rtol=0, atol=3e-3)


@pytest.mark.parametrize("name", NAMES)
def test_untrained_weights_never_reach_b(name: str) -> None:
    assert drive(name, paper_network(name)).ended() is not Outcome.REACHED


def test_one_literal_pass_forgets_and_drives_into_the_obstacle() -> None:
    forgetful = literal_pass()
    assert_allclose(forgetful.forward([[0.0, 0.0]]), [[0.970, 0.003]], rtol=0, atol=5e-4)
    trace = drive("bassil-v1", forgetful)
    assert trace.ended() is Outcome.COLLIDED
    assert trace.path()[-1, 0] == pytest.approx(OBSTACLE[0], abs=1e-12)


def test_without_an_obstacle_15_straight_steps_lead_to_b() -> None:
    trace = drive("bassil-v1", obstacle="none")
    assert trace.ended() is Outcome.REACHED
    assert trace.steps[0] == 15
    assert abs(trace.path()[:, 1]).max() < 0.06
    assert path_length(trace.path()) < B[0] + 0.02


@pytest.mark.parametrize("name", NAMES)
def test_two_bits_cannot_tell_on_which_side_to_pass(name: str) -> None:
    assert drive(name, obstacle="mirrored").ended() is Outcome.COLLIDED


def test_the_mirrored_obstacle_is_the_mirrored_obstacle() -> None:
    (x0, y0, x1, y1), mirrored = OBSTACLE, bassil_scene(obstacle="mirrored").worlds.boxes
    assert_array_equal(mirrored, [[x0, -y1, x1, -y0]])
    assert len(bassil_scene(obstacle="none").worlds.boxes) == 0


def test_scene_and_network_agree_on_what_is_assumed() -> None:
    assert (A, B, STEP) == ((0.0, 0.0), (11.73, 0.0), 0.8287)
    assert OBSTACLE == (4.365, -1.0, 7.365, 3.75)
    for name, step, radius in (("bassil-v1", STEP, 1e-9), ("bassil-replay-v1", 1.0, 0.05)):
        scene, codec = bassil_scene(name), paper_network(name).card.codec
        assert codec is not None
        assert (codec["step"], codec["period"]) == (step, scene.motion.period)
        assert [sensor.name for sensor in scene.sensors] == ["clear_sight", "off_line"]
        assert isinstance(scene.sensors[1], OffLine)
        assert scene.sensors[1].threshold == step / 2
        assert (scene.mission.goal_radius, scene.mission.time_limit) == (radius, 60.0)
        assert_array_equal(scene.worlds.boxes, [OBSTACLE])
        assert_array_equal(scene.worlds.bounds, [[-20, -20, 20, 20]])


def test_a_drive_has_the_same_bits_every_time(v1: Trace) -> None:
    again = drive("bassil-v1")
    assert_array_equal(again.pose, v1.pose)
    assert_array_equal(again.commands, v1.commands)


def test_unknown_names_are_answered_with_the_known_ones() -> None:
    assert scenario_names() == sorted(NAMES)
    with pytest.raises(SettingError) as unknown:
        bassil_scene("bassil-v2")
    assert str(unknown.value) == (
        "unknown scenario 'bassil-v2'; did you mean 'bassil-v1'? "
        "Allowed: bassil-replay-v1, bassil-v1."
    )
    with pytest.raises(SettingError, match=r"unknown obstacle 'paperr'; did you mean 'paper'\?"):
        bassil_scene(obstacle="paperr")
