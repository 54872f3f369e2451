from __future__ import annotations

import os
from pathlib import Path
from typing import BinaryIO

import pytest

from rovernav.core import (
    FileError,
    canonical_json,
    read_bytes,
    read_text,
    sha256_of,
    write_atomic,
    write_text,
)


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_writes_and_makes_the_folder(tmp_path: Path) -> None:
    path = tmp_path / "a" / "b" / "c.txt"
    write_text(path, "Höhe\n")
    assert path.read_bytes() == b"H\xc3\xb6he\n"
    write_text(path, "2")
    assert path.read_text() == "2"
    assert names(path.parent) == ["c.txt"]


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_a_failure_keeps_the_old_file(tmp_path: Path, error: BaseException) -> None:
    path = tmp_path / "a.txt"
    path.write_text("old")

    def fail(file: BinaryIO) -> None:
        file.write(b"new")
        raise error

    with pytest.raises((FileError, KeyboardInterrupt)) as caught:
        write_atomic(path, fail)
    assert path.read_text() == "old"
    assert names(tmp_path) == ["a.txt"]
    if isinstance(caught.value, FileError):
        assert str(caught.value) == f"cannot write {path}: No space left on device"


def test_the_old_file_stands_until_the_new_one_is_whole(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_text("old")

    def look(file: BinaryIO) -> None:
        file.write(b"new")
        file.flush()
        assert path.read_text() == "old"
        assert len(names(tmp_path)) == 2

    write_atomic(path, look)
    assert path.read_text() == "new"


@pytest.mark.parametrize(
    ("place", "message"),
    [
        ("file/below/a.txt", "cannot write .*a.txt: (Not a directory|File exists)"),
        ("file/a.txt", "cannot write .*a.txt: (Not a directory|File exists)"),
        ("folder", "cannot write .*folder: Is a directory"),
        ("x" * 300, "cannot write .*: File name too long"),
        ("nul\0.txt", "cannot write .*: that is no file name"),
    ],
)
def test_places_where_no_file_can_be(tmp_path: Path, place: str, message: str) -> None:
    (tmp_path / "file").touch()
    (tmp_path / "folder").mkdir()
    with pytest.raises(FileError, match=message):
        write_text(tmp_path / place, "x")
    assert names(tmp_path) == ["file", "folder"]


@pytest.mark.parametrize("path", [Path(), Path("/")])
def test_a_path_without_a_name(path: Path) -> None:
    with pytest.raises(FileError, match="that is no file name"):
        write_text(path, "x")


def test_reads_up_to_the_limit(tmp_path: Path) -> None:
    path = tmp_path / "a.bin"
    path.write_bytes(b"x" * 1000)
    assert read_bytes(path, limit=1000, what="file") == b"x" * 1000
    with pytest.raises(FileError) as caught:
        read_bytes(path, limit=999, what="network file")
    assert str(caught.value) == (
        f"{path} has 1,000 bytes, more than a network file may have (999 bytes)"
    )


def test_each_reason_stands_alone(tmp_path: Path) -> None:
    """Once the reason was wrapped in a second sentence."""
    with pytest.raises(FileError) as caught:
        read_bytes(tmp_path, limit=9, what="checkpoint")
    assert str(caught.value) == f"{tmp_path} is a folder; give the checkpoint itself"
    with pytest.raises(FileError) as caught:
        read_bytes(tmp_path / "a", limit=9, what="checkpoint")
    assert str(caught.value) == f"there is no checkpoint at {tmp_path / 'a'}; check the path"


def test_devices_and_odd_names(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(FileError, match="pipe is no ordinary file; give the trace itself"):
        read_bytes(tmp_path / "pipe", limit=9, what="trace")
    with pytest.raises(FileError, match=r"cannot read the trace .*: embedded null"):
        read_bytes(Path("a\0b"), limit=9, what="trace")
    with pytest.raises(FileError, match=r"cannot read the trace .*: .*too long"):
        read_bytes(tmp_path / ("x" * 300), limit=9, what="trace")
    (tmp_path / "loop").symlink_to("loop")
    with pytest.raises(FileError, match=r"cannot read the trace .*loop"):
        read_bytes(tmp_path / "loop", limit=9, what="trace")


def test_text_is_utf8(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_bytes(b"\xef\xbb\xbfab")
    assert read_text(path, limit=9, what="table") == "ab"
    path.write_bytes(b"ab\xe9")
    with pytest.raises(FileError, match=r"is not UTF-8 text \(byte 2\); save the table as UTF-8"):
        read_text(path, limit=9, what="table")


def test_canonical_json_has_one_form() -> None:
    assert canonical_json({"b": [1, 0.1], "a": None}) == '{"a":null,"b":[1,0.1]}'
    assert canonical_json({"a": "é"}) == '{"a":"\\u00e9"}'
    with pytest.raises(ValueError, match="not JSON compliant"):
        canonical_json(float("nan"))


def test_sha256() -> None:
    abc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"  # FIPS 180-2, B.1
    assert sha256_of(b"abc") == sha256_of(b"a", b"bc") == abc
