"""A drive or an export that is killed leaves each of its files whole, or not at all."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from tests.cli.runner import write_ground

pytestmark = pytest.mark.long
COMMAND = (sys.executable, "-m", "rovernav")
DRIVE = (
    "drive", "--terrain", "ground.tif", "--frame", "local", "--from", "3,4", "--to", "24,14",
    "--rover", "research", "--controller", "goal-seeker", "--body", "--drift",
)  # fmt: skip
KILLS = 12


def whole(words: tuple[str, ...], folder: Path) -> tuple[dict[str, bytes], float]:
    """What a run that nobody kills writes, and how long it takes once its folder is there [s]."""
    with subprocess.Popen((*COMMAND, *words), stdout=subprocess.DEVNULL) as process:
        begun = wait_for(folder, process)
    assert process.returncode == 0
    return {path.name: path.read_bytes() for path in folder.iterdir()}, time.monotonic() - begun


def wait_for(folder: Path, process: subprocess.Popen[bytes]) -> float:
    """Until the folder is there, or the process has ended; what time it is then [s]."""
    while not folder.exists() and process.poll() is None:
        time.sleep(0.005)
    return time.monotonic()


def killed(words: tuple[str, ...], folder: Path, delay: float) -> int:
    """Start a run and kill it so long after its folder is there; its exit status."""
    with subprocess.Popen((*COMMAND, *words), stdout=subprocess.DEVNULL) as process:
        wait_for(folder, process)
        time.sleep(delay)
        process.kill()
    return process.returncode


def left(folder: Path, expected: dict[str, bytes]) -> set[str]:
    """Names of the files that are there, all whole; beside them only what says it is not done."""
    names = set[str]()
    for path in folder.iterdir() if folder.exists() else ():
        if path.name in expected:
            assert path.read_bytes() == expected[path.name], path.name
            names.add(path.name)
        else:
            hidden = path.name.startswith(".") and path.name.endswith(".tmp")
            assert hidden, path.name
            assert any(name in path.name for name in expected), path.name
    return names


def test_a_killed_drive_leaves_whole_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write_ground(tmp_path / "ground.tif")
    expected, seconds = whole((*DRIVE, "--out", "whole"), tmp_path / "whole")
    assert set(expected) == {"drive.png", "path.csv", "path.geojson", "trace.npz"}
    rng, ends = np.random.default_rng(0), set[int]()
    for k, share in enumerate(np.sort(rng.uniform(0.0, 1.0, KILLS))):
        out = tmp_path / f"out{k}"
        ends.add(killed((*DRIVE, "--out", out.name), out, float(share) * seconds))
        left(out, expected)
    assert -9 in ends
    assert ends <= {-9, 0}
    again, _ = whole((*DRIVE, "--out", "out0"), tmp_path / "out0")
    assert {name: again[name] for name in expected} == expected


@pytest.mark.parametrize("name", ["d.csv", "d.html", "d.gif", "d.mcap"])
def test_a_killed_export_leaves_a_whole_file(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if name.endswith(".mcap"):
        pytest.importorskip("rosbags", reason="needs the extra ros")
    monkeypatch.chdir(tmp_path)
    write_ground(tmp_path / "ground.tif")
    whole((*DRIVE, "--out", "drive"), tmp_path / "drive")
    words = ("export", "drive/trace.npz", "--to")
    (tmp_path / "whole").mkdir()
    expected, seconds = whole((*words, f"whole/{name}"), tmp_path / "whole")
    rng = np.random.default_rng(1)
    for k, share in enumerate(rng.uniform(0.0, 1.0, KILLS // 3)):
        out = tmp_path / f"out{k}"
        out.mkdir()
        assert killed((*words, f"{out.name}/{name}"), out, float(share) * seconds) in (-9, 0)
        left(out, expected)
