"""What a bag says: the messages of ROS 2, made from a trace."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, final

import numpy as np

from ..core import F64

if TYPE_CHECKING:
    from ..sim import Trace
    from ..terrain import Terrain

SECOND = 1_000_000_000
"""One second [ns]."""
MAP = "map"


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
        self._made: dict[int, tuple[list[int], F64]] = {}

    def stamps(self, k: int) -> list[int]:
        """When rover k was at each pose, from the start on (steps + 1,) [ns]."""
        return self._way(k)[0]

    def _way(self, k: int) -> tuple[list[int], F64]:
        """Stamps and heights of rover k."""
        if k not in self._made:
            last = int(self._trace.steps[k]) + 1
            stamps = np.rint(self._trace.time[:last, k] * SECOND).astype(np.int64).tolist()
            self._made[k] = (stamps, self._heights(self._trace.path(k)))
        return self._made[k]

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

    def _turned(self, heading: float) -> Any:
        """A turn about z."""
        half = 0.5 * float(heading)
        return self._new(
            "geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=math.sin(half), w=math.cos(half)
        )

    def _pose(self, k: int, step: int) -> Any:
        x, y, heading = self._trace.pose[step, k].tolist()
        return self._new(
            "geometry_msgs/msg/Pose",
            position=self._point("Point", x, y, self._way(k)[1][step]),
            orientation=self._turned(heading),
        )

    def twist(self, body: Sequence[float] | F64) -> Any:
        """A body twist: forward [m/s], left [m/s], turn [rad/s]."""
        return self._new(
            "geometry_msgs/msg/Twist",
            linear=self._point("Vector3", body[0], body[1], 0.0),
            angular=self._point("Vector3", 0.0, 0.0, body[2]),
        )

    def mean_twist(self, k: int, step: int) -> F64:
        """Body twist (3,) that leads from the pose before `step` to the one at it.

        Displacement over time, seen from the heading in the middle of the turn; 0 at the start.
        """
        if step == 0:
            return np.zeros(3)
        time = float(self._trace.time[step, k] - self._trace.time[step - 1, k])
        before, after = self._trace.pose[step - 1, k], self._trace.pose[step, k]
        turn = math.remainder(float(after[2] - before[2]), 2.0 * math.pi)
        middle = float(before[2]) + 0.5 * turn
        c, s = math.cos(middle), math.sin(middle)
        dx, dy = (after[:2] - before[:2]).tolist()
        return np.array([c * dx + s * dy, c * dy - s * dx, turn]) / time

    def odometry(self, k: int, step: int, name: str) -> Any:
        """Where rover k is, and how it moved there."""
        nothing = np.zeros(36)
        return self._new(
            "nav_msgs/msg/Odometry",
            header=self._header(self.stamps(k)[step], f"{name}odom"),
            child_frame_id=f"{name}base_link",
            pose=self._new(
                "geometry_msgs/msg/PoseWithCovariance", pose=self._pose(k, step), covariance=nothing
            ),
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

    def transform(self, k: int, step: int, name: str) -> Any:
        """From odom to base_link."""
        x, y, heading = self._trace.pose[step, k].tolist()
        stamps, heights = self._way(k)
        shift = self._point("Vector3", x, y, heights[step])
        frames = (f"{name}odom", f"{name}base_link")
        return self._tied(stamps[step], frames, shift, self._turned(heading))

    def origin(self, name: str) -> Any:
        """From map to odom: no drift."""
        shift = self._point("Vector3", 0.0, 0.0, 0.0)
        return self._tied(0, (MAP, f"{name}odom"), shift, self._turned(0.0))

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
                pose=self._pose(k, step),
            )
            for step, stamp in enumerate(stamps)
        ]
        return self._new("nav_msgs/msg/Path", header=self._header(stamps[-1], MAP), poses=poses)

    def goal(self, k: int, name: str) -> Any:
        """Where rover k wanted to go, without a heading of its own."""
        x, y = self._trace.mission.goal[k].tolist()
        z = float(self._heights(self._trace.mission.goal[k : k + 1])[0])
        pose = self._new(
            "geometry_msgs/msg/Pose",
            position=self._point("Point", x, y, z),
            orientation=self._turned(0.0),
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
