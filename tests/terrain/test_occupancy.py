from __future__ import annotations

import gzip
import math
import warnings
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from rovernav.core import FileError, SettingError, ShapeError
from rovernav.sim import Grid
from rovernav.terrain import Occupancy, read_occupancy

GREY = np.array([[0, 254, 205], [254, 254, 100], [0, 0, 254], [254, 254, 254]], np.uint8)
YAML = "image: map.pgm\nresolution: 0.05\norigin: [-1.5, 2.0, 0.0]\nnegate: 0\n" \
       "occupied_thresh: 0.65\nfree_thresh: 0.196\n"  # fmt: skip


def ros(folder: Path, text: str = YAML, grey: np.ndarray = GREY) -> Path:
    h, w = grey.shape
    (folder / "map.pgm").write_bytes(b"P5\n# made\n%d %d\n255\n" % (w, h) + grey.tobytes())
    (folder / "map.yaml").write_text(text)
    return folder / "map.yaml"


def test_a_ros_map(tmp_path: Path) -> None:
    found = read_occupancy(ros(tmp_path))
    assert (found.name, found.source) == ("map", "ROS map map.yaml")
    assert found.frame.to_map(0.0, 0.0) == (-1.5, 2.0)
    assert found.frame.cell == 0.05
    # 100 is darker than free and lighter than occupied: unknown, like 205
    blocked = [[1, 0, 1], [0, 0, 1], [1, 1, 0], [0, 0, 0]]
    known = [[1, 1, 0], [1, 1, 0], [1, 1, 1], [1, 1, 1]]
    assert_array_equal(found.blocked, blocked[::-1])
    assert_array_equal(found.known, known[::-1])
    assert found.share == pytest.approx(5 / 12)
    assert Grid(frame=found.frame, blocked=found.blocked).blocked.sum() == 5


def test_a_ros_map_that_is_negated_and_turned(tmp_path: Path) -> None:
    text = YAML.replace("negate: 0", "negate: 1").replace("2.0, 0.0]", f"2.0, {math.pi / 2}]")
    found = read_occupancy(ros(tmp_path, text, 255 - GREY))
    assert_array_equal(found.blocked, read_occupancy(ros(tmp_path)).blocked)
    assert found.frame.to_map(1.0, 0.0) == pytest.approx((-1.5, 3.0))


def test_a_ros_map_of_png(tmp_path: Path) -> None:
    import rasterio

    ros(tmp_path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with rasterio.open(
            tmp_path / "map.png", "w", driver="PNG", count=4, height=4, width=3, dtype="uint8"
        ) as data:
            data.write(np.stack([GREY, GREY, GREY, np.full_like(GREY, 255)]))
    path = ros(tmp_path, YAML.replace(".pgm", ".png"))
    assert read_occupancy(path).share == pytest.approx(5 / 12)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("resolution: 0.05", "resolution: 0"), "resolution = 0: input should be greater than 0"),
        (("resolution: 0.05\n", ""), "the key 'resolution' is missing; add it"),
        (("[-1.5, 2.0, 0.0]", "[1]"), "the key 'origin.1' is missing|origin"),
        (("negate: 0", "mode: raw"), "mode = 'raw': input should be 'trinary' or 'scale'"),
        (("map.pgm", "none.pgm"), r"there is no map at .*none.pgm; check the path"),
        (("map.pgm", "map.yaml"), "is not a PGM or PNG image; export the map as one of them"),
        (("image: map.pgm", "image: ["), "map.yaml"),
    ],
)
def test_ros_maps_that_are_none(tmp_path: Path, change: tuple[str, str], message: str) -> None:
    path = ros(tmp_path, YAML.replace(*change))
    with pytest.raises((FileError, SettingError), match=message):
        read_occupancy(path)


def test_a_cut_off_image(tmp_path: Path) -> None:
    path = ros(tmp_path)
    (tmp_path / "map.pgm").write_bytes(b"P5\n3000 4000\n255\nabc")
    with pytest.raises(FileError, match=r"map.pgm is a damaged or cut-off PGM image"):
        read_occupancy(path)


POLE = """<model name='c{0}'><pose frame=''>{1} {2} 0 0 0 0</pose><link name='l'><collision
name='c'><geometry><cylinder><radius>0.075</radius></cylinder></geometry></collision></link></model>
"""


def world(folder: Path, *places: tuple[float, float], name: str = "a.world") -> Path:
    poles = "".join(POLE.format(n, x, y) for n, (x, y) in enumerate(places))
    text = (
        f"<sdf version='1.6'><world name='w'>{poles}<state><model name='c0'/></state></world></sdf>"
    )
    (folder / name).write_text(text)
    return folder / name


def test_a_barn_world(tmp_path: Path) -> None:
    found = read_occupancy(world(tmp_path, (-0.075, 0.075), (-4.425, 9.525)))
    assert found.frame.shape == (64, 30)
    assert_array_equal(np.argwhere(found.blocked), [[0, 29], [63, 0]])
    assert_allclose(found.discs, [[4.425, 0.075, 0.075], [0.075, 9.525, 0.075]], atol=1e-12)
    packed = tmp_path / "b.world.gz"
    packed.write_bytes(gzip.compress((tmp_path / "a.world").read_bytes()))
    assert_array_equal(read_occupancy(packed).blocked, found.blocked)
    assert read_occupancy(packed).name == "b"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (b"<sdf><world>", "is no Gazebo world"),
        (b"<sdf><world name='x'/></sdf>", "has no cylinders with places; give a world of the BARN"),
        (b"<sdf><!DOCTYPE x></sdf>", "declares its own entities, which no Gazebo world needs"),
        (b"<?xml version='1.0'?><!DOCTYPE x [<!ENTITY a 'b'>]><sdf>&a;</sdf>", "declares its own"),
        (b"\x1f\x8bxxxx", "is a damaged or cut-off world"),
        (b"nothing", "is no occupancy map; give a ROS map"),
    ],
)
def test_worlds_that_are_none(tmp_path: Path, text: bytes, message: str) -> None:
    (tmp_path / "a.world").write_bytes(text)
    with pytest.raises(FileError, match=message):
        read_occupancy(tmp_path / "a.world")


def test_a_pole_off_the_field(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"a cylinder at \(7, 1\) lies off its field of 4.5 x 9.6"):
        read_occupancy(world(tmp_path, (-1.0, 1.0), (7.0, 1.0)))
    with pytest.raises(FileError, match=r"has no cylinders with places|is no Gazebo world"):
        read_occupancy(world(tmp_path, (math.nan, 1.0)))


def test_a_world_that_unpacks_without_end(tmp_path: Path) -> None:
    (tmp_path / "a.world.gz").write_bytes(gzip.compress(b"<sdf>" + b" " * 60_000_000))
    with pytest.raises(FileError, match="has more than 50,000,000 bytes, which no BARN world has"):
        read_occupancy(tmp_path / "a.world.gz")


def test_occupancy_must_fit_its_frame(tmp_path: Path) -> None:
    found = read_occupancy(ros(tmp_path))
    with pytest.raises(ShapeError, match=r"needs uint8 cells of shape \(4, 3\), got float64"):
        Occupancy(
            frame=found.frame, blocked=np.zeros((4, 3)),  # type: ignore[arg-type]
            known=found.known, discs=found.discs,
            name="x", source="x",
        )  # fmt: skip


@pytest.mark.data
def test_barn_worlds_are_those_of_the_archive(data_dir: Path) -> None:
    barn = data_dir / "barn"
    for number in (0, 150):
        one = read_occupancy(barn / "barn_worlds_dev.npz", world=number)
        raw = read_occupancy(barn / f"raw_world_samples/world_{number}.world.gz")
        assert_array_equal(one.blocked, raw.blocked)
        assert_allclose(np.sort(one.discs, 0), np.sort(raw.discs, 0), rtol=0, atol=1e-6)
    for number in (None, 1):
        with pytest.raises(SettingError, match=r"holds the worlds 0, 5, ... 295, got .*--world N"):
            read_occupancy(barn / "barn_worlds_dev.npz", world=number)
