from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest

from rovernav.adapters import register_envs
from rovernav.core import InputError, MissingExtraError, Outcome, SettingError, ShapeError
from rovernav.scenes import practice_task

gymnasium = pytest.importorskip("gymnasium", reason="needs the extra gym")

NAME = "RovernavRover-v1"
SMALL: dict[str, Any] = {"side": 16.0, "cell": 0.5, "nearest": 3.0, "farthest": 8.0, "beams": 9,
                         "time_limit": 12.0}  # fmt: skip
"""Small worlds and short drives: episodes end in every way within a few steps."""


@pytest.fixture(autouse=True)
def _registered() -> None:
    register_envs()
    register_envs()  # twice does no harm


def make(**more: Any) -> Any:
    return gymnasium.make(f"rovernav:{NAME}", **{**SMALL, **more})


def make_many(count: int, **more: Any) -> Any:
    return gymnasium.make_vec(NAME, num_envs=count, **{**SMALL, **more})


def test_gymnasiums_checker_has_nothing_to_complain_about() -> None:
    from gymnasium.utils.env_checker import check_env

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gymnasium.make(NAME).unwrapped)
        env = make(render_mode="rgb_array")
        check_env(env.unwrapped)
    env.close()


def test_a_seed_gives_the_same_episode_and_the_next_is_elsewhere() -> None:
    env = make()
    first, _ = env.reset(seed=4)
    second, _ = env.reset()
    again, _ = env.reset(seed=4)
    other, _ = env.reset(seed=5)
    assert np.array_equal(first, again)
    assert not np.array_equal(first, second)
    assert not np.array_equal(first, other)


def test_worlds_are_as_the_generator_makes_them() -> None:
    env = make().unwrapped
    env.reset(seed=11)
    grid, start, goal = practice_task(
        np.random.default_rng(np.random.SeedSequence(11)), env._rows.rover,
        side=16.0, cell=0.5, nearest=3.0, farthest=8.0,
    )  # fmt: skip
    assert np.array_equal(env._rows.worlds.grid.blocked[0], grid.blocked)
    assert np.array_equal(env._rows.mission.start[0], start)
    assert np.array_equal(env._rows.mission.goal[0], goal)
    assert grid.blocked.mean() <= 0.4


def test_what_is_seen_is_where_the_rover_is() -> None:
    env = make().unwrapped
    seen, info = env.reset(seed=2)
    action = np.array([0.5, -0.25], np.float32)
    before = info["distance_m"]
    seen, reward, terminated, truncated, info = env.step(action)
    assert not terminated
    assert not truncated
    rows, rover = env._rows, env._rows.rover
    x, y, heading = rows.state.pose[0]
    to_goal = rows.mission.goal[0] - (x, y)
    bearing = np.arctan2(to_goal[1], to_goal[0]) - heading
    far = np.hypot(*to_goal)
    wanted = [np.cos(bearing), np.sin(bearing), far / (16.0 * np.sqrt(2.0)), 0.5, -0.25]
    np.testing.assert_allclose(seen[:5], wanted, rtol=0, atol=1e-6)
    assert seen[5:].shape == (9,)
    np.testing.assert_allclose(seen[5:], rows.ranges(np.zeros(1, int))[0] / 6.0, atol=1e-6)
    np.testing.assert_allclose(reward, before - info["distance_m"] - 0.02, atol=1e-12)
    np.testing.assert_allclose(rows.state.twist[0], (0.5 * rover.speed, 0, -0.25 * rover.turn_rate))


def ends(*, careful: bool) -> list[tuple[float, bool, bool, dict[str, Any], float]]:
    """How episodes end when a rover drives at its goal, or to where its beams are free near it."""
    env = make(time_limit=60.0 if careful else 12.0)
    found = []
    seen, info = env.reset(seed=1)
    for _ in range(200):
        beams = np.linspace(-np.pi / 2, np.pi / 2, 9)
        off = np.abs(beams - np.arctan2(seen[1], seen[0])) + 9.0 * (
            careful & (seen[5:] * 6.0 < 0.9)
        )
        turn = beams[np.argmin(off)] if off.min() < 3.0 else np.pi
        action = np.array([float(abs(turn) < 0.5), np.clip(turn / 0.7, -1, 1)], np.float32)
        before = info["distance_m"]
        seen, reward, terminated, truncated, info = env.step(action)
        if terminated or truncated:
            found.append((reward, terminated, truncated, info, before))
            with pytest.raises(gymnasium.error.ResetNeeded, match="call reset"):
                env.unwrapped.step(action)
            seen, info = env.reset()
    return found


def test_ends_are_told_apart_and_rewarded() -> None:
    seen: set[int] = set()
    for reward, terminated, truncated, info, before in ends(careful=False) + ends(careful=True):
        outcome = Outcome(info["outcome"])
        bonus = {Outcome.REACHED: 10.0, Outcome.TIMED_OUT: 0.0}.get(outcome, -5.0)
        progress = before - info["distance_m"]
        np.testing.assert_allclose(reward, progress - 0.02 + bonus, rtol=0, atol=1e-12)
        assert (terminated, truncated) == (outcome != Outcome.TIMED_OUT,
                                           outcome == Outcome.TIMED_OUT)  # fmt: skip
        assert info["is_success"] is (outcome == Outcome.REACHED)
        seen.add(outcome)
    assert {Outcome.REACHED, Outcome.COLLIDED, Outcome.TIMED_OUT} <= seen


def plain(item: Any) -> Any:
    """Arrays as lists, so that == compares them."""
    if isinstance(item, dict):
        return {key: plain(part) for key, part in sorted(item.items())}
    if isinstance(item, np.ndarray) and item.dtype == object:
        return [plain(part) for part in item]
    return item.tolist() if isinstance(item, np.ndarray) else item


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
@pytest.mark.parametrize("episodes", [1, 3])
def test_the_batch_is_so_many_environments_bit_for_bit(mode: str, episodes: int) -> None:
    from gymnasium.vector import AutoresetMode, SyncVectorEnv

    batch = make_many(4, autoreset_mode=mode, episodes=episodes)
    apart = SyncVectorEnv([lambda: make(episodes=episodes)] * 4, autoreset_mode=AutoresetMode(mode))
    assert batch.metadata["autoreset_mode"] is AutoresetMode(mode)
    assert batch.single_observation_space == apart.single_observation_space
    assert batch.action_space == apart.action_space
    rng = np.random.default_rng(0)
    got, wanted = batch.reset(seed=[3, 8, 8, 21]), apart.reset(seed=[3, 8, 8, 21])
    ended = 0
    for _ in range(45):
        assert got[0].tobytes() == wanted[0].tobytes()
        assert [plain(part) for part in got[1:]] == [plain(part) for part in wanted[1:]]
        # The second and third row have the same seed but not the same actions.
        actions = rng.uniform(-0.3, 1.0, (4, 2)).astype(np.float32)
        got, wanted = batch.step(actions), apart.step(actions)
        ended += int((got[2] | got[3]).sum())
    assert ended >= 8
    apart.close()


def test_rows_that_nobody_resets_stay_and_cannot_be_driven_on() -> None:
    batch, alone = make_many(3, autoreset_mode="Disabled"), make()
    batch.reset(seed=7)
    alone.reset(seed=8)
    forward = np.tile(np.array([1.0, 0.0], np.float32), (3, 1))
    while not (done := np.logical_or(*(found := batch.step(forward))[2:4])).any():
        pass
    with pytest.raises(gymnasium.error.ResetNeeded, match="call reset"):
        batch.step(forward)
    after, info = batch.reset(options={"reset_mask": done})
    assert np.array_equal(after[~done], found[0][~done])
    assert (after[done] != found[0][done]).any(axis=1).all()
    assert info["_distance_m"].tolist() == done.tolist()
    batch.step(forward)
    for wrong in (np.zeros(3, bool), np.ones(2, bool), np.ones(3)):
        with pytest.raises(ValueError, match="3 booleans, one of them true"):
            batch.reset(options={"reset_mask": wrong})


def test_episodes_may_share_a_world_until_it_is_used_up() -> None:
    env = make(episodes=3).unwrapped
    env.reset(seed=0)
    worlds, goals = [], []
    for _ in range(7):
        worlds.append(env._rows.worlds.grid.blocked.tobytes())
        goals.append(tuple(env._rows.mission.goal[0]))
        env.reset()
    kinds = [worlds.index(world) for world in worlds]
    assert kinds == [0, 0, 0, 3, 3, 3, 6]
    assert len(set(goals)) == 7


def test_pictures_of_rovers_in_their_worlds() -> None:
    batch = make_many(2, render_mode="rgb_array")
    batch.reset(seed=1)
    before = batch.render()
    batch.step(np.array([[1, 0.5], [0, 0]], np.float32))
    after = batch.render()
    assert len(after) == 2
    assert (after[0] != before[0]).any()
    assert after[0].shape[2] == 3
    assert after[0].dtype == np.uint8
    assert make().unwrapped.render() is None


@pytest.mark.parametrize(
    ("settings", "sentence"),
    [
        ({"period": 0.0}, "a period above 0, got 0.0"),
        ({"side": float("nan")}, "a side above 0"),
        ({"nearest": 9.0}, "must be longer than the goal's radius and fit"),
        ({"cell": 4.0}, "8 to 2000 cells a side"),
        ({"episodes": 0}, "one episode or more, got 0"),
        ({"rover": "paper-point"}, "cannot turn"),
        ({"rover": "nobody"}, "nobody"),
        ({"beams": 1}, "3 to 4096 beams"),
        ({"beam": 9}, "a task has no setting 'beam'; did you mean 'beams'"),
    ],
)
def test_settings_that_make_no_environment(settings: dict[str, Any], sentence: str) -> None:
    with pytest.raises(SettingError, match=sentence):
        make_many(1, **settings)


def test_modes_and_numbers_that_do_not_exist() -> None:
    with pytest.raises(gymnasium.error.Error, match="unknown render_mode 'human'"):
        make_many(1, render_mode="human")
    with pytest.raises(gymnasium.error.Error, match="one rover or more, got 0"):
        make_many(0)
    with pytest.raises(ValueError, match="3 rows need a seed each, got 2"):
        make_many(3).reset(seed=[1, 2])
    with pytest.raises(gymnasium.error.ResetNeeded, match="no episode has begun; call reset"):
        make_many(1).step(np.zeros((1, 2), np.float32))


def test_actions_that_are_none_are_refused_and_the_batch_goes_on() -> None:
    batch = make_many(3)
    batch.reset(seed=1)
    with pytest.raises(ShapeError, match=r"3 rovers need actions of shape \(3, 2\), got \(2, 2\)"):
        batch.step(np.zeros((2, 2), np.float32))
    with pytest.raises(ShapeError, match=r"3 rovers need .* got \(2, 3\)"):
        batch.step(np.zeros((2, 3), np.float32))
    wrong = np.zeros((3, 2), np.float32)
    wrong[1, 0] = np.nan  # as a policy that diverged gives them
    with pytest.raises(InputError, match=r"must be finite; that of rover 1 is \[nan, 0.0\]"):
        batch.step(wrong)
    seen = batch.step(np.zeros((3, 2), np.float32))[0]
    assert np.isfinite(seen).all()
    env = make().unwrapped
    env.reset(seed=1)
    with pytest.raises(ShapeError, match=r"1 rover needs actions of shape \(2,\), got \(3,\)"):
        env.step(np.zeros(3, np.float32))


def test_gymnasium_finds_it_by_the_name_of_the_package() -> None:
    import subprocess
    import sys

    for first in (
        "import gymnasium",
        "import rovernav.adapters as a, gymnasium; a.register_envs()",
    ):
        script = f"{first}; print(gymnasium.make('rovernav:{NAME}').spec.id)"
        done = subprocess.run(
            [sys.executable, "-W", "error", "-c", script],
            capture_output=True, text=True, check=True,
        )  # fmt: skip
        assert done.stdout == f"{NAME}\n"


def test_without_gymnasium_a_sentence_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "gymnasium.envs.registration", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'rovernav\[gym\]'"):
        register_envs()
