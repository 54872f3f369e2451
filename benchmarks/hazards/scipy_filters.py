"""SciPy's filters and distance transform, and NumPy for the rest, as a user writes them."""

from __future__ import annotations

from typing import Any

import numpy as np
from harness.model import Trial

from . import task


def build(size: int) -> Trial:
    """Plane fit, roughness, steps, distance, slip and energy."""
    from scipy import ndimage

    from rovernav.kernels import traction as k
    from rovernav.rover import drive_table, read_rover

    z, rover = task.heights(size), read_rover("perseverance")
    row = drive_table(rover)[0]
    n = 2 * task.REACH + 1
    lever, ones = np.arange(n) - float(task.REACH), np.ones(n)
    inertia = n * (lever**2).sum()

    def planes(z: Any) -> tuple[Any, Any, Any]:
        z = z.astype(np.float64)
        along = ndimage.correlate1d(ndimage.correlate1d(z, ones, axis=0), lever, axis=1)
        across = ndimage.correlate1d(ndimage.correlate1d(z, lever, axis=0), ones, axis=1)
        total = ndimage.correlate1d(ndimage.correlate1d(z, ones, axis=0), ones, axis=1)
        square = ndimage.correlate1d(ndimage.correlate1d(z * z, ones, axis=0), ones, axis=1)
        rest = square - total**2 / n**2 - (along**2 + across**2) / inertia
        p, q = along / inertia / task.CELL, across / inertia / task.CELL
        rms = np.sqrt(np.maximum(rest, 0.0) / n**2)
        edge = task.REACH
        inner = (slice(edge, -edge), slice(edge, -edge))
        return tuple(np.pad(a[inner], edge, mode="edge") for a in (p, q, rms))

    def ledge(z: Any) -> Any:
        out, rise = np.zeros(z.shape, np.float32), np.tan(rover.max_slope) * task.CELL
        for di, dj in ((0, 1), (1, 0), (1, 1), (1, -1)):
            a = z[di:, max(0, dj) : z.shape[1] + min(0, dj)]
            b = z[: z.shape[0] - di, max(0, -dj) : z.shape[1] - max(0, dj)]
            dz = np.abs(a - b)
            dz[dz <= rise * np.hypot(di, dj)] = 0.0
            for view in (
                out[di:, max(0, dj) : z.shape[1] + min(0, dj)],
                out[: z.shape[0] - di, max(0, -dj) : z.shape[1] - max(0, dj)],
            ):
                np.maximum(view, dz, out=view)
        return out

    def work() -> float:
        p, q, _ = planes(z)
        rise = np.hypot(p, q)
        bad = (np.arctan(rise) > rover.max_slope) | (ledge(z) > rover.max_step)
        distance = ndimage.distance_transform_edt(~bad) * task.CELL
        blocked = distance <= rover.radius * (1.0 + 1e-12)
        slip = np.interp(rise, np.linspace(-1.0, 1.0, k.NODES), row[k.FIRST : k.FIRST + k.NODES])
        stretch = np.sqrt(1.0 + rise * rise)
        force = np.maximum(row[k.WEIGHT] * (rise + row[k.ROLLING]) / stretch, 0.0)
        with np.errstate(divide="ignore"):
            energy = (force / row[k.EFFICIENCY] + row[k.IDLE] / row[k.SPEED]) * stretch / (1 - slip)
        assert energy.shape == blocked.shape
        return float(blocked.sum())

    return task.calls(work)
