"""Many rovers that learn, each in a world of its own: what an environment does, without Gymnasium.

One environment is a batch of one row; so a row of a batch is that environment, bit for bit.
"""

from __future__ import annotations

import contextlib
import dataclasses
import math
from collections.abc import Mapping
from typing import Any, NamedTuple, final

import numpy as np

from ..core import (
    F32,
    F64,
    I64,
    Bool,
    Command,
    Frame,
    InputError,
    Mission,
    Observation,
    Outcome,
    RoverState,
    SettingError,
    ShapeError,
    suggest,
    value,
)
from ..kernels import drive as kernels
from ..rover import Rover, read_rover
from ..scenes import another_task, practice_task
from ..sim import DifferentialDrive, Drive, DriveState, Grid, RangeFan, Worlds, tick

REACHED, HARMED, STEP = 10.0, -5.0, -0.02
"""Reward for reaching the goal, for any other end but time, and for each step."""
OTHERS = 5
"""Observations besides the beams."""


@value
class Task:
    """What the environment is about; the settings of ``gymnasium.make``.

    Attributes:
        rover: Preset or rover file with a differential drive.
        side: Side of the square worlds [m].
        cell: Their cell [m].
        beams: Range beams over 180 deg.
        reach: Of the beams [m].
        period: Time between two actions [s].
        nearest: Shortest straight line from start to goal [m].
        farthest: Longest [m].
        time_limit: Longest drive [s].
        goal_radius: [m].
        episodes: Episodes in each world, each with a task of its own: making a world takes as long
            as thousands of steps. Seeding begins with a new one.
    """

    rover: str = "research"
    side: float = 32.0
    cell: float = 0.25
    beams: int = 49
    reach: float = 6.0
    period: float = 1.0
    nearest: float = 5.0
    farthest: float = 15.0
    time_limit: float = 150.0
    goal_radius: float = 0.5
    episodes: int = 1

    def _check(self) -> None:
        for name in ("side", "cell", "reach", "period", "nearest", "time_limit", "goal_radius"):
            number = getattr(self, name)
            if not (isinstance(number, int | float) and math.isfinite(number) and number > 0):
                raise SettingError(f"the environment needs a {name} above 0, got {number!r}")
        if not self.goal_radius < self.nearest <= self.farthest <= self.side:
            raise SettingError(
                f"tasks must be longer than the goal's radius and fit into the world: "
                f"{self.nearest:g} to {self.farthest:g} m in {self.side:g} m"
            )
        episodes: Any = self.episodes  # whatever was passed to gymnasium.make
        if not (isinstance(episodes, int) and episodes >= 1):
            raise SettingError(f"a world has one episode or more, got {episodes!r}")
        if not 8 <= round(self.side / self.cell) <= 2000:
            raise SettingError(
                f"a world has 8 to 2000 cells a side, got {self.side:g} m in cells of "
                f"{self.cell:g} m"
            )

    @classmethod
    def of(cls, settings: Mapping[str, Any]) -> Task:
        """A task by the names of its settings.

        Raises:
            SettingError: There is no setting of that name, or its value cannot be.
        """
        known = [field.name for field in dataclasses.fields(cls)]
        for name in settings:
            if name not in known:
                raise SettingError(f"a task has no setting {name!r}; {suggest(name, known)}")
        return cls(**settings)

    def vehicle(self) -> Rover:
        """The rover.

        Raises:
            RovernavError: There is none of that name, or it has no differential drive.
        """
        rover = read_rover(self.rover)
        if rover.drive != "differential":
            raise SettingError(
                f"rover {rover.name} cannot turn; the environment needs one that does"
            )
        return rover


class Step(NamedTuple):
    """What a step gave, row by row.

    Attributes:
        reward: (n,).
        terminated: Reached the goal, or came to harm (n,).
        truncated: Ran out of time (n,).
    """

    reward: F64
    terminated: Bool
    truncated: Bool


@final
class Actions:
    """Commands what it is told: the memory is the twist."""

    def start(self, mission: Mission, rng: np.random.Generator) -> F64:
        """No motion."""
        return np.zeros((len(mission.start), 3))

    def act(self, observation: Observation, memory: F64) -> tuple[Command, F64]:
        """What was put into the memory."""
        return Command(twist=memory), memory


@final
class Rows:
    """Worlds, rovers and their states.

    Args:
        task: What they do.
        count: How many.
    """

    def __init__(self, task: Task, count: int) -> None:
        self.task, self.count = task, count
        self.rover = task.vehicle()
        self.fan = RangeFan(reach=task.reach, beams=task.beams)
        self.motion = DifferentialDrive(
            speed=self.rover.speed, turn_rate=self.rover.turn_rate, period=task.period
        )
        cells = round(task.side / task.cell)
        self._frame = Frame(cell=task.cell, shape=(cells, cells))
        self._blocked = np.zeros((count, cells, cells), np.uint8)
        self._left = np.zeros(count, np.int64)
        self._start, self._goal = np.zeros((count, 3)), np.ones((count, 2))
        self._drive = self._set_up()
        self.state = RoverState.at_start(self.mission)
        self.paths: list[list[F64]] = [[] for _ in range(count)]
        self.keep_paths = False

    @property
    def mission(self) -> Mission:
        """Starts and goals now."""
        return self._drive.mission

    @property
    def worlds(self) -> Worlds:
        """The worlds now."""
        return self._drive.worlds

    def _set_up(self) -> Drive:
        side = self._frame.extent[0]
        worlds = Worlds(
            boxes=np.zeros((0, 4)),
            offsets=np.zeros(self.count + 1, np.int64),
            bounds=np.tile(np.array([0.0, 0.0, side, side]), (self.count, 1)),
            of=np.arange(self.count),
            grid=Grid(frame=self._frame, blocked=self._blocked),
        )
        mission = Mission(
            start=self._start.copy(), goal=self._goal.copy(),
            goal_radius=self.task.goal_radius, time_limit=self.task.time_limit,
        )  # fmt: skip
        return Drive(
            worlds=worlds, mission=mission, sensors=(), controller=Actions(), motion=self.motion
        )

    def reset(self, rows: I64, generators: list[np.random.Generator], *, anew: bool) -> None:
        """Give these rows new tasks, each from its own generator.

        Args:
            rows: Which (m,).
            generators: One for each of them.
            anew: In new worlds, even where a world has episodes left.
        """
        for k, rng in zip(rows.tolist(), generators, strict=True):
            self._renew(k, rng, anew=anew)
            self.paths[k] = [self._start[k, :2].copy()]
        self._drive = self._set_up()
        self.state = _put(self.state, RoverState.at_start(self.mission), rows)

    def _renew(self, k: int, rng: np.random.Generator, *, anew: bool) -> None:
        task = self.task
        lengths = {"nearest": task.nearest, "farthest": task.farthest}
        self._left[k] -= 1
        if not anew and self._left[k] > 0:
            grid = Grid(frame=self._frame, blocked=self._blocked[k])
            with contextlib.suppress(SettingError):  # no other task: then another world
                self._start[k], self._goal[k] = another_task(rng, grid, **lengths)
                return
        grid, self._start[k], self._goal[k] = practice_task(
            rng, self.rover, side=task.side, cell=task.cell, **lengths
        )
        self._blocked[k] = grid.blocked
        self._left[k] = task.episodes

    def step(self, actions: Any) -> Step:
        """Drive all rows that have not ended for one period; the others stay.

        Args:
            actions: Forward speed and turn rate (n, 2) as shares of the rover's limits; beyond
                [-1, 1] they are cut off.

        Raises:
            ShapeError: Not two numbers for each rover.
            InputError: One is not finite, as those of a policy that diverged.
        """
        share = self._shares(actions)
        twist = np.zeros((self.count, 3))
        twist[:, 0] = share[:, 0] * self.rover.speed
        twist[:, 2] = share[:, 1] * self.rover.turn_rate
        before, was = self.distance(), self.state.driving
        state = DriveState(rovers=self.state, sensors=(), controller=twist)
        self.state = tick(self._drive, state).rovers
        if self.keep_paths:
            for k, here in enumerate(self.state.pose[:, :2]):
                self.paths[k].append(here)
        outcome = self.state.outcome
        ended = was & (outcome != Outcome.DRIVING)
        reached, late = outcome == Outcome.REACHED, outcome == Outcome.TIMED_OUT
        harmed = ended & ~reached & ~late
        reward = before - self.distance() + STEP
        reward += np.where(ended & reached, REACHED, 0.0) + np.where(harmed, HARMED, 0.0)
        return Step(np.where(was, reward, 0.0), ended & ~late, ended & late)

    def _shares(self, actions: Any) -> F64:
        given = np.asarray(actions, np.float64)
        if given.size != 2 * self.count or (given.ndim > 1 and given.shape[-1] != 2):
            raise ShapeError(
                f"{self.count} {'rover needs' if self.count == 1 else 'rovers need'} actions of "
                f"shape {(2,) if self.count == 1 else (self.count, 2)}, got {given.shape}"
            )
        wrong = np.flatnonzero(~np.isfinite(given.reshape(self.count, 2)).all(axis=1))
        if len(wrong):
            raise InputError(
                f"actions must be finite; that of rover {wrong[0]} is "
                f"{given.reshape(self.count, 2)[wrong[0]].tolist()}"
            )
        return np.clip(given.reshape(self.count, 2), -1.0, 1.0)

    def distance(self) -> F64:
        """Straight lines to the goals (n,) [m]."""
        x, y = (self._goal - self.state.pose[:, :2]).T
        return np.sqrt(x * x + y * y)

    def ranges(self, rows: I64) -> F64:
        """What the beams of these rows read (m, beams) [m]."""
        some = dataclasses.replace(self.worlds, of=self.worlds.of[rows])
        state = _take(self.state, rows)
        return self.fan.read(some, state, None)[0]

    def observe(self, rows: I64) -> F32:
        """What these rows see (m, 5 + beams)."""
        state, goal = _take(self.state, rows), self._goal[rows]
        seen = np.empty((len(rows), 2))
        kernels.goal_in_body(state.pose, goal, seen)  # NumPy's cosines depend on the batch
        return features(seen, self.ranges(rows), state.twist, task=self.task, rover=self.rover)

    def info(self, rows: I64) -> dict[str, Any]:
        """Facts about these rows that are no observation."""
        outcome = self.state.outcome[rows]
        return {
            "distance_m": self.distance()[rows],
            "outcome": outcome.astype(np.int64),
            "is_success": outcome == Outcome.REACHED,
        }


def features(goal: F64, ranges: F64, twist: F64, *, task: Task, rover: Rover) -> F32:
    """What an agent sees (n, 5 + beams), every number within [-1, 1].

    Cosine and sine of the goal's bearing from the rover's heading, its distance as a share of the
    world's diagonal, forward speed and turn rate as shares of their limits, and each beam as a
    share of its reach.

    Args:
        goal: In the rover's frame (n, 2) [m].
        ranges: (n, beams) [m].
        twist: Body velocity (n, 3) [m/s, m/s, rad/s].
        task: What the environment is about.
        rover: Whose limits.
    """
    x, y = goal.T
    far = np.sqrt(x * x + y * y)
    safe = np.where(far > 0.0, far, 1.0)
    diagonal = task.side * math.sqrt(2.0)
    columns = [
        np.where(far > 0.0, x / safe, 1.0),
        y / safe,
        np.minimum(far / diagonal, 1.0),
        twist[:, 0] / rover.speed,
        twist[:, 2] / rover.turn_rate,
        *(ranges / task.reach).T,
    ]
    return np.clip(np.stack(columns, axis=1), -1.0, 1.0).astype(np.float32)


def _put(whole: RoverState, part: RoverState, rows: I64) -> RoverState:
    """`whole` with these rows as in `part`."""
    fields: dict[str, Any] = {}
    for field in dataclasses.fields(whole):
        array = getattr(whole, field.name).copy()
        array[rows] = getattr(part, field.name)[rows]
        fields[field.name] = array
    return RoverState(**fields)


def _take(whole: RoverState, rows: I64) -> RoverState:
    """These rows alone."""
    return RoverState(**{f.name: getattr(whole, f.name)[rows] for f in dataclasses.fields(whole)})
