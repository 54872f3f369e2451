"""Whatever a file holds, a reader returns a value or raises one sentence of ours."""

from __future__ import annotations

import json
import math
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from safetensors.numpy import load, save

from rovernav.core import RovernavError, canonical_json, read_yaml, sha256_of
from rovernav.learn import (
    OnlineSettings,
    Training,
    load_training,
    paper_network,
    read_patterns,
    save_training,
    shipped_patterns,
)
from rovernav.nets import load_network, save_network
from rovernav.terrain import (
    open_raster,
    quality,
    read_occupancy,
    read_recipe,
    read_terrain,
    recipe_of,
)
from tests.terrain.test_formats import pds3

TABLE, ONLINE = shipped_patterns("bassil-v1"), OnlineSettings()


def ground(path: Path, **given: Any) -> Any:
    """Read elevations, and judge them; what is large is only opened."""
    raster = open_raster(path, **given)
    return quality(read_terrain(path, **given)) if math.prod(raster.frame.shape) < 1e6 else raster


READERS: dict[str, Callable[[Path], Any]] = {
    "network": load_network,
    "training": lambda path: load_training(path, ONLINE, TABLE),
    "patterns": read_patterns,
    "patterns of two inputs": lambda path: read_patterns(path, inputs=2),
    "yaml": lambda path: read_yaml(path, what="scenario file"),
    "geotiff": ground,
    "ascii grid": ground,
    "table": lambda path: ground(path, cell=1.0),
    "array": lambda path: ground(path, cell=1.0),
    "archive": ground,
    "png": lambda path: ground(path, cell=1.0, heights=(0.0, 9.0)),
    "pds3": ground,
    "isis": ground,
    "pds4": ground,
    "recipe": lambda path: recipe_of(read_recipe(path), source="the file"),
    "world": read_occupancy,
    "worlds": lambda path: read_occupancy(path, world=5),
}
GROUND: dict[str, tuple[str, dict[str, Any]]] = {
    "geotiff": ("GTiff", {"crs": "EPSG:32630"}), "ascii grid": ("AAIGrid", {}), "png": ("PNG", {}),
    "isis": ("ISIS3", {"crs": "EPSG:32630"}), "pds4": ("PDS4", {"crs": "EPSG:32630"}),
}  # fmt: skip
CSV = b'# c\nin:a,"in:b",out:c\n1,2.5e-3,-4\n.5,"6",7\n'
YAML = b"a: 1e-3\nb: [no, 010, {c: 'x'}]\n? d\n: |\n  text\ne: &f *f\ng: !!int 3\n2012-11-26: ~\n"
RECIPE = b"size_m: [20, 20]\nrelief: {hurst: 0.7}\ncraters: {body: mars}\nrocks: 0.05\n"
WORLD = (
    b"<sdf version='1.6'><world name='w'><model name='c'><pose>-1 1 0 0 0 0</pose><link>"
    b"<collision><geometry><cylinder/></geometry></collision></link></model></world></sdf>"
)
TEXTS = {"yaml": YAML, "recipe": RECIPE, "world": WORLD, "table": b"1 2 3\n4 5 6\n7 8 9.5\n"}
WORDS = [b"\0", b"\xff", b"\xef\xbb\xbf", b"\r", b"\n", b'"', b"'", b",", b"#", b"[", b"{", b"NaN",
         b"1e999", b"_", b"-", b"null", b": ", b"!!float ''", b"!!set {a}", b"&a ", b"*a", b"<<: ",
         b"9" * 30, b"\xf0\x9f\x9a\x99", b"\\ud800"]  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("fuzz")


def whole(name: str, folder: Path) -> bytes:
    """A file that the reader takes."""
    path = folder / "whole"
    if name == "network":
        save_network(paper_network(), path)
        return path.read_bytes()
    if name == "training":
        save_training(Training.fresh(paper_network()), ONLINE, TABLE, path)
        return path.read_bytes()
    if name in GROUND:
        return gdal_file(name, folder)
    if name in ("array", "archive", "worlds"):
        return arrays(name, path)
    if name == "pds3":
        return pds3(folder).read_bytes()
    return TEXTS.get(name, CSV)


def gdal_file(name: str, folder: Path) -> bytes:
    import rasterio
    import rasterio.shutil

    driver, more = GROUND[name]
    z = np.arange(30).reshape(5, 6).astype(np.uint8 if name == "png" else np.float32)
    place: dict[str, Any] = (
        {} if name == "png" else {"transform": rasterio.Affine(2, 0, 4e5, 0, -2, 4e6)}
    )
    path = folder / ("whole.xml" if name == "pds4" else "whole.x")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # pictures have no coordinates
        if driver in ("AAIGrid", "PNG"):  # these can only be copied
            with rasterio.MemoryFile() as memory:
                with memory.open(driver="GTiff", width=6, height=5, count=1, dtype=z.dtype,
                                 **place) as data:  # fmt: skip
                    data.write(z, 1)
                rasterio.shutil.copy(memory.name, path, driver=driver)
        else:
            with rasterio.open(path, "w", driver=driver, width=6, height=5, count=1,
                               dtype=z.dtype, **place, **more) as data:  # fmt: skip
                data.write(z, 1)
    return path.read_bytes()


def arrays(name: str, path: Path) -> bytes:
    z = np.arange(30.0).reshape(5, 6)
    with path.open("wb") as file:
        if name == "array":
            np.save(file, z)
        elif name == "archive":
            np.savez(file, elevation=z, cell=2.0)
        else:
            np.savez(file, world_ids=np.array([0, 5]), cyl_005=np.array([[-1.0, 1.0]]),
                     grid_005=np.zeros((30, 64), np.uint8))  # fmt: skip
    return path.read_bytes()


def check(name: str, folder: Path, content: bytes) -> None:
    path = folder / "file"
    path.with_name("file.aux.xml").unlink(missing_ok=True)  # GDAL reads it, if it lies there
    path.write_bytes(content)
    try:
        READERS[name](path)
    except RovernavError as error:
        said = str(error)
        if ("file" not in said and "too little" not in said) or "\n" in said or len(said) > 600:
            pytest.fail(f"not one short sentence that names the file: {said}")


@st.composite
def damaged(draw: st.DrawFn, content: bytes) -> bytes:
    """`content` with a few bytes changed, dropped, repeated or put in."""
    data = bytearray(content)
    for _ in range(draw(st.integers(1, 4))):
        a, b = sorted(draw(st.tuples(*[st.integers(0, len(data))] * 2)))
        new = draw(st.sampled_from(WORDS) | st.binary(max_size=3) | st.just(bytes(data[a:b]) * 2))
        data[a : draw(st.sampled_from([a, a + 1, b]))] = new
    return bytes(data)


few = settings(
    max_examples=80, derandomize=True, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
many = settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
each_reader = pytest.mark.parametrize("name", READERS)


def try_bytes(data: st.DataObject, name: str, folder: Path) -> None:
    content = data.draw(st.binary(max_size=200) | damaged(whole(name, folder)))
    check(name, folder, content)


@each_reader
@few
@given(data=st.data())
def test_damaged_files(data: st.DataObject, name: str, folder: Path) -> None:
    try_bytes(data, name, folder)


@pytest.mark.long
@each_reader
@many
@given(data=st.data())
def test_damaged_files_at_length(data: st.DataObject, name: str, folder: Path) -> None:
    try_bytes(data, name, folder)


numbers = st.integers(-2, 5) | st.just(10**30) | st.floats()
json_values = st.recursive(
    st.none() | st.booleans() | numbers | st.text(max_size=4),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner),
    max_leaves=6,
)
tensors = st.sampled_from(
    [np.zeros(17), np.zeros(17, np.float32), np.zeros(3), np.zeros((17, 1)), np.zeros(17, int)]
)


def try_headers(data: st.DataObject, name: str, folder: Path) -> None:
    """Fields replaced at will under a hash that fits."""
    content = whole(name, folder)
    outer = json.loads(content[8 : 8 + int.from_bytes(content[:8], "little")])
    header = json.loads(outer["__metadata__"]["rovernav"])
    arrays = load(content)
    del header["sha256"]
    for field in data.draw(st.lists(st.sampled_from(sorted(header)), min_size=1, max_size=3)):
        header[field] = data.draw(json_values)
    if data.draw(st.booleans()):
        arrays[data.draw(st.sampled_from(sorted(arrays)))] = data.draw(tensors)
    text = json.dumps(header, sort_keys=True, separators=(",", ":"))
    parts = [arrays[key].tobytes() for key in ("parameters", "deltas") if key in arrays]
    header["sha256"] = sha256_of(text.encode(), *parts)
    check(name, folder, save(arrays, {"rovernav": json.dumps(header)}))


with_header = pytest.mark.parametrize("name", ["network"])


@with_header
@few
@given(data=st.data())
def test_forged_headers(data: st.DataObject, name: str, folder: Path) -> None:
    try_headers(data, name, folder)


@pytest.mark.long
@with_header
@many
@given(data=st.data())
def test_forged_headers_at_length(data: st.DataObject, name: str, folder: Path) -> None:
    try_headers(data, name, folder)


@with_header
def test_the_forger_can_write_a_file_that_is_read(name: str, folder: Path) -> None:
    content = whole(name, folder)
    outer = json.loads(content[8 : 8 + int.from_bytes(content[:8], "little")])
    header = json.loads(outer["__metadata__"]["rovernav"])
    digest = header.pop("sha256")
    arrays = load(content)
    parts = [arrays[key].tobytes() for key in ("parameters", "deltas") if key in arrays]
    assert digest == sha256_of(canonical_json(header).encode(), *parts)
