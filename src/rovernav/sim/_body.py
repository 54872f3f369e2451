"""A rover with a body: steering, motors, slip, energy, footprint and attitude."""

from __future__ import annotations

import math
from typing import Any, final

import numpy as np

from ..core import F64, Command, Mission, RoverState, SettingError, read_only
from ..kernels import body as kernels
from ..kernels import draws, traction
from ..kernels import settle as st
from ..kernels import wheels as wh
from ..kernels.body import BodyArrays, Ends, GroundArrays, Rows
from ..rover import Rover, Soil, drive_table
from ._footing import footing
from ._world import Worlds

SLACK = 1e-3
"""A swept footprint is never too small, and too large by at most this [m]."""
STUCK_SHARE, STUCK_WAY = 0.05, 2.0
"""Stuck: less than this share of a commanded way of so many wheel bases was made good."""
_STEERING = {"two-axis": wh.TWO_AXIS, "skid": wh.SKID, "ackermann": wh.ACKERMANN, "crab": wh.CRAB}


@final
class Body:
    """Moves rovers as bodies: they steer, slip, spend energy, stand on the ground and meet things.

    A command is held within the limits of motors and steering, followed with the motors' lag, and
    reduced by the soil's slip on the slope the body stands on. The footprint is swept from step to
    step against boxes, shapes, grids and high rocks. At the end of each part of a step the wheels
    are set onto the ground. Without ground, mobility, lag and size it moves as `DifferentialDrive`
    and `TwoAxis` do, to the same bits.

    Args:
        rover: Who drives.
        period: Time between two decisions [s].
        soil: A soil or its name; the rover's own where not given.
        slip: "low", "expected" or "high" edge of what is likely, or "none" for wheels that never
            slip.
        spread: Slip and side slip of each rover are multiplied by a number of its own, evenly
            drawn from 1 - spread to 1 + spread.
        grid: Whether the footprint must not touch blocked cells of the worlds' grid. False where a
            grid only shows to sensors where ground is bad.
        parts: Parts into which a step is cut; where not given, as many as it takes for wheels at
            full speed to go no farther than their radius in one.

    Raises:
        SettingError: A number or name that is not allowed.
    """

    def __init__(  # noqa: PLR0913 - settings by keyword
        self, rover: Rover, *, period: float = 0.5, soil: str | Soil | None = None,
        slip: str = "expected", spread: float = 0.0, grid: bool = True, parts: int | None = None,
    ) -> None:  # fmt: skip
        if not (math.isfinite(period) and period > 0):
            raise SettingError(f"the period must be above 0 s, got {period!r}")
        if not 0.0 <= spread <= 1.0:
            raise SettingError(f"the spread of slip must lie in 0 to 1, got {spread!r}")
        if parts is not None and not 1 <= parts <= 1000:
            raise SettingError(f"a step has 1 to 1000 parts, got {parts!r}")
        self.rover, self.period, self.spread = rover, float(period), float(spread)
        self.soil: str | None = None
        self.parts = parts or _parts(rover, self.period)
        chassis = np.zeros(st.CHASSIS) if rover.chassis is None else rover.chassis_array()
        table = np.zeros((0, traction.COLUMNS))
        if rover.mobility is not None:
            table = drive_table(rover, soil, slip="expected" if slip == "none" else slip).copy()
            if slip == "none":
                table[:, traction.FIRST :] = 0.0
            self.soil = soil.name if isinstance(soil, Soil) else soil or rover.mobility.soil
        elif soil is not None:
            drive_table(rover, soil)
        numbers = _numbers(rover, self.period, self.parts, grid=grid)
        for array in (numbers, chassis, table):
            array.flags.writeable = False
        self._arrays = BodyArrays(numbers, chassis, table)
        self._ready: tuple[Any, Any, int, GroundArrays] | None = None

    def start(self, mission: Mission, rng: np.random.Generator) -> F64:
        """What slip and side slip of each rover are multiplied by (n, 2).

        Hangs on the generator and each rover's number, not on who else is in the batch.
        """
        out = np.zeros((len(mission.start), 2))
        if self.spread > 0.0:
            key = int(rng.integers(2**62))
            draws.uniform_pairs(key, read_only(mission.number), self.spread, out)
        return 1.0 + out

    def place(self, worlds: Worlds, mission: Mission, state: RoverState) -> RoverState:
        """The rovers set down where they are; those that cannot be there have ended."""
        n = len(state.pose)
        nothing = Command(twist=np.zeros((n, 3)))
        return self._run(worlds, mission, state, nothing, np.ones((n, 2)), placing=True)

    def move(
        self, worlds: Worlds, mission: Mission, state: RoverState, command: Command, factor: F64
    ) -> RoverState:
        """The state one period later, obstacles, ground and ends considered.

        Args:
            worlds: Where.
            mission: Goals and limits.
            state: Now; rovers that have ended stay as they are.
            command: What is commanded.
            factor: From `start`.
        """
        return self._run(worlds, mission, state, command, factor)

    def step(self, state: RoverState, command: Command) -> RoverState:
        """The state one period later on level ground without obstacles or goals."""
        n = len(state.pose)
        nowhere = Mission(
            start=state.pose, goal=np.zeros((n, 2)), goal_radius=0.0, time_limit=1e300
        )
        return self.move(Worlds.single(rovers=n), nowhere, state, command, np.ones((n, 2)))

    def _run(
        self, worlds: Worlds, mission: Mission, state: RoverState, command: Command,
        factor: F64, *, placing: bool = False,
    ) -> RoverState:  # fmt: skip
        rows, ground = _rows(state), self._ground(worlds)
        twist = read_only(np.ascontiguousarray(command.twist, dtype=np.float64))
        kernels.move(
            twist, read_only(factor), rows, _ends(worlds, mission), self._arrays, ground,
            worlds.arrays(), placing,
        )  # fmt: skip
        return RoverState(**rows._asdict())

    def _ground(self, worlds: Worlds) -> GroundArrays:
        """The worlds' ground made ready; the last one is kept, told by identity."""
        count = len(worlds.offsets)
        kept = self._ready
        same = kept is not None and kept[0] is worlds.ground and kept[1] is worlds.rocks
        if kept is None or not same or kept[2] != count:
            kept = (worlds.ground, worlds.rocks, count, footing(worlds, self.rover))
            self._ready = kept
        return kept[3]


def _rows(state: RoverState) -> Rows:
    """Copies of a state's arrays, to be changed."""
    return Rows(*(getattr(state, name).copy() for name in Rows._fields))


def _ends(worlds: Worlds, mission: Mission) -> Ends:
    return Ends(mission.goal, worlds.bounds, float(mission.goal_radius), float(mission.time_limit))


def _parts(rover: Rover, period: float) -> int:
    if rover.wheel_radius == 0.0:
        return 1
    return min(100, max(1, math.ceil(rover.speed * period / rover.wheel_radius - 1e-9)))


def _numbers(rover: Rover, period: float, parts: int, *, grid: bool) -> F64:
    """The rover as `kernels.wheels` describes it."""
    steering, chassis, part = rover.steering, rover.chassis, period / parts
    n = np.zeros(wh.BODY)
    n[wh.STEERING], n[wh.SPEED], n[wh.TURN_RATE] = (
        _STEERING[steering.kind], rover.speed, rover.turn_rate,
    )  # fmt: skip
    n[wh.WHEEL_SPEED] = steering.wheel_speed or np.inf
    n[wh.ACCELERATION] = steering.acceleration or np.inf
    n[wh.TURN_ACCELERATION] = steering.turn_acceleration or np.inf
    if steering.lag > 0.0:
        n[wh.LEFT_OVER] = math.exp(-part / steering.lag)
        n[wh.MEAN_LEFT] = -math.expm1(-part / steering.lag) * steering.lag / part
    n[wh.STEER] = math.tan(steering.max_steer) if steering.max_steer < math.pi / 2 else np.inf
    n[wh.PERIOD], n[wh.PART], n[wh.PARTS], n[wh.GRID] = period, part, parts, float(grid)
    n[wh.STALL], n[wh.TIP], n[wh.PATIENT] = np.inf, np.inf, STUCK_SHARE
    n[wh.FRONT], n[wh.REAR], n[wh.HALF_WIDTH] = (
        0.5 * rover.length, -0.5 * rover.length, 0.5 * rover.width,
    )  # fmt: skip
    n[wh.LIFT], n[wh.SLACK] = rover.clearance, SLACK
    if chassis is None:
        return n
    x, half = chassis.wheel_x, 0.5 * rover.track
    n[wh.AXLE] = x[1] if len(x) == 3 else x[-1]
    far = max(abs(place - n[wh.AXLE]) for place in x) / n[wh.STEER]
    n[wh.OUTER], n[wh.INNER] = half + far, half - far
    n[wh.STALL], n[wh.TIP] = STUCK_WAY * chassis.wheelbase, chassis.static_tilt
    n[wh.STRIP_IN] = max(0.0, half - 0.5 * chassis.wheel_width)
    n[wh.STRIP_OUT] = half + 0.5 * chassis.wheel_width
    return n
