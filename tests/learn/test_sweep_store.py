"""The file of a sweep: torn, damaged, foreign, in use; and a sweep killed again and again."""

from __future__ import annotations

import dataclasses
import shutil
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rovernav.core import FileError, SettingError
from rovernav.learn import (
    Patterns,
    SweepSettings,
    SweepStore,
    shipped_patterns,
    sweep,
    write_members_csv,
    write_settings_csv,
)

TABLE = shipped_patterns("bassil-v1")
SETTINGS = SweepSettings(etas=(0.1, 0.4), seeds=4000, epochs=10, tolerance=0.3)
LONG = SweepSettings(etas=(0.1, 0.4), momenta=(0.0, 0.9), seeds=20_000, epochs=700, tolerance=0.001)
CHILD = "import sys; from tests.learn.test_sweep_store import go_on; go_on(sys.argv[1])"


def open_it(path: Path, settings: SweepSettings = SETTINGS, *, resume: bool = True) -> SweepStore:
    return SweepStore.open(path, settings, TABLE, resume=resume)


@pytest.fixture
def whole(tmp_path: Path) -> Path:
    """The file of a finished sweep."""
    path = tmp_path / "sweep.members"
    with open_it(path, resume=False) as store:
        assert sweep(TABLE, SETTINGS, store=store).finished
    return path


def test_a_finished_sweep_is_read_back(whole: Path) -> None:
    with open_it(whole) as store:
        assert store.members == 8000
        result = sweep(TABLE, SETTINGS, store=store)
    fresh = sweep(TABLE, SETTINGS)
    assert (result.updates, result.updates_now) == (fresh.updates, 0)
    assert [s.epochs for s in result.settings] == [s.epochs for s in fresh.settings]


@pytest.mark.parametrize("cut", [1, 16, 17 * 1024, 17 * 1024 + 9, 100_000])
def test_a_torn_end_is_done_again(whole: Path, cut: int) -> None:
    data = whole.read_bytes()
    whole.write_bytes(data[:-cut])
    with open_it(whole) as store:
        assert store.members < 8000
        assert store.members % store.block == 0
        assert sweep(TABLE, SETTINGS, store=store).finished
    assert whole.read_bytes() == data


@pytest.mark.parametrize("junk", [b"\0" * 50, b"x" * 30_000])
def test_what_stands_behind_the_end_is_cut_off(whole: Path, junk: bytes) -> None:
    data = whole.read_bytes()
    whole.write_bytes(data + junk)
    with open_it(whole) as store:
        assert store.members == 8000
    assert whole.read_bytes() == data


def test_a_flipped_bit_is_noticed(whole: Path, rng: np.random.Generator) -> None:
    data = whole.read_bytes()
    start = data.index(b"\n") + 1
    for _ in range(5):
        place = int(rng.integers(start, len(data)))
        hurt = bytearray(data)
        hurt[place] ^= 1 << int(rng.integers(8))
        whole.write_bytes(hurt)
        with open_it(whole) as store:
            assert store.members < 8000
            assert sweep(TABLE, SETTINGS, store=store).finished
        assert whole.read_bytes() == data


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"etas": (0.1, 0.3)}, "with etas = [0.1, 0.4], not [0.1, 0.3]"),
        ({"momenta": (0.1,)}, "with momenta = [0.5], not [0.1]"),
        ({"seeds": 5000}, "with seeds = 4000, not 5000"),
        ({"epochs": 11}, "with epochs = 10, not 11"),
        ({"tolerance": 0.2}, "with tolerance = 0.3, not 0.2"),
        ({"order": "shuffled"}, 'with order = "cyclic", not "shuffled"'),
        ({"topology": (2, 4, 2)}, "with topology = [2, 3, 2], not [2, 4, 2]"),
    ],
)
def test_another_sweep_is_refused(whole: Path, changes: Any, words: str) -> None:
    with pytest.raises(SettingError) as caught:
        open_it(whole, dataclasses.replace(SETTINGS, **changes))
    assert words in str(caught.value)


def test_another_table_is_refused(whole: Path) -> None:
    other = Patterns(x=TABLE.x, y=-TABLE.y, inputs=TABLE.inputs, outputs=TABLE.outputs)
    with pytest.raises(SettingError, match="another pattern table"):
        SweepStore.open(whole, SETTINGS, other, resume=True)


def test_a_sweep_is_not_begun_over_another(whole: Path) -> None:
    with pytest.raises(SettingError, match="go on with it by --resume"):
        open_it(whole, resume=False)


def test_resuming_what_was_never_begun_begins_it(tmp_path: Path) -> None:
    with open_it(tmp_path / "new" / "file") as store:
        assert store.members == 0


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "holds no results"),
        (b"a,b\n1,2\n", "holds no results"),
        (b"[1]\n", "holds no results"),
        (b"\xff\xfe" * 50, "holds no results"),
        (b'{"format":"rovernav-sweep","version":9}\n', "version must be 1, got 9"),
        (b'{"format":"rovernav-sweep","version":1,"block":0}\n', "is damaged: blocks of 0"),
    ],
)
def test_foreign_files(tmp_path: Path, content: bytes, words: str) -> None:
    path = tmp_path / "f"
    path.write_bytes(content)
    with pytest.raises(FileError) as caught:
        open_it(path)
    assert words in str(caught.value)
    assert path.read_bytes() == content


def test_two_sweeps_do_not_share_a_file(whole: Path) -> None:
    pytest.importorskip("fcntl")
    with open_it(whole), pytest.raises(FileError, match="in use by another sweep"):
        open_it(whole)
    with open_it(whole):
        pass


def test_a_full_disk_is_told_before_the_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    full = shutil.disk_usage(tmp_path)._replace(free=10_000)
    monkeypatch.setattr(shutil, "disk_usage", lambda _: full)
    with pytest.raises(FileError, match=r"8,000 members need 0\.0 GB .* use fewer seeds"):
        open_it(tmp_path / "f", resume=False)
    assert not (tmp_path / "f").exists()


def go_on(name: str) -> None:
    """What the killed process does."""
    folder = Path(name)
    with SweepStore.open(folder / "sweep.members", LONG, TABLE, resume=True) as store:
        sys.stdout.write(f"{store.members}\n")
        sys.stdout.flush()
        result = sweep(TABLE, LONG, store=store, on_event=tell)
        write_members_csv(store, LONG, len(TABLE.x), folder / "sweep.csv")
        write_settings_csv(result, folder / "settings.csv")


def tell(event: Any) -> None:
    sys.stdout.write(f"{event.members}\n")
    sys.stdout.flush()


def run(folder: Path, root: Path, lines: int | None = None, delay: float = 0.0) -> tuple[int, int]:
    """Run the child to its end, or kill it `delay` [s] after so many lines.

    Returns:
        Exit status, and the members that it had kept when it told so last.
    """
    command = [sys.executable, "-c", CHILD, str(folder)]
    kept = 0
    with subprocess.Popen(command, cwd=root, stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout is not None
        for number, line in enumerate(child.stdout, 1):
            kept = int(line)
            if number == lines:
                time.sleep(delay)
                child.kill()
        return child.wait(), kept


@pytest.mark.parametrize("kills", [2, pytest.param(12, marks=pytest.mark.long)])
def test_killed_and_resumed_gives_the_same_files(kills: int, tmp_path: Path, root: Path) -> None:
    rng = np.random.default_rng(kills)
    hurt, quiet = tmp_path / "hurt", tmp_path / "quiet"
    last = 0
    for _ in range(kills):
        lines, delay = int(rng.integers(2, 3 + 12 // kills)), float(rng.uniform(0.0, 0.05))
        status, kept = run(hurt, root, lines, delay)
        assert status == -9
        assert kept >= last  # no block that was finished is lost
        with SweepStore.open(hurt / "sweep.members", LONG, TABLE, resume=True) as store:
            assert kept <= store.members < LONG.members
            last = store.members
    assert run(hurt, root) == (0, LONG.members)
    assert run(quiet, root) == (0, LONG.members)
    for name in ("sweep.members", "sweep.csv", "settings.csv"):
        assert (hurt / name).read_bytes() == (quiet / name).read_bytes()
