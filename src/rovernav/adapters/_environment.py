"""The environment ``RovernavRover-v1`` for Gymnasium, alone and as a true batch.

This file imports Gymnasium, which loads it when somebody makes the environment.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, final

import gymnasium
import numpy as np
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode

from ..core import F32, I64, U8, Bool, Outcome
from ._rows import OTHERS, Rows, Task

RENDER = ["rgb_array"]
PER_SECOND = 10
FIRST = np.zeros(1, np.int64)


def _spaces(task: Task) -> tuple[Any, Any]:
    """What one rover sees, and what it can do."""
    low = np.full(OTHERS + task.beams, -1.0, np.float32)
    low[2] = low[OTHERS:] = 0.0
    return (
        gymnasium.spaces.Box(low, np.ones_like(low), dtype=np.float32),
        gymnasium.spaces.Box(-1.0, 1.0, (2,), np.float32),
    )


@final
class RoverEnv(gymnasium.Env[Any, Any]):
    """A rover in a world that it does not know, new in each episode.

    Observation (54,), each within [-1, 1]: cosine and sine of the goal's bearing, its distance,
    forward speed, turn rate, 49 range beams from right to left. Action (2,): forward speed and turn
    rate as shares of the rover's limits. Reward: metres by which the goal came nearer, -0.02 a
    step, +10 for reaching it, -5 for a collision or leaving the world. An episode terminates with
    these ends, and is truncated when time runs out.

    The worlds are generated ground with rocks, or discs, bars and bays; the goal can be reached,
    but not in a straight line. What a rover cannot stand on counts as an obstacle.

    Args:
        render_mode: ``rgb_array`` or None.
        settings: As `rovernav.adapters.Task` takes them.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012 - as Gymnasium declares it
        "render_modes": RENDER, "render_fps": PER_SECOND,
    }  # fmt: skip

    def __init__(self, render_mode: str | None = None, **settings: Any) -> None:
        self.render_mode = _check_mode(render_mode)
        self.task = Task.of(settings)
        self.observation_space, self.action_space = _spaces(self.task)
        self._rows = Rows(self.task, 1)
        self._rows.keep_paths = render_mode is not None
        self._fresh = False

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[F32, dict[str, Any]]:
        """A new world and task; the same seed gives the same."""
        super().reset(seed=seed)
        self._rows.reset(FIRST, [self.np_random], anew=seed is not None)
        self._fresh = True
        return self._rows.observe(FIRST)[0], self._info()

    def step(self, action: F32) -> tuple[F32, float, bool, bool, dict[str, Any]]:
        """Drive for one period."""
        if not (self._fresh and self._rows.state.driving[0]):
            why = "the episode has ended" if self._fresh else "no episode has begun"
            raise gymnasium.error.ResetNeeded(f"{why}; call reset before step")
        reward, terminated, truncated = self._rows.step(action)
        seen = self._rows.observe(FIRST)[0]
        return seen, float(reward[0]), bool(terminated[0]), bool(truncated[0]), self._info()

    def render(self) -> U8 | None:
        """The rover in its world, as colours (h, w, 3)."""
        return None if self.render_mode is None else _picture(self._rows, 0)

    def _info(self) -> dict[str, Any]:
        return {name: of[0].item() for name, of in self._rows.info(FIRST).items()}


@final
class RoverVectorEnv(gymnasium.vector.VectorEnv[Any, Any, Any]):
    """Many rovers in one batch, each in a world of its own: row k is `RoverEnv`, bit for bit.

    Seeded with an integer s, row k is the environment that is seeded with s + k.

    Args:
        num_envs: How many.
        render_mode: ``rgb_array`` or None.
        autoreset_mode: ``NextStep`` (the first step after an end begins the next episode, with
            reward 0), ``SameStep`` (the step that ends an episode returns the first observation of
            the next, and the last in ``final_obs``) or ``Disabled`` (ended rows are reset with
            ``options={"reset_mask": ...}``).
        settings: As `rovernav.adapters.Task` takes them.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012 - each batch has its own mode
        "render_modes": RENDER, "render_fps": PER_SECOND,
        "autoreset_mode": AutoresetMode.NEXT_STEP,
    }  # fmt: skip

    def __init__(
        self,
        num_envs: int = 1,
        render_mode: str | None = None,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        **settings: Any,
    ) -> None:
        if num_envs < 1:
            raise gymnasium.error.Error(f"a batch needs one rover or more, got {num_envs}")
        self.mode = AutoresetMode(autoreset_mode)
        self.metadata = {**self.metadata, "autoreset_mode": self.mode}
        self.render_mode = _check_mode(render_mode)
        self.num_envs, self.task = num_envs, Task.of(settings)
        self.single_observation_space, self.single_action_space = _spaces(self.task)
        batch = gymnasium.vector.utils.batch_space
        self.observation_space = batch(self.single_observation_space, num_envs)
        self.action_space = batch(self.single_action_space, num_envs)
        self._rows = Rows(self.task, num_envs)
        self._rows.keep_paths = render_mode is not None
        self._all: I64 = np.arange(num_envs)
        self._generators: list[Any] = [None] * num_envs
        self._seeds: list[int] = [-1] * num_envs
        self._ended: Bool = np.zeros(num_envs, bool)
        self._fresh = False

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[F32, dict[str, Any]]:
        """New worlds and tasks in all rows, or in those of ``options["reset_mask"]``."""
        seeds = self._one_each(seed)
        mask = _mask(options, self.num_envs)
        rows = np.flatnonzero(mask)
        seeded = np.array([one is not None for one in seeds])
        for k in rows.tolist():
            if seeded[k] or self._generators[k] is None:
                self._generators[k], self._seeds[k] = seeding.np_random(seeds[k])
        self._renew(rows[seeded[rows]], anew=True)
        self._renew(rows[~seeded[rows]])
        self._ended[rows] = False
        self._fresh = self._fresh or bool(mask.all())
        return self._rows.observe(self._all), self._info(rows)

    def step(self, actions: F32) -> tuple[F32, Any, Bool, Bool, dict[str, Any]]:
        """Drive every row for one period; those that ended begin anew as the mode says."""
        waiting = self._ended.copy()
        if not self._fresh or (self.mode is AutoresetMode.DISABLED and waiting.any()):
            why = "an episode has ended" if self._fresh else "no episode has begun"
            raise gymnasium.error.ResetNeeded(f"{why}; call reset before step")
        reward, terminated, truncated = self._rows.step(actions)
        self._ended = terminated | truncated
        last: dict[str, Any] = {}
        again = waiting
        if self.mode is AutoresetMode.SAME_STEP:
            again = self._ended
            last = self._last(np.flatnonzero(again))
        if again.any():
            self._renew(np.flatnonzero(again))
        return (
            self._rows.observe(self._all), reward, terminated, truncated,
            {**last, **self._info(self._all)},
        )  # fmt: skip

    def render(self) -> tuple[U8, ...] | None:
        """Each rover in its world, as colours (h, w, 3)."""
        if self.render_mode is None:
            return None
        return tuple(_picture(self._rows, k) for k in range(self.num_envs))

    @property
    def np_random(self) -> Any:  # pyright: ignore[reportIncompatibleMethodOverride]
        """The generator of each row."""
        return tuple(self._generators)

    @property
    def np_random_seed(self) -> Any:
        """The seed of each row's generator."""
        return tuple(self._seeds)

    def _one_each(self, seed: int | Sequence[int | None] | None) -> list[int | None]:
        if seed is None:
            return [None] * self.num_envs
        if isinstance(seed, int | np.integer):
            return [int(seed) + k for k in range(self.num_envs)]
        if len(seed) != self.num_envs:
            raise ValueError(f"{self.num_envs} rows need a seed each, got {len(seed)}")
        return list(seed)

    def _renew(self, rows: I64, *, anew: bool = False) -> None:
        self._rows.reset(rows, [self._generators[k] for k in rows.tolist()], anew=anew)

    def _info(self, rows: I64) -> dict[str, Any]:
        """Facts of these rows, in arrays over all, each with a mask of its own."""
        mask = np.zeros(self.num_envs, bool)
        mask[rows] = True
        found: dict[str, Any] = {}
        for name, of in self._rows.info(rows).items():
            found[name] = np.zeros(self.num_envs, of.dtype)
            found[name][rows] = of
            found[f"_{name}"] = mask.copy()
        return found

    def _last(self, rows: I64) -> dict[str, Any]:
        """Last observation and facts of the rows that ended in this step."""
        if not len(rows):
            return {}
        mask = np.zeros(self.num_envs, bool)
        mask[rows] = True
        seen = np.full(self.num_envs, None, dtype=object)
        for k, one in zip(rows.tolist(), self._rows.observe(rows), strict=True):
            seen[k] = one.copy()
        return {
            "final_obs": seen, "_final_obs": mask,
            "final_info": self._info(rows), "_final_info": mask.copy(),
        }  # fmt: skip


def _mask(options: dict[str, Any] | None, count: int) -> Bool:
    """Which rows to reset."""
    if options is None or "reset_mask" not in options:
        return np.ones(count, bool)
    mask = np.asarray(options["reset_mask"])
    if mask.shape != (count,) or mask.dtype != np.bool_ or not mask.any():
        raise ValueError(
            f"reset_mask must hold {count} booleans, one of them true, "
            f"got {mask.dtype} {mask.shape}"
        )
    return mask


def _check_mode(mode: str | None) -> str | None:
    if mode is not None and mode not in RENDER:
        raise gymnasium.error.Error(f"unknown render_mode {mode!r}; allowed: rgb_array and None")
    return mode


def _picture(rows: Rows, k: int) -> U8:
    """The rover of a row in its world."""
    from ..show import Moment, Place, Stage

    here = np.array([k])
    side = rows.task.side
    heading, outcome = float(rows.state.pose[k, 2]), Outcome(int(rows.state.outcome[k]))
    ranges = rows.ranges(here)[0]
    turn = heading + rows.fan.angles
    ends = rows.state.pose[k, :2] + ranges[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    place = Place(
        window=(0.0, 0.0, side, side), start=rows.mission.start[k, :2], goal=rows.mission.goal[k],
        goal_radius=rows.task.goal_radius, worlds=rows.worlds, k=k, rover=rows.rover,
    )  # fmt: skip
    time = float(rows.state.time[k])
    moment = Moment(
        path=np.stack(rows.paths[k]), heading=heading, beams=ends, met=ranges < rows.task.reach,
        words=f"{time:,.0f} s, {rows.distance()[k]:.1f} m to the goal", ended=outcome,
    )  # fmt: skip
    return Stage(place).frame(moment)
