"""What one would take instead: a walk in C, ir-sim, navground, MuJoCo."""

from __future__ import annotations

import ctypes
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from harness.ccode import c_function, pointer
from harness.model import Result, Stopwatch, Trial

from . import task


def c_walk(rovers: int) -> Trial:
    """The same rovers, grid, beams and motion; the plain walk from cell to cell."""
    function, grid, angles = c_function("walk"), task.grid(), task.angles()
    start, mean = task.starts(grid, rovers), np.zeros(1)
    numbers = (task.REACH, task.SPEED, task.TURN, task.PERIOD)

    def trial(repeats: int) -> Result:
        watch = Stopwatch()
        for _ in range(repeats):
            pose, mean[0] = start.copy(), 0.0
            with watch:
                function(
                    pointer(pose), ctypes.c_long(rovers), pointer(angles),
                    ctypes.c_long(task.BEAMS), pointer(grid), ctypes.c_long(task.SIDE),
                    ctypes.c_long(task.STEPS), *map(ctypes.c_double, numbers), pointer(mean),
                )  # fmt: skip
        return watch.result(repeats * task.STEPS * rovers, float(mean[0]))

    return trial


def ir_sim(_rovers: int) -> Trial:
    """One rover with its lidar of 64 beams among the discs; pictures off."""
    import irsim
    import yaml

    x, y, heading = task.starts(task.grid(), 1)[0].tolist()
    lidar = {
        "name": "lidar2d", "range_min": 0, "range_max": task.REACH, "number": task.BEAMS,
        "angle_range": task.VIEW,
    }  # fmt: skip
    robot = {
        "kinematics": {"name": "diff"}, "shape": {"name": "circle", "radius": 0.2},
        "state": [x, y, heading], "goal": [1.0, 1.0, 0.0], "vel_max": [2, 2], "vel_min": [-2, -2],
        "sensors": [lidar],
    }  # fmt: skip
    obstacles = [
        {"shape": {"name": "circle", "radius": r}, "state": [px, py, 0.0]}
        for px, py, r in task.discs().tolist()
        if np.hypot(px - x, py - y) > r + 1.0
    ]
    frame = {"height": task.SIDE, "width": task.SIDE, "step_time": task.PERIOD}
    frame["collision_mode"] = "unobstructed"
    path = Path(tempfile.mkdtemp()) / "world.yaml"
    path.write_text(yaml.safe_dump({"world": frame, "robot": [robot], "obstacle": obstacles}))
    env = irsim.make(str(path), display=False, disable_all_plot=True, log_level="ERROR")
    action = np.array([[task.SPEED], [task.TURN]])

    def trial(repeats: int) -> Result:
        watch = Stopwatch()
        with watch:
            for _ in range(repeats):
                env.step(action)
        return watch.result(repeats, float("nan"))._replace(note="discs instead of a grid")

    return trial


def navground(rovers: int) -> Trial:
    """64 agents with a lidar of 64 beams each among the discs; scans asked for from Python."""
    from navground import core, sim

    rovers = min(rovers, 64)
    world = sim.World()
    for x, y, r in task.discs():
        world.add_obstacle(sim.Obstacle(core.Disc((x, y), r)))
    seen: list[Any] = []
    for pose in task.starts(task.grid(), rovers):
        agent = sim.Agent()
        agent.radius, agent.control_period = 0.2, task.PERIOD
        agent.kinematics = core.Kinematics.make_type("2WDiff")
        agent.kinematics.max_speed = 2.0
        agent.behavior = core.Behavior.make_type("Dummy")
        agent.pose = core.Pose2(pose[:2], pose[2])
        agent.controller.follow_velocity((task.SPEED, 0.0))
        lidar = sim.StateEstimation.make_type("Lidar")
        lidar.range, lidar.resolution = task.REACH, task.BEAMS
        lidar.field_of_view, lidar.start_angle = task.VIEW, -task.VIEW / 2
        world.add_agent(agent)
        seen.append((lidar, agent, core.SensingState()))
    world.update(task.PERIOD)
    for lidar, agent, state in seen:
        lidar.prepare(agent, world)
        lidar.prepare_state(state)

    def trial(repeats: int) -> Result:
        watch, mean = Stopwatch(), 0.0
        with watch:
            for _ in range(repeats):
                world.update(task.PERIOD)
                for lidar, agent, state in seen:
                    lidar.update(agent, world, state)
        for lidar, _, state in seen:
            mean += float(np.mean(lidar.read_ranges(state))) / len(seen)
        note = f"discs instead of a grid; mean reading {mean:.1f}"
        return watch.result(repeats * rovers, float("nan"))._replace(note=note)

    return trial


def mujoco(_rovers: int) -> Trial:
    """The beams alone: `mj_multiRay` over a height field that stands up where blocked."""
    import mujoco as mj

    half = task.SIDE / 2
    model = mj.MjModel.from_xml_string(
        f"<mujoco><asset><hfield name='g' nrow='{task.SIDE}' ncol='{task.SIDE}' "
        f"size='{half} {half} 2 0.1'/></asset><worldbody><geom type='hfield' hfield='g'/>"
        "</worldbody></mujoco>"
    )
    grid = task.grid()
    model.hfield_data[:] = grid.ravel()
    data = mj.MjData(model)
    mj.mj_forward(model, data)
    places, angles = task.starts(grid, 64), task.angles()
    got, far = np.zeros(task.BEAMS, np.int32), np.zeros(task.BEAMS)

    def trial(repeats: int) -> Result:
        watch = Stopwatch()
        with watch:
            for k in range(repeats):
                x, y, heading = places[k % len(places)]
                a = angles + heading
                ways = np.stack([np.cos(a), np.sin(a), 0.0 * a], axis=1).ravel()
                eye = np.array([x - half, y - half, 1.0])
                mj.mj_multiRay(
                    model, data, eye, ways, None, 1, -1, got, far, None, task.BEAMS, task.REACH
                )
        return watch.result(repeats, float("nan"))._replace(note="beams alone, nothing moves")

    return trial
