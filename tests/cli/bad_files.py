"""Files that no command can use, each wrong in one way."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from rovernav.learn import Training, paper_network, paper_training, save_training
from rovernav.nets import Card, Network, save_network
from tests.cli.runner import run, write_ground

TABLE = "in:x,in:y,out:u,out:v\n0,0,1,1\n0,1,1,-1\n"
ENDS = "from: [0, 0]\nto: [9, 0]\n"


def table(text: str | bytes = TABLE) -> None:
    raw = text if isinstance(text, bytes) else text.encode()
    Path("table.csv").write_bytes(raw)


def scenario(more: str = "", *, ends: str = ENDS) -> None:
    Path("drive.yaml").write_text(ends + more)


def rover(**changes: str) -> None:
    keys = {
        "name": "mine", "source": "a test", "drive": "two-axis", "length_m": "0.0",
        "width_m": "0.0", "wheel_radius_m": "0.0", "clearance_m": "0.2", "max_slope_deg": "20.0",
        "max_step_m": "0.2", "speed_m_s": "1.0", "step_m": "1.0",
    } | changes  # fmt: skip
    Path("rover.yaml").write_text("".join(f"{key}: {item}\n" for key, item in keys.items()))


def network(
    *,
    topology: tuple[int, ...] = (2, 3, 2),
    codec: dict[str, Any] | None = None,
    name: str = "net.safetensors",
    keep: float | None = None,
) -> None:
    names = ("sigmoid",) * (len(topology) - 2) + ("linear",)
    drawn = Network.seeded(topology, names, np.random.default_rng(0))
    save_network(drawn.with_card(Card(codec=codec)), Path(name))
    spoil(name, keep)


def spoil(path: str, keep: float | None) -> None:
    """Keep a share of a file's bytes, or with 1.0 all of them but with one bit turned."""
    if keep is not None:
        raw = bytearray(Path(path).read_bytes())
        raw[-1] ^= 1
        Path(path).write_bytes(raw[: int(keep * len(raw))])


def raw(path: str, data: bytes) -> None:
    Path(path).write_bytes(data)


def foreign_safetensors() -> None:
    from safetensors.numpy import save_file

    save_file({"a": np.zeros(3)}, "net.safetensors")


def checkpoint(keep: float | None = None) -> None:
    """An unfinished training of the paper's network."""
    _, patterns, settings = paper_training()
    save_training(Training.fresh(paper_network()), settings, patterns, Path("run.ckpt"))
    spoil("run.ckpt", keep)


def half_a_training() -> None:
    """A checkpoint after two epochs, and a file that is no trace of them."""
    table()
    words = ("--init", "paper", "--epochs", "2", "--checkpoint", "run.ckpt", "--out", "half")
    assert run("train", "bassil-v1", *words).code == 0


def trace(keep: float) -> None:
    assert run("drive", "bassil-v1", "--out", ".").code == 0
    spoil("trace.npz", keep)


def ground(*, keep: float | None = None, cells: tuple[float, ...] = (), **changes: Any) -> None:
    """An elevation model; see `write_ground` for what is right about it."""
    import rasterio

    if cells:
        a, b, d, e = cells
        changes["transform"] = rasterio.Affine(a, b, -7.0, d, e, 9.0)
    write_ground(Path("ground.tif"), **changes)
    spoil("ground.tif", keep)


def ground_of(height: float) -> None:
    """An elevation model with one height everywhere."""
    import rasterio

    ground(nodata=-9999.0)
    with rasterio.open("ground.tif", "r+") as file:
        file.write(np.full((40, 60), height, np.float32), 1)


def ground_in(unit: str) -> None:
    import rasterio

    ground()
    with rasterio.open("ground.tif", "r+") as file:
        file.units = (unit,)


def sized(shape: tuple[int, int]) -> None:
    """A GeoTIFF that says it has so many rows and columns, and holds none of them."""
    import rasterio

    tiled: dict[str, Any] = {"tiled": True, "blockxsize": 1024, "blockysize": 1024}
    profile: dict[str, Any] = {
        "driver": "GTiff", "count": 1, "dtype": "float32", "height": shape[0], "width": shape[1],
        "crs": "EPSG:32633", "transform": rasterio.Affine(0.5, 0.0, -7.0, 0.0, -0.5, 9.0),
        "SPARSE_OK": True, "BIGTIFF": "YES", **(tiled if min(shape) > 1024 else {}),
    }  # fmt: skip
    with rasterio.open("ground.tif", "w", **profile):
        pass


def zone(ring: list[list[float]]) -> None:
    """An elevation model and one zone in its own coordinates."""
    ground()
    crs = {"type": "name", "properties": {"name": "EPSG:32633"}}
    polygon = {"type": "Polygon", "coordinates": [ring], "crs": crs}
    Path("zone.json").write_text(json.dumps(polygon))


def array(heights: Any) -> None:
    np.save("ground.npy", heights, allow_pickle=True)


def picture(path: str) -> None:
    """A grey picture."""
    import warnings

    import rasterio

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # it has no coordinates
        profile: dict[str, Any] = {"count": 1, "dtype": "uint8", "width": 5, "height": 4}
        with rasterio.open(path, "w", driver="PNG", **profile) as file:
            file.write(np.zeros((4, 5), np.uint8), 1)
