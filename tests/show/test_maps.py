from __future__ import annotations

import dataclasses
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from rovernav.core import Frame, Outcome, ShapeError
from rovernav.rover import read_rover, standing
from rovernav.show import draw_drive, draw_terrain, relief_pixels
from rovernav.terrain import Terrain

from .pictures import Points, drive, pixels, share

MARS = 'PROJCS["Equirectangular MARS",GEOGCS["Mars"]]'


def hill_in_the_north(cell: float = 0.5, crs: str | None = None) -> Terrain:
    """20 x 20 cells, flat but for a hill before the north edge."""
    heights = np.zeros((20, 20))
    heights[14:18, 8:12] = 3.0 * cell
    frame = Frame(cell=cell, shape=(20, 20), origin=(100.0, 5000.0), crs=crs)
    return Terrain.from_heights(heights, frame, name="hill", source="test")


def test_north_is_up(tmp_path: Path) -> None:
    image = pixels(draw_terrain(hill_in_the_north(), tmp_path / "t.png"))
    assert image.shape == (962, 1378, 3)
    map_only = image[70:830, 160:930]
    yellow = map_only[..., 0] - map_only[..., 2] > 40  # the tint of high ground
    upper, lower = np.split(yellow, 2)
    assert upper.mean() > 0.02
    assert lower.mean() == 0.0


def test_forbidden_ground_is_drawn_where_it_is(tmp_path: Path) -> None:
    terrain = hill_in_the_north()
    ground = standing(terrain, read_rover("sojourner"))
    plain = pixels(draw_terrain(terrain, tmp_path / "t.png"))[70:830, 160:930]
    image = pixels(draw_terrain(terrain, tmp_path / "t.png", standing=ground))[70:830, 160:930]
    upper, lower = np.split((image != plain).any(axis=-1), 2)
    assert abs(upper.mean() / 2 - ground.share) < 0.03
    assert lower.mean() == 0.0
    other = standing(Terrain.from_heights(
        np.zeros((3, 3)), Frame(cell=1.0, shape=(3, 3)), name="x", source="x"
    ), read_rover("sojourner"))  # fmt: skip
    with pytest.raises(ShapeError, match=r"shape \(3, 3\), the terrain \(20, 20\)"):
        draw_terrain(terrain, tmp_path / "t.png", standing=other)


def test_a_drive_has_its_way_its_ends_and_the_same_bytes(tmp_path: Path) -> None:
    terrain = hill_in_the_north(crs=MARS)
    trace = drive([(2, 2), (4, 3), (6, 2), (7, 4)], Outcome.COLLIDED, goal=(8, 4))
    path = draw_drive(trace, tmp_path / "drive.png", terrain=terrain)
    first = path.read_bytes()
    image = pixels(path)
    assert image.shape == (962, 1430, 3)
    main = image[:, :1010]
    for colour in ("#443a83", "#21918c", "#8fd744"):  # viridis at 1/6, 1/2 and 5/6 of the time
        assert share(main, colour) > 2e-4
    assert share(main, "#D55E00") > 1e-4  # the cross
    assert draw_drive(trace, path, terrain=terrain).read_bytes() == first
    dots = np.array([[3.0, 4.0], [np.nan, np.nan], [5.0, 4.0]])
    assert draw_drive(trace, path, terrain=terrain, sensed=dots).read_bytes() != first
    with pytest.raises(ShapeError, match=r"must have shape \(m, 2\), got \(3,\)"):
        draw_drive(trace, path, terrain=terrain, sensed=np.zeros(3))


def test_a_drive_shows_its_route_and_where_the_rover_thought_it_was(tmp_path: Path) -> None:
    terrain = hill_in_the_north(crs=MARS)
    trace = drive([(2, 2), (4, 3), (6, 2), (7, 4)], Outcome.TIMED_OUT, goal=(8, 4))
    believed = np.zeros((3, 1, 7))
    believed[:, 0, :2] = [(2.0, 2.0), (4.0, 5.0), (6.5, 6.0)]
    lost = dataclasses.replace(trace, channels={"estimate": believed})
    ways = {"plain": (trace, None), "routed": (trace, np.array([[2.0, 2.0], [5.0, 7.0]])),
            "lost": (lost, None)}  # fmt: skip
    main = {
        name: pixels(draw_drive(one, tmp_path / f"{name}.png", terrain=terrain, route=way))[
            :, :1010
        ]
        for name, (one, way) in ways.items()
    }
    for name, colour in (("routed", "#0072B2"), ("lost", "#E69F00")):
        assert share(main[name], colour) > share(main["plain"], colour) + 1e-4
    with pytest.raises(ShapeError, match=r"route points must have shape \(m, 2\), got \(3,\)"):
        draw_drive(trace, tmp_path / "d.png", terrain=terrain, route=np.zeros(3))


@pytest.mark.parametrize(
    ("points", "outcome"),
    [
        ([(2.0, 5.0)], Outcome.DRIVING),  # not a step
        ([(2.0, 5.0), (2.0, 5.0)], Outcome.STUCK),
        ([(18.0, 5.0), (21.0, 12.0)], Outcome.LEFT_MAP),
        ([(18.0, 5.0), (np.nan, np.inf)], Outcome.LEFT_MAP),
        ([(1.0, 1.0), (19.0, 9.0)], Outcome.TIMED_OUT),  # all over the map
    ],
)
def test_drives_of_every_shape(tmp_path: Path, points: Points, outcome: Outcome) -> None:
    heights = np.zeros((20, 40))
    heights[:5] = np.nan
    frame = Frame(cell=0.5, shape=(20, 40))
    terrain = Terrain.from_heights(heights, frame, name="half known", source="test")
    ground = standing(terrain, read_rover("sojourner"))
    trace = drive(points, outcome, goal=(15.0, 5.0))
    path = draw_drive(trace, tmp_path / "d.png", terrain=terrain, standing=ground)
    assert pixels(path).shape == (962, 1430, 3)


def test_large_maps_are_thinned_out(tmp_path: Path) -> None:
    rows = np.arange(2600)[:, None] * np.ones((1, 40))
    frame = Frame(cell=1.0, shape=rows.shape)
    terrain = Terrain.from_heights(rows, frame, name="strip", source="test")
    ground = standing(terrain, read_rover("perseverance"))
    assert pixels(draw_terrain(terrain, tmp_path / "t.png", standing=ground)).shape[0] == 962


def test_importing_the_room_loads_no_plotting_library() -> None:
    code = "import sys, rovernav.show; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_the_ground_as_colours_is_north_up_and_shows_what_is_forbidden() -> None:
    terrain = hill_in_the_north()
    ground = standing(terrain, read_rover("sojourner"))
    plain, window = relief_pixels(terrain)
    assert (plain.shape, plain.dtype, window) == ((20, 20, 3), np.uint8, (0.0, 0.0, 10.0, 10.0))
    marked, _ = relief_pixels(terrain, standing=ground)
    changed = (plain != marked).any(axis=-1)
    assert np.array_equal(changed, (ground.reason != 0)[::-1])
    part, shown = relief_pixels(terrain, window=(2.0, 5.0, 6.0, 9.0))
    assert (part.shape, shown) == ((8, 8, 3), (2.0, 5.0, 6.0, 9.0))
    coarse, whole = relief_pixels(terrain, pixels=10)
    assert (coarse.shape, whole) == ((10, 10, 3), window)
