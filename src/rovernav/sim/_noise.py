"""Sensors with noise: ranges, infra-red voltages, tilt. Every draw hangs on rover and reading."""

from __future__ import annotations

import math
from typing import NamedTuple, final

import numpy as np

from ..core import F64, I64, Mission, RoverState, SettingError, suggest, value
from ..kernels import noise as kernels
from ._curves import CURVES, Curve
from ._fan import RangeFan
from ._world import Worlds

MOST_SEEDS = 2**63


class Draws(NamedTuple):
    """What noise remembers: who the rovers are, and how often they have read.

    Attributes:
        keys: Key of each rover (n,), uint64.
        step: Readings so far.
    """

    keys: I64
    step: int

    def next(self) -> Draws:
        """After one reading more."""
        return self._replace(step=self.step + 1)


def draws(mission: Mission, rng: np.random.Generator) -> Draws:
    """The keys of some rovers: one seed is drawn, whatever their number."""
    out = np.empty(len(mission.number), np.uint64)
    kernels.keys(int(rng.integers(MOST_SEEDS)), mission.number, out)
    return Draws(keys=out, step=0)  # pyright: ignore[reportArgumentType]


@value
class RangeNoise:
    """What spoils a range; see `rovernav.kernels.noise.spoil` for the formula.

    Attributes:
        core: Standard deviation at range 0 [m].
        relative: What each metre adds to it.
        stray: Chance that a beam goes astray, for each metre of range [1/m].
        spread: Standard deviation of stray readings [m].
        back: Chance that it is back at the next reading: 1 / mean length of a burst.
        lose: Chance that a beam loses its echo, for each metre of range [1/m].
        find: Chance that a lost beam has it again at the next reading: 1 / mean length of a burst.
        least: Nothing nearer is read [m].
        grain: Readings are whole multiples of this [m]; 0 for any number.
        source: Where the numbers come from.
    """

    core: float = 0.0
    relative: float = 0.0
    stray: float = 0.0
    spread: float = 0.0
    back: float = 1.0
    lose: float = 0.0
    find: float = 1.0
    least: float = 0.0
    grain: float = 0.0
    source: str = ""

    def _check(self) -> None:
        for name in ("core", "relative", "stray", "spread", "lose", "least", "grain"):
            got = getattr(self, name)
            if not (math.isfinite(got) and got >= 0.0):
                raise SettingError(f"range noise: {name} must be 0 or more, got {got!r}")
        for name in ("find", "back"):
            got = getattr(self, name)
            if not 0.0 < got <= 1.0:
                raise SettingError(f"range noise: {name} must lie above 0 and up to 1, got {got!r}")

    def numbers(self) -> kernels.RangeNoise:
        """As the kernels take it."""
        return kernels.RangeNoise(
            *(float(getattr(self, name)) for name in kernels.RangeNoise._fields)
        )


class _Seen(NamedTuple):
    draws: Draws
    since: I64


@final
class NoisyFan:
    """A range fan whose readings are spoilt: Gaussian core, strays, echoes lost in bursts.

    Args:
        fan: The ideal fan.
        noise: What spoils it.
        cone: So many neighbouring beams make one reading, the nearest of them: a cone of sound.
    """

    name = "beams"

    def __init__(self, fan: RangeFan, noise: RangeNoise, *, cone: int = 1) -> None:
        if cone < 1 or len(fan.angles) % cone:
            raise SettingError(
                f"a cone must be a whole part of the fan's {len(fan.angles)} beams, got {cone!r}"
            )
        self.fan, self.noise, self.cone = fan, noise, int(cone)
        self.reach = fan.reach
        self.angles: F64 = fan.angles.reshape(-1, cone).mean(axis=1)

    def points(self, poses: F64, readings: F64) -> F64:
        """Where the beams of one rover seem to have met something; see `RangeFan.points`."""
        a = poses[:, 2:3] + self.angles
        met = readings < self.reach
        x, y = poses[:, :1] + readings * np.cos(a), poses[:, 1:2] + readings * np.sin(a)
        return np.stack([x[met], y[met]], axis=1)

    def start(self, mission: Mission, rng: np.random.Generator) -> _Seen:
        """All beams see at the start."""
        n = len(mission.start)
        return _Seen(draws(mission, rng), np.zeros((n, len(self.angles)), np.int64))

    def read(self, world: Worlds, state: RoverState, memory: _Seen) -> tuple[F64, _Seen]:
        """Distances (n, beams) [m], at most `reach`."""
        true = nearest(self.fan.read(world, state, None)[0], self.cone)
        out, since = np.empty_like(true), np.empty(true.shape, np.int64)
        draw = memory.draws.next()
        kernels.spoil(
            true, draw.keys, draw.step, memory.since, self.reach, self.noise.numbers(), since, out
        )
        return out, _Seen(draw, since)


@final
class InfraRed:
    """Triangulating infra-red sensors: a voltage that falls with distance, read back in metres.

    What is nearer than the voltage's peak is read as farther away, as with the real ones.

    Args:
        curve: The sensor, or its name: ``GP2D120`` or ``GP2Y0A02YK0F``.
        beams: How many there are, evenly from right to left.
        view: Angle between the outermost [rad].
        name: Channel.
    """

    def __init__(
        self,
        curve: str | Curve = "GP2Y0A02YK0F",
        *,
        beams: int = 5,
        view: float = math.pi,
        name: str = "beams",
    ) -> None:
        if isinstance(curve, str):
            if curve not in CURVES:
                raise SettingError(f"unknown infra-red sensor {curve!r}; {suggest(curve, CURVES)}")
            curve = CURVES[curve]
        self.name, self.curve, self.reach = name, curve, curve.reach
        self._fan = RangeFan(reach=FAR * curve.reach, beams=beams, view=view)
        self.angles: F64 = self._fan.angles

    def start(self, mission: Mission, rng: np.random.Generator) -> Draws:
        """Who reads."""
        return draws(mission, rng)

    def read(self, world: Worlds, state: RoverState, memory: Draws) -> tuple[F64, Draws]:
        """Distances (n, beams) [m], from the curve's nearest to `reach`."""
        true, _ = self._fan.read(world, state, None)
        out, now = np.empty_like(true), memory.next()
        c = self.curve
        kernels.infrared(true, now.keys, now.step, c.rows, c.noise, c.counts, c.volt, out)
        return out, now


@final
class Tilt:
    """An inertial unit's pitch and roll: a constant error for each rover, and one per reading.

    Args:
        bias: Standard deviation of the constant error [rad].
        noise: Standard deviation of the other [rad].
    """

    name = "tilt"

    def __init__(
        self, *, bias: float = math.radians(0.5), noise: float = math.radians(0.1)
    ) -> None:
        for what, got in (("bias", bias), ("noise", noise)):
            if not (math.isfinite(got) and got >= 0.0):
                raise SettingError(f"the {what} of a tilt must be 0 rad or more, got {got!r}")
        self.bias, self.noise = float(bias), float(noise)

    def start(self, mission: Mission, rng: np.random.Generator) -> Draws:
        """Who reads."""
        return draws(mission, rng)

    def read(self, world: Worlds, state: RoverState, memory: Draws) -> tuple[F64, Draws]:
        """Pitch and roll (n, 2) [rad]."""
        out, now = np.empty((len(state.pose), 2)), memory.next()
        kernels.tilted(state.attitude, now.keys, now.step, self.bias, self.noise, out)
        return out, now


FAR = 4.0
"""An infra-red sensor looks this many times as far as it can tell distances."""


def nearest(ranges: F64, cone: int) -> F64:
    """The shortest of each `cone` of neighbouring beams (n, b cone): (n, b)."""
    if cone == 1:
        return ranges
    out = np.empty((len(ranges), ranges.shape[1] // cone))
    kernels.nearest_of(ranges, cone, out)
    return out


LIDAR = RangeNoise(
    core=0.01, relative=0.002, lose=0.0005, find=0.5, least=0.06, grain=0.001,
    source="assumed: the usual scanner for a laptop robot, 1 cm at close range",
)  # fmt: skip
SONAR = RangeNoise(
    core=0.014, relative=0.0001, stray=0.026, spread=0.99, back=0.60, lose=0.020, find=0.19,
    least=0.3, grain=0.001, source="fitted to the first half of the SCITOS G5 log",
)  # fmt: skip

_RANGERS = {
    "lidar": lambda: NoisyFan(RangeFan(reach=10.0, beams=181, view=math.pi), LIDAR),
    "sonar": lambda: NoisyFan(RangeFan(reach=4.0, beams=65, view=math.pi), SONAR, cone=5),
    "sonar-ring": lambda: NoisyFan(
        RangeFan(reach=5.0, beams=120, view=2.0 * math.pi * 119 / 120), SONAR, cone=5
    ),
    "infrared-near": lambda: InfraRed("GP2D120"),
    "infrared-far": lambda: InfraRed("GP2Y0A02YK0F"),
}


def ranger(name: str) -> NoisyFan | InfraRed:
    """A range sensor by name.

    ``lidar``: 181 beams over 180 deg, 10 m. ``sonar``: 13 cones over 180 deg, 4 m. ``sonar-ring``:
    24 cones of 15 deg all round, 5 m. ``infrared-near`` (4 to 40 cm) and ``infrared-far`` (20 to
    150 cm): five sensors over 180 deg.

    Raises:
        SettingError: No range sensor has that name.
    """
    if name not in _RANGERS:
        raise SettingError(f"unknown range sensor {name!r}; {suggest(name, _RANGERS)}")
    return _RANGERS[name]()
