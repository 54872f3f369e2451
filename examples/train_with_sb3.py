"""Train a driver by reinforcement learning with stable-baselines3, and measure it.

    pip install 'rovernav[gym]' stable-baselines3
    python examples/train_with_sb3.py --steps 1000000 --out driver.zip

Every episode is measured on worlds that were not trained in, beside a policy that acts at random.
"""

from __future__ import annotations

import argparse
import time
from typing import Any

import gymnasium
import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import VecEnv

NAME = "rovernav:RovernavRover-v1"
TEST_SEED = 1_000_000
"""Worlds of the test have seeds from here on; those of the training are far below."""


class Batch(VecEnv):
    """A rovernav batch as stable-baselines3 takes it: both reset in the step that ends an episode.

    One object steps all rovers in one call; there are no processes and no copies of a world.
    """

    def __init__(self, count: int, **settings: Any) -> None:
        settings = {"autoreset_mode": "SameStep", **settings}
        self.batch = gymnasium.make_vec(NAME, num_envs=count, **settings)
        self.render_mode = None
        inner = self.batch
        super().__init__(count, inner.single_observation_space, inner.single_action_space)
        self.sums, self.steps = np.zeros(count), np.zeros(count, int)

    def reset(self) -> np.ndarray:
        """New worlds in all rows."""
        seeds = [seed for seed in self._seeds if seed is not None]
        self.sums[:], self.steps[:] = 0.0, 0
        return self.batch.reset(seed=seeds or None)[0]

    def step_async(self, actions: np.ndarray) -> None:
        """Remember what to do."""
        self.actions = actions

    def step_wait(self) -> Any:
        """Do it, and say of each episode that ended how it went."""
        seen, reward, terminated, truncated, info = self.batch.step(self.actions)
        done = terminated | truncated
        self.sums += reward
        self.steps += 1
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for k in np.flatnonzero(done):
            infos[k] = {
                "terminal_observation": info["final_obs"][k],
                "TimeLimit.truncated": bool(truncated[k]),
                "is_success": bool(info["final_info"]["is_success"][k]),
                "outcome": int(info["final_info"]["outcome"][k]),
                "episode": {"r": self.sums[k], "l": int(self.steps[k]), "t": 0.0},
            }
            self.sums[k], self.steps[k] = 0.0, 0
        return seen, reward.astype(np.float32), done, infos

    def close(self) -> None:
        """Nothing is open."""
        self.batch.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """An attribute, the same for each row."""
        return [getattr(self, attr_name, None)] * self.num_envs

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Set an attribute of all rows."""
        setattr(self, attr_name, value)

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> Any:
        """Call a method of the batch."""
        return [getattr(self.batch, method_name)(*args, **kwargs)]

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """No row has a wrapper of its own."""
        return [False] * self.num_envs


def measure(act: Any, episodes: int, **settings: Any) -> dict[str, float]:
    """Drive one episode in each of so many unseen worlds.

    Args:
        act: From observations (n, b) to actions (n, 2).
        episodes: How many worlds.
        settings: Of the environment.

    Returns:
        Share that reached the goal, share that collided, mean return.
    """
    batch = gymnasium.make_vec(NAME, num_envs=episodes, autoreset_mode="NextStep", **settings)
    seen, _ = batch.reset(seed=TEST_SEED)
    going, total = np.ones(episodes, bool), np.zeros(episodes)
    outcome = np.zeros(episodes, int)
    while going.any():
        seen, reward, terminated, truncated, info = batch.step(act(seen))
        total += np.where(going, reward, 0.0)
        ended = going & (terminated | truncated)
        outcome[ended] = info["outcome"][ended]
        going &= ~ended
    return {
        "reached": float((outcome == 1).mean()),
        "collided": float((outcome == 2).mean()),
        "return": float(total.mean()),
    }


def train(steps: int, *, rovers: int = 64, seed: int = 0, **settings: Any) -> PPO:
    """A driver trained with PPO on so many steps of all rovers together."""
    torch.set_num_threads(1)  # small matrices: more threads only wait for each other
    batch = Batch(rovers, episodes=8, **settings)
    model = PPO(
        "MlpPolicy", batch, n_steps=128, batch_size=1024, n_epochs=6, gamma=0.99, ent_coef=0.003,
        learning_rate=5e-4, policy_kwargs={"net_arch": [128, 128]}, seed=seed, verbose=0,
    )  # fmt: skip
    return model.learn(total_timesteps=steps)


def main() -> None:
    """Train, measure, save."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--steps", type=int, default=300_000, help="steps of all rovers together")
    parser.add_argument("--rovers", type=int, default=64)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--episodes", type=int, default=200, help="worlds to measure in")
    parser.add_argument("--out", default="", help="where to save the policy, like driver.zip")
    asked = parser.parse_args()
    began = time.perf_counter()
    model = train(asked.steps, rovers=asked.rovers, seed=asked.seed)
    print(f"{asked.steps:,} steps in {time.perf_counter() - began:.0f} s")
    rng = np.random.default_rng(asked.seed)
    drivers = {
        "random": lambda seen: rng.uniform(-1.0, 1.0, (len(seen), 2)),
        "trained": lambda seen: model.predict(seen, deterministic=True)[0],
    }
    print(f"{'':8}  reached  collided   return")
    for name, act in drivers.items():
        got = measure(act, asked.episodes)
        print(f"{name:8}  {got['reached']:7.1%}  {got['collided']:8.1%}  {got['return']:7.2f}")
    if asked.out:
        model.save(asked.out)


if __name__ == "__main__":
    main()
