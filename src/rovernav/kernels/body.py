"""One step of rovers with bodies: steering, slip, energy, what they touch, how they stand, ends.

All of a step in one kernel, rover by rover in a fixed order, so that a row does not depend on the
batch. A step is cut into parts; in each the wheels' twist is constant, and at its end the body is
settled on the ground. Definitions: docs/derivations.md.

Symbols: (u, v, w) body twist of the wheels; p, q rise along and to the left of the way for each
metre of map; s slip, y side slip (positive to the right); F/e pull [N]; T a part's length [s].
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from . import footprint as fp
from . import settle as st
from . import standing as under
from . import traction as tr
from . import wheels as wh
from ._jit import kernel
from .contact import BodyArrays, GroundArrays, first_touch
from .drive import WorldArrays, first_contact
from .geometry import MISS
from .surface import height_at

DRIVING, REACHED, COLLIDED, TIPPED, HIGH_CENTRED, STUCK, LEFT_MAP, TIMED_OUT = range(8)
"""As `core.Outcome`."""
LATE = 1e-9
"""Seconds by which a time limit may be missed through rounding [s]."""


class Rows(NamedTuple):
    """The state of n rovers as arrays, as `core.RoverState` has them."""

    time: Any
    pose: Any
    twist: Any
    odometry: Any
    outcome: Any
    attitude: Any
    slip: Any
    energy: Any
    stall: Any


class Ends(NamedTuple):
    """Goals (n, 2), edge of each world (w, 4) [m], goal radius [m] and time limit [s]."""

    goal: Any
    bounds: Any
    radius: float
    limit: float


@kernel(inline=True, bare=True)
def _settled(
    k: int, of: int, body: BodyArrays, ground: GroundArrays, after: Rows, room: Any
) -> int:
    """Set rover k onto its ground; writes its attitude and returns how that ends it."""
    n, chassis = body.numbers, body.chassis
    layer = of if ground.wheel.shape[0] > 1 else 0
    pose, row = after.pose[k], room[2]
    at, h = room[0], room[1]
    turns = st.settle_one(
        ground.wheel[layer], ground.gradient[layer], ground.cell, chassis, pose, (at, h), row
    )
    if row[st.CODE] != st.NO_GROUND:
        below, step = ground.ground[layer], ground.step[layer]
        row[st.CLEARANCE] = under.clearance_of(below, ground.cell, chassis, pose, turns, row[st.Z])
        row[st.STEP] = under.step_under(step, ground.cell, chassis, pose, at, turns)
    missing = row[st.CODE] == st.NO_GROUND or row[st.CLEARANCE] != row[st.CLEARANCE]
    if missing or row[st.STEP] != row[st.STEP]:
        return COLLIDED if _over(ground.wheel[layer], ground.cell, pose, n) else LEFT_MAP
    after.attitude[k, 0] = row[st.Z] + ground.offset
    after.attitude[k, 1], after.attitude[k, 2] = row[st.PITCH], row[st.ROLL]
    if row[st.TILT] > n[wh.TIP]:
        return TIPPED
    return HIGH_CENTRED if row[st.CLEARANCE] <= chassis[st.LEAST_CLEARANCE] else DRIVING


@kernel(bare=True)
def _over(grid: Any, c: float, pose: Any, n: Any) -> bool:
    """Whether the whole footprint lies over the grid, holes or not."""
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    rows, columns = grid.shape
    for corner in range(4):
        x = n[wh.FRONT] if corner < 2 else n[wh.REAR]
        y = n[wh.HALF_WIDTH] * (1.0 - 2.0 * (corner % 2))
        px, py = pose[0] + cos * x - sin * y, pose[1] + sin * x + cos * y
        if not (0.0 <= px <= columns * c and 0.0 <= py <= rows * c):
            return False
    return True


@kernel(bare=True)
def _climbs_a_ledge(
    old: Any, pose: Any, of: int, body: BodyArrays, ground: GroundArrays, row: Any
) -> bool:
    """Whether a wheel went up a ledge that is higher than it climbs.

    A ledge is where `step` says so; a wheel goes up it where its centre has risen by more than the
    highest step, or more steeply than 45 degrees.
    """
    chassis = body.chassis
    if not row[st.STEP] > chassis[st.MAX_STEP]:
        return False
    layer, c = of if ground.wheel.shape[0] > 1 else 0, ground.cell
    for wheel in range(6):
        axle = wheel % 3
        x = (
            chassis[st.X_ONE]
            if axle == 0
            else (chassis[st.X_MID] if axle == 1 else chassis[st.X_END])
        )
        y = 0.5 * chassis[st.TRACK] * (1.0 if wheel < 3 else -1.0)
        ax, ay, _ = fp.along_arc(old, (x, y, 0.0), 1.0)
        bx, by, _ = fp.along_arc(pose, (x, y, 0.0), 1.0)
        rise = height_at(ground.wheel[layer], c, bx, by) - height_at(ground.wheel[layer], c, ax, ay)
        way = np.sqrt((bx - ax) * (bx - ax) + (by - ay) * (by - ay))
        if rise > min(way, chassis[st.MAX_STEP]) and rise > 0.0:
            return True
    return False


@kernel(inline=True)
def _slope(attitude: Any, u: float, v: float) -> tuple[float, float]:
    """Rise along a way (u, v) in body axes and to the left of it, for each metre of map."""
    fast = np.sqrt(u * u + v * v)
    if fast == 0.0:
        return 0.0, 0.0
    ahead = math.tan(attitude[1])
    left = math.tan(attitude[2]) * np.sqrt(1.0 + ahead * ahead)
    return (ahead * u + left * v) / fast, (left * u - ahead * v) / fast


@kernel(inline=True, bare=True)
def _drive_part(
    k: int, wanted: Any, factor: Any, body: BodyArrays, after: Rows
) -> tuple[float, float, float]:
    """Turn rover k's wheels for one part; returns its way over the map (forward, left, turn).

    Writes its twist, slip, energy and stall.
    """
    n, part, twist = body.numbers, body.numbers[wh.PART], after.twist[k]
    u, mu = wh.responded(twist[0], wanted[0], n[wh.ACCELERATION], n)
    v, mv = wh.responded(twist[1], wanted[1], n[wh.ACCELERATION], n)
    w, mw = wh.responded(twist[2], wanted[2], n[wh.TURN_ACCELERATION], n)
    if n[wh.STEERING] == wh.ACKERMANN:
        v, mv = -w * n[wh.AXLE], -mw * n[wh.AXLE]
    p, q = _slope(after.attitude[k], mu, mv)
    slip = side = 0.0
    if body.table.shape[0] > 0:
        mean, _ = wh.wheel_speeds(mu, mv, mw, n, body.chassis)
        slip, side = tr.slips(p, q, body.table, 0)
        slip, side = min(1.0, slip * factor[0]), side * factor[1]
        pull = tr.pull_of(p, body.table, 0)
        if pull * mean > body.table[0, tr.POWER]:
            slow = body.table[0, tr.POWER] / (pull * mean)
            u, v, w, mu, mv, mw = u * slow, v * slow, w * slow, mu * slow, mv * slow, mw * slow
            mean = mean * slow
        after.energy[k] += part * (pull * mean + body.table[0, tr.IDLE])
    twist[0], twist[1], twist[2] = u, v, w
    after.slip[k, 0], after.slip[k, 1] = slip, -side
    stretch = np.sqrt(1.0 + p * p)
    normal = np.sqrt(stretch * stretch + q * q)
    made, slid = (
        (1.0 - slip) / stretch + side * p * q / (normal * stretch),
        -side * stretch / normal,
    )
    after.stall[k, 0] += part * np.sqrt(wanted[0] * wanted[0] + wanted[1] * wanted[1])
    after.stall[k, 1] += part * (1.0 - slip) * np.sqrt(mu * mu + mv * mv)
    return (mu * made - mv * slid) * part, (mv * made + mu * slid) * part, mw * (1.0 - slip) * part


@kernel(inline=True, bare=True)
def _move_part(
    k: int,
    step: Any,
    of: int,
    body: BodyArrays,
    ground: GroundArrays,
    world: WorldArrays,
    after: Rows,
    room: Any,
) -> int:
    """Move rover k by a step (forward, left, turn) until it meets something; how that ends it."""
    pose, old, n = after.pose[k], room[4], body.numbers
    old[0], old[1], old[2] = pose[0], pose[1], pose[2]
    bx, by, turned = fp.along_arc(old, step, 1.0)
    ended, t = DRIVING, MISS
    if n[wh.FRONT] > n[wh.REAR]:
        t = first_touch(old, step, of, body, ground, world, room[3])
        if t <= 1.0:
            bx, by, turned = fp.along_arc(old, step, t)
    else:
        t = first_contact(k, old[0], old[1], bx, by, world)
        if t <= 1.0:
            bx, by = old[0] + t * (bx - old[0]), old[1] + t * (by - old[1])
    if t <= 1.0:
        ended = COLLIDED
    pose[0], pose[1] = bx, by
    pose[2] = math.atan2(math.sin(turned), math.cos(turned)) if step[2] != 0.0 else old[2]
    after.odometry[k] += np.hypot(bx - old[0], by - old[1])
    if ground.wheel.size > 0:
        stands = _settled(k, of, body, ground, after, room)
        if ended == DRIVING:
            ended = stands
        if ended == DRIVING and _climbs_a_ledge(old, pose, of, body, ground, room[2]):
            ended = COLLIDED
    return ended


@kernel(inline=True)
def _outside(pose: Any, edge: Any) -> bool:
    return not (edge[0] <= pose[0] <= edge[2] and edge[1] <= pose[1] <= edge[3])


@kernel(inline=True, bare=True)
def _end(k: int, ended: int, of: int, ends: Ends, after: Rows) -> None:
    """Write how rover k ends: what stopped it, the map's edge, the goal, being stuck, time."""
    pose = after.pose[k]
    if ended != COLLIDED and _outside(pose, ends.bounds[of]):
        ended = LEFT_MAP
    if ended in (DRIVING, STUCK):
        gap = np.hypot(ends.goal[k, 0] - pose[0], ends.goal[k, 1] - pose[1])
        if gap <= ends.radius:
            ended = REACHED
    if ended == DRIVING and after.time[k] >= ends.limit - LATE:
        ended = TIMED_OUT
    after.outcome[k] = ended
    if ended != DRIVING:
        after.twist[k, 0], after.twist[k, 1], after.twist[k, 2] = 0.0, 0.0, 0.0


@kernel(inline=True)
def _stuck(stall: Any, n: Any) -> bool:
    """Whether a rover made too little of its commanded way; begins anew where it did not."""
    if not stall[0] >= n[wh.STALL]:
        return False
    if stall[1] < n[wh.PATIENT] * stall[0]:
        return True
    stall[0], stall[1] = 0.0, 0.0
    return False


@kernel(inline=True, bare=True)
def _fetch(pose: Any, of: int, body: BodyArrays, ground: GroundArrays) -> None:
    """Ask for the ground that a rover will be set onto."""
    k = of if ground.wheel.shape[0] > 1 else 0
    maps = ground.wheel[k], ground.gradient[k], ground.ground[k], ground.step[k]
    under.fetch_ground(maps, ground.cell, body.chassis, pose)


@kernel()
def _rooms() -> Any:
    return (
        np.empty((6, 3)), np.empty(6), np.zeros(st.SETTLED), np.empty((24, 2)), np.empty(3),
        np.empty(3),
    )  # fmt: skip


@kernel()
def move(
    command: Any,
    factor: Any,
    after: Rows,
    ends: Ends,
    body: BodyArrays,
    ground: GroundArrays,
    world: WorldArrays,
    placing: bool,
) -> None:
    """Move each rover that drives for one period, in place.

    Args:
        command: Body twists (n, 3).
        factor: What slip and side slip of each rover are multiplied by (n, 2).
        after: The states, changed; those of rovers that have ended stay as they are.
        ends: Goals, edges and limits.
        body: The rover.
        ground: Ground and rocks.
        world: Obstacles.
        placing: Only set the rovers down where they are: attitude, and who has ended already.
    """
    _move_all(command, factor, after, ends, body, ground, world, (_rooms(), placing))


@kernel(bare=True)
def _move_all(
    command: Any,
    factor: Any,
    after: Rows,
    ends: Ends,
    body: BodyArrays,
    ground: GroundArrays,
    world: WorldArrays,
    more: Any,
) -> None:
    """`move` with its room."""
    room, placing = more
    n = body.numbers
    parts, wanted = 1 if placing else int(n[wh.PARTS]), room[5]
    for k in range(len(command)):
        if k + 1 < len(command) and ground.wheel.size > 0:
            _fetch(after.pose[k + 1], world.of[k + 1], body, ground)
        if after.outcome[k] != DRIVING:
            continue
        of, ended = world.of[k], DRIVING
        u, v, w = command[k, 0], command[k, 1], command[k, 2]
        after.time[k] += 0.0 if placing else n[wh.PERIOD]
        if not abs(u) + abs(v) + abs(w) < np.inf:
            after.outcome[k] = LEFT_MAP
            after.twist[k, 0], after.twist[k, 1], after.twist[k, 2] = 0.0, 0.0, 0.0
            continue
        wanted[0], wanted[1], wanted[2] = wh.allowed(u, v, w, n, body.chassis)
        for _ in range(parts):
            step = (0.0, 0.0, 0.0)
            if not placing:
                step = _drive_part(k, wanted, factor[k], body, after)
            ended = _move_part(k, step, of, body, ground, world, after, room)
            if ended == DRIVING and _stuck(after.stall[k], n):
                ended = STUCK
            if ended != DRIVING or _outside(after.pose[k], ends.bounds[of]):
                break
        _end(k, ended, of, ends, after)
