"""Routes over rasters planned in blocks and stretches, against planning over all cells at once."""

from __future__ import annotations

import dataclasses
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import ndimage

from rovernav import plan
from rovernav.cli import _trip
from rovernav.core import FileError, InputError, SettingError
from rovernav.plan import Errand, travel_far
from rovernav.rover import Rover, hazards, read_rover, standing
from rovernav.terrain import Raster, open_raster
from tests.cli.runner import run, tell

CELL = 2.0


@pytest.fixture(scope="module")
def who() -> Rover:
    return read_rover("research")


def raster_of(folder: Path, heights: np.ndarray) -> Raster:
    np.save(folder / "ground.npy", np.flipud(heights).astype(np.float32))
    return open_raster(folder / "ground.npy", cell=CELL)


def fractal(n: int, rng: np.random.Generator) -> np.ndarray:
    """Self-affine hills, about a fifth of them too steep."""
    spectrum = np.fft.rfft2(rng.normal(size=(n, n)))
    k = np.hypot(np.fft.fftfreq(n)[:, None], np.fft.rfftfreq(n)[None])
    k[0, 0] = 1.0
    z = np.fft.irfft2(spectrum * k**-1.8, (n, n))
    south, east = np.gradient(z)
    return 0.22 * z / np.hypot(south, east).std()


def discs(n: int, rng: np.random.Generator) -> np.ndarray:
    """Holes of 2 to 8 cells' radius."""
    y, x = np.mgrid[:n, :n]
    z = np.zeros((n, n))
    for i, j, r in zip(*rng.integers(0, n, (2, n * n // 600)), rng.integers(2, 9, n), strict=False):
        z[(y - i) ** 2 + (x - j) ** 2 <= r * r] = np.nan
    return z


def maze(n: int, rng: np.random.Generator, wide: int = 32, wall: int = 5) -> np.ndarray:
    """Every room has a door to the one before it in a random walk, and some have more."""
    rooms, z = n // wide, np.zeros((n, n))
    east, north = np.ones((2, rooms, rooms), bool)
    seen, stack = {(0, 0)}, [(0, 0)]
    while stack:
        i, j = stack[-1]
        near = [(i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)]
        near = [p for p in near if p not in seen and min(p) >= 0 and max(p) < rooms]
        if not near:
            stack.pop()
            continue
        a, b = near[rng.integers(len(near))]
        seen.add((a, b))
        stack.append((a, b))
        if a == i:
            east[i, min(j, b)] = False
        else:
            north[min(i, a), j] = False
    for i, j in np.ndindex(rooms, rooms):
        if east[i, j] and rng.random() > 0.1:
            z[i * wide : (i + 1) * wide + wall, (j + 1) * wide : (j + 1) * wide + wall] = np.nan
        if north[i, j] and rng.random() > 0.1:
            z[(i + 1) * wide : (i + 1) * wide + wall, j * wide : (j + 1) * wide + wall] = np.nan
    return z


def walls(n: int, _rng: np.random.Generator) -> np.ndarray:
    """Two walls as thin as a post, that blocks of cells do not show."""
    z = np.zeros((n, n))
    z[: int(0.9 * n), n // 2] = np.nan
    z[int(0.2 * n) :, n // 3] = np.nan
    return z


def pieces(free: Any) -> np.ndarray:
    """Number of the piece that each cell belongs to, 0 where there is none."""
    found: Any = ndimage.label(free)
    return found[0]


def ends_on(ground: plan.Going) -> Any:
    """Places near two corners, in the largest piece of free ground."""
    labels = pieces(ground.blocked == 0)
    free = np.argwhere(labels == np.bincount(labels.ravel())[1:].argmax() + 1)
    n = ground.frame.shape[0]
    return tuple(
        tuple((free[((free - share * n) ** 2).sum(axis=1).argmin()][::-1] + 0.5) * CELL)
        for share in (0.07, 0.93)
    )


@pytest.mark.parametrize(
    ("kind", "block"), [(fractal, 8), (fractal, 16), (discs, 12), (maze, 8), (maze, 16), (walls, 9)]
)
def test_as_short_as_over_all_cells_at_once(
    tmp_path: Path, who: Rover, kind: Any, block: int
) -> None:
    raster = raster_of(tmp_path, kind(768, np.random.default_rng(5)))
    ground = plan.going(hazards(raster.read(), who), who)
    start, goal = ends_on(ground)
    best = plan.directed(ground, start, goal)
    trip = travel_far(Errand(raster, who), [start, goal], block=block, stretch=200.0)
    assert trip.found
    assert trip.length <= 1.02 * best.length
    np.testing.assert_allclose(trip.points[[0, -1]], [start, goal])
    np.testing.assert_allclose(ground.cost_of(trip.points), trip.length, rtol=1e-9)
    (told,) = trip.account()
    assert math.isclose(told["length"], trip.length, rel_tol=1e-9)
    assert math.isclose(told["time"], ground.by("time").cost_of(trip.points), rel_tol=1e-9)
    assert told["steepest"] <= who.max_slope
    assert trip.far is not None
    assert trip.far.stations is not None
    np.testing.assert_allclose(trip.far.stations.distance[-1], trip.length, rtol=1e-9)
    assert (np.diff(trip.far.stations.distance) >= -1e-9).all()
    heights = raster.read().elevation_at(*trip.points.T)
    assert trip.heights is not None
    np.testing.assert_allclose(trip.heights, heights, atol=1e-3)


def test_a_way_through_a_froth_is_found(tmp_path: Path, who: Rover) -> None:
    z = np.zeros((1400, 1400))
    z[np.random.default_rng(5).random(z.shape) < 0.085] = np.nan  # forbids 55 % of all cells
    raster = raster_of(tmp_path, z)
    start, goal = ends_on(plan.going(hazards(raster.read(), who), who))
    trip = travel_far(Errand(raster, who), [start, goal], block=10, stretch=400.0)
    assert trip.found


def test_least_energy_is_about_that_over_all_cells(tmp_path: Path, who: Rover) -> None:
    raster = raster_of(tmp_path, fractal(240, np.random.default_rng(2)))
    ground = plan.going(hazards(raster.read(), who), who, objective="energy")
    start, goal = ends_on(ground)
    best = plan.directed(ground, start, goal)
    errand = Errand(raster, who, "energy")
    trip = travel_far(errand, [start, goal], block=8, stretch=80.0)
    assert trip.cost <= 1.02 * best.cost
    assert math.isclose(trip.cost, ground.cost_of(trip.points), rel_tol=1e-9)
    assert math.isclose(sum(trip.account()[0]["terms"].values()), trip.cost, rel_tol=1e-9)
    why = plan.why_far(errand, trip.points, (240.0, 240.0))
    plainly = plan.why_here(ground, trip.points, (240.0, 240.0))
    np.testing.assert_allclose(why["at"], plainly["at"])
    assert why["per_metre"] == pytest.approx(plainly["per_metre"])
    assert math.isclose(why["distance"], plainly["distance"], rel_tol=1e-9)


@pytest.mark.parametrize("name", ["research", "perseverance"])
@pytest.mark.parametrize("chunk", [1, 30, 10**4])
def test_a_survey_says_of_blocks_what_their_cells_say(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, chunk: int
) -> None:
    rng = np.random.default_rng(3)
    z = 0.7 * fractal(101, rng)[:, :90]
    z[40:60, 20:30] = np.nan
    monkeypatch.setattr("rovernav.plan._lookout.CHUNK", chunk)
    raster, rover = raster_of(tmp_path, z), read_rover(name)
    found, free = plan.survey(raster, rover, block=7), standing(raster.read(), rover).blocked == 0
    assert found.share.shape == (15, 13)
    for i, j in np.ndindex(15, 13):
        here = free[7 * i : 7 * i + 7, 7 * j : 7 * j + 7]
        assert math.isclose(found.share[i, j], here.mean(), abs_tol=1e-6)
        if j < 12:
            both = free[7 * i : 7 * i + 7, 7 * j : 7 * j + 14]
            assert found.east[i, j] in _borders(both, 1)
        if i < 14:
            both = free[7 * i : 7 * i + 14, 7 * j : 7 * j + 7]
            assert found.north[i, j] in _borders(both, 0)
    assert math.isclose(found.free, free.mean())


def _borders(both: np.ndarray, axis: int) -> set[int]:
    """What a border may say: 1 where free cells face each other, 2 where the largest pieces do.

    Pieces of the same size leave a choice.
    """
    halves = np.moveaxis(both, axis, 0)[:7], np.moveaxis(both, axis, 0)[7:]
    edges = halves[0][-1], halves[1][0]
    meets = int((edges[0] & edges[1]).any())
    largest = []
    for half, row in zip(halves, (-1, 0), strict=True):
        labels = pieces(half)
        sizes = np.bincount(labels.ravel(), minlength=labels.max() + 1)[1:]
        chosen = [n + 1 for n in np.flatnonzero(sizes == sizes.max(initial=0))]
        largest.append([labels[row] == n for n in chosen])
    return {meets + 2 * int((a & b).any()) for a in largest[0] for b in largest[1]} or {meets}


def test_only_ground_where_shorter_ways_may_run_is_looked_at(
    tmp_path: Path, who: Rover, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rovernav.plan._lookout.CHUNK", 32)
    for room in ("_lookout", "_lines"):
        monkeypatch.setattr(f"rovernav.plan.{room}.AROUND", 8.0)
    z = np.zeros((600, 600))
    ends = [(40.0, 600.0), (1160.0, 600.0)]
    errand = Errand(raster_of(tmp_path, z), who)
    trip = travel_far(errand, ends, block=8, stretch=200.0)
    assert math.isclose(trip.length, 1120.0, rel_tol=1e-5)
    assert 0.05 < trip.looked < 0.25
    assert trip.forbidden == 0.0
    # a wall across the way; its short end lies beyond what is looked at first
    z[80:400, 300] = np.nan
    trip = travel_far(Errand(raster_of(tmp_path, z), who), ends, block=8, stretch=200.0)
    north = math.hypot(560.0, 200.0) + math.hypot(560.0, 200.0)
    assert math.isclose(trip.length, north, rel_tol=0.01)
    assert 0.3 < trip.looked < 1.0
    # nothing shorter is missed, and what is proven needs not all of the map
    z[:, 299:302] = np.nan
    z[500:510, 299:302] = 0.0
    trip = travel_far(Errand(raster_of(tmp_path, z), who), ends, block=8, stretch=200.0)
    assert trip.found
    assert (trip.points[:, 1].max() - 1000.0) < 20.0
    z[:] = 0.0
    z[280:320, 560:562] = z[280:320, 600:602] = np.nan
    z[280:282, 560:602] = z[318:320, 560:602] = np.nan
    trip = travel_far(Errand(raster_of(tmp_path, z), who), ends, block=8, stretch=200.0)
    assert trip.legs[0].way is plan.Way.GOAL_ENCLOSED
    assert trip.looked < 0.5


@pytest.mark.parametrize("threads", [1, 5])
def test_the_same_bits_whatever_the_threads(
    tmp_path: Path, who: Rover, monkeypatch: pytest.MonkeyPatch, threads: int
) -> None:
    raster = raster_of(tmp_path, fractal(500, np.random.default_rng(5)))
    ends = ends_on(plan.going(hazards(raster.read(), who), who))
    monkeypatch.setattr("rovernav.plan._lookout.CHUNK", 64)
    usual = travel_far(Errand(raster, who), ends, block=8, stretch=100.0)
    monkeypatch.setattr("rovernav.plan._lookout.THREADS", threads)
    other = travel_far(Errand(raster, who), ends, block=8, stretch=100.0)
    np.testing.assert_array_equal(usual.points, other.points)
    assert usual.account() == other.account()


def ringed(n: int, rise: tuple[float, float]) -> np.ndarray:
    """A plain with a bank around its middle, less steep on one side."""
    y, x = np.mgrid[:n, :n] - n / 2.0
    off = np.hypot(x, y)
    steep = np.where(x < -0.8 * off, *rise)
    return CELL * steep * np.clip(off - 0.2 * n, 0.0, 12.0)


def test_which_limit_stands_in_a_far_way(tmp_path: Path, who: Rover) -> None:
    who = dataclasses.replace(who, mobility=None)  # limits by direction come on top
    gentle, steep = np.tan(who.max_slope + 0.1), np.tan(who.max_slope + 0.3)
    raster = raster_of(tmp_path, ringed(400, (gentle, steep)))
    stops = [(400.0, 400.0), (760.0, 420.0)]
    trip = travel_far(Errand(raster, who), stops, block=8, stretch=100.0)
    assert trip.status == "unreachable"
    assert "forbidden ground encloses the start" in trip.reason
    least = trip.barriers[0]
    assert least.limit == "slope"
    assert who.max_slope + 0.05 < least.needed < who.max_slope + 0.32
    assert least.at is not None
    assert 150.0 < math.hypot(least.at[0] - 400.0, least.at[1] - 400.0) < 200.0
    assert least.words in trip.reason
    assert "along the line with the least forbidden ground" in least.words
    assert f"rises from {math.degrees(who.max_slope):.2f} deg to" in least.words
    lower = dataclasses.replace(who, max_slope=0.99 * who.max_slope + 0.01 * least.needed)
    assert not travel_far(Errand(raster, lower), stops, block=8, stretch=100.0).found
    eased = dataclasses.replace(who, max_slope=1.001 * least.needed)
    assert travel_far(Errand(raster, eased), stops, block=8, stretch=100.0).found


def test_a_limit_is_named_across_ground_wider_than_what_is_looked_at(
    tmp_path: Path, who: Rover
) -> None:
    who = dataclasses.replace(who, mobility=None)
    rise = CELL * np.tan(who.max_slope + 0.1)
    z = np.tile(rise * np.clip(np.arange(1500) - 400.0, 0.0, 700.0), (60, 1))
    stops = [(20.0, 60.0), (2980.0, 60.0)]
    trip = travel_far(Errand(raster_of(tmp_path, z), who), stops, block=8, stretch=300.0)
    assert trip.status == "unreachable"
    assert trip.barriers[0].limit == "slope"
    assert abs(trip.barriers[0].needed - who.max_slope - 0.1) < 0.01


def test_zones_and_holes_stand_in_a_far_way(tmp_path: Path, who: Rover) -> None:
    import shapely

    raster, stops = raster_of(tmp_path, np.zeros((300, 300))), [(60.0, 300.0), (540.0, 310.0)]
    wall = shapely.box(295.0, -10.0, 305.0, 700.0)
    for margin in (0.0, 20.0):
        zones = plan.Zones(avoid=wall, margin=margin)
        trip = travel_far(Errand(raster, who, zones=zones), stops, block=8, stretch=60.0)
        (only,) = trip.barriers
        assert (only.limit, only.unit) == ("zone", "")
        assert "a way opens if the zones are lifted" in trip.reason
    zones = plan.Zones(avoid=shapely.union_all([
        shapely.box(295.0, -10.0, 305.0, 290.0), shapely.box(295.0, 310.0, 305.0, 700.0)
    ]), margin=15.0)  # fmt: skip
    trip = travel_far(Errand(raster, who, zones=zones), stops, block=8, stretch=60.0)
    (only,) = trip.barriers
    assert only.limit == "margin"
    assert 5.0 < only.needed < 10.0
    z = np.zeros((300, 300))
    z[:, 148:152] = np.nan
    trip = travel_far(Errand(raster_of(tmp_path, z), who), stops, block=8, stretch=60.0)
    (only,) = trip.barriers
    assert only.limit == "no data"
    assert only.at is not None
    assert abs(only.at[0] - 300.0) < 10.0
    # a hole in one place, a bank in another
    z[:, 60:66] = 3.0 * np.arange(6)
    z[:, 66:] += 18.0
    trip = travel_far(Errand(raster_of(tmp_path, z), who), stops, block=8, stretch=60.0)
    (only,) = trip.barriers
    assert only.limit in ("slope and no data", "slope and step and no data")
    assert "no single limit opens a way: " in only.words
    away = travel_far(Errand(raster, who), [stops[0], (700.0, 3.0)], block=8)
    assert away.barriers == ()


def test_that_there_is_no_way_is_an_answer(tmp_path: Path, who: Rover) -> None:
    z = np.zeros((300, 300))
    z[:, 148:152] = np.nan
    raster = raster_of(tmp_path, z)
    errand = Errand(raster, who)
    trip = travel_far(errand, [(50.0, 60.0), (550.0, 300.0)], block=8, stretch=60.0)
    assert trip.status == "unreachable"
    assert trip.legs[0].way is plan.Way.GOAL_ENCLOSED or trip.legs[0].way is plan.Way.START_ENCLOSED
    assert "forbidden ground encloses the" in trip.reason
    assert trip.nearest is not None
    assert abs(trip.nearest[0] - 290.0) < 20.0
    assert abs(trip.nearest[1] - 300.0) < 20.0
    assert trip.far is not None
    assert trip.far.stations is None
    for ends, said in (
        ([(50.0, 60.0), (600.5, 3.0)], "the goal (600.5, 3) m lies beyond the map, which is 600 m"),
        ([(-1.0, 60.0), (500.0, 3.0)], "the start (-1, 60) m lies beyond the map"),
        ([(300.0, 60.0), (500.0, 3.0)], " m away; a height is missing there"),
        ([(300.0, 60.0), (500.0, 3.0)], "the start (300, 60) m touches forbidden ground; the near"),
        ([(50.0, 60.0), (300.0, 60.0)], "the goal (300, 60) m touches forbidden ground; the near"),
    ):
        assert said in travel_far(errand, ends, block=8).reason


def test_a_hole_larger_than_what_is_looked_at(tmp_path: Path, who: Rover) -> None:
    z = np.zeros((900, 900))
    z[200:, 200:] = np.nan
    trip = travel_far(Errand(raster_of(tmp_path, z), who), [(9.0, 9.0), (1500.0, 1500.0)])
    assert trip.legs[0].reason == "the goal (1500, 1500) m lies in a hole of the map without data"
    assert [barrier.limit for barrier in trip.barriers] == ["no data"]
    with pytest.raises(InputError, match="every height is missing"):
        plan.survey(raster_of(tmp_path, np.full((50, 50), np.nan)), who)


def test_stops_zones_and_their_order(tmp_path: Path, who: Rover) -> None:
    raster = raster_of(tmp_path, np.zeros((500, 500)))
    import shapely

    zones = plan.Zones(avoid=shapely.box(300.0, 100.0, 500.0, 2000.0), margin=20.0)
    errand = Errand(raster, who, zones=zones)
    stops = [(50.0, 800.0), (900.0, 900.0), (100.0, 100.0), (900.0, 100.0), (700.0, 950.0)]
    trip = travel_far(errand, stops, order="best", block=8, stretch=100.0)
    assert trip.order == (0, 2, 3, 1, 4)
    assert len(trip.account()) == 4
    import shapely.geometry

    way = shapely.geometry.LineString(trip.points)
    assert way.distance(zones.avoid) >= 20.0 - 1e-9
    least = (
        math.hypot(50, 700)
        + math.hypot(180, 20)
        + 240
        + math.hypot(380, 20)
        + 800
        + math.hypot(200, 50)
    )
    assert abs(trip.length / least - 1.0) < 0.02
    same = travel_far(errand, [(50.0, 800.0)] * 2, block=8)
    assert (same.length, len(same.points)) == (0.0, 1)


def test_what_is_refused(tmp_path: Path, who: Rover) -> None:
    raster = raster_of(tmp_path, np.zeros((50, 50)))
    ends = [(5.0, 5.0), (50.0, 50.0)]
    with pytest.raises(InputError, match="a start and a goal, got 1 stops"):
        travel_far(Errand(raster, who), ends[:1])
    with pytest.raises(SettingError, match="unknown order 'bets'"):
        travel_far(Errand(raster, who), ends, order="bets")
    with pytest.raises(SettingError, match="unknown objective 'enrgy'; did you mean"):
        travel_far(Errand(raster, who, "enrgy"), ends)
    with pytest.raises(SettingError, match="neighbours must be 8, 16 or 32"):
        travel_far(Errand(raster, who, neighbours=9), ends)
    with pytest.raises(SettingError, match="at most 12 stops between start and goal, got 14"):
        travel_far(Errand(raster, who), ends * 8, order="best")
    raster.path.unlink()
    with pytest.raises((FileError, OSError)):
        travel_far(Errand(open_raster(raster.path), who), ends)


def test_the_command_says_the_same_whichever_way_it_plans(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    raster = raster_of(tmp_path, 0.8 * fractal(500, np.random.default_rng(4)))
    words = ("route", raster.path, "--cell", "2", "--frame", "local", "--from", "60,60", "--to",
             "930,940", "--why", "500,500", "--soil", "loose-sand")  # fmt: skip
    whole = tell(*words, "--out", tmp_path / "whole")
    monkeypatch.setattr(_trip, "WHOLE", 10_000)
    blocks = tell(*words, "--out", tmp_path / "blocks")
    assert whole["block"] is None
    assert blocks["block"] >= 4
    assert set(whole) == set(blocks)
    assert math.isclose(blocks["length_m"], whole["length_m"], rel_tol=0.01)
    assert math.isclose(blocks["energy_j"], whole["energy_j"], rel_tol=0.05)
    assert whole["looked_share"] == 1.0
    assert 0.0 < blocks["looked_share"] <= 1.0
    assert abs(blocks["forbidden_share"] - whole["forbidden_share"]) < 0.1
    made = {p.name for p in (tmp_path / "blocks").iterdir()}
    assert made == {p.name for p in (tmp_path / "whole").iterdir()}
    lines = json.loads((tmp_path / "blocks" / "route.geojson").read_text())["features"]
    assert math.isclose(lines[0]["properties"]["length_m"], blocks["length_m"], rel_tol=1e-12)
    said = run(*words, "--out", tmp_path / "blocks", "--no-picture")
    assert "Found a way of" in said.out
    assert "along the route, a metre costs:" in said.out
