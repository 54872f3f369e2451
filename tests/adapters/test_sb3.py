from __future__ import annotations

import importlib.util
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rovernav.adapters import register_envs

pytest.importorskip("gymnasium", reason="needs the extra gym")
pytest.importorskip("stable_baselines3", reason="needs stable-baselines3, which .ci/run installs")

SMALL = {"side": 16.0, "cell": 0.5, "nearest": 3.0, "farthest": 6.0, "time_limit": 60.0}
"""Small worlds are made quickly, and short tasks are learnt in seconds."""


@pytest.fixture
def example(root: Path) -> Any:
    register_envs()
    spec = importlib.util.spec_from_file_location("example", root / "examples/train_with_sb3.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # what others say while they are imported
        spec.loader.exec_module(module)
    return module


def test_ten_seconds_of_training_beat_a_random_policy(example: Any) -> None:
    rng = np.random.default_rng(0)
    chance = example.measure(lambda seen: rng.uniform(-1.0, 1.0, (len(seen), 2)), 60, **SMALL)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        model = example.train(10_240, rovers=20, seed=0, **SMALL)
    skill = example.measure(lambda seen: model.predict(seen, deterministic=True)[0], 60, **SMALL)
    assert skill["return"] > chance["return"] + 2.0
    assert skill["reached"] > chance["reached"]


def test_measuring_is_repeatable_and_counts_every_episode_once(example: Any) -> None:
    def still(seen: np.ndarray) -> np.ndarray:
        return np.zeros((len(seen), 2))

    settings = {**SMALL, "time_limit": 5.0}
    assert example.measure(still, 7, **settings) == {
        "reached": 0.0, "collided": 0.0, "return": pytest.approx(-0.1)
    }  # fmt: skip


def test_the_batch_tells_how_each_episode_ended(example: Any) -> None:
    batch = example.Batch(6, **SMALL)
    batch.seed(4)
    batch.reset()
    ended: list[dict[str, Any]] = []
    for _ in range(80):
        seen, reward, done, infos = batch.step(np.tile([1.0, 0.0], (6, 1)).astype(np.float32))
        assert [bool(info) for info in infos] == done.tolist()
        assert (seen.shape, reward.dtype) == ((6, 54), np.float32)
        for k in np.flatnonzero(done):
            assert not np.array_equal(infos[k]["terminal_observation"], seen[k])
            ended.append(infos[k])
    assert len(ended) > 6
    assert {info["outcome"] for info in ended} >= {2}
    assert all(info["TimeLimit.truncated"] == (info["outcome"] == 7) for info in ended)
    assert batch.env_is_wrapped(object) == [False] * 6
