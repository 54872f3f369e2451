"""One controller's drive, step by step; any step can be asked why."""

from __future__ import annotations

import dataclasses
import math
import time
from typing import Any, final

import numpy as np

from ..control import Why, explain
from ..core import F64, Controller, Outcome, RovernavError
from ..nets import Network
from ..rover import Rover, Standing
from ..scenes import Ground, Scenario, Scene
from ..sim import Drive, DriveState, RangeFan, Trace, TraceBuilder, begin, clearance, tick

KEYFRAME = 64
"""Every so many steps the whole state is kept, so that any step can be gone back to quickly."""
MOST_STEPS = 50_000


@dataclasses.dataclass(frozen=True)
class Pick:
    """A controller that was chosen.

    Attributes:
        key: ``train``, a registered name, or ``file:N`` for an uploaded network.
        label: What the page calls it.
        network: The uploaded network.
    """

    key: str
    label: str
    network: Network | None = None

    @property
    def controller_name(self) -> str:
        """What a scenario file says: a name, or the network file beside it."""
        return "network.safetensors" if ":" in self.key or self.key == "train" else self.key


@dataclasses.dataclass(frozen=True)
class Moment:
    """What there is to tell about one step of a drive.

    Attributes:
        step: Which.
        time: [s].
        pose: x [m], y [m], heading [rad].
        command: Forward [m/s], left [m/s], turn [rad/s] that was given here; None at the end.
        channels: Readings by sensor.
        tilt: Slope of the ground under the rover [rad]; 0 on flat ground.
        to_goal: Distance to the goal [m].
        driven: Distance driven so far [m].
    """

    step: int
    time: float
    pose: tuple[float, float, float]
    command: tuple[float, float, float] | None
    channels: dict[str, F64]
    tilt: float
    to_goal: float
    driven: float


@dataclasses.dataclass(frozen=True)
class Entry:
    """All that one controller's drive begins with.

    Attributes:
        pick: Who drives.
        controller: The same, ready.
        network: Its network, where it is not a registered one.
        scenario: The scenario file that gives this drive again.
        scene: What the scenario describes.
        rover: Who is driven.
        note: Anything to say about it, like another rover than the chosen one.
    """

    pick: Pick
    controller: Controller
    network: Network | None
    scenario: Scenario
    scene: Scene | Ground
    rover: Rover
    note: str = ""


@final
class DriveRun:
    """A drive under way or ended."""

    def __init__(self, entry: Entry) -> None:
        self.entry, self.pick, self.rover = entry, entry.pick, entry.rover
        self.scenario, self.controller, self.note = entry.scenario, entry.controller, entry.note
        self.error, self.kept = "", ""
        scene = entry.scene
        self.ground = scene if isinstance(scene, Ground) else None
        self.scene: Scene = scene.scene if isinstance(scene, Ground) else scene
        self.trace: Trace | None = None
        self.clearance = math.nan
        self._drive: Drive = self.scene.drive(entry.controller)
        self._state = begin(self._drive, np.random.default_rng(entry.scenario.seed))
        self._builder = TraceBuilder("all")
        self._builder.add(self._state.rovers, None, None)
        self._keys: dict[int, DriveState] = {0: self._state}
        self._told: dict[int, tuple[Why, DriveState]] = {}
        self.times: list[float] = [0.0]
        self.poses: list[tuple[float, float, float]] = [_pose(self._state)]
        self.driven: list[float] = [0.0]
        self.commands: list[tuple[float, float, float]] = []
        self.readings: list[dict[str, F64]] = []
        if not self._state.rovers.driving.any():
            self._finish()

    @property
    def steps(self) -> int:
        """Steps driven so far."""
        return len(self.commands)

    @property
    def ended(self) -> bool:
        """Whether it is over."""
        return self.trace is not None or bool(self.error)

    @property
    def outcome(self) -> Outcome:
        """How it ended; DRIVING while it has not."""
        return Outcome(int(self._state.rovers.outcome[0]))

    @property
    def standing(self) -> Standing | None:
        """Where its rover can stand; None on flat ground."""
        return None if self.ground is None else self.ground.standing

    def advance(self, seconds: float) -> None:
        """Drive on for at most `seconds` of work, at least one step; errors end it with words."""
        until = time.perf_counter() + seconds
        try:
            while not self.ended:
                self._step()
                if time.perf_counter() >= until:
                    return
        except RovernavError as error:
            self.error = str(error)

    def _step(self) -> None:
        state = tick(self._drive, self._state)
        self._builder.add(state.rovers, state.observation, state.command)
        assert state.observation is not None
        assert state.command is not None
        self.readings.append({name: b[0] for name, b in state.observation.channels.items()})
        self.times.append(float(state.rovers.time[0]))
        self.poses.append(_pose(state))
        self.driven.append(float(state.rovers.odometry[0]))
        a, b, c = state.command.twist[0].tolist()
        self._state = state
        self.commands.append((a, b, c))  # last: `steps` counts these
        if self.steps % KEYFRAME == 0:
            self._keys[self.steps] = state
        if not state.rovers.driving.any():
            self._finish()
        elif self.steps >= MOST_STEPS:
            self.error = f"stopped after {MOST_STEPS:,} steps; the command line drives longer"

    def _finish(self) -> None:
        settings = self.scenario.model_dump(mode="json", by_alias=True, exclude_none=True)
        trace = self._builder.finish(
            self.scene.mission, self._state.rovers, seed=self.scenario.seed, settings=settings
        )
        self.clearance = clearance(trace.path(), self.scene.worlds)
        self.trace = trace

    def step_at(self, seconds: float) -> int:
        """The last step that was reached `seconds` after the start."""
        return max(0, min(int(np.searchsorted(self.times, seconds, "right")) - 1, self.steps))

    def moment(self, step: int) -> Moment:
        """What there is to tell about a step."""
        step = max(0, min(step, self.steps))
        x, y, heading = self.poses[step]
        goal = self.scene.mission.goal[0]
        tilt = 0.0
        if self.ground is not None and self.ground.terrain.frame.contains(x, y):
            under = float(self.ground.standing.slope[self.ground.terrain.frame.cell_of(x, y)])
            tilt = under if math.isfinite(under) else math.nan
        here = step < self.steps
        return Moment(
            step=step,
            time=self.times[step],
            pose=(x, y, heading),
            command=self.commands[step] if here else None,
            channels=self.readings[step] if here else {},
            tilt=tilt,
            to_goal=math.dist((x, y), goal),
            driven=self.driven[step],
        )

    @property
    def fan(self) -> RangeFan | None:
        """Its range beams, if it carries any."""
        fans = [sensor for sensor in self.scene.sensors if isinstance(sensor, RangeFan)]
        return fans[0] if fans else None

    def beams(self, step: int) -> list[tuple[float, float, bool]]:
        """Ends of the beams at a step: x, y [m], and whether they met something."""
        fan = self.fan
        if fan is None or step >= self.steps:
            return []
        x, y, heading = self.poses[step]
        ranges, angles = self.readings[step][fan.name], fan.angles + heading
        ends = np.stack([x + ranges * np.cos(angles), y + ranges * np.sin(angles)], axis=1)
        return [(px, py, bool(r < fan.reach)) for (px, py), r in zip(ends, ranges, strict=True)]

    def sensed(self, step: int, *, most: int = 1500) -> F64:
        """Where its beams met something up to a step (m, 2), thinned to `most` points."""
        fan, last = self.fan, min(step + 1, self.steps)
        if fan is None or not last:
            return np.empty((0, 2))
        ranges = np.array([reading[fan.name] for reading in self.readings[:last]])
        points = fan.points(np.array(self.poses[:last]), ranges)
        cells = np.unique(np.round(points / 0.1).astype(np.int64), axis=0)
        return 0.1 * cells.astype(np.float64)[:: max(1, math.ceil(len(cells) / most))]

    def why(self, step: int) -> tuple[Why, DriveState]:
        """Why it decided what it did at a step, and the state after it.

        The drive is gone through again from the last state that was kept, so the controller sees
        exactly what it saw.
        """
        step = max(0, min(step, self.steps - 1))
        if step not in self._told:
            begun = max(key for key in list(self._keys) if key <= step)
            state = self._keys[begun]
            for _ in range(step - begun):
                state = tick(self._drive, state)
            after = tick(self._drive, state)
            assert after.observation is not None
            why = explain(self.controller, after.observation, state.controller)
            if len(self._told) > 16:
                self._told.clear()
            self._told[step] = why, after
        return self._told[step]

    def summary(self) -> dict[str, Any]:
        """The numbers of an ended drive, plain."""
        straight = math.dist(self.scenario.start, self.scenario.goal)
        steep = self.standing.steepest(np.array(self.poses)[:, :2]) if self.standing else 0.0
        return {
            "controller": self.pick.label,
            "rover": self.rover.name,
            "outcome": self.outcome.label if not self.error else "error",
            "length_m": self.driven[-1],
            "straight_m": straight,
            "detour": self.driven[-1] / straight if straight > 0 else None,
            "time_s": self.times[-1],
            "steps": self.steps,
            "clearance_m": self.clearance if math.isfinite(self.clearance) else None,
            "max_slope_deg": math.degrees(steep),
            "to_goal_m": math.dist(self.poses[-1][:2], self.scene.mission.goal[0]),
        }


def _pose(state: DriveState) -> tuple[float, float, float]:
    x, y, heading = state.rovers.pose[0].tolist()
    return x, y, heading
