from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from rovernav.sim import load_trace
from tests.cli.runner import run, tell, write_ground

ACROSS = ("--from", "-5,-8", "--to", "20,-6.5", "--controller", "goal-seeker")


@pytest.fixture
def trace(here: Path) -> str:
    write_ground(here / "ground.tif")
    return tell("drive", "--terrain", "ground.tif", *ACROSS)["files"][3]


def test_a_table_of_everything(trace: str) -> None:
    report = tell("export", trace, "--to", "deep/t.csv")
    assert report["ground"] is True
    assert report["bytes"] == Path("deep/t.csv").stat().st_size
    with Path("deep/t.csv").open() as file:
        rows = list(csv.DictReader(file))
    kept = load_trace(Path(trace))
    assert len(rows) == kept.steps[0] + 1
    assert [float(row["beams_3"]) for row in rows[:-1]] == kept.channels["beams"][:, 0, 3].tolist()
    assert float(rows[0]["map_x"]) == -5.0
    assert rows[-1]["outcome"] == "reached"


def test_the_folder_of_a_drive_will_do(trace: str) -> None:
    folder = Path(trace).parent
    assert tell("export", folder, "--to", "t.csv")["trace"] == trace
    Path("empty").mkdir()
    said = run("export", "empty", "--to", "t.csv")
    assert (said.code, said.out) == (2, "")
    assert "there is no" in said.err
    assert "empty/trace.npz" in said.err


def test_a_map_of_all_drives(trace: str) -> None:
    tell("export", trace, "--to", "t.geojson")
    whole = json.loads(Path("t.geojson").read_text())
    assert "UTM zone 33N" in whole["crs_wkt"]
    assert [f["properties"]["rover"] for f in whole["features"]] == [0, 0, 0]


def test_a_bag_with_scans_and_heights(trace: str) -> None:
    pytest.importorskip("rosbags", reason="needs the extra ros")
    from tests.adapters.test_bag import said

    tell("export", trace, "--to", "t.mcap")
    found = said(Path("t.mcap"))
    kept = load_trace(Path(trace))
    assert len(found["/scan"]) == kept.steps[0] == len(found["/odom"]) - 1
    assert max(one.pose.pose.position.z for _, one in found["/odom"]) > 0.1


def test_a_movie_and_a_page(trace: str) -> None:
    assert run("export", trace, "--to", "t.gif").out == "Written:\n  t.gif\n"
    with Image.open("t.gif") as movie:
        assert getattr(movie, "n_frames", 1) > 50
    tell("export", trace, "--to", "t.html")
    assert "reached the goal after" in Path("t.html").read_text()


def test_drive_writes_a_movie_if_asked() -> None:
    files = tell("drive", "bassil-v1", "--movie")["files"]
    assert [Path(file).name for file in files] == [
        "drive.png", "path.csv", "path.geojson", "trace.npz", "drive.gif"
    ]  # fmt: skip
    with Image.open(files[-1]) as movie:
        assert getattr(movie, "n_frames", 1) == 16
    tell("export", files[3], "--to", "again.gif")
    assert Path("again.gif").read_bytes() == Path(files[-1]).read_bytes()


def test_ground_that_is_gone_is_told_and_left_out(trace: str) -> None:
    Path("ground.tif").unlink()
    said = run("export", trace, "--to", "t.csv")
    assert said.code == 0
    assert "note: written without ground: there is no" in said.err
    assert "map_x" not in Path("t.csv").read_text()
    for name in ("t.gif", "t.html"):
        assert run("export", trace, "--to", name).code == 0


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("--to", "t.xyz"), "no such form '.xyz'; Allowed: .csv, .geojson, .gif, .html, .mcap."),
        (("--to", "t.jso"), "did you mean '.geojson'?"),
        (("--to", "rovernav-drive/trace.npz"), "no such form '.npz'"),
        (("--to", "t.gif", "--row", "1"), "--row must be from 0 to 0 in this trace, got 1"),
        ((), "--to"),
    ],
)
def test_what_cannot_be_written(trace: str, words: tuple[str, ...], sentence: str) -> None:
    said = run("export", trace, *words)
    assert said.code == 2
    assert sentence in said.err
    assert len(said.err.splitlines()) <= 2


def test_ends_alone_cannot_be_exported(here: Path) -> None:
    from rovernav.sim import save_trace, simulate
    from tests.sim.drives import Always, drive

    save_trace(simulate(drive(Always(1.0, 0.0, 0.0)), record="none"), here / "t.npz")
    for name in ("t.csv", "t.geojson", "t.gif", "t.html", "t.mcap"):
        said = run("export", "t.npz", "--to", name)
        assert (said.code, Path(name).exists()) == (2, False)
        assert "path" in said.err
    assert np.load("t.npz")["pose"].shape == (1, 1, 3)
