"""What one would take instead: a walk in C, MuJoCo's rays and its rover."""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np
from harness.ccode import c_function, pointer
from harness.model import Result, Stopwatch, Trial

from . import ours, task


def c_march(rovers: int) -> Trial:
    """The same eyes, beams and ground: from patch to patch in C, the same quadratic in each."""
    from rovernav.sim import _seeing

    function, setting = c_function("march"), task.FOUR
    drive, state, seen = ours.first_look(ours.fleet(rovers, setting))
    ground = _seeing.seen(drive.worlds)
    looks = ours.looks_of(drive, state, ground, setting)
    ways = np.ascontiguousarray(looks.ways)
    n, mean = len(seen), np.zeros(1)

    def trial(repeats: int) -> Result:
        watch = Stopwatch()
        for _ in range(repeats):
            mean[0] = 0.0
            with watch:
                function(
                    pointer(looks.eye), pointer(looks.axes), ctypes.c_long(n), pointer(ways),
                    ctypes.c_long(task.BEAMS), pointer(ground.heights), ctypes.c_long(task.SIDE),
                    ctypes.c_double(setting.cell), ctypes.c_double(task.REACH * setting.cell),
                    pointer(mean),
                )  # fmt: skip
        got = float(mean[0] / setting.cell)
        return watch.result(repeats * n, got)._replace(note="beams alone, nothing moves")

    return trial


def mujoco(_rovers: int) -> Trial:
    """The beams alone: `mj_multiRay` over the same heights as a height field."""
    import mujoco as mj

    from rovernav.sim import _seeing

    setting = task.FOUR
    drive, state, _ = ours.first_look(ours.fleet(64, setting))
    ground = _seeing.seen(drive.worlds)
    looks = ours.looks_of(drive, state, ground, setting)
    height = ground.heights[0].astype(float)
    low, rise = height.min(), np.ptp(height)
    half = 0.5 * setting.cell * (task.SIDE - 1)
    model = mj.MjModel.from_xml_string(
        f"<mujoco><asset><hfield name='g' nrow='{task.SIDE}' ncol='{task.SIDE}' "
        f"size='{half} {half} {rise} 1'/></asset><worldbody><geom type='hfield' hfield='g'/>"
        "</worldbody></mujoco>"
    )
    model.hfield_data[:] = ((height - low) / rise).ravel()
    data = mj.MjData(model)
    mj.mj_forward(model, data)
    got, far = np.zeros(task.BEAMS, np.int32), np.zeros(task.BEAMS)
    middle = np.array([0.5 * setting.cell * task.SIDE, 0.5 * setting.cell * task.SIDE, low])
    eyes = looks.eye - middle
    ways = np.einsum("ab,nac->nbc", looks.ways, looks.axes)
    reach = task.REACH * setting.cell

    def trial(repeats: int) -> Result:
        watch, total = Stopwatch(), 0.0
        with watch:
            for k in range(repeats):
                m = k % len(eyes)
                mj.mj_multiRay(
                    model, data, eyes[m], ways[m].ravel(), None, 1, -1, got, far, None,
                    task.BEAMS, reach,
                )  # fmt: skip
                total += float(np.where(far < 0.0, reach, np.minimum(far, reach)).mean())
        note = f"beams alone; mean reading {total / repeats / setting.cell:.1f} cells of 64 rovers"
        return watch.result(repeats, float("nan"))._replace(note=note)

    return trial


def mujoco_body(_rovers: int) -> Trial:
    """One rover with six wheels on a rocker-bogie that drives over the same ground, no beams."""
    from rovernav.adapters import Physics
    from rovernav.core import Frame
    from rovernav.rover import read_rover
    from rovernav.terrain import Terrain

    setting = task.SIX
    terrain: Any = Terrain(
        frame=Frame(cell=setting.cell, shape=(task.SIDE, task.SIDE)), height=task.heights(setting),
        offset=0.0, name="ground", source="made",
    )  # fmt: skip
    rover = read_rover(setting.rover)
    physics = Physics(terrain, rover)
    start = ours.fleet(16, setting, beams=False).mission.start[0]
    twist = np.tile([rover.speed, 0.0], (1, task.STEPS, 1))

    def trial(repeats: int) -> Result:
        watch = Stopwatch()
        with watch:
            for _ in range(repeats):
                physics.drive(start[None], twist, period=task.PERIOD)
        result = watch.result(repeats * task.STEPS, float("nan"))
        return result._replace(note="body alone, rigid contacts instead of soil")

    return trial
