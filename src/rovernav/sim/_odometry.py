"""Where a rover thinks it is, if nobody tells it: odometry that drifts."""

from __future__ import annotations

import math
from typing import NamedTuple, final

import numpy as np

from ..core import F64, Mission, RoverState, SettingError, value
from ..kernels import odometry as kernels
from ._noise import Draws, draws
from ._world import Worlds


@value
class Drift:
    """How an estimate of the pose drifts.

    Attributes:
        scale: Standard deviation of the constant error of length, of each rover.
        walk: Random error of length [m/sqrt(m)].
        turn: Random error of heading [rad/sqrt(m)].
        curl: Standard deviation of the constant error of heading [rad/m].
        rise: Random error of height [m/sqrt(m)].
        sun: Standard deviation of a heading by the sun [rad]; 0 without a sun sensor.
    """

    scale: float = 0.04
    walk: float = 0.13
    turn: float = 0.004
    curl: float = 0.0
    rise: float = 0.01
    sun: float = 0.0

    def _check(self) -> None:
        for name in kernels.Drift._fields:
            got = getattr(self, name)
            if not (math.isfinite(got) and got >= 0.0):
                raise SettingError(f"drift: {name} must be 0 or more, got {got!r}")


class _Estimate(NamedTuple):
    draws: Draws
    last: F64
    now: F64


@final
class Odometry:
    """A rover's own estimate of its pose: wheels and a gyro, perhaps the sun, no satellites.

    A rover that carries one is steered by it: its goal, its map and its controller know the
    estimate, not the truth. It begins at the true pose.

    Args:
        drift: How it drifts. By default about as Spirit's odometry did beside its corrected track,
            without its mean error and its heavy tails.
    """

    name = "estimate"

    def __init__(self, drift: Drift | None = None) -> None:
        self.drift = drift or Drift()
        self._numbers = kernels.Drift(
            *(float(getattr(self.drift, name)) for name in kernels.Drift._fields)
        )

    def start(self, mission: Mission, rng: np.random.Generator) -> _Estimate:
        """At the true start, height 0 there, and sure of it."""
        now = np.zeros((len(mission.start), kernels.D + 1))
        now[:, : kernels.A + 1] = mission.start
        return _Estimate(draws(mission, rng), mission.start, now)

    def read(self, world: Worlds, state: RoverState, memory: _Estimate) -> tuple[F64, _Estimate]:
        """The estimate (n, 7): x, y [m], heading [rad], height above the start [m]; variances.

        Variances are those of place (both axes together) [m^2], heading [rad^2] and height [m^2].
        """
        now, draw = memory.now.copy(), memory.draws.next()
        kernels.advance(
            state.pose, memory.last, state.slip, draw.keys, draw.step, heights(world),
            self._numbers, now,
        )  # fmt: skip
        return now[:, : kernels.TOLD].copy(), _Estimate(draw, state.pose, now)


def heights(world: Worlds) -> kernels.Heights:
    """The ground of worlds as kernels take it."""
    of = np.ascontiguousarray(world.of)
    if world.ground is None:
        return kernels.Heights(height=_FLAT, cell=1.0, of=of)
    layers = world.ground.height
    layers = np.ascontiguousarray(layers if layers.ndim == 3 else layers[None])
    layers.flags.writeable = False
    return kernels.Heights(height=layers, cell=float(world.ground.frame.cell), of=of)


_FLAT = np.zeros((0, 0, 0), np.float32)
_FLAT.flags.writeable = False
