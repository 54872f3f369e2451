"""A rover with a body, one at a time and in small steps: wheels, slip, energy, what it touches."""

from __future__ import annotations

import math

import numpy as np
from shapely import affinity
from shapely.geometry import Polygon, box

from tests.naive import settle as standing
from tests.naive import traction


def wheels(rover):
    """Where each wheel touches and whether it is steered."""
    c, half = rover.chassis, 0.5 * rover.track
    axle = c.wheel_x[1] if len(c.wheel_x) == 3 else c.wheel_x[-1]
    kind = rover.steering.kind
    return [
        (x, y, kind == "crab" or (kind == "ackermann" and x != axle))
        for x in c.wheel_x for y in (half, -half)
    ]  # fmt: skip


def velocity(twist, x, y):
    return np.array([twist[0] - twist[2] * y, twist[1] + twist[2] * x])


def can(rover, twist):
    """Whether each wheel can roll the way it moves: a fixed one forward, a steered one in reach."""
    if rover.steering.kind == "skid":
        return twist[1] == 0.0
    for x, y, steered in wheels(rover):
        u, v = velocity(twist, x, y)
        angle = abs(math.atan2(v, u))
        angle = min(angle, math.pi - angle)
        if math.hypot(u, v) > 1e-12 and angle > (rover.steering.max_steer if steered else 0) + 1e-9:
            return False
    return True


def rolling(rover, twist):
    """Speed of each wheel's rim [m/s]."""
    out = []
    for x, y, _ in wheels(rover):
        u, v = velocity(twist, x, y)
        out.append(abs(u) if rover.steering.kind == "skid" else math.hypot(u, v))
    return out


def follow(old, target, limit, lag, seconds, count=20_000):
    """A speed that follows a target, by Euler's rule; its end and its mean."""
    now, total, dt = old, 0.0, seconds / count
    for _ in range(count):
        rate = (target - now) / lag
        now += max(-limit, min(limit, rate)) * dt if limit else rate * dt
        total += now * dt
    return now, total / seconds


def costs(rover, soil, attitude, twist, factor):
    """Slip, side slip and power [W] for wheels that turn so, on a body that stands so."""
    ahead = math.tan(attitude[1])
    left = math.tan(attitude[2]) * math.hypot(1.0, ahead)
    way = math.atan2(twist[1], twist[0])
    slip, side, *_ = traction.cost(ahead, left, way, rover, soil)
    slip, side = min(1.0, slip * factor[0]), side * factor[1]
    m, pitch = rover.mobility, math.atan(ahead * math.cos(way) + left * math.sin(way))
    pull = m.mass * m.gravity * (math.sin(pitch) + soil.rolling_resistance * math.cos(pitch))
    mean = float(np.mean(rolling(rover, twist)))
    return slip, side, max(0.0, pull) / m.efficiency * mean + m.idle_power


def over_the_map(attitude, twist, slip, side):
    """Speed over the map, in body axes, of wheels that turn so: what is lost, and slid downhill."""
    ahead = math.tan(attitude[1])
    left = math.tan(attitude[2]) * math.hypot(1.0, ahead)
    u, v = twist[0], twist[1]
    along = np.array([u, v, ahead * u + left * v])
    if not along.any():
        return along[:2]
    along *= math.hypot(u, v) / np.linalg.norm(along)  # wheels turn along the ground
    up = np.array([-ahead, -left, 1.0])
    aside = np.cross(up / np.linalg.norm(up), along)
    return ((1.0 - slip) * along - side * aside)[:2]


def moved(pose, twist, slip, ground_speed, seconds, count=2000):
    """The pose after driving so, by the midpoint rule."""
    x, y, a = pose
    dt, turn = seconds / count, twist[2] * (1.0 - slip)
    for _ in range(count):
        mid = a + 0.5 * turn * dt
        x += (ground_speed[0] * math.cos(mid) - ground_speed[1] * math.sin(mid)) * dt
        y += (ground_speed[0] * math.sin(mid) + ground_speed[1] * math.cos(mid)) * dt
        a += turn * dt
    return x, y, math.atan2(math.sin(a), math.cos(a))


def stand(wheel, cell, rover, pose):
    """Height, pitch and roll."""
    found = standing.settle(wheel, cell, rover, pose)
    return found["z"], found["pitch"], found["roll"]


def footprint(rover, pose) -> Polygon:
    long, wide = 0.5 * rover.length, 0.5 * rover.width
    turned = affinity.rotate(box(-long, -wide, long, wide), pose[2], (0, 0), use_radians=True)
    return affinity.translate(turned, pose[0], pose[1])
