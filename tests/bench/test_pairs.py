from __future__ import annotations

import math

import numpy as np
import pytest

from rovernav.bench import draw_pairs, score, wilson
from rovernav.control import GoalSeeker, SensedPlanner
from rovernav.core import Threads
from rovernav.learn import find_controller
from rovernav.rover import read_rover
from rovernav.terrain import hills


def test_confidence_intervals_are_wilsons() -> None:
    # Newcombe 1998, Statistics in Medicine 17, table I: 81 of 263, method 3.
    low, high = wilson(81, 263)
    assert (round(low, 4), round(high, 4)) == (0.2553, 0.3662)
    assert wilson(0, 20)[0] == 0.0
    assert wilson(20, 20)[1] == 1.0


def test_controllers_meet_the_same_pairs_and_counts_add_up() -> None:
    ground = hills(np.random.default_rng(4), shape=(120, 120), cell=0.2, relief=4.0, craters=25)
    pairs = draw_pairs(ground, read_rover("research"), 6, seed=2, nearest=5.0)
    events: list[float] = []
    planner = score(pairs, "planner", SensedPlanner(), on_event=events.append)
    seeker = score(pairs, "seeker", GoalSeeker())
    assert sum(planner.counts.values()) == sum(seeker.counts.values()) == 6
    assert planner.reached > seeker.reached
    assert planner.detour >= 1.0
    assert events == sorted(events)
    assert events[-1] == 1.0
    report = seeker.report()
    assert math.isnan(report["detour"]) == (seeker.reached == 0)
    assert report["drives"] == 6
    np.testing.assert_array_equal(planner.trace.mission.start[:, :2], pairs.starts)


@pytest.mark.parametrize("together", [1, 4, 20])
def test_a_score_does_not_depend_on_who_drives_how_many_together(
    together: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    from rovernav.bench import _pairs

    monkeypatch.setattr(_pairs, "TOGETHER", together)
    ground = hills(np.random.default_rng(4), shape=(120, 120), cell=0.2, relief=4.0, craters=25)
    pairs = draw_pairs(ground, read_rover("research"), 9, seed=2, nearest=5.0)
    for driver in (GoalSeeker(), find_controller("neural")):
        events: list[float] = []
        whole = score(pairs, "it", driver)
        parts = score(pairs, "it", driver, executor=Threads(2), on_event=events.append)
        for name in ("time", "pose", "outcome", "steps", "length"):
            assert getattr(whole.trace, name).tobytes() == getattr(parts.trace, name).tobytes()
        assert whole.report() | {"seconds": 0} == parts.report() | {"seconds": 0}
        assert max(events) == 1.0


def test_pairs_come_from_the_seed_alone() -> None:
    ground = hills(np.random.default_rng(4), shape=(120, 120), cell=0.2, relief=4.0, craters=25)

    def draw(seed: int) -> np.ndarray:
        return draw_pairs(ground, read_rover("research"), 4, seed=seed, nearest=5.0).starts

    np.testing.assert_array_equal(draw(1), draw(1))
    assert not np.array_equal(draw(1), draw(2))


@pytest.mark.parametrize("nearest", [1000.0])
def test_pairs_that_do_not_exist_are_refused(nearest: float) -> None:
    from rovernav.core import SettingError

    ground = hills(np.random.default_rng(4), shape=(60, 60), cell=0.2, relief=1.0, craters=5)
    with pytest.raises(SettingError, match="found 0 of 3 start and goal pairs"):
        draw_pairs(ground, read_rover("research"), 3, nearest=nearest)
