from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from rovernav.core import Frame, InputError
from rovernav.rover import read_rover
from rovernav.show import draw_movie
from rovernav.sim import (
    DifferentialDrive,
    Drift,
    HoleSensor,
    Odometry,
    Patch,
    RangeFan,
    Trace,
    Worlds,
    simulate,
)
from rovernav.terrain import Terrain
from tests.sim.drives import Always, drive

FAN = RangeFan(reach=3.0, beams=9)


def driven(**more: Any) -> tuple[Trace, Worlds]:
    """Two rovers that turn while they drive past a box."""
    set_up = drive(
        Always(0.25, 0.0, 0.1), (3.0, 1.0, 4.0, 4.0), starts=((1.0, 1.0, 0.0), (2.0, -3.0, 1.0)),
        limit=9.0, sensors=(FAN,), motion=DifferentialDrive(speed=1.0, turn_rate=1.0, period=0.5),
    )  # fmt: skip
    return simulate(set_up, **more), set_up.worlds


def frames(path: Path) -> list[np.ndarray]:
    with Image.open(path) as movie:
        found = []
        for k in range(getattr(movie, "n_frames", 1)):
            movie.seek(k)
            found.append(np.asarray(movie.convert("RGB")).astype(int))
        return found


def test_the_rover_moves_the_ground_stays(tmp_path: Path) -> None:
    trace, worlds = driven()
    seen: list[float] = []
    path = draw_movie(
        trace, tmp_path / "d.gif", worlds=worlds, sensors=(FAN,), rover=read_rover("research"),
        on_event=seen.append,
    )  # fmt: skip
    shown = frames(path)
    assert len(shown) == trace.steps[0] + 1 == len(seen)
    assert (seen[-1], seen) == (1.0, sorted(seen))
    changed = [(a != b).any(axis=2) for a, b in itertools.pairwise(shown)]
    assert all(0.0 < part.mean() < 0.2 for part in changed)
    with Image.open(path) as movie:
        assert movie.info["loop"] == 0
    assert path.stat().st_size < 150_000


def test_what_each_rover_carries_and_meets_is_seen(tmp_path: Path) -> None:
    trace, worlds = driven()
    around: dict[str, Any] = {"worlds": worlds, "rover": read_rover("research")}
    plain = frames(draw_movie(trace, tmp_path / "a.gif", **around))
    beams = frames(draw_movie(trace, tmp_path / "b.gif", sensors=(FAN,), **around))
    other = frames(draw_movie(trace, tmp_path / "c.gif", k=1, **around))
    bare = frames(draw_movie(trace, tmp_path / "d.gif"))
    assert (plain[2] != beams[2]).any()  # at the end nothing is read any more
    assert plain[2].shape != other[2].shape or (plain[2] != other[2]).any()
    assert plain[2].shape != bare[2].shape or (plain[2] != bare[2]).any()


def test_a_long_drive_has_few_frames_with_both_ends(tmp_path: Path) -> None:
    trace, _ = driven()
    all_of_them = frames(draw_movie(trace, tmp_path / "a.gif"))
    some = frames(draw_movie(trace, tmp_path / "b.gif", frames=5))
    assert len(some) == 5
    for k in (0, -1):  # the palette is another
        assert np.abs(some[k] - all_of_them[k]).mean() < 2.0


def test_on_ground(tmp_path: Path) -> None:
    frame = Frame(cell=0.5, shape=(24, 40))
    heights = 0.1 * np.tile(np.arange(40.0), (24, 1))
    ground = Terrain.from_heights(heights, frame, name="slope $_{", source="a test")
    shown = frames(draw_movie(driven()[0], tmp_path / "a.gif", terrain=ground, frames=3))
    assert len(np.unique(shown[0].reshape(-1, 3), axis=0)) > 40


def test_the_same_drive_gives_the_same_bytes(tmp_path: Path) -> None:
    one, two = (draw_movie(driven()[0], tmp_path / name, frames=4) for name in ("a.gif", "b.gif"))
    assert one.read_bytes() == two.read_bytes()


def test_what_cannot_be_a_movie_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="kept no path to draw"):
        draw_movie(driven(record="none")[0], tmp_path / "a.gif")
    with pytest.raises(InputError, match="two frames or more, got 1"):
        draw_movie(driven()[0], tmp_path / "a.gif", frames=1)
    assert list(tmp_path.iterdir()) == []


def test_what_looks_down_is_no_fan(tmp_path: Path) -> None:
    holes = HoleSensor()
    trace = simulate(drive(Always(0.25, 0.0, 0.0), sensors=(holes,), limit=3.0), seed=1)
    plain = draw_movie(trace, tmp_path / "a.gif")
    carried = draw_movie(trace, tmp_path / "b.gif", sensors=(holes,))
    assert plain.read_bytes() == carried.read_bytes()


def test_what_it_believes_and_what_its_eyes_see_is_shown(tmp_path: Path) -> None:
    eyes, odometry = Patch(far=3.0, cell=0.3), Odometry(Drift(scale=0.3))
    set_up = drive(Always(0.25, 0.0, 0.0), sensors=(eyes, odometry), limit=9.0)
    trace = simulate(set_up, seed=1)
    plain = frames(draw_movie(trace, tmp_path / "a.gif"))[6]
    seeing = frames(draw_movie(trace, tmp_path / "b.gif", sensors=(eyes,)))[6]
    assert orange(plain) > 40
    alone = simulate(drive(Always(0.25, 0.0, 0.0), limit=9.0), seed=1)
    assert orange(frames(draw_movie(alone, tmp_path / "c.gif"))[6]) < orange(plain)
    assert 50 < (np.abs(plain - seeing).max(axis=2) > 40).sum() < 0.3 * plain[..., 0].size


def orange(frame: np.ndarray) -> int:
    """Pixels in about the colour of what is believed."""
    return int((np.abs(frame - (230, 159, 0)).max(axis=2) < 30).sum())
