from __future__ import annotations

import pytest

from rovernav.core import SettingError
from rovernav.studio._playback import Playback


class Clock:
    """A clock that a test winds."""

    def __init__(self) -> None:
        self.at = 100.0

    def __call__(self) -> float:
        return self.at


def test_it_plays_at_its_speed_and_stops_at_the_end() -> None:
    clock = Clock()
    play = Playback(clock)
    assert play.now(10.0) == 0.0
    play.begin()
    clock.at += 1.0
    assert play.now(10.0) == 5.0
    play.set_speed(2.0)
    clock.at += 1.0
    assert play.now(10.0) == 7.0
    play.hold()
    clock.at += 50.0
    assert play.now(10.0) == 7.0
    play.play(10.0)
    clock.at += 50.0
    assert play.now(10.0) == 10.0
    assert not play.playing
    play.play(10.0)  # from the start again
    assert play.now(10.0) == 0.0


def test_it_waits_for_a_drive_that_is_not_there_yet() -> None:
    clock = Clock()
    play = Playback(clock)
    play.begin()
    clock.at += 10.0
    assert play.now(3.0, more=True) == 3.0
    assert play.playing
    clock.at += 0.1
    assert play.now(20.0, more=True) == pytest.approx(3.5)


def test_scrubbing_jumps_whether_it_plays_or_not() -> None:
    clock = Clock()
    play = Playback(clock)
    play.seek(4.0)
    assert play.now(10.0) == 4.0
    play.play(10.0)
    clock.at += 0.25
    assert play.now(10.0) == 5.25
    play.seek(-3.0)
    assert play.now(10.0) == 0.0


@pytest.mark.parametrize("speed", [0.0, -1.0, 3.0, float("nan")])
def test_odd_speeds_are_refused(speed: float) -> None:
    with pytest.raises(SettingError, match="the speed must be one of"):
        Playback().set_speed(speed)
