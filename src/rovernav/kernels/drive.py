"""One step of a drive for n rovers: goals seen from the rover, commands, motion, sight, contact.

Symbols: pose rows x [m], y [m], heading [rad]; c, s cosine and sine of the heading.
Every row is computed by itself in a fixed order, so it does not depend on the batch.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ._jit import kernel
from .geometry import MISS, first_boxes, first_cell
from .shapes import first_shapes

_NO_CORNERS, _NO_NUMBERS, _NO_ENDS = np.zeros((0, 2)), np.zeros(0), np.zeros(0, np.int64)
for _array in (_NO_CORNERS, _NO_NUMBERS, _NO_ENDS):
    _array.flags.writeable = False  # as the arrays of worlds are: one compiled kernel for all


class WorldArrays(NamedTuple):
    """Packed worlds as arrays.

    Attributes:
        boxes: All boxes (m, 4): x0, y0, x1, y1 [m].
        offsets: Box k of world i has offsets[i] <= k < offsets[i + 1] (w + 1,).
        of: World of each rover (n,).
        blocked: Grid of each world or one for all (g, h, w); (0, 0, 0) where there is none.
        cell: Its cell [m].
        corners: Corners of all rounded polygons (p, 2) [m].
        ends: Polygon i has the corners ends[i] to ends[i + 1] (m + 1,).
        radius: What each polygon is grown by (m,) [m].
        shapes: World i has the polygons shapes[i] to shapes[i + 1] (w + 1,); empty where no world
            has any.
    """

    boxes: Any
    offsets: Any
    of: Any
    blocked: Any
    cell: float
    corners: Any = _NO_CORNERS
    ends: Any = _NO_ENDS
    radius: Any = _NO_NUMBERS
    shapes: Any = _NO_ENDS


@kernel(bare=True)
def goal_in_body(pose: Any, goal: Any, out: Any) -> None:
    """The goal (n, 2) seen from each rover: forward, left [m], to out (n, 2)."""
    for k in range(pose.shape[0]):
        c, s = math.cos(pose[k, 2]), math.sin(pose[k, 2])
        dx, dy = goal[k, 0] - pose[k, 0], goal[k, 1] - pose[k, 1]
        out[k, 0] = c * dx + s * dy
        out[k, 1] = c * dy - s * dx


@kernel(bare=True)
def side_by_side(left: Any, right: Any, out: Any) -> None:
    """The first columns of two channels, to out (n, 2)."""
    for k in range(out.shape[0]):
        out[k, 0], out[k, 1] = left[k, 0], right[k, 0]


@kernel(bare=True)
def axis_speeds(
    outputs: Any, step: float, period: float, goal: Any, sight: Any, stop_at_goal: bool, out: Any
) -> None:
    """Outputs (n, 2) as body twists: `step` times the output in each `period`, to out (n, 3).

    With `stop_at_goal`, a step at least as long as the way to the goal (n, 2) ends at it where the
    sight (n, 1) is clear.
    """
    for k in range(out.shape[0]):
        forward, left = step * np.float64(outputs[k, 0]), step * np.float64(outputs[k, 1])
        x, y = goal[k, 0], goal[k, 1]
        near = x * x + y * y <= forward * forward + left * left
        if stop_at_goal and near and sight[k, 0] == 1.0:
            forward, left = x, y
        out[k, 0], out[k, 1], out[k, 2] = forward / period, left / period, 0.0


@kernel(bare=True)
def two_axis(pose: Any, twist: Any, period: float, out: Any) -> None:
    """Move each rover by its forward and left speed for one period; headings stay."""
    for k in range(pose.shape[0]):
        c, s = math.cos(pose[k, 2]), math.sin(pose[k, 2])
        dx, dy = twist[k, 0] * period, twist[k, 1] * period
        out[k, 0] = pose[k, 0] + (c * dx - s * dy)
        out[k, 1] = pose[k, 1] + (s * dx + c * dy)
        out[k, 2] = pose[k, 2]


@kernel(bare=True)
def differential(
    pose: Any, twist: Any, speed: float, turn_rate: float, period: float, out: Any, driven: Any
) -> None:
    """Move each rover along the arc of its limited speed v and turn rate w for one period.

    The chord of an arc of w T is v T sin(w T/2) / (w T/2) long and points w T/2 from the heading.

    Args:
        pose: Poses (n, 3).
        twist: Commands (n, 3); the sideways part is ignored.
        speed: Limit of |v| [m/s].
        turn_rate: Limit of |w| [rad/s].
        period: T [s].
        out: Poses after it (n, 3), headings in (-pi, pi].
        driven: Body velocities that were driven (n, 3).
    """
    for k in range(pose.shape[0]):
        v = min(max(twist[k, 0], -speed), speed)
        w = min(max(twist[k, 2], -turn_rate), turn_rate)
        half = 0.5 * w * period
        chord = v * period * (math.sin(half) / half if half != 0.0 else 1.0)
        a = pose[k, 2] + half
        out[k, 0] = pose[k, 0] + chord * math.cos(a)
        out[k, 1] = pose[k, 1] + chord * math.sin(a)
        turned = pose[k, 2] + w * period
        out[k, 2] = math.atan2(math.sin(turned), math.cos(turned))
        driven[k, 0], driven[k, 1], driven[k, 2] = v, 0.0, w


@kernel(bare=True)
def first_contact(k: int, ax: float, ay: float, bx: float, by: float, world: WorldArrays) -> float:
    """Smallest t at which rover k's segment from a to b meets its world, or MISS."""
    of = world.of[k]
    t = first_boxes(ax, ay, bx, by, world.boxes, world.offsets[of], world.offsets[of + 1])
    if world.blocked.size:
        c, layer = world.cell, of if world.blocked.shape[0] > 1 else 0
        t = min(t, first_cell(ax / c, ay / c, bx / c, by / c, world.blocked[layer]))
    if world.shapes.size:
        which = (world.shapes[of], world.shapes[of + 1])
        t = min(t, first_shapes(ax, ay, bx, by, world.corners, world.ends, world.radius, which))
    return t


class StepArrays(NamedTuple):
    """One step of n rovers: what was, what the motion made of it, and where it may end.

    Attributes:
        before: Poses before the step (n, 3).
        driving: Outcomes before the step (n,); 0 where a rover still drives.
        clock: Times before the step (n,) [s].
        way: Distances driven before the step (n,) [m].
        goal: Goals (n, 2) [m].
        bounds: Edge of each world (w, 4): x0, y0, x1, y1 [m].
        pose: Poses the motion leads to (n, 3); then where the step ends.
        twist: Body velocities (n, 3); then 0 where a rover has ended.
        time: Times after the step (n,); then those before where a rover had ended.
        length: Written: distances driven after the step (n,).
        outcome: Written: outcomes after the step (n,).
    """

    before: Any
    driving: Any
    clock: Any
    way: Any
    goal: Any
    bounds: Any
    pose: Any
    twist: Any
    time: Any
    length: Any
    outcome: Any


@kernel(bare=True)
def meet(step: StepArrays, world: WorldArrays, radius: float, limit: float, ends: Any) -> None:
    """End the step of each rover that still drives where it meets something; the others stay.

    A pose that is not finite moves nothing and has left the map.

    Args:
        step: Changed.
        world: The true worlds.
        radius: A rover this near its goal has reached it [m].
        limit: A rover that drove as long has timed out [s].
        ends: Codes of DRIVING, and of having timed out, reached the goal, left the map and
            collided; where several are true the last one counts.
    """
    for k in range(step.pose.shape[0]):
        x0, y0, a = step.before[k, 0], step.before[k, 1], step.before[k, 2]
        x, y = step.pose[k, 0], step.pose[k, 1]
        lost = not (math.isfinite(x) and math.isfinite(y) and math.isfinite(step.pose[k, 2]))
        if step.driving[k] != ends[0] or lost:
            x, y = x0, y0
            step.pose[k, 0], step.pose[k, 1], step.pose[k, 2] = x0, y0, a
        if step.driving[k] != ends[0]:
            step.time[k], step.length[k] = step.clock[k], step.way[k]
            step.outcome[k] = step.driving[k]
            step.twist[k, 0], step.twist[k, 1], step.twist[k, 2] = 0.0, 0.0, 0.0
            continue
        t = first_contact(k, x0, y0, x, y, world)
        if t <= 1.0:
            x, y = x0 + t * (x - x0), y0 + t * (y - y0)
            step.pose[k, 0], step.pose[k, 1] = x, y
        step.length[k] = step.way[k] + np.hypot(x - x0, y - y0)
        edge = step.bounds[world.of[k]]
        outside = x < edge[0] or y < edge[1] or x > edge[2] or y > edge[3]
        outcome = ends[0]
        if step.time[k] >= limit:
            outcome = ends[1]
        if np.hypot(step.goal[k, 0] - x, step.goal[k, 1] - y) <= radius:
            outcome = ends[2]
        if outside or lost:
            outcome = ends[3]
        if t <= 1.0:
            outcome = ends[4]
        step.outcome[k] = outcome
        if outcome != ends[0]:
            step.twist[k, 0], step.twist[k, 1], step.twist[k, 2] = 0.0, 0.0, 0.0


@kernel(bare=True)
def clear_sight(pose: Any, goal: Any, world: WorldArrays, out: Any) -> None:
    """1 where the straight segment from rover to goal meets nothing, else 0, to out (n, 1)."""
    for k in range(pose.shape[0]):
        t = first_contact(k, pose[k, 0], pose[k, 1], goal[k, 0], goal[k, 1], world)
        out[k, 0] = 1.0 if t == MISS else 0.0


@kernel(bare=True)
def off_line(pose: Any, start: Any, goal: Any, threshold: float, out: Any) -> None:
    """1 where a rover is more than `threshold` [m] off the line start-goal, else 0 (n, 1)."""
    for k in range(pose.shape[0]):
        dx, dy = goal[k, 0] - start[k, 0], goal[k, 1] - start[k, 1]
        length = np.hypot(dx, dy)
        across = dx * (pose[k, 1] - start[k, 1]) - dy * (pose[k, 0] - start[k, 0])
        out[k, 0] = 1.0 if abs(across) > threshold * length else 0.0
