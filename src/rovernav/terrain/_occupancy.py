"""Maps that say free or blocked: ROS map_server files and worlds of the BARN challenge.

Sources: the ROS package map_server (its YAML keys and thresholds); D. Perille et al., Benchmarking
Metric Ground Navigation, SSRR 2020 (BARN: cylinders on a lattice of 30 x 64 cells of 0.15 m).
"""

from __future__ import annotations

import gzip
import io
import math
import zlib
from pathlib import Path
from typing import Any, Literal

import numpy as np

from ..core import F64, U8, FileError, Frame, SettingError, ShapeError, build, read_yaml, value
from ._gdal import opened, words_of
from ._raster import MAX_CELLS

BARN_CELL, BARN_SHAPE, BARN_WEST = 0.15, (64, 30), -4.5
BARN_RADIUS = 0.075
LARGEST_WORLD = 50_000_000
"""A world file larger than this is refused, unpacked or not [bytes]."""


@value
class Occupancy:
    """Where a robot may not be, on a grid of square cells.

    Attributes:
        frame: Where the cells lie; row 0 south.
        blocked: (h, w) uint8, 1 where something stands or nothing is known, else 0.
        known: (h, w) uint8, 0 where nothing is known, else 1.
        discs: (n, 3) local x, y and radius [m] of what stands there, where the file has shapes.
        name: Short name for titles and file names.
        source: Where it comes from, for reports.
    """

    frame: Frame
    blocked: U8
    known: U8
    discs: F64
    name: str
    source: str

    def _check(self) -> None:
        for cells in (self.blocked, self.known):
            if cells.shape != self.frame.shape or cells.dtype != np.uint8:
                raise ShapeError(
                    f"an occupancy map needs uint8 cells of shape {self.frame.shape}, got "
                    f"{cells.dtype} of shape {cells.shape}"
                )

    @property
    def share(self) -> float:
        """Share of the cells that are blocked, 0 to 1."""
        return float(np.count_nonzero(self.blocked) / self.blocked.size)


def read_occupancy(path: str | Path, *, world: int | None = None) -> Occupancy:
    """A map of free and blocked cells from a file on this machine.

    ======================  ====================================================================
    ROS map_server (.yaml)  with its image (PGM or PNG) beside it; modes trinary and scale
    BARN world (.world)     Gazebo's SDF, or packed with gzip (.world.gz)
    BARN archive (.npz)     many worlds; `world` says which
    ======================  ====================================================================

    Args:
        path: The file.
        world: Number of a world in an archive.

    Raises:
        FileError: Missing, damaged or of another kind.
        SettingError: A key of the YAML is wrong, or `world` is missing or not there.
    """
    path = Path(path)
    head = _start(path)
    if head.startswith(b"PK"):
        return _barn_archive(path, world)
    if world is not None:
        raise SettingError(f"{path} holds one map; leave the number of the world out")
    if head.startswith(b"\x1f\x8b") or head.lstrip().startswith((b"<sdf", b"<?xml")):
        return _barn_world(path)
    if path.suffix.lower() in (".yaml", ".yml"):
        return _ros_map(path)
    raise FileError(
        f"{path} is no occupancy map; give a ROS map (.yaml), a BARN world (.world, .world.gz) or "
        "an archive of BARN worlds (.npz)"
    )


def _start(path: Path) -> bytes:
    try:
        with path.open("rb") as file:
            return file.read(64)
    except FileNotFoundError:
        raise FileError(f"there is no map at {path}; check the path") from None
    except OSError as error:
        raise FileError(f"cannot read the map {path}: {error.strerror}") from None


def _ros_map(path: Path) -> Occupancy:
    from pydantic import BaseModel, ConfigDict, Field

    class Map(BaseModel):
        """The YAML file of map_server."""

        model_config = ConfigDict(extra="ignore", allow_inf_nan=False)
        image: str = Field(min_length=1)
        resolution: float = Field(gt=0)
        origin: tuple[float, float, float]
        negate: bool = False
        occupied_thresh: float = Field(0.65, ge=0, le=1)
        free_thresh: float = Field(0.196, ge=0, le=1)
        mode: Literal["trinary", "scale"] = "trinary"

    meta = build(Map, read_yaml(path, what="map"), source=str(path))
    grey = _grey(path.parent / meta.image)
    dark = grey / 255.0 if meta.negate else 1.0 - grey / 255.0
    occupied, free = dark > meta.occupied_thresh, dark < meta.free_thresh
    x, y, yaw = meta.origin
    turn = ((math.cos(yaw), -math.sin(yaw)), (math.sin(yaw), math.cos(yaw)))
    plain: Any = {"axes": turn} if yaw else {}
    return Occupancy(
        frame=Frame(cell=meta.resolution, shape=grey.shape, origin=(x, y), **plain),
        blocked=(~free)[::-1].astype(np.uint8),
        known=(occupied | free)[::-1].astype(np.uint8),
        discs=np.empty((0, 3)),
        name=path.stem,
        source=f"ROS map {path.name}",
    )


def _grey(path: Path) -> F64:
    """An image as grey values (h, w), 0 to 255, row 0 the top; colours are averaged."""
    head = _start(path)
    driver = "PNG" if head.startswith(b"\x89PNG") else "PNM"
    if driver == "PNM" and head[:2] not in (b"P5", b"P6"):
        raise FileError(f"{path} is not a PGM or PNG image; export the map as one of them")
    with opened(path, driver) as data:
        if data.width * data.height > MAX_CELLS:
            raise FileError(f"{path} has more than {MAX_CELLS:,} pixels; crop the map first")
        if data.dtypes[0] != "uint8":
            raise FileError(f"{path} has {data.dtypes[0]} pixels; export the map with 8 bits")
        colours = [n for n in range(1, data.count + 1) if data.colorinterp[n - 1].name != "alpha"]
        return np.asarray(data.read(colours), np.float64).mean(axis=0)


def _barn_archive(path: Path, world: int | None) -> Occupancy:
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as data:
            worlds = [int(n) for n in data["world_ids"]]
            if world not in worlds:
                raise SettingError(
                    f"{path} holds the worlds {worlds[0]}, {worlds[1]}, ... {worlds[-1]}, got "
                    f"{'none' if world is None else world}; name one with --world N"
                )
            centres = np.asarray(data[f"cyl_{world:03d}"], np.float64)
            filled = np.asarray(data[f"grid_{world:03d}"])
    except SettingError:
        raise
    except Exception as error:  # zip files fail in many families
        raise FileError(f"{path} is no archive of BARN worlds ({words_of(error)})") from None
    if centres.ndim != 2 or centres.shape[1] != 2 or filled.shape != BARN_SHAPE[::-1]:
        raise FileError(f"{path}: world {world} is damaged; fetch the archive again")
    return _barn(centres, filled.T.astype(np.uint8), f"barn-{world}", f"BARN world {world}")


def _barn_world(path: Path) -> Occupancy:
    centres = _cylinders(path)
    i = np.floor((centres[:, 0] - BARN_WEST) / BARN_CELL).astype(int)
    j = np.floor(centres[:, 1] / BARN_CELL).astype(int)
    h, w = BARN_SHAPE
    off = (i < 0) | (i >= w) | (j < 0) | (j >= h)
    if off.any():
        x, y = centres[np.argmax(off)]
        raise FileError(
            f"{path} is no BARN world: a cylinder at ({x:g}, {y:g}) lies off its field of "
            "4.5 x 9.6 m"
        )
    filled = np.zeros(BARN_SHAPE, np.uint8)
    filled[j, i] = 1
    name = path.name.partition(".")[0]
    return _barn(centres, filled, name, f"BARN world {path.name}")


def _barn(centres: F64, filled: U8, name: str, source: str) -> Occupancy:
    frame = Frame(cell=BARN_CELL, shape=BARN_SHAPE, origin=(BARN_WEST, 0.0))
    discs = np.column_stack([centres - frame.origin, np.full(len(centres), BARN_RADIUS)])
    return Occupancy(
        frame=frame, blocked=np.ascontiguousarray(filled), known=np.ones(BARN_SHAPE, np.uint8),
        discs=np.ascontiguousarray(discs), name=name, source=source,
    )  # fmt: skip


def _cylinders(path: Path) -> F64:
    """Centres (n, 2) [m] of the cylinders that stand in a Gazebo world."""
    from xml.etree import ElementTree

    text = _unpacked(path)
    if b"<!DOCTYPE" in text or b"<!ENTITY" in text:
        raise FileError(f"{path} declares its own entities, which no Gazebo world needs")
    try:
        root = ElementTree.parse(io.BytesIO(text)).getroot()
        models = [m for m in root.findall("./world/model") if m.find(".//cylinder") is not None]
        poses = [[float(n) for n in (m.findtext("pose") or "").split()[:2]] for m in models]
        centres = np.array(poses, np.float64)
    except (ElementTree.ParseError, ValueError, RecursionError) as error:
        raise FileError(f"{path} is no Gazebo world ({words_of(error)}); fetch it again") from None
    if centres.ndim != 2 or centres.shape[1:] != (2,) or not np.isfinite(centres).all():
        raise FileError(f"{path} has no cylinders with places; give a world of the BARN challenge")
    return centres


def _unpacked(path: Path) -> bytes:
    try:
        with path.open("rb") as file:
            packed = file.read(2) == b"\x1f\x8b"
            file.seek(0)
            stream: Any = gzip.GzipFile(fileobj=file) if packed else file
            text = stream.read(LARGEST_WORLD + 1)
    except (OSError, EOFError, zlib.error) as error:
        raise FileError(
            f"{path} is a damaged or cut-off world ({words_of(error)}); fetch it again"
        ) from None
    if len(text) > LARGEST_WORLD:
        raise FileError(f"{path} has more than {LARGEST_WORLD:,} bytes, which no BARN world has")
    return text
