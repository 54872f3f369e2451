"""What driving costs, from the soil's own curves and trigonometry, one slope at a time."""

from __future__ import annotations

import math

import numpy as np


def cost(p, q, heading, rover, soil):
    """Slip, side slip, speed [m/s], power [W], energy and time per metre of map."""
    along = p * math.cos(heading) + q * math.sin(heading)
    across = q * math.cos(heading) - p * math.sin(heading)
    pitch = math.atan(along)
    forward = np.array([1.0, 0.0, along])
    left = np.cross([-along, -across, 1.0], forward)
    roll = math.asin(left[2] / np.linalg.norm(left))  # of the left axis against level
    slip = float(np.interp(max(pitch, 0.0), soil.slope, soil.slip))
    lean = math.atan(across / math.sqrt(1 + along**2))
    side = math.copysign(float(np.interp(abs(lean), soil.slope, soil.side_slip)), lean)
    m = rover.mobility
    pull = m.mass * m.gravity * (math.sin(pitch) + soil.rolling_resistance * math.cos(pitch))
    drive = max(0.0, pull) / m.efficiency
    wheels = rover.speed
    if m.drive_power and drive * wheels > m.drive_power:
        wheels = m.drive_power / drive
    if slip >= 1.0 or (1 - slip) ** 2 <= side**2:
        return slip, side, 0.0, math.nan, math.inf, math.inf, pitch, roll
    speed = wheels * math.sqrt((1 - slip) ** 2 - side**2)
    power = drive * wheels + m.idle_power
    ground = 1.0 / math.cos(pitch)
    return slip, side, speed, power, power / speed * ground, ground / speed, pitch, roll
