from __future__ import annotations

import builtins
import math
import sys
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rovernav.adapters import write_bag
from rovernav.core import Frame, InputError, MissingExtraError, SettingError
from rovernav.sim import (
    ClearSight,
    DifferentialDrive,
    HoleSensor,
    Odometry,
    RangeFan,
    Trace,
    simulate,
)
from rovernav.terrain import Terrain
from tests.sim.drives import Always, drive

pytest.importorskip("rosbags", reason="needs the extra ros: pip install 'rovernav[ros]'")

STARTS = ((1.0, 2.0, 0.3), (9.5, 0.0, -2.0), (10.0, 0.0, 0.0))
SENSORS = (RangeFan(reach=4.0, beams=7), ClearSight())
SECOND = 1_000_000_000


def driven(*starts: tuple[float, float, float], **more: Any) -> Trace:
    """Rovers that turn while they drive, among boxes: no number is like another."""
    set_up = drive(
        Always(0.25, 0.0, 0.2), (3.0, 1.0, 4.0, 4.0), (8.0, -3.0, 9.0, -1.0),
        starts=starts, limit=9.0, sensors=SENSORS,
        motion=DifferentialDrive(speed=1.0, turn_rate=1.0, period=0.3),
    )  # fmt: skip
    return simulate(set_up, seed=3, **more)


@pytest.fixture
def terrain() -> Terrain:
    frame = Frame(cell=0.5, shape=(48, 48))
    heights = -2600.0 + 0.125 * np.tile(np.arange(48.0), (48, 1))
    return Terrain.from_heights(heights, frame, name="slope", source="a test")


def said(path: Path) -> dict[str, list[tuple[int, Any]]]:
    """What a bag holds, by topic: the stamp of each message, and the message."""
    from rosbags.rosbag2 import Reader
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    found: dict[str, list[tuple[int, Any]]] = defaultdict(list)
    with Reader(path) as reader:
        stamps = []
        for connection, stamp, data in reader.messages():
            stamps.append(stamp)
            message = store.deserialize_cdr(data, connection.msgtype)
            found[connection.topic].append((stamp, message))
    assert stamps == sorted(stamps)
    return found


def stamp_of(header: Any) -> int:
    return header.stamp.sec * SECOND + header.stamp.nanosec


def heading_of(turn: Any) -> float:
    assert (turn.x, turn.y) == (0.0, 0.0)
    assert_allclose(turn.z**2 + turn.w**2, 1.0, rtol=1e-15)
    return 2.0 * math.atan2(turn.z, turn.w)


def at(point: Any) -> tuple[float, float, float]:
    return point.x, point.y, point.z


@pytest.mark.parametrize("several", [False, True])
def test_every_number_of_a_trace_comes_back(
    several: bool, terrain: Terrain, tmp_path: Path
) -> None:
    trace = driven(*(STARTS if several else STARTS[:1]))
    write_bag(trace, tmp_path / "drive.mcap", terrain=terrain, sensors=SENSORS)
    found = said(tmp_path / "drive.mcap")
    for k in range(len(trace.outcome)):
        _check_rover(found, trace, k, f"rover{k}/" if several else "", terrain)
    _check_frames(found, trace)


def _check_rover(found: Any, trace: Trace, k: int, name: str, terrain: Terrain) -> None:
    steps = int(trace.steps[k])
    stamps = [round(float(t) * SECOND) for t in trace.time[: steps + 1, k]]
    height = np.nan_to_num(terrain.elevation_at(*trace.path(k).T) + 2600.0)  # 0 off the map
    odometry = found[f"/{name}odom"]
    assert [stamp for stamp, _ in odometry] == stamps
    for step, (stamp, one) in enumerate(odometry):
        assert (stamp_of(one.header), one.header.frame_id) == (stamp, f"{name}odom")
        assert one.child_frame_id == f"{name}base_link"
        pose = one.pose.pose
        assert at(pose.position)[:2] == tuple(trace.path(k)[step])
        assert_allclose(pose.position.z, height[step], rtol=0, atol=1e-9)
        off = heading_of(pose.orientation) - trace.pose[step, k, 2]
        assert_allclose(math.remainder(off, 2 * math.pi), 0.0, atol=1e-15)
    _check_twists(found, trace, k, name, stamps)

    end, path = found[f"/{name}path"][0]
    assert (end, path.header.frame_id, len(path.poses)) == (stamps[-1], "map", steps + 1)
    assert [at(one.pose.position)[:2] for one in path.poses] == [*map(tuple, trace.path(k))]
    assert [stamp_of(one.header) for one in path.poses] == stamps
    assert found[f"/{name}outcome"][0][1].data == trace.ended(k).label
    _, goal = found[f"/{name}goal_pose"][0]
    assert at(goal.pose.position)[:2] == tuple(trace.mission.goal[k])
    assert goal.header.frame_id == "map"


def _check_twists(found: Any, trace: Trace, k: int, name: str, stamps: list[int]) -> None:
    steps = int(trace.steps[k])
    commands = found.get(f"/{name}cmd_vel", [])
    assert [stamp for stamp, _ in commands] == stamps[:-1]
    for step, (_, one) in enumerate(commands):
        got = (one.linear.x, one.linear.y, one.angular.z)
        assert got == tuple(trace.commands[step, k])
        assert (one.linear.z, one.angular.x, one.angular.y) == (0.0, 0.0, 0.0)
    # The mean twist is a chord's: at 0.25 m/s and 0.2 rad/s for 0.3 s shorter by sin(x)/x.
    for _, one in found[f"/{name}odom"][1:steps]:
        assert_allclose(one.twist.twist.linear.x, 0.25 * math.sin(0.03) / 0.03, rtol=1e-9)
        assert_allclose(one.twist.twist.linear.y, 0.0, atol=1e-9)
        assert_allclose(one.twist.twist.angular.z, 0.2, rtol=1e-9)
    scans, fan = found.get(f"/{name}scan", []), SENSORS[0]
    assert [stamp for stamp, _ in scans] == stamps[:-1]
    for step, (_, one) in enumerate(scans):
        read = trace.channels["beams"][step, k]
        wanted = np.where(read < 4.0, read, np.inf).astype(np.float32)
        assert np.array_equal(one.ranges, wanted)
        assert one.header.frame_id == f"{name}base_link"
        assert_allclose(one.angle_min + np.arange(7) * one.angle_increment, fan.angles, atol=1e-6)
        assert (one.range_min, one.range_max) == (0.0, 4.0)
    sight = [tuple(one.data) for _, one in found.get(f"/{name}sensors/clear_sight", [])]
    assert sight == [*map(tuple, trace.channels["clear_sight"][:steps, k])]


def _check_frames(found: Any, trace: Trace) -> None:
    static = [(t.header.frame_id, t.child_frame_id) for t in found["/tf_static"][0][1].transforms]
    several = len(trace.outcome) > 1
    names = [f"rover{k}/" if several else "" for k in range(len(trace.outcome))]
    assert static == [("map", f"{name}odom") for name in names]
    moved = [(stamp, one) for stamp, message in found["/tf"] for one in message.transforms]
    for k, name in enumerate(names):
        mine = [(s, one) for s, one in moved if one.child_frame_id == f"{name}base_link"]
        assert {one.header.frame_id for _, one in mine} == {f"{name}odom"}
        assert all(stamp_of(one.header) == stamp for stamp, one in mine)
        places = [at(one.transform.translation)[:2] for _, one in mine]
        assert places == [*map(tuple, trace.path(k))]


def matrix(turn: Any) -> np.ndarray:
    """A quaternion as a rotation matrix, by SciPy."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]).as_matrix()


def test_a_body_has_its_attitude_and_height(terrain: Terrain, tmp_path: Path) -> None:
    import dataclasses

    trace = driven(STARTS[0])
    rng = np.random.default_rng(2)
    attitude = rng.normal(0.0, 0.2, (*trace.time.shape, 3))
    attitude[..., 0] -= 2598.0
    trace = dataclasses.replace(trace, attitude=attitude)
    write_bag(trace, tmp_path / "a.mcap", terrain=terrain)
    for (_, one), (height, pitch, roll), pose in zip(
        said(tmp_path / "a.mcap")["/odom"], attitude[:, 0], trace.pose[:, 0], strict=True
    ):
        turned = matrix(one.pose.pose.orientation)
        c, s = np.cos(pose[2]), np.sin(pose[2])
        # x of the body: towards the heading, up by the pitch; z of its left side: up by the roll.
        ahead = [np.cos(pitch) * c, np.cos(pitch) * s, np.sin(pitch)]
        assert_allclose(turned[:, 0], ahead, rtol=0, atol=1e-12)
        assert_allclose(turned[2, 1], np.sin(roll) * np.cos(pitch), rtol=0, atol=1e-12)
        assert_allclose(one.pose.pose.position.z, height + 2600.0, rtol=0, atol=1e-9)


def test_odometry_that_drifts_is_what_the_rover_believes(tmp_path: Path) -> None:
    set_up = drive(
        Always(0.25, 0.0, 0.2), starts=STARTS[:2], goal=(19.0, 19.0), limit=9.0,
        sensors=(Odometry(),), motion=DifferentialDrive(speed=1.0, turn_rate=1.0, period=0.3),
    )  # fmt: skip
    trace = simulate(set_up, seed=3)
    write_bag(trace, tmp_path / "a.mcap")
    found = said(tmp_path / "a.mcap")
    assert "/tf_static" not in found
    moved = [t for _, message in found["/tf"] for t in message.transforms]
    for k in (0, 1):
        told = trace.channels["estimate"][:, k]
        shown = [at(one.pose.pose.position)[:2] for _, one in found[f"/rover{k}/odom"]]
        assert shown[:-1] == [*map(tuple, told[:, :2])]
        assert np.hypot(*(np.array(shown[-1]) - trace.path(k)[-1])) > 1e-3
        body = [t for t in moved if t.child_frame_id == f"rover{k}/base_link"]
        root = [t for t in moved if t.child_frame_id == f"rover{k}/odom"]
        assert {t.header.frame_id for t in root} == {"map"}
        for low, high, pose in zip(root, body, trace.pose[:, k], strict=True):
            turned = matrix(low.transform.rotation)
            place = turned @ at(high.transform.translation) + at(low.transform.translation)
            assert_allclose(place[:2], pose[:2], rtol=0, atol=1e-9)
            whole = turned @ matrix(high.transform.rotation)
            assert_allclose(whole[:2, 0], (np.cos(pose[2]), np.sin(pose[2])), rtol=0, atol=1e-9)
        assert [at(one.pose.position)[:2] for one in found[f"/rover{k}/path"][0][1].poses] == [
            *map(tuple, trace.path(k))
        ]


def test_some_beams_met_something() -> None:
    beams = driven(*STARTS).channels["beams"]
    assert (beams < 4.0).any()
    assert (beams == 4.0).any()


def test_the_same_trace_gives_the_same_messages_without_ground(tmp_path: Path) -> None:
    trace = driven(STARTS[0], record="path")
    write_bag(trace, tmp_path / "a.mcap")
    found = said(tmp_path / "a.mcap")
    assert set(found) == {"/tf_static", "/tf", "/odom", "/goal_pose", "/path", "/outcome"}
    assert {one.pose.pose.position.z for _, one in found["/odom"]} == {0.0}


def test_what_looks_down_is_no_scan(tmp_path: Path) -> None:
    holes = HoleSensor()
    trace = simulate(drive(Always(0.25, 0.0, 0.2), sensors=(holes,), limit=3.0), seed=3)
    write_bag(trace, tmp_path / "a.mcap", sensors=(holes,))
    found = said(tmp_path / "a.mcap")
    assert "/scan" not in found
    assert "/sensors/down" in found


def test_a_beam_that_failed_stays_nan(tmp_path: Path) -> None:
    import dataclasses

    trace = driven(STARTS[0])
    beams = trace.channels["beams"].copy()
    beams[0, 0, 2] = np.nan
    trace = dataclasses.replace(trace, channels={"beams": beams})
    write_bag(trace, tmp_path / "a.mcap", sensors=SENSORS)
    ranges = said(tmp_path / "a.mcap")["/scan"][0][1].ranges
    assert np.isnan(ranges[2])
    assert not np.isnan(np.delete(ranges, 2)).any()


def test_what_cannot_be_a_bag_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="record 'path' or 'all'"):
        write_bag(driven(STARTS[0], record="none"), tmp_path / "a.mcap")
    with pytest.raises(SettingError, match=r"is a \.mcap file, got .*a\.bag"):
        write_bag(driven(STARTS[0]), tmp_path / "a.bag")
    assert list(tmp_path.iterdir()) == []


def test_without_the_extra_a_sentence_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = builtins.__import__

    def without(name: str, *args: Any, **kwargs: Any) -> Any:
        if name.split(".")[0] == "rosbags":
            raise ImportError(name)
        return real(name, *args, **kwargs)

    monkeypatch.delitem(sys.modules, "rosbags.rosbag2", raising=False)
    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(MissingExtraError, match=r"pip install 'rovernav\[ros\]'"):
        write_bag(driven(STARTS[0]), tmp_path / "a.mcap")
