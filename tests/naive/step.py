"""A whole step of one rover with a body, slowly: who reads it sees what the simulation does.

Nothing is shared with the kernels but the layers of ground that the wheels stand on and the table
of slip, which have twins of their own. Steering is found by halving what is asked until every wheel
can do it, attitude by Newton's method, what is met by many small steps with shapely.

Every decision notes how near to the other answer it was (`Near`), so that a comparison can leave
out what rounding decides.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
from shapely import affinity
from shapely.geometry import MultiPoint, Point, box

from tests.naive import body, settle

WAYS = 24
"""Small steps in which a part's way is looked at for things that are met."""
NODES = np.linspace(-1.0, 1.0, 129)


@dataclasses.dataclass
class Row:
    """One rover's state."""

    pose: list[float]
    twist: list[float]
    attitude: list[float]
    slip: list[float]
    stall: list[float]
    time: float
    odometry: float
    energy: float
    outcome: str = "driving"


@dataclasses.dataclass
class Near:
    """How near decisions were to the other answer, least of all, each in its own unit."""

    angle: float = math.inf
    length: float = math.inf
    share: float = math.inf

    def clear(self, *, angle: float, length: float, share: float) -> bool:
        return self.angle > angle and self.length > length and self.share > share


@dataclasses.dataclass
class Place:
    """One world: ground as the wheels take it, what blocks, edge, goal, limits; slip; the step."""

    wheel: Any
    below: Any
    step: Any
    cell: float
    offset: float
    boxes: Any
    rocks: Any
    bounds: Any
    goal: Any
    radius: float
    limit: float
    table: Any
    period: float = 0.5
    parts: int = 2


def steered(rover, told):
    """The nearest twist to the commanded one that steering and motors can do."""
    kind, (u, v, w) = rover.steering.kind, told
    top = rover.speed
    if kind == "two-axis":
        return [min(max(u, -top), top), min(max(v, -top), top), 0.0]
    w = min(max(w, -rover.turn_rate), rover.turn_rate)
    if kind == "crab":
        shrink = min(1.0, top / max(math.hypot(u, v), 1e-300))
        u, v = u * shrink, v * shrink
        share = _largest(lambda s: _follows(rover, (u, s * v, s * w)))
        v, w = share * v, share * w
    else:
        u, v = min(max(u, -top), top), 0.0
    if kind == "ackermann":
        x = rover.chassis.wheel_x
        axle = x[1] if len(x) == 3 else x[-1]
        if not body.can(rover, (u, -w * axle, w)):
            w *= _largest(lambda s: body.can(rover, (u, -s * w * axle, s * w)))
        v = -w * axle
    fastest = max(body.rolling(rover, (u, v, w)))
    limit = rover.steering.wheel_speed or math.inf
    slow = min(1.0, limit / fastest) if fastest > 0 else 1.0
    return [u * slow, v * slow, w * slow]


def _follows(rover, twist):
    """Whether all wheels can roll so, and none of them backwards while the rover goes forward."""
    if math.isclose(rover.steering.max_steer, math.pi / 2):
        return True
    with_it = all(twist[0] * body.velocity(twist, x, y)[0] >= 0.0 for x, y, _ in body.wheels(rover))
    return with_it and body.can(rover, twist)


def _largest(possible):
    """The largest share from 0 to 1 up to which all is possible, by halving."""
    if possible(1.0):
        return 1.0
    low, high = 0.0, 1.0
    for _ in range(60):
        mid = 0.5 * (low + high)
        low, high = (mid, high) if possible(mid) else (low, mid)
    return low


def responded(old, target, limit, lag, seconds):
    """A speed that follows its target: at the end of a part, and its mean over it."""
    fade = math.exp(-seconds / lag) if lag else 0.0
    new = target + (old - target) * fade
    if limit and abs(new - old) > limit * seconds:
        new = old + math.copysign(limit * seconds, new - old)
        return new, 0.5 * (old + new)
    mean = target + (old - target) * (lag / seconds * (1.0 - fade) if lag else 0.0)
    return new, mean


def drive(rover, table, row, wanted, factor, seconds):
    """Turn the wheels for one part; the way over the map in body axes and the turn."""
    s = rover.steering
    limits = (s.acceleration, s.acceleration, s.turn_acceleration)
    both = [
        responded(old, to, limit, s.lag, seconds)
        for old, to, limit in zip(row.twist, wanted, limits, strict=True)
    ]
    twist, mean = [list(x) for x in zip(*both, strict=True)]
    if s.kind == "ackermann":
        x = rover.chassis.wheel_x
        axle = x[1] if len(x) == 3 else x[-1]
        twist[1], mean[1] = -twist[2] * axle, -mean[2] * axle
    slip = side = 0.0
    if table is not None:
        ahead = math.tan(row.attitude[1])
        left = math.tan(row.attitude[2]) * math.hypot(1.0, ahead)
        way = math.atan2(mean[1], mean[0]) if math.hypot(mean[0], mean[1]) else None
        along = across = 0.0
        if way is not None:
            along = ahead * math.cos(way) + left * math.sin(way)
            across = left * math.cos(way) - ahead * math.sin(way)
        lean = across / math.hypot(1.0, along)
        slip = min(1.0, float(np.interp(along, NODES, table[1])) * factor[0])
        side = float(np.interp(lean, NODES, table[2])) * factor[1]
        m, pitch = rover.mobility, math.atan(along)
        load = math.sin(pitch) + table[0] * math.cos(pitch)
        pull = max(0.0, m.mass * m.gravity * load) / m.efficiency
        rim = float(np.mean(body.rolling(rover, mean)))
        if m.drive_power and pull * rim > m.drive_power:
            slow = m.drive_power / (pull * rim)
            twist, mean = [slow * x for x in twist], [slow * x for x in mean]
            rim *= slow
        row.energy += seconds * (pull * rim + m.idle_power)
    row.twist, row.slip = twist, [slip, -side]
    row.stall[0] += seconds * math.hypot(wanted[0], wanted[1])
    row.stall[1] += seconds * (1.0 - slip) * math.hypot(mean[0], mean[1])
    ground = body.over_the_map(row.attitude, mean, slip, side)
    return float(ground[0]) * seconds, float(ground[1]) * seconds, mean[2] * (1 - slip) * seconds


def along(pose, way, share):
    """The pose after a share of an arc with constant speeds in body axes."""
    forward, left, turn = (share * x for x in way)
    a = pose[2]
    if abs(turn) > 1e-12:
        s, c = math.sin(turn) / turn, (1.0 - math.cos(turn)) / turn
    else:
        s, c = 1.0, 0.5 * turn
    x, y = forward * s - left * c, forward * c + left * s
    return [
        pose[0] + x * math.cos(a) - y * math.sin(a),
        pose[1] + x * math.sin(a) + y * math.cos(a),
        a + turn,
    ]


def _at(shape, pose):
    return affinity.translate(
        affinity.rotate(shape, pose[2], (0, 0), use_radians=True), pose[0], pose[1]
    )


def _blocks(rover, place):
    """Pairs of what blocks and the part of the rover that it blocks."""
    long, wide = 0.5 * rover.length, 0.5 * rover.width
    whole = box(-long, -wide, long, wide)
    out = [(box(*b), whole) for b in place.boxes]
    for x, y, r, high in place.rocks:
        disc = Point(x, y).buffer(r, 256)
        on_wheels, on_belly = high > rover.max_step, high > rover.clearance
        if on_wheels and on_belly:
            out.append((disc, whole))
        elif on_wheels:
            inner = max(0.0, rover.track / 2 - rover.chassis.wheel_width / 2)
            outer = rover.track / 2 + rover.chassis.wheel_width / 2
            out.append((disc, box(-long, inner, long, outer)))
            out.append((disc, box(-long, -outer, long, -inner)))
        elif on_belly:
            c = rover.chassis
            half = c.belly_length / 2
            belly = box(c.belly_x - half, -c.belly_width / 2, c.belly_x + half, c.belly_width / 2)
            out.append((disc, belly))
    return out


def met(rover, place, pose, way, near):
    """The share of a way after which the rover meets something, or None."""
    blocks = _blocks(rover, place)
    ends = MultiPoint([pose[:2], along(pose, way, 1.0)[:2]]).buffer(rover.radius + 0.1, 4)
    blocks = [(thing, part) for thing, part in blocks if thing.intersects(ends)]

    def gap(share):
        at = along(pose, way, share)
        return min((_at(part, at).distance(thing) for thing, part in blocks), default=math.inf)

    before = 0.0
    for k in range(WAYS + 1):
        share = k / WAYS
        now = gap(share)
        if now <= 0.0:
            low, high = before, share
            for _ in range(40):
                mid = 0.5 * (low + high)
                low, high = (low, mid) if gap(mid) <= 0.0 else (mid, high)
            return low
        near.length = min(near.length, now)
        before = share
    return None


def stand(rover, place, row, near):
    """Set the rover onto its ground; how that ends it."""
    here = row.pose
    try:
        found = settle.settle(place.wheel, place.cell, rover, here)
    except np.linalg.LinAlgError:
        found = {"z": math.nan}
    h, w = place.wheel.shape
    edge = [w * place.cell, h * place.cell]
    points = settle.wheels(rover, 0.0, (0.0, 0.0))
    if math.isfinite(found["z"]) and found["gap"] < 1e-6:
        spin = settle.rotation(found["pitch"], found["roll"], here[2])
        arms = settle.wheels(rover, found["rocker"], (found["bogie_left"], found["bogie_right"]))
        points = [np.array([*here[:2], found["z"]]) + spin @ arm for arm in arms]
        inside = all(0 <= p[0] <= edge[0] and 0 <= p[1] <= edge[1] for p in points)
        clearance = _clearance(place, rover, here, found)
        ledge = max(_ledge(place, p) for p in points) if inside else math.nan
    else:
        inside, clearance, ledge = False, math.nan, math.nan
    near.length = min(
        [near.length, *(abs(p[k] - e) for p in points for k in (0, 1) for e in (0.0, edge[k]))]
    )
    if not inside or math.isnan(clearance) or math.isnan(ledge):
        corners = np.array(body.footprint(rover, here).exterior.coords)
        over = ((corners >= 0) & (corners <= edge)).all()
        return ("collided" if over else "left_map"), math.nan
    row.attitude = [found["z"] + place.offset, found["pitch"], found["roll"]]
    tilt = math.acos(min(1.0, math.cos(found["pitch"]) * math.cos(found["roll"])))
    near.angle = min(near.angle, abs(tilt - rover.chassis.static_tilt))
    near.length = min(near.length, abs(clearance), abs(ledge - rover.max_step))
    if tilt > rover.chassis.static_tilt:
        return "tipped", ledge
    return ("high_centred" if clearance <= 0.0 else "driving"), ledge


def _clearance(place, rover, pose, found):
    """`settle.clearance` with only the posts about the rover."""
    reach, c = rover.radius + rover.chassis.belly_length + 4 * place.cell, place.cell
    h, w = place.below.shape
    i0, j0 = (max(0, int((pose[k] - reach) / c)) for k in (1, 0))
    i1, j1 = min(h, int((pose[1] + reach) / c)), min(w, int((pose[0] + reach) / c))
    part = place.below[i0:i1, j0:j1]
    if min(part.shape) < 2:
        return math.nan
    there = (pose[0] - j0 * c, pose[1] - i0 * c, pose[2])
    return settle.clearance(part, c, rover, there, found)


def _ledge(place, p):
    """The highest step at the four posts about a wheel."""
    h, w = place.step.shape
    j, i = math.floor(p[0] / place.cell - 0.5), math.floor(p[1] / place.cell - 0.5)
    return max(
        float(place.step[min(max(i + a, 0), h - 1), min(max(j + b, 0), w - 1)])
        for a in (0, 1) for b in (0, 1)
    )  # fmt: skip


def climbs(rover, place, old, new, ledge, near):
    """Whether a wheel went up a ledge that is higher than it climbs."""
    if not ledge > rover.max_step:
        return False
    out = False
    for x, y, _ in body.wheels(rover):
        a, b = (
            (p[0] + x * math.cos(p[2]) - y * math.sin(p[2]),
             p[1] + x * math.sin(p[2]) + y * math.cos(p[2]))
            for p in (old, new)
        )  # fmt: skip
        rise = settle.bilinear(place.wheel, place.cell, *b) - settle.bilinear(
            place.wheel, place.cell, *a
        )
        limit = min(math.dist(a, b), rover.max_step)
        near.length = min(near.length, abs(rise - limit) + (0.0 if limit > 0 else 1.0))
        out = out or (rise > limit and rise > 0.0)
    return out


def step(rover, place, row, told, factor):
    """One period of one rover, in place; how near its decisions were."""
    near, ended, parts = Near(), "driving", place.parts
    row.time += place.period
    wanted = steered(rover, told)
    for _ in range(parts):
        way = drive(rover, place.table, row, wanted, factor, place.period / parts)
        old, ended = list(row.pose), "driving"
        share = met(rover, place, old, way, near)
        new = along(old, way, 1.0 if share is None else share)
        row.pose = [new[0], new[1], math.atan2(math.sin(new[2]), math.cos(new[2]))]
        row.odometry += math.dist(old[:2], new[:2])
        stands, ledge = stand(rover, place, row, near)
        if share is not None:
            ended = "collided"
        elif stands != "driving":
            ended = stands
        elif climbs(rover, place, old, row.pose, ledge, near):
            ended = "collided"
        if ended == "driving":
            ended = _stuck(rover, row, near)
        x0, y0, x1, y1 = place.bounds
        outside = not (x0 <= row.pose[0] <= x1 and y0 <= row.pose[1] <= y1)
        if ended != "driving" or outside:
            break
    _ends(place, row, ended, outside, near)
    return near


def _stuck(rover, row, near):
    """Stuck is who made less than a twentieth of a way of two wheel bases."""
    due = 2.0 * rover.chassis.wheelbase
    near.share = min(near.share, abs(row.stall[0] - due))
    if row.stall[0] < due:
        return "driving"
    near.share = min(near.share, abs(row.stall[1] / row.stall[0] - 0.05))
    if row.stall[1] < 0.05 * row.stall[0]:
        return "stuck"
    row.stall = [0.0, 0.0]
    return "driving"


def _ends(place, row, ended, outside, near):
    x, y = row.pose[:2]
    near.length = min(
        near.length, *(abs(a - b) for a, b in zip((x, y) * 2, place.bounds, strict=True))
    )
    if ended != "collided" and outside:
        ended = "left_map"
    gap = math.dist((x, y), place.goal)
    near.length = min(near.length, abs(gap - place.radius))
    if ended in ("driving", "stuck") and gap <= place.radius:
        ended = "reached"
    if ended == "driving" and row.time >= place.limit - 1e-9:
        ended = "timed_out"
    row.outcome = ended
    if ended != "driving":
        row.twist = [0.0, 0.0, 0.0]
