"""Kept drives beside each other, and their pictures."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from rovernav.core import FileError
from rovernav.studio import Library, Options
from rovernav.studio._drive_compare import drive_png, drive_result, overlay
from rovernav.studio._drive_world import World
from rovernav.studio._session import Session

PNG = b"\x89PNG\r\n\x1a\n"


@pytest.fixture
def session(tmp_path: Path) -> Iterator[Session]:
    made = Session("key", "me", Options(show=False), Library(tmp_path / "runs.sqlite3"))
    yield made
    made.close()


def driven(session: Session, *keys: str) -> None:
    session.drive.choose(keys)
    session.drive.drive()
    until = time.monotonic() + 60
    while session.drive.running and time.monotonic() < until:
        time.sleep(0.01)


def test_a_kept_drive_has_the_picture_that_the_command_line_makes(session: Session) -> None:
    driven(session, "bassil")
    (run,) = session.library.list(kind="drive")
    assert drive_result(run) == "reached, 16.51 m, 15 s"
    assert drive_png(session.library, run).startswith(PNG)
    made = (("craters", 0), ("relief_m", 1.0), ("side_m", 20.0))
    session.drive.set_world(World(ground="hills", made=made, start=(4, 4), goal=(16, 16)))
    driven(session, "planner")
    latest = session.library.list(kind="drive")[0]
    assert drive_png(session.library, latest).startswith(PNG)


def test_a_kept_drive_whose_ground_is_gone_says_so(session: Session, tmp_path: Path) -> None:
    from tests.cli.runner import write_ground

    ground = write_ground(tmp_path / "g.tif")
    session.drive.offer_terrain(ground)
    session.drive.choose(["planner"])
    session.drive.set_world(session.drive.file_world("g.tif"), settle=True)
    driven(session, "planner")
    (run,) = session.library.list(kind="drive")
    ground.unlink()
    with pytest.raises(FileError, match="there is no elevation file"):
        drive_png(session.library, run)


def test_tracks_lie_on_top_of_each_other_with_obstacles_where_all_had_the_same() -> None:
    tracks = [np.array([[0.0, 0], [5, 1]]), np.array([[0.0, 0], [4, -2]]), np.empty((0, 2))]
    outcomes = ["reached", "collided", "<script>"]
    drawn = overlay(tracks, outcomes, None)
    assert drawn.count("<polyline") == 2
    assert "<script>" not in drawn
    assert "var(--rn-blue)" in drawn
    assert "var(--rn-orange)" in drawn
    assert overlay(tracks, outcomes, World()).count(">A</text>") == 1
    assert overlay([np.empty((0, 2))], [""], None).startswith("<svg")
