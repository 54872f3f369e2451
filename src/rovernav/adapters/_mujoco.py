"""MuJoCo as a second opinion: the same ground, rover and commands in another's physics.

It checks how a rover stands, not how it slips: contacts have friction, but nothing sinks or shears.
"""

from __future__ import annotations

import copy
import importlib
from typing import Any, final

import numpy as np

from ..core import F64, I64, Bool, InputError, MissingExtraError, ShapeError, value
from ..rover import Rover
from ..rover._settle import checked_poses
from ..terrain import Terrain, planes_over
from ._mujoco_model import (
    BASE,
    SIDES,
    STEP,
    Steering,
    Wheels,
    heights,
    mjcf,
    steered_wheels,
    wheel_names,
    wheel_places,
)

HELD = 1e9
"""Inertia that holds a joint where it is [kg or kg m^2]."""
DAMPED = 10.0
"""While x, y and heading are held, motion dies away at this rate [1/s]."""
DROP = 0.02
"""How far above the highest ground below it a rover begins, in wheel radii."""
STILL, LONGEST = 5e-4, 6.0
"""A rover rests when nothing moves faster [m/s, rad/s]; how long that may take [s]."""
LOOK = 0.05
"""How often that is looked at [s]."""
_ARMS = ("rocker_left", "rocker_right", "bogie_left", "bogie_right")


@value
class Rested:
    """How rovers stand in MuJoCo; angles and heights as in `rovernav.rover.Settled`.

    Attributes:
        pose: x, y, heading (n, 3) [m, m, rad].
        z: Height of the rover's middle, level with its axles (n,) [m].
        pitch: Nose up (n,) [rad].
        roll: Left side up (n,) [rad].
        rocker: Left rocker against the body, nose up (n,) [rad]; 0 where there is none.
        bogie_left: Left bogie against the body, nose up (n,) [rad]; 0 where there is none.
        bogie_right: The right one (n,) [rad].
        wheels: How many wheels touch the ground (n,).
        belly: Whether the belly touches it (n,).
        still: Whether nothing moved any more (n,).
    """

    pose: F64
    z: F64
    pitch: F64
    roll: F64
    rocker: F64
    bogie_left: F64
    bogie_right: F64
    wheels: I64
    belly: Bool
    still: Bool

    @property
    def tilt(self) -> F64:
        """Angle of the body against level (n,) [rad]."""
        return np.arccos(np.minimum(1.0, np.cos(self.pitch) * np.cos(self.roll)))


@final
class Physics:
    """One rover on one ground in MuJoCo.

    Args:
        terrain: The ground, without holes. Its posts become a height field: MuJoCo spans two
            triangles between any four of them.
        rover: Needs wheels and a mass. How its mass is shared between body, arms and wheels is an
            assumption; the whole's is placed so that it tips over at the rover's `static_tilt`.
        wheels: "sphere", as settling takes them, or "cylinder" of the wheels' own width.
        steering: "skid": the wheels of a side turn alike. "corners": all wheels but those in the
            middle of a side are turned into the arc first.
        threads: For batches of rovers; the numbers do not depend on it.

    Raises:
        MissingExtraError: The extra ``physics`` is not installed.
        SettingError: Wheels or steering that there are none of, a rover without wheels or mass.
        InputError: Ground with holes.
    """

    def __init__(
        self,
        terrain: Terrain,
        rover: Rover,
        *,
        wheels: Wheels = "sphere",
        steering: Steering = "skid",
        threads: int = 1,
    ) -> None:
        self.terrain, self.rover, self.threads = terrain, rover, threads
        self._steering: Steering = steering
        mujoco, text = _mujoco(), mjcf(terrain, rover, wheels=wheels, steering=steering)
        self._loose = mujoco.MjModel.from_xml_string(text)
        self._loose.hfield_data[:] = heights(terrain).ravel()
        self._held = copy.copy(self._loose)
        for name in ("x", "y", "heading"):
            self._held.joint(name).armature = HELD
        self._held.geom_condim[:] = 1
        self._held.dof_damping[:] = DAMPED * _inertia(self._loose)
        self._names = {self._loose.joint(k).name for k in range(self._loose.njnt)}

    def rest(self, poses: Any, *, hold: bool = True) -> Rested:
        """Rovers let down onto the ground, at rest.

        Each begins above the ground, as flush with it as a plane is. With `hold` x, y and heading
        stay what they are and wheels slide freely: nothing but the shape of the ground decides how
        it stands. Otherwise wheels are braked and friction holds it, more or less.

        Args:
            poses: x, y, heading (n, 3) [m, m, rad].
            hold: Whether x, y and heading are held.

        Raises:
            ShapeError: `poses` is not (n, 3).
            InputError: A pose nearer to the edge of the ground than the rover is long.
        """
        rows = checked_poses(poses)
        batch = self._batch(self._held if hold else self._loose, self._above(rows))
        still = np.zeros(len(rows), bool)
        for _ in range(round(LONGEST / LOOK)):
            moving = np.flatnonzero(~still)
            batch.step(moving.astype(np.int32), round(LOOK / STEP))
            still[moving] = np.abs(batch.qvel[moving]).max(axis=1) < STILL
            if still.all():
                break
        return self._seen(batch, still)

    def drive(self, starts: Any, twists: Any, *, period: float) -> list[Rested]:
        """Rovers that follow commands, from rest.

        Args:
            starts: x, y, heading (n, 3) [m, m, rad].
            twists: For each rover and period forward speed [m/s] and turn rate [rad/s] (n, k, 2).
            period: Time between two commands [s].

        Returns:
            How they stand at the start and after each period: k + 1 values of n rows.

        Raises:
            ShapeError: Shapes that do not fit.
            InputError: A start too near to the edge of the ground. One that drives off it falls.
        """
        twists = np.asarray(twists, np.float64)
        rows = checked_poses(starts)
        if twists.ndim != 3 or twists.shape[0] != len(rows) or twists.shape[2] != 2:
            raise ShapeError(
                f"twists must be ({len(rows)}, k, 2): speed and turn rate of each rover in each "
                f"period, got shape {twists.shape}"
            )
        begun = self.rest(rows)
        batch = self._batch(self._loose, self._joints(begun))
        out, steps = [begun], max(1, round(period / STEP))
        for k in range(twists.shape[1]):
            batch.ctrl[:] = self.controls(twists[:, k])
            batch.step(None, steps)
            out.append(self._seen(batch, np.abs(batch.qvel).max(axis=1) < STILL))
        return out

    def controls(self, twist: F64) -> F64:
        """Wheel rates [rad/s] for speeds and turn rates (n, 2); then angles of steered wheels."""
        x, y = wheel_places(self.rover)
        speed, turn = twist[:, :1], twist[:, 1:]
        along, across = speed - y * turn, x * turn + 0.0 * speed
        r = self.rover.wheel_radius
        if self._steering == "skid":
            return along / r
        steered = steered_wheels(self.rover)
        angle = np.arctan2(across, along)
        angle = np.where(np.hypot(across, along) < 1e-9, 0.0, angle)
        back = np.abs(angle) > 0.5 * np.pi
        angle = np.where(back, angle - np.copysign(np.pi, angle), angle)
        rate = np.hypot(across, along) * np.where(back, -1.0, 1.0)
        rate[:, ~steered] = along[:, ~steered]
        return np.hstack([rate / r, angle[:, steered]])

    def picture(
        self,
        stands: Rested,
        row: int = 0,
        *,
        size: tuple[int, int] = (960, 600),
        view: tuple[float, float, float] = (2.5, 120.0, -18.0),
    ) -> Any:
        """What a camera sees of one of `stands`, (height, width, 3) uint8.

        Without a screen it needs MUJOCO_GL=egl or osmesa in the environment before MuJoCo loads.

        Args:
            stands: Where rovers stand.
            row: Which of them.
            size: Width and height of the picture, up to 1600 x 1000.
            view: Distance from the rover's middle [lengths of the rover]; where the camera looks
                to, counter-clockwise from east, and how far above level [deg].
        """
        mujoco = _mujoco()
        data = mujoco.MjData(self._loose)
        data.qpos[:] = self._joints(stands)[row]
        mujoco.mj_forward(self._loose, data)
        camera = mujoco.MjvCamera()
        camera.lookat = data.body("base").xpos
        camera.distance = view[0] * max(self.rover.length, self.rover.width)
        camera.azimuth, camera.elevation = view[1:]
        with mujoco.Renderer(self._loose, height=size[1], width=size[0]) as renderer:
            renderer.update_scene(data, camera)
            return renderer.render()

    def _batch(self, model: Any, joints: F64) -> Any:
        batch = _mujoco().batch.Batch(model, len(joints), self.threads)
        batch.qpos = joints
        return batch

    def _above(self, rows: F64) -> F64:
        """Joints (n, nq) of rovers above the ground, flush with planes fitted to it."""
        reach = self.rover.radius
        width, height = self.terrain.frame.extent
        middle = 0.5 * np.array([width, height])
        inside = np.abs(rows[:, :2] - middle) < middle - (reach + self.terrain.frame.cell)
        if not inside.all():
            bad = rows[~inside.all(axis=1)][0]
            raise InputError(
                f"the pose at ({bad[0]:.6g}, {bad[1]:.6g}) m is nearer than {reach:.3g} m to the "
                "edge of the ground, which would let the rover fall; choose one farther inside"
            )
        joints = np.zeros((len(rows), self._loose.nq))
        planes = planes_over(self.terrain, self.rover.footing)
        for row, (x, y, heading) in enumerate(rows):
            i, j = self.terrain.frame.cell_of(x, y)
            p, q = float(planes.east[i, j]), float(planes.north[i, j])
            ahead = p * np.cos(heading) + q * np.sin(heading)
            left = q * np.cos(heading) - p * np.sin(heading)
            pitch, roll = np.arctan(ahead), np.arctan(left / np.hypot(1.0, ahead))
            z = self._height(x, y, (heading, pitch, roll))
            joints[row, : len(BASE)] = x, y, z, heading, pitch, roll
        return joints

    def _height(self, x: float, y: float, turned: tuple[float, float, float]) -> float:
        """How high the rover's middle must be for all wheels and the belly to be in the air [m]."""
        mujoco, model = _mujoco(), self._loose
        data = mujoco.MjData(model)
        data.qpos[: len(BASE)] = x, y, 0.0, *turned
        mujoco.mj_kinematics(model, data)
        least, cell = -np.inf, self.terrain.frame.cell
        for geom in np.flatnonzero(model.geom_conaffinity):
            reach = model.geom_rbound[geom]
            east, north, up = data.geom_xpos[geom]
            i, j = self.terrain.frame.cell_of(east, north)
            n = int(reach / cell) + 1
            near = self.terrain.height[max(0, i - n) : i + n + 1, max(0, j - n) : j + n + 1]
            low = reach if model.geom_type[geom] != mujoco.mjtGeom.mjGEOM_BOX else 0.0
            least = max(least, float(near.max()) + low - up)
        return least + DROP * self.rover.wheel_radius

    def _joints(self, stands: Rested) -> F64:
        """Joints (n, nq) of rovers that stand so."""
        s, model = stands, self._loose
        joints = np.zeros((len(s.z), model.nq))
        joints[:, : len(BASE)] = np.column_stack(
            [s.pose[:, :2], s.z - self.terrain.offset, s.pose[:, 2], s.pitch, s.roll]
        )
        angles = (s.rocker, -s.rocker, s.bogie_left - s.rocker, s.bogie_right + s.rocker)
        for name, angle in zip(_ARMS, angles, strict=True):
            if name in self._names:
                joints[:, model.joint(name).qposadr[0]] = angle
        return joints

    def _seen(self, batch: Any, still: Any) -> Rested:
        """What the rows of a batch look like."""
        mujoco, model = _mujoco(), batch.model
        joints, data = batch.qpos.copy(), mujoco.MjData(batch.model)
        kept = {name: joints[:, k] for k, name in enumerate(BASE)}
        turned = {
            name: joints[:, model.joint(name).qposadr[0]]
            if name in self._names
            else np.zeros(len(joints))
            for name in _ARMS
        }
        wheels = [model.geom(name).id for name in wheel_names(self.rover)]
        belly = model.geom("belly").id
        touching, grounded = np.zeros(len(joints), np.int64), np.zeros(len(joints), bool)
        for row in range(len(joints)):
            data.qpos[:] = joints[row]
            mujoco.mj_fwdPosition(model, data)
            met = {int(geom) for pair in data.contact.geom for geom in pair}
            touching[row], grounded[row] = len(met.intersection(wheels)), belly in met
        bogie = {side: turned[f"bogie_{side}"] + turned[f"rocker_{side}"] for side in SIDES}
        if "bogie_left" not in self._names:
            bogie = dict.fromkeys(SIDES, np.zeros(len(joints)))
        rocker = 0.5 * (turned["rocker_left"] - turned["rocker_right"])
        return Rested(
            pose=np.column_stack([kept["x"], kept["y"], kept["heading"]]),
            z=kept["z"] + self.terrain.offset, pitch=kept["pitch"], roll=kept["roll"],
            rocker=rocker, bogie_left=bogie["left"], bogie_right=bogie["right"],
            wheels=touching, belly=grounded, still=still,
        )  # fmt: skip


def _inertia(model: Any) -> F64:
    """Inertia that each joint feels (nv,) [kg or kg m^2]."""
    mujoco = _mujoco()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    return np.diag(full).copy()


def _mujoco() -> Any:
    """MuJoCo, loaded when it is needed."""
    try:
        importlib.import_module("mujoco.batch")  # MuJoCo before 4 has none
    except ImportError:
        raise MissingExtraError(
            "the physics check needs the extra 'physics'; install it with: "
            "pip install 'rovernav[physics]'"
        ) from None
    return importlib.import_module("mujoco")
