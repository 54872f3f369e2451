"""Traces as ROS 2 bags, one MCAP file each: what rosbag2, Foxglove and rosbags open.

Frames follow REP-105: ``map`` holds ``odom`` holds ``base_link``, x forward, y left, z up
(REP-103). Where a rover carries odometry that drifts, ``odom`` is what it believes, and ``map`` to
``odom`` corrects it; otherwise they are one. Where there are several rovers, names begin with that
of the rover: ``/rover3/odom``, frame ``rover3/odom``.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..core import InputError, MissingExtraError, Sensor, SettingError, write_atomic

if TYPE_CHECKING:
    from ..sim import Trace
    from ..terrain import Terrain
    from ._messages import Messages

SUFFIX = ".mcap"
MOST = 1000
"""Rovers in one bag: each has topics of its own."""


class Note(NamedTuple):
    """A message that is to be written.

    Attributes:
        stamp: When it was sent [ns].
        topic: Where.
        kind: The type of the message.
        message: The message.
    """

    stamp: int
    topic: str
    kind: str
    message: Any


def write_bag(
    trace: Trace,
    path: Path,
    *,
    terrain: Terrain | None = None,
    sensors: Sequence[Sensor] = (),
) -> None:
    """Write a trace as a ROS 2 bag in one MCAP file, which holds the definitions of its messages.

    Topics of each rover, stamped with the seconds since the start:

    - ``odom`` nav_msgs/Odometry: where the rover thinks it is, and the mean twist of the step that
      led there; roll and pitch of rovers with bodies.
    - ``cmd_vel`` geometry_msgs/Twist: each command, at the moment it was given.
    - ``scan`` sensor_msgs/LaserScan, one topic for each fan of beams, ``scan_NAME`` beyond the
      first; a beam that met nothing is +inf (REP-117). Other sensors: std_msgs/Float64MultiArray
      on ``sensors/NAME``.
    - ``goal_pose`` geometry_msgs/PoseStamped at the start, ``path`` nav_msgs/Path, the true way,
      and ``outcome`` std_msgs/String at the end.
    - ``/tf`` and ``/tf_static``.

    Height z counts from the lowest point of the terrain; it is 0 without one. Rovers with bodies
    have the height of their middle at the axles.

    Args:
        trace: The drives, recorded with all or with the path alone.
        path: The ``.mcap`` file.
        terrain: The ground that was driven, if any.
        sensors: What the rovers carried; those with `angles` and `reach` become laser scans.

    Raises:
        MissingExtraError: The extra ``ros`` is not installed.
        SettingError: The file is not named ``.mcap``.
        InputError: The trace keeps no path, or has too many rovers.
        FileError: The file cannot be written.
    """
    need_rosbags()
    from ._messages import Messages

    if path.suffix.lower() != SUFFIX:
        raise SettingError(f"a bag is a {SUFFIX} file, got {path}; end its name with {SUFFIX}")
    rovers = len(trace.outcome)
    if len(trace.pose) <= int(np.max(trace.steps, initial=0)):
        raise InputError("this trace keeps only where the drive ended; record 'path' or 'all'")
    if rovers > MOST:
        raise InputError(f"a bag holds at most {MOST} rovers, this trace has {rovers}")
    messages = Messages(trace, terrain)
    notes = sorted(_notes(messages, trace, sensors), key=lambda note: note.stamp)
    data = _packed(notes, messages)
    write_atomic(path, lambda file: file.write(data))


def need_rosbags() -> None:
    """Raise `MissingExtraError` unless the extra ``ros`` is installed."""
    try:
        import rosbags.rosbag2  # noqa: F401  # pyright: ignore[reportUnusedImport]
    except ImportError:
        raise MissingExtraError(
            "ROS 2 bags need the extra 'ros'; install it with: pip install 'rovernav[ros]'"
        ) from None


def _notes(messages: Messages, trace: Trace, sensors: Sequence[Sensor]) -> Iterator[Note]:
    fans = {sensor.name: sensor for sensor in sensors if _is_fan(sensor)}
    several = len(trace.outcome) > 1
    if not messages.drifts:
        static = [messages.origin(_name(k, several)) for k in range(len(trace.outcome))]
        yield Note(0, "/tf_static", "tf2_msgs/msg/TFMessage", messages.transforms(static))
    for k in range(len(trace.outcome)):
        yield from _rover(messages, trace, k, fans, _name(k, several))


def _is_fan(sensor: Any) -> bool:
    """Whether its beams are spread evenly and reach equally far: what a LaserScan can say."""
    angles = np.asarray(getattr(sensor, "angles", ()), np.float64)
    even = angles.ndim == 1 and len(angles) > 1 and np.allclose(np.diff(angles, 2), 0.0, atol=1e-9)
    return bool(even) and np.ndim(getattr(sensor, "reach", ())) == 0 and hasattr(sensor, "reach")


def _name(k: int, several: bool) -> str:
    return f"rover{k}/" if several else ""


def _rover(
    messages: Messages, trace: Trace, k: int, fans: dict[str, Any], name: str
) -> Iterator[Note]:
    """All that rover k sends, in the order of time."""
    steps = int(trace.steps[k])
    stamps = messages.stamps(k)
    yield Note(0, f"/{name}goal_pose", "geometry_msgs/msg/PoseStamped", messages.goal(k, name))
    for step in range(steps + 1):
        at = stamps[step]
        moved = messages.transforms(messages.transform(k, step, name))
        yield Note(at, "/tf", "tf2_msgs/msg/TFMessage", moved)
        yield Note(at, f"/{name}odom", "nav_msgs/msg/Odometry", messages.odometry(k, step, name))
        if step < len(trace.commands) and step < steps:
            yield from _sensed(messages, trace, (k, step), fans, name)
            command = messages.twist(trace.commands[step, k])
            yield Note(at, f"/{name}cmd_vel", "geometry_msgs/msg/Twist", command)
    end = stamps[steps]
    yield Note(end, f"/{name}path", "nav_msgs/msg/Path", messages.path(k, name))
    ended = messages.text(trace.ended(k).label)
    yield Note(end, f"/{name}outcome", "std_msgs/msg/String", ended)


def _sensed(
    messages: Messages, trace: Trace, at: tuple[int, int], fans: dict[str, Any], name: str
) -> Iterator[Note]:
    k, step = at
    stamp = messages.stamps(k)[step]
    first = next((sensor for sensor in trace.channels if sensor in fans), None)
    for sensor, readings in trace.channels.items():
        reading = readings[step, k]
        if sensor in fans:
            topic = f"/{name}scan" if sensor == first else f"/{name}scan_{sensor}"
            scan = messages.scan(k, step, name, fans[sensor], reading)
            yield Note(stamp, topic, "sensor_msgs/msg/LaserScan", scan)
        else:
            numbers = messages.numbers(reading, sensor)
            kind = "std_msgs/msg/Float64MultiArray"
            yield Note(stamp, f"/{name}sensors/{sensor}", kind, numbers)


def _packed(notes: Iterable[Note], messages: Messages) -> bytes:
    """The bytes of a bag with these messages, in this order."""
    from rosbags.rosbag2 import StoragePlugin, Writer

    with tempfile.TemporaryDirectory(prefix="rovernav-bag-") as scratch:
        folder = Path(scratch) / "drive"
        with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as bag:
            open_topics: dict[str, Any] = {}
            for stamp, topic, kind, message in notes:
                if topic not in open_topics:
                    open_topics[topic] = bag.add_connection(
                        topic, kind, typestore=messages.store,
                        offered_qos_profiles=messages.quality(latched=topic == "/tf_static"),
                    )  # fmt: skip
                data = messages.store.serialize_cdr(message, kind)
                bag.write(open_topics[topic], stamp, data)
        return (folder / f"drive{SUFFIX}").read_bytes()
