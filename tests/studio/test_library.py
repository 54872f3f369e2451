from __future__ import annotations

import os
import signal
import sqlite3
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rovernav.core import FileError, SettingError
from rovernav.studio import Library
from rovernav.studio._library import usual_library

RUN: dict[str, Any] = {
    "kind": "training",
    "title": "a run",
    "command": "rovernav train x.csv",
    "settings": {"eta": 0.25, "hidden": (3, 4)},
    "summary": {"epochs": np.int64(7), "error": float("nan"), "weights": np.array([1.5, 2.0])},
    "files": {"network.safetensors": b"\0\1\2", "curve.csv": b"epoch\n"},
}


def add(library: Library, **changes: Any) -> str:
    """Keep a run like `RUN`, but for the changes."""
    return library.add(**RUN | changes)


@pytest.fixture
def library(tmp_path: Path) -> Library:
    return Library(tmp_path / "deep" / "runs.sqlite3")


def test_what_goes_in_comes_out(library: Library) -> None:
    name = add(library)
    (run,) = library.list()
    assert run.id == name
    assert library.get(name).title == "a run"
    assert dict(run.settings) == {"eta": 0.25, "hidden": [3, 4]}
    assert dict(run.summary) == {"epochs": 7, "error": None, "weights": [1.5, 2.0]}
    assert run.files == ("curve.csv", "network.safetensors")
    assert library.file(name, "network.safetensors") == b"\0\1\2"
    assert abs(run.created - time.time()) < 60


def test_the_latest_stands_first_and_kinds_can_be_picked(library: Library) -> None:
    names = [add(library, kind=kind) for kind in ("training", "drive", "drive")]
    assert [run.id for run in library.list()] == names[::-1]
    assert [run.id for run in library.list(kind="drive")] == names[:0:-1]
    assert [run.id for run in library.list(limit=1)] == names[2:]


def test_renaming_and_deleting(library: Library) -> None:
    name = add(library)
    library.rename(name, "  two\nlines <b>and</b> \0 more ")
    assert library.get(name).title == "two lines <b>and</b> more"
    for title, said in (("", "needs a name"), (" \n", "needs a name"), ("x" * 121, "120 letters")):
        with pytest.raises(SettingError, match=said):
            library.rename(name, title)
    library.delete(name)
    library.delete(name)
    assert library.list() == []
    for action in (
        lambda: library.get(name), lambda: library.rename(name, "x"),
        lambda: library.file(name, "curve.csv"),
    ):  # fmt: skip
        with pytest.raises(SettingError, match=r"no longer in the library|has no file"):
            action()
    with sqlite3.connect(library.path) as connection:
        assert connection.execute("SELECT count(*) FROM file").fetchone() == (0,)
    connection.close()


@pytest.mark.parametrize(
    "name", ["../x", "a/b", "", ".hidden", "x" * 81, "a\0b", "c:\\x", "ü.csv", "a b"]
)
def test_file_names_are_plain(library: Library, name: str) -> None:
    with pytest.raises(SettingError, match="plain name"):
        add(library, files={name: b""})
    assert library.list() == []


def test_what_is_not_plain_data_is_refused_whole(library: Library) -> None:
    with pytest.raises(SettingError, match="must be plain data"):
        add(library, settings={"x": object()})
    with pytest.raises(SettingError, match="has 64,000,001 bytes"):
        add(library, files={"a.bin": b"x", "b.bin": bytes(64_000_001)})
    assert library.list() == []


def test_it_is_found_again(library: Library) -> None:
    name = add(library)
    again = Library(library.path)
    assert [run.id for run in again.list()] == [name]


def test_a_foreign_file_is_left_alone(tmp_path: Path) -> None:
    text, other, later = (tmp_path / name for name in ("a.txt", "b.sqlite3", "c.sqlite3"))
    text.write_text("hello " * 1000)
    with sqlite3.connect(other) as connection:
        connection.execute("CREATE TABLE t (x)")
    connection.close()
    Library(later)
    with sqlite3.connect(later) as connection:
        connection.execute("PRAGMA user_version = 9")
    connection.close()
    for path, said in (
        (text, "cannot be used"), (other, "is not a library of runs"),
        (later, "of version 9, this rovernav knows 1"), (tmp_path, "is no file"),
        (text / "x.sqlite3", "cannot keep runs in"),
    ):  # fmt: skip
        before = path.read_bytes() if path.is_file() else b""
        with pytest.raises(FileError, match=said):
            Library(path)
        assert (path.read_bytes() if path.is_file() else b"") == before


def test_its_usual_place_is_the_user_s(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    monkeypatch.setenv("HOME", str(tmp_path))
    assert usual_library().is_relative_to(tmp_path)


def test_many_threads_and_two_studios_share_a_file(library: Library) -> None:
    other = Library(library.path)
    failed: list[BaseException] = []

    def work(mine: Library) -> None:
        try:
            for _ in range(10):
                name = add(mine)
                mine.rename(name, "mine")
                assert mine.get(name).title == "mine"
        except BaseException as error:
            failed.append(error)

    threads = [threading.Thread(target=work, args=(each,)) for each in (library, other) * 2]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert failed == []
    assert len(library.list()) == 40


WRITER = """
import sys
from pathlib import Path
from rovernav.studio import Library
library = Library(Path(sys.argv[1]))
for number in range(10**9):
    name = library.add(kind="training", title=f"run {number}", command="", settings={},
                       summary={"number": number}, files={"a.bin": bytes([number % 256]) * 300_000})
    print(name, flush=True)
"""


def test_a_killed_writer_loses_no_run_that_was_kept(tmp_path: Path) -> None:
    path = tmp_path / "runs.sqlite3"
    said: list[str] = []
    for kill in range(2):
        with subprocess.Popen(
            [sys.executable, "-c", WRITER, str(path)], stdout=subprocess.PIPE, text=True,
            env=dict(os.environ),
        ) as process:  # fmt: skip
            assert process.stdout is not None
            for _ in range(3 + kill):
                said.append(process.stdout.readline().strip())
            time.sleep(0.013 * kill)
            process.send_signal(signal.SIGKILL)
            said += process.stdout.read().split()
    library = Library(path)
    kept = {run.id: run for run in library.list()}
    assert set(said) - {""} <= set(kept)
    for run in kept.values():
        number = run.summary["number"]
        assert library.file(run.id, "a.bin") == bytes([number % 256]) * 300_000
