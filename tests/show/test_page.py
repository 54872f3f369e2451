from __future__ import annotations

import base64
import dataclasses
import io
import json
import re
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from PIL import Image

from rovernav.core import Frame, InputError
from rovernav.rover import read_rover
from rovernav.show import surface_of, write_page
from rovernav.sim import Shape, Trace, Worlds, simulate
from rovernav.terrain import Terrain
from tests.sim.drives import Always, drive
from tests.studio.browser import browsing

STARTS = ((1.0, 2.0, 0.0), (1.0, 9.0, -0.5))
SHAPES = (Shape.disc(6.0, 4.0, 0.7), Shape.polygon([(3, 7), (5, 7), (5, 8), (4, 7.4)]))
HOSTILE = '</script><b id="x">&$_{name}'


@pytest.fixture
def terrain() -> Terrain:
    """A dome with a hole in it, 12 m to the north and 20 m to the east."""
    frame = Frame(cell=0.5, shape=(24, 40))
    row, column = np.mgrid[:24, :40]
    heights = -2600.0 + 2.0 * np.sin(row / 23 * np.pi) * np.sin(column / 39 * np.pi)
    heights[3:6, 30:34] = np.nan
    return Terrain.from_heights(heights, frame, name=HOSTILE, source="a test")


def driven(**more: Any) -> tuple[Trace, Worlds]:
    worlds = Worlds.single([(9, 9, 10, 11)], bounds=(0, 0, 20, 12), shapes=SHAPES, rovers=2)
    set_up = drive(Always(0.4, 0.1, 0.0), starts=STARTS, goal=(15.0, 5.0), limit=20.0)
    return simulate(type(set_up)(
        worlds=worlds, mission=set_up.mission, sensors=(), controller=set_up.controller,
        motion=set_up.motion,
    ), **more), worlds  # fmt: skip


def data_of(path: Path) -> dict[str, Any]:
    found = re.search(r'<script id="data" type="application/json">(.*?)</script>', path.read_text())
    assert found is not None
    return json.loads(found[1])


def numbers(text: str, dtype: str) -> np.ndarray:
    return np.frombuffer(base64.b64decode(text), dtype)


def test_the_page_holds_the_drive_and_the_ground(terrain: Terrain, tmp_path: Path) -> None:
    trace, worlds = driven()
    path = write_page(
        trace, tmp_path / "d.html", terrain=terrain, worlds=worlds, rover=read_rover("research")
    )
    data = data_of(path)
    assert data["title"] == HOSTILE
    assert data["words"].startswith("2 drives; the first ")
    for k, one in enumerate(data["rovers"]):
        poses = numbers(one["poses"], "<f4").reshape(one["count"], 7)
        assert_allclose(poses[:, 1:3], trace.path(k), rtol=0, atol=1e-5)
        z = np.nan_to_num(terrain.elevation_at(*trace.path(k).T) - terrain.span[0])
        assert_allclose(poses[:, 3], z, rtol=0, atol=1e-3)
        assert_allclose(poses[:, 4], trace.pose[: one["count"], k, 2], atol=1e-6)
        assert not poses[:, 5:].any()
    ground = data["ground"]
    levels = numbers(ground["z"], "<u2").reshape(ground["size"][::-1]).astype(float)
    west, south, east, north = ground["window"]
    columns, rows = ground["size"]
    x, y = np.meshgrid(np.linspace(west, east, columns), np.linspace(north, south, rows))
    wanted = terrain.elevation_at(x, y) - terrain.span[0]
    assert np.array_equal(np.isnan(wanted), levels == 65535)
    got = ground["low"] + levels / 65534 * (ground["high"] - ground["low"])
    known = np.isfinite(wanted)
    assert not known.all()
    assert_allclose(got[known], wanted[known], rtol=0, atol=1e-4)
    image = Image.open(io.BytesIO(base64.b64decode(ground["image"].split(",")[1])))
    assert image.mode == "RGB"
    corners = [np.array(one["xy"]) for one in data["obstacles"]]
    assert_allclose(corners[0], [[9, 9], [10, 9], [10, 11], [9, 11]])
    assert len(corners) == 3
    assert_allclose(np.hypot(*(corners[1] - (6.0, 4.0)).T), 0.7, atol=1e-3)
    assert data["ends"][1]["goal"][:2] == [15.0, 5.0]


def test_a_body_has_its_pitch_and_roll(tmp_path: Path) -> None:
    trace, worlds = driven()
    attitude = np.random.default_rng(0).normal(0.0, 0.2, (*trace.time.shape, 3))
    trace = dataclasses.replace(trace, attitude=attitude)
    one = data_of(write_page(trace, tmp_path / "d.html", worlds=worlds))["rovers"][1]
    poses = numbers(one["poses"], "<f4").reshape(one["count"], 7)
    assert_allclose(poses[:, 5:], attitude[: one["count"], 1, 1:], rtol=0, atol=1e-6)


def test_only_drives_of_one_world_share_a_page(tmp_path: Path) -> None:
    trace, worlds = driven()
    apart = Worlds(
        boxes=np.zeros((0, 4)), offsets=np.zeros(3, np.int64), of=np.array([0, 1]),
        bounds=np.array([[0.0, 0, 20, 12]] * 2),
    )  # fmt: skip
    assert len(data_of(write_page(trace, tmp_path / "a.html", worlds=worlds))["rovers"]) == 2
    assert len(data_of(write_page(trace, tmp_path / "b.html", worlds=apart))["rovers"]) == 1


def test_a_page_asks_for_nothing_and_names_nothing_elsewhere(tmp_path: Path) -> None:
    text = write_page(driven()[0], tmp_path / "a.html").read_text()
    assert "http" not in text.replace('http-equiv="Content-Security-Policy"', "")
    assert "default-src 'none'" in text


def test_ends_alone_are_no_page(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="kept no path to draw"):
        write_page(driven(record="none")[0], tmp_path / "a.html")


def test_a_surface_covers_its_window_to_the_edge(terrain: Terrain) -> None:
    found = surface_of(terrain, points=7, pixels=7)
    assert found.x.tolist()[:: len(found.x) - 1] == [0.0, 20.0]
    assert found.y.tolist()[:: len(found.y) - 1] == [12.0, 0.0]
    x, y = np.meshgrid(found.x, found.y)
    assert np.array_equal(found.z, terrain.elevation_at(x, y) - terrain.span[0], equal_nan=True)


def until(true: Callable[[], bool]) -> None:
    """Wait, at most a minute; the page forbids the browser's own waiting, which evaluates text."""
    end = time.monotonic() + 60.0
    while not true():
        assert time.monotonic() < end
        time.sleep(0.05)


def pixels(page: Any) -> np.ndarray:
    return np.asarray(Image.open(io.BytesIO(page.screenshot())).convert("RGB")).astype(int)


def test_it_opens_from_a_folder_turns_and_plays(terrain: Terrain, tmp_path: Path) -> None:
    trace, worlds = driven()
    path = write_page(trace, tmp_path / "d.html", terrain=terrain, worlds=worlds)
    with browsing() as browser:
        page = browser.new_context(viewport={"width": 800, "height": 500}).new_page()
        asked: list[str] = []
        wrong: list[str] = []
        page.on("request", lambda request: asked.append(request.url))
        page.on("pageerror", lambda error: wrong.append(str(error)))
        page.goto(path.as_uri())
        page.locator("body[data-ready=yes]").wait_for(timeout=60_000)
        page.get_by_role("button", name="Pause").click()
        assert page.inner_text("h1") == HOSTILE
        assert page.locator("#x").count() == 0
        first = pixels(page)
        assert len(np.unique(first[100:400].reshape(-1, 3), axis=0)) > 300  # relief is drawn
        page.mouse.move(400, 250)
        page.mouse.down()
        page.mouse.move(520, 200, steps=3)
        page.mouse.up()
        turned = pixels(page)
        assert (first != turned).any(axis=2).mean() > 0.2
        page.mouse.wheel(0, -400)
        near = f"JSON.parse(document.body.dataset.camera).far < {_far(page)}"
        until(lambda: page.evaluate(near))
        assert (pixels(page) != turned).any(axis=2).mean() > 0.2
        before = page.inner_text("#clock")
        page.get_by_role("button", name="Play").click()
        until(lambda: page.inner_text("#clock") != before)
        assert wrong == []
        assert [url for url in asked if not url.startswith(("file:", "data:"))] == []


def _far(page: Any) -> float:
    """How far the camera begins; coming closer takes it below."""
    west, south, east, north = page.evaluate("data.ground.window")
    return 1.45 * max(east - west, north - south) - 1e-6
