"""What a bag says: the messages of ROS 2, made from a trace."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, final

import numpy as np

from ..core import F64

if TYPE_CHECKING:
    from ..sim import Trace
    from ..terrain import Terrain

SECOND = 1_000_000_000
"""One second [ns]."""
MAP = "map"
ESTIMATE = "estimate"
"""The channel of `rovernav.sim.Odometry`: x, y [m], heading [rad] and more."""


class Way(NamedTuple):
    """Where a rover was: x, y, z [m], roll, pitch, heading [rad], as ROS counts them.

    Attributes:
        stamps: When (m,) [ns].
        true: (m, 6).
        believed: What the rover thought (m, 6); the same array where it knew.
    """

    stamps: list[int]
    true: F64
    believed: F64


@final
class Messages:
    """Makes messages from a trace.

    Args:
        trace: The drives.
        terrain: The ground that was driven, for heights.

    Attributes:
        store: The definitions of all messages: those of ROS 2 Humble, which later ones kept.
    """

    def __init__(self, trace: Trace, terrain: Terrain | None) -> None:
        from rosbags.typesys import Stores, get_typestore

        self.store = get_typestore(Stores.ROS2_HUMBLE)
        self._trace, self._terrain = trace, terrain
        self._made: dict[int, Way] = {}

    def stamps(self, k: int) -> list[int]:
        """When rover k was at each pose, from the start on (steps + 1,) [ns]."""
        return self._way(k).stamps

    def _way(self, k: int) -> Way:
        """Where rover k was, and where it thought that it was."""
        if k not in self._made:
            last = int(self._trace.steps[k]) + 1
            stamps = np.rint(self._trace.time[:last, k] * SECOND).astype(np.int64).tolist()
            true = self._true(k, last)
            self._made[k] = Way(stamps, true, self._believed(k, true))
        return self._made[k]

    def _true(self, k: int, last: int) -> F64:
        """x, y, z [m], roll, pitch, heading [rad] (last, 6), pitch positive with the nose down."""
        pose = self._trace.pose[:last, k]
        true = np.zeros((last, 6))
        true[:, :2], true[:, 5] = pose[:, :2], pose[:, 2]
        true[:, 2] = self._heights(pose[:, :2])
        if self._trace.attitude is not None:
            height, pitch, roll = self._trace.attitude[:last, k].T
            low = 0.0 if self._terrain is None else self._terrain.span[0]
            true[:, 2], true[:, 3], true[:, 4] = height - low, roll, -pitch
        return true

    def _believed(self, k: int, true: F64) -> F64:
        """The same of the rover's own estimate; the truth where it makes none.

        After the last step nothing is read, so the last error stays.
        """
        if ESTIMATE not in self._trace.channels:
            return true
        told = self._trace.channels[ESTIMATE][: len(true) - 1, k]
        out = true.copy()
        out[: len(told), :2], out[: len(told), 5] = told[:, :2], told[:, 2]
        if len(told):
            x, y, turn = _between(out[len(told) - 1], true[len(told) - 1])
            out[-1] = _moved(true[-1], x, y, turn)
        return out

    def _heights(self, points: F64) -> F64:
        """Heights (m,) above the lowest point of the ground [m]; 0 where nothing is known."""
        if self._terrain is None:
            return np.zeros(len(points))
        z = self._terrain.elevation_at(*points.T) - self._terrain.span[0]
        return np.nan_to_num(z, nan=0.0)

    def _new(self, kind: str, **fields: Any) -> Any:
        return self.store.types[kind](**fields)

    def _header(self, stamp: int, frame: str) -> Any:
        time = self._new("builtin_interfaces/msg/Time", sec=stamp // SECOND, nanosec=stamp % SECOND)
        return self._new("std_msgs/msg/Header", stamp=time, frame_id=frame)

    def _point(self, kind: str, x: float, y: float, z: float) -> Any:
        return self._new(f"geometry_msgs/msg/{kind}", x=float(x), y=float(y), z=float(z))

    def _turned(self, roll: float, pitch: float, heading: float) -> Any:
        """A turn about z, then about the new y, then about the new x."""
        cx, cy, cz = (math.cos(0.5 * float(a)) for a in (roll, pitch, heading))
        sx, sy, sz = (math.sin(0.5 * float(a)) for a in (roll, pitch, heading))
        return self._new(
            "geometry_msgs/msg/Quaternion",
            x=sx * cy * cz - cx * sy * sz,
            y=cx * sy * cz + sx * cy * sz,
            z=cx * cy * sz - sx * sy * cz,
            w=cx * cy * cz + sx * sy * sz,
        )

    def _pose(self, at: F64) -> Any:
        return self._new(
            "geometry_msgs/msg/Pose",
            position=self._point("Point", *at[:3]),
            orientation=self._turned(*at[3:]),
        )

    def twist(self, body: Sequence[float] | F64) -> Any:
        """A body twist: forward [m/s], left [m/s], turn [rad/s]."""
        return self._new(
            "geometry_msgs/msg/Twist",
            linear=self._point("Vector3", body[0], body[1], 0.0),
            angular=self._point("Vector3", 0.0, 0.0, body[2]),
        )

    def mean_twist(self, k: int, step: int) -> F64:
        """Body twist (3,) that leads from where it thought to be before `step` to there at it.

        Displacement over time, seen from the heading in the middle of the turn; 0 at the start.
        """
        if step == 0:
            return np.zeros(3)
        time = float(self._trace.time[step, k] - self._trace.time[step - 1, k])
        before, after = self._way(k).believed[step - 1 : step + 1]
        turn = math.remainder(float(after[5] - before[5]), 2.0 * math.pi)
        middle = float(before[5]) + 0.5 * turn
        c, s = math.cos(middle), math.sin(middle)
        dx, dy = (after[:2] - before[:2]).tolist()
        return np.array([c * dx + s * dy, c * dy - s * dx, turn]) / time

    def odometry(self, k: int, step: int, name: str) -> Any:
        """Where rover k thinks it is, and how it moved there."""
        nothing, here = np.zeros(36), self._pose(self._way(k).believed[step])
        return self._new(
            "nav_msgs/msg/Odometry",
            header=self._header(self.stamps(k)[step], f"{name}odom"),
            child_frame_id=f"{name}base_link",
            pose=self._new("geometry_msgs/msg/PoseWithCovariance", pose=here, covariance=nothing),
            twist=self._new(
                "geometry_msgs/msg/TwistWithCovariance",
                twist=self.twist(self.mean_twist(k, step)),
                covariance=nothing,
            ),
        )

    def _tied(self, stamp: int, frames: tuple[str, str], shift: Any, turn: Any) -> Any:
        return self._new(
            "geometry_msgs/msg/TransformStamped",
            header=self._header(stamp, frames[0]),
            child_frame_id=frames[1],
            transform=self._new("geometry_msgs/msg/Transform", translation=shift, rotation=turn),
        )

    def transform(self, k: int, step: int, name: str) -> list[Any]:
        """From odom to base_link; where the estimate drifts, from map to odom as well."""
        way = self._way(k)
        stamp, at = way.stamps[step], way.believed[step]
        shift, turn = self._point("Vector3", *at[:3]), self._turned(*at[3:])
        found = [self._tied(stamp, (f"{name}odom", f"{name}base_link"), shift, turn)]
        if way.believed is not way.true:
            x, y, angle = _between(way.true[step], at)
            shift = self._point("Vector3", x, y, 0.0)
            found.append(self._tied(stamp, (MAP, f"{name}odom"), shift, self._turned(0, 0, angle)))
        return found

    @property
    def drifts(self) -> bool:
        """Whether the rovers make estimates of their own."""
        return ESTIMATE in self._trace.channels

    def origin(self, name: str) -> Any:
        """From map to odom: no drift."""
        shift = self._point("Vector3", 0.0, 0.0, 0.0)
        return self._tied(0, (MAP, f"{name}odom"), shift, self._turned(0.0, 0.0, 0.0))

    def transforms(self, some: list[Any]) -> Any:
        """Transforms in one message."""
        return self._new("tf2_msgs/msg/TFMessage", transforms=some)

    def path(self, k: int, name: str) -> Any:
        """The way that rover k drove, each pose with its time."""
        stamps = self.stamps(k)
        poses = [
            self._new(
                "geometry_msgs/msg/PoseStamped",
                header=self._header(stamp, MAP),
                pose=self._pose(at),
            )
            for at, stamp in zip(self._way(k).true, stamps, strict=True)
        ]
        return self._new("nav_msgs/msg/Path", header=self._header(stamps[-1], MAP), poses=poses)

    def goal(self, k: int, name: str) -> Any:
        """Where rover k wanted to go, without a heading of its own."""
        x, y = self._trace.mission.goal[k].tolist()
        z = float(self._heights(self._trace.mission.goal[k : k + 1])[0])
        pose = self._new(
            "geometry_msgs/msg/Pose",
            position=self._point("Point", x, y, z),
            orientation=self._turned(0.0, 0.0, 0.0),
        )
        return self._new("geometry_msgs/msg/PoseStamped", header=self._header(0, MAP), pose=pose)

    def scan(self, k: int, step: int, name: str, fan: Any, reading: F64) -> Any:
        """What a fan of beams read; +inf where it met nothing, NaN where it failed."""
        stamps = self.stamps(k)
        ranges = np.where(reading >= fan.reach, np.inf, reading).astype(np.float32)
        return self._new(
            "sensor_msgs/msg/LaserScan",
            header=self._header(stamps[step], f"{name}base_link"),
            angle_min=float(fan.angles[0]),
            angle_max=float(fan.angles[-1]),
            angle_increment=float(fan.angles[1] - fan.angles[0]),
            time_increment=0.0,
            scan_time=(stamps[step + 1] - stamps[step]) / SECOND,
            range_min=0.0,
            range_max=float(fan.reach),
            ranges=ranges,
            intensities=np.zeros(0, np.float32),
        )

    def numbers(self, reading: F64, label: str) -> Any:
        """Readings as they are."""
        dim = self._new(
            "std_msgs/msg/MultiArrayDimension", label=label, size=len(reading), stride=len(reading)
        )
        layout = self._new("std_msgs/msg/MultiArrayLayout", dim=[dim], data_offset=0)
        return self._new(
            "std_msgs/msg/Float64MultiArray", layout=layout, data=np.array(reading, np.float64)
        )

    def text(self, words: str) -> Any:
        """Words."""
        return self._new("std_msgs/msg/String", data=words)

    @staticmethod
    def quality(*, latched: bool) -> list[Any]:
        """Quality of service: reliable; latched for what is said once and holds for good."""
        from rosbags.interfaces import (
            Qos,
            QosDurability,
            QosHistory,
            QosLiveliness,
            QosReliability,
            QosTime,
        )

        endless = QosTime(9223372036, 854775807)
        return [
            Qos(
                history=QosHistory.KEEP_LAST,
                depth=1 if latched else 10,
                reliability=QosReliability.RELIABLE,
                durability=QosDurability.TRANSIENT_LOCAL if latched else QosDurability.VOLATILE,
                deadline=endless,
                lifespan=endless,
                liveliness=QosLiveliness.AUTOMATIC,
                liveliness_lease_duration=endless,
                avoid_ros_namespace_conventions=False,
            )
        ]


def _between(to: F64, of: F64) -> tuple[float, float, float]:
    """The shift [m] and turn [rad] in the plane that carry the pose `of` onto `to`."""
    turn = math.remainder(float(to[5] - of[5]), 2.0 * math.pi)
    c, s = math.cos(turn), math.sin(turn)
    return (
        float(to[0] - (c * of[0] - s * of[1])), float(to[1] - (s * of[0] + c * of[1])), turn,
    )  # fmt: skip


def _moved(at: F64, x: float, y: float, turn: float) -> F64:
    """A pose carried by a shift and turn in the plane."""
    c, s = math.cos(turn), math.sin(turn)
    out = at.copy()
    out[0], out[1] = c * at[0] - s * at[1] + x, s * at[0] + c * at[1] + y
    out[5] = math.remainder(float(at[5] + turn), 2.0 * math.pi)
    return out
