"""A body set onto the ground by brute force: rotation matrices, a residual, Newton's method."""

from __future__ import annotations

import math

import numpy as np


def wheel_centres(z: np.ndarray, cell: float, radius: float) -> np.ndarray:
    """Height of a wheel's centre over each post, by looking at every other post."""
    h, w = z.shape
    out = np.full((h, w), -math.inf)
    for i, j in np.ndindex(h, w):
        for a, b in np.ndindex(h, w):
            left = radius**2 - cell**2 * ((a - i) ** 2 + (b - j) ** 2)
            if left >= 0.0:
                top = float(z[a, b]) + math.sqrt(left)
                out[i, j] = math.nan if math.isnan(top) or math.isnan(out[i, j]) else max(
                    out[i, j], top
                )  # fmt: skip
    return out


def bilinear(grid: np.ndarray, cell: float, x: float, y: float) -> float:
    h, w = grid.shape
    u, v = min(max(x / cell - 0.5, 0.0), w - 1.0), min(max(y / cell - 0.5, 0.0), h - 1.0)
    j, i = min(int(u), w - 2), min(int(v), h - 2)
    a, b = u - j, v - i
    (sw, se), (nw, ne) = grid[i : i + 2, j : j + 2].tolist()
    return (1 - b) * ((1 - a) * sw + a * se) + b * ((1 - a) * nw + a * ne)


def turn(angle: float) -> np.ndarray:
    """Nose up, in a side's plane (x, z)."""
    return np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])


def rotation(pitch: float, roll: float, yaw: float) -> np.ndarray:
    """Body to ground: roll first, then pitch (nose up), then heading."""
    cp, sp, cr, sr = math.cos(pitch), math.sin(pitch), math.cos(roll), math.sin(roll)
    up = np.array([[cp, 0, -sp], [0, 1, 0], [sp, 0, cp]])
    side = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    head = np.array(
        [[math.cos(yaw), -math.sin(yaw), 0], [math.sin(yaw), math.cos(yaw), 0], [0, 0, 1]]
    )
    return head @ up @ side


def wheels(rover, rocker: float, bogies: tuple[float, float]) -> list[np.ndarray]:
    """Wheel centres in body axes, left side then right, front to rear."""
    c, out = rover.chassis, []
    for side, sign in enumerate((1.0, -1.0)):
        pivot, joint = np.array(c.rocker), np.array(c.bogie)
        if c.suspension == "rigid":
            flat = [np.array([x, 0.0]) for x in c.wheel_x]
        else:
            spin = turn(sign * rocker)
            flat = [pivot + spin @ (np.array([x, 0.0]) - pivot) for x in c.wheel_x]
        if c.suspension == "rocker-bogie":
            moved = pivot + spin @ (joint - pivot)
            on_bogie = (0, 1) if c.bogie_wheels == "front" else (1, 2)
            for k in on_bogie:
                arm = np.array([c.wheel_x[k], 0.0]) - joint
                flat[k] = moved + turn(bogies[side]) @ arm
        y = sign * rover.track / 2
        out += [np.array([p[0], y, p[1]]) for p in flat]
    return out


def settle(wheel: np.ndarray, cell: float, rover, pose) -> dict[str, float]:
    """Attitude of a rover whose every wheel is as high as the map of wheel centres says.

    Four wheels on a rigid board are the exception: three carry it, and none may be in the ground.
    """
    x, y, yaw = pose
    kind = rover.chassis.suspension
    count = {"averaging": 4, "rocker-bogie": 6}[kind]

    def residual(q: np.ndarray) -> np.ndarray:
        z, pitch, roll, rocker, left, right = [*q, 0.0, 0.0][:6]
        spin = rotation(pitch, roll, yaw)
        gaps = []
        for point in wheels(rover, rocker, (left, right)):
            at = np.array([x, y, z]) + spin @ point
            gaps.append(at[2] - bilinear(wheel, cell, at[0], at[1]))
        return np.array(gaps)

    q = np.zeros(count)
    q[0] = bilinear(wheel, cell, x, y)
    for _ in range(60):
        now, slope = residual(q), np.empty((count, count))
        for k in range(count):
            step = np.zeros(count)
            step[k] = 1e-7
            slope[:, k] = (residual(q + step) - residual(q - step)) / 2e-7
        move = np.linalg.solve(slope, now)
        q = q - move * min(1.0, 0.2 / max(np.abs(move).max(), 1e-300))
        if np.abs(move).max() < 1e-11:
            break
    names = ("z", "pitch", "roll", "rocker", "bogie_left", "bogie_right")
    return dict(zip(names, [*q, 0.0, 0.0], strict=False)) | {
        "gap": float(np.abs(residual(q)).max())
    }


def clearance(ground: np.ndarray, cell: float, rover, pose, settled) -> float:
    """Least distance of posts, and of nine points, from the belly's plane."""
    c = rover.chassis
    spin = rotation(settled["pitch"], settled["roll"], pose[2])
    origin = np.array([pose[0], pose[1], settled["z"]])
    up = rover.clearance - rover.wheel_radius
    mid, half = c.belly_x, (c.belly_length / 2, c.belly_width / 2)
    gaps = []
    for i in (-1, 0, 1):
        for j in (-1, 0, 1):
            at = origin + spin @ np.array([mid + i * half[0], j * half[1], up])
            gaps.append(at[2] - bilinear(ground, cell, at[0], at[1]))
    normal = spin[:, 2]
    for i, j in np.ndindex(ground.shape):
        px, py = (j + 0.5) * cell, (i + 0.5) * cell
        base = origin + up * normal
        top = base[2] - (normal[0] * (px - base[0]) + normal[1] * (py - base[1])) / normal[2]
        body = spin.T @ (np.array([px, py, top]) - origin)
        if abs(body[0] - mid) <= half[0] and abs(body[1]) <= half[1]:
            gaps.append(top - float(ground[i, j]))
    return min(gaps) * normal[2]
