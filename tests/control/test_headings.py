from __future__ import annotations

import math

import numpy as np
import pytest

from rovernav.control import GoalSeeker, HeadingCodec, SensedPlanner, build_codec
from rovernav.core import Mission, Observation, SettingError
from rovernav.mapping import LocalMapper

ANGLES = np.linspace(-math.pi / 2, math.pi / 2, 49)


def seen(goal: tuple[float, float], *, beams: float = 6.0, around: float = 12.0) -> Observation:
    return Observation(
        goal=np.array([goal], dtype=np.float64),
        twist=np.zeros((1, 3)),
        channels={
            "beams": np.full((1, 49), beams),
            "around": np.full((1, 64), around),
            "reach": np.full((1, 1), 12.0),
        },
    )


def choose(heading: int, goal: tuple[float, float], **what: float) -> np.ndarray:
    codec, logits = HeadingCodec(), np.zeros((1, 32))
    logits[0, heading] = 9.0
    return codec.decode(logits, seen(goal, **what)).twist[0]


def test_inputs_are_free_shares_heading_and_distance() -> None:
    x = HeadingCodec().encode(seen((0.0, 3.0), around=6.0))[0]
    np.testing.assert_allclose(x[:64], 0.5)
    # The goal is to the left, so the rover's heading is a quarter to the right of its direction.
    np.testing.assert_allclose(x[64:], [0.0, -1.0, 0.25], atol=1e-12)


def test_towards_a_goal_ahead_it_drives_straight_at_full_speed() -> None:
    np.testing.assert_allclose(choose(0, (5.0, 0.0)), [0.3, 0.0, 0.0], atol=1e-12)


def test_a_goal_behind_makes_it_turn_on_the_spot() -> None:
    v, _, w = choose(0, (-5.0, 0.1))
    assert v == 0.0
    assert w == pytest.approx(0.698)


def test_headings_count_to_the_left_from_the_goal() -> None:
    assert choose(2, (5.0, 0.0))[2] == pytest.approx(2 * math.tau / 32, rel=1e-9)
    assert choose(30, (5.0, 0.0))[2] == pytest.approx(-2 * math.tau / 32, rel=1e-9)


def test_the_heading_is_drawn_towards_the_stronger_neighbour() -> None:
    codec, logits = HeadingCodec(), np.full((1, 32), -5.0)
    logits[0, [0, 1]] = 3.0, 2.0
    w = codec.decode(logits, seen((5.0, 0.0))).twist[0, 2]
    assert 0.0 < w < math.tau / 32 / 2


def test_it_stops_before_what_it_sees_ahead() -> None:
    assert choose(0, (5.0, 0.0), beams=0.2)[0] == pytest.approx(0.15)
    assert choose(0, (5.0, 0.0), beams=0.04)[0] == 0.0


def test_it_does_not_drive_past_its_goal() -> None:
    assert choose(0, (0.1, 0.0))[0] == pytest.approx(0.1)


def test_settings_build_the_same_codec_again() -> None:
    codec = HeadingCodec(rays=32, headings=16, speed=0.1, margin=0.2)
    assert build_codec(codec.settings()).settings() == codec.settings()


def test_rays_that_do_not_fit_are_refused() -> None:
    with pytest.raises(SettingError, match="needs 32 rays around, this rover has 64"):
        HeadingCodec(rays=32).encode(seen((1.0, 0.0)))


@pytest.mark.parametrize("what", [{"speed": 0.0}, {"turn_rate": -1.0}, {"period": math.nan}])
def test_absurd_motors_are_refused(what: dict[str, float]) -> None:
    with pytest.raises(SettingError, match=f"codec headings: {next(iter(what))} must be above 0"):
        HeadingCodec(**what)  # pyright: ignore[reportArgumentType]


def sensed(beams: np.ndarray, goal: tuple[float, float] = (20.0, 0.0)) -> np.ndarray:
    """The teacher's distribution at the origin, facing east, after one scan."""
    mission = Mission.between((0.0, 0.0), goal, goal_radius=0.5, time_limit=9.0)
    mapper = LocalMapper(ANGLES, reach=6.0)
    start = mission.start * [1.0, 1.0, 0.0]
    _, local = mapper.update(mapper.start(mission), start, mission.goal, {"beams": beams[None]})
    return SensedPlanner().headings(local)[0]


def test_on_open_ground_the_teacher_points_at_the_goal_and_is_symmetric() -> None:
    p = sensed(np.full(49, 6.0))
    assert p.argmax() == 0
    assert p.sum() == pytest.approx(1.0)
    np.testing.assert_allclose(p[1:], p[:0:-1], atol=0.02)


def test_before_a_wall_the_teacher_says_left_or_right_and_not_ahead() -> None:
    beams = np.full(49, 6.0)
    beams[16:33] = 1.5 / np.cos(ANGLES[16:33])  # a wall 1.5 m ahead, seen 30 deg to both sides
    p = sensed(beams)
    assert p[[31, 0, 1]].sum() < 0.02
    assert p[2:9].sum() > 0.3
    assert p[24:31].sum() > 0.3


def test_the_teacher_goes_around_the_nearer_end() -> None:
    beams = np.full(49, 6.0)
    beams[22:45] = 1.5 / np.maximum(np.cos(ANGLES[22:45]), 0.3)  # reaches far to the left
    p = sensed(beams)
    assert p[20:32].sum() > 0.95


def test_what_was_never_sensed_is_free() -> None:
    # A wall all around but behind, where nothing looks: behind is the way.
    p = sensed(np.full(49, 1.0))
    assert p[8:25].sum() > 0.99


def test_the_goal_seeker_always_points_at_the_goal() -> None:
    command, _ = GoalSeeker().act(seen((0.0, 4.0)), None)
    assert command.twist[0, 2] > 0.6


def test_the_planner_needs_a_map() -> None:
    with pytest.raises(SettingError, match="needs a rover with a local map"):
        SensedPlanner().act(seen((1.0, 0.0)), None)
