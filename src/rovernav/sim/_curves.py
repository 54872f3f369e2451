"""Response curves of infra-red distance sensors, from the makers' data sheets.

Source: the look-up tables and power fits that Webots ships for these sensors (Cyberbotics, Apache
2.0, projects/devices/sharp/protos), which follow Sharp's data sheets. The near branch, from contact
to the peak, is in no table: a straight line from `CONTACT` of the peak is assumed.
"""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

from ..core import F64, value

CONTACT = 0.3
"""Voltage at contact as a share of the peak: assumed."""
COUNTS, VOLT = 1024, 5.0
"""A converter of 10 bits over 5 V."""


@value
class Curve:
    """An infra-red distance sensor.

    Attributes:
        name: Its maker's.
        rows: Distance [m] and voltage [V], distances rising (t, 2); from contact.
        noise: Standard deviation as a share of the voltage.
        fit: a, b, c of the power fit d = a V^b + c [m].
        nearest: Distance of the peak [m]: nothing nearer is ever read.
        reach: Distance of the last row [m]: nothing farther is.
        counts: Distance that each count is read as (c,) [m].
        volt: Voltage of the last count [V].
    """

    name: str
    rows: F64
    noise: float
    fit: tuple[float, float, float]
    nearest: float
    reach: float
    counts: F64
    volt: float

    def voltage(self, distance: F64) -> F64:
        """Output [V] at distances [m], without noise."""
        from ..kernels import noise

        last = len(self.rows) - 1
        each = [noise.voltage(float(d), self.rows, last) for d in np.ravel(distance)]
        return np.array(each).reshape(np.shape(distance))

    def doubt(self) -> F64:
        """Readings, rising, and their standard deviations (t, 2) [m].

        At a distance of the table with voltage V: noise V, and a third of a count's width of the
        converter, times the slope of the fit, together with what the fit itself is off.
        """
        a, b, c = self.fit
        beyond = self.rows[:, 0] >= self.nearest
        true, volts = self.rows[beyond].T
        read = np.round(a * volts**b + c, 6)
        slope = np.abs(a * b * volts ** (b - 1.0))
        count = VOLT / (COUNTS - 1)
        spread = slope * np.hypot(self.noise * volts, count / 3.0)
        return np.ascontiguousarray(
            np.column_stack([read, np.round(np.hypot(spread, read - true), 6)])
        )


def curve(
    name: str,
    rows: tuple[tuple[float, float], ...],
    noise: float,
    fit: tuple[float, float, float],
) -> Curve:
    """A curve from the rows of a data sheet, the near branch added.

    Distances are rounded to a micrometre, so that they do not hang on a machine's power function.
    """
    table = np.array([(0.0, CONTACT * rows[0][1]), *rows])
    near, reach = rows[0][0], rows[-1][0]
    a, b, c = fit
    volts = np.arange(1, COUNTS) * (VOLT / (COUNTS - 1))
    read = np.clip(np.round(a * volts**b + c, 6), near, reach)
    return Curve(
        name=name, rows=table, noise=noise, fit=fit, nearest=near, reach=reach,
        counts=np.concatenate([[reach], read]), volt=VOLT,
    )  # fmt: skip


_SHORT = (
    (0.030, 3.03), (0.035, 2.78), (0.040, 2.72), (0.050, 2.33), (0.060, 2.01), (0.070, 1.76),
    (0.080, 1.55), (0.090, 1.40), (0.100, 1.25), (0.120, 1.04), (0.140, 0.92), (0.160, 0.82),
    (0.180, 0.73), (0.200, 0.66), (0.250, 0.53), (0.300, 0.42), (0.350, 0.37), (0.400, 0.31),
)  # fmt: skip
_LONG = (
    (0.15, 2.75), (0.20, 2.51), (0.30, 1.99), (0.40, 1.52), (0.50, 1.25), (0.60, 1.04),
    (0.70, 0.87), (0.80, 0.79), (0.90, 0.74), (1.00, 0.69), (1.10, 0.60), (1.20, 0.55),
    (1.30, 0.50), (1.40, 0.47), (1.50, 0.45),
)  # fmt: skip

CURVES = MappingProxyType(
    {
        "GP2D120": curve("GP2D120", _SHORT, 0.005, (0.1594, -0.8533, -0.02916)),
        "GP2Y0A02YK0F": curve("GP2Y0A02YK0F", _LONG, 0.015, (0.7611, -0.9313, -0.1252)),
    }
)
"""Sharp's sensors by name."""
