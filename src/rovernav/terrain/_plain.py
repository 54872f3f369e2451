"""Maps of free and blocked cells as ground: level where it is free, missing where it is not."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..core import FileError, SettingError, read_yaml
from ..core.frame import PLAIN
from ._gdal import Options, refuse_cell
from ._occupancy import read_occupancy
from ._posts import ArrayPosts, Placing


def is_plain(path: Path, head: bytes) -> bool:
    """Whether a file is a ROS map or a BARN world, by its name and its first bytes."""
    text = head.lstrip(b"\xef\xbb\xbf \t\r\n")
    packed = head[:2] == b"\x1f\x8b" and ".world" in path.name.lower()
    return path.suffix.lower() in (".yaml", ".yml") or b"<sdf" in text or packed


def read_plain(path: Path, given: Options) -> tuple[Placing, ArrayPosts]:
    """The cells of a map: 0 m where it is free, NaN where something stands or nothing is known.

    Raises:
        FileError: Missing or damaged, turned against the axes, or without a free cell.
        SettingError: A cell or an order of rows for a file that has its own.
    """
    yaml = path.suffix.lower() in (".yaml", ".yml")
    if yaml and "image" not in read_yaml(path, what="map"):
        raise FileError(
            f"{path} is no map, for it names no image; give a ROS map or an elevation model, and "
            "a scenario file to rovernav drive alone"
        )
    found = read_occupancy(path)
    frame = found.frame
    refuse_cell(path, given.cell, frame.cell)
    if given.south_first:
        raise SettingError(f"{path} is a map, which has its own order of rows; leave it out")
    if frame.axes != PLAIN:
        raise FileError(
            f"{path} is turned by its origin's third number; set that to 0, and give places in "
            "the map's own axes"
        )
    if found.blocked.all():
        raise FileError(
            f"{path} has no free cell; check its thresholds, and whether negate should be set"
        )
    cells = np.where(found.blocked != 0, np.float32(np.nan), np.float32(0.0))
    placing = Placing(shape=frame.shape, corner=frame.origin, step=(frame.cell, frame.cell))
    return placing, ArrayPosts(array=cells)


def beside(path: Path) -> Path | None:
    """The YAML file of a map that lies beside its picture, if there is one of the same name."""
    for suffix in (".yaml", ".yml"):
        if path.with_suffix(suffix).is_file():
            return path.with_suffix(suffix)
    return None
