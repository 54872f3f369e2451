"""Where the results of a sweep are kept: a file that grows block by block and outlives a crash.

The file begins with a line of JSON (format, version, settings, hash of the patterns, members of a
block). Then come the blocks in order: number and CRC-32 (two little-endian 32-bit words) and a row
of 17 bytes for each member. Whatever does not fit at the end, such as half a block, is cut off
when a sweep is resumed.
"""

from __future__ import annotations

import io
import json
import os
import shutil
import struct
import time
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO, final

import numpy as np

from ..core import FileError, SettingError, canonical_json, write_atomic
from ._patterns import Patterns
from ._sweep_block import ROW, Rows, block_size
from ._sweep_settings import SweepSettings

FORMAT, VERSION = "rovernav-sweep", 1
_HEAD = struct.Struct("<II")
_LONGEST_HEADER = 2_000_000
_CSV_ROW = 80
"""Bytes that a member takes in sweep.csv, at most."""
_PATIENCE = 1.0
"""Blocks may wait so long before the disk is told to keep them for good [s]."""


@final
class SweepStore:
    """Rows of the members of one sweep, in order.

    Attributes:
        members: How many members are in it.
        block: Members of a block.
    """

    def __init__(self, file: BinaryIO, settings: SweepSettings, block: int) -> None:
        self._file, self._settings, self.block = file, settings, block
        self._start = file.tell()
        self._synced = time.monotonic()
        self.members = 0

    @classmethod
    def in_memory(cls, settings: SweepSettings, patterns: Patterns) -> SweepStore:
        """A store that is gone with the process; 17 bytes for each member."""
        return cls(io.BytesIO(), settings, block_size(settings, patterns))

    @classmethod
    def open(
        cls, path: Path, settings: SweepSettings, patterns: Patterns, *, resume: bool = False
    ) -> SweepStore:
        """A store in a file, new or resumed.

        Args:
            path: The file; its folder is made if needed.
            settings: The sweep's.
            patterns: The sweep's.
            resume: Go on with the file if it exists.

        Raises:
            SettingError: The file exists but `resume` is False, or it is of another sweep; names
                the first setting that differs.
            FileError: It cannot be read or written, is no such file, another process is at it, or
                the disk has too little room.
        """
        header = {
            "format": FORMAT,
            "version": VERSION,
            "settings": settings.plain(),
            "patterns": patterns.sha256,
            "block": block_size(settings, patterns),
        }
        if path.exists():
            if not resume:
                raise SettingError(
                    f"{path} exists: a sweep was begun there; go on with it by --resume, "
                    "or name another folder"
                )
        else:
            _check_room(path, settings.members)
            line = f"{canonical_json(header)}\n".encode()
            write_atomic(path, lambda file: file.write(line))
        try:
            file = path.open("r+b", buffering=0)
        except OSError as error:
            raise FileError(f"cannot open {path}: {error.strerror}") from error
        try:
            _lock(file, path)
            found = _header(file, path)
            _check_same(path, found, header)
            store = cls(file, settings, found["block"])
            store._take_over()
        except BaseException:
            file.close()
            raise
        return store

    def append(self, rows: Rows) -> None:
        """Keep the rows of the next block.

        Raises:
            FileError: The disk refused.
        """
        data = np.ascontiguousarray(rows, ROW).tobytes()
        number = self.members // self.block
        record = _HEAD.pack(number, _sum(number, data)) + data
        try:
            view = memoryview(record)
            while view:
                view = view[self._file.write(view) :]
            if time.monotonic() - self._synced > _PATIENCE:
                self._sync()
        except OSError as error:
            raise FileError(f"cannot keep the sweep's results: {error.strerror}") from error
        self.members += len(rows)

    def rows(self) -> Iterator[Rows]:
        """The rows, block by block, from the first on."""
        end = self._file.tell()
        try:
            self._file.seek(self._start)
            for number in range(-(-self.members // self.block)):
                rows = self._read(number)
                if rows is None:
                    raise FileError("the file of the sweep was changed while it was in use")
                here = self._file.tell()
                yield rows
                self._file.seek(here)
        finally:
            self._file.seek(end)

    def close(self) -> None:
        """Make sure that all is on the disk; nothing can be kept or read afterwards."""
        if not self._file.closed:
            self._sync()
            self._file.close()

    def __enter__(self) -> SweepStore:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _sync(self) -> None:
        if not isinstance(self._file, io.BytesIO):
            os.fsync(self._file.fileno())
        self._synced = time.monotonic()

    def _take_over(self) -> None:
        """Count the blocks that are whole, and cut off what comes after."""
        number, end = 0, self._file.tell()
        while self.members < self._settings.members:
            rows = self._read(number)
            if rows is None:
                break
            self.members += len(rows)
            number, end = number + 1, self._file.tell()
        self._file.seek(end)
        self._file.truncate()

    def _read(self, number: int) -> Rows | None:
        """The block that begins here, or None if it is not whole."""
        count = min(self.block, self._settings.members - number * self.block)
        size = _HEAD.size + count * ROW.itemsize
        record = _read_all(self._file, size)
        if len(record) < size:
            return None
        data = record[_HEAD.size :]
        if _HEAD.unpack(record[: _HEAD.size]) != (number, _sum(number, data)):
            return None
        return np.frombuffer(data, ROW)


def _read_all(file: BinaryIO, size: int) -> bytes:
    """`size` bytes, or as many as there are."""
    parts: list[bytes] = []
    while size and (part := file.read(size)):
        parts.append(part)
        size -= len(part)
    return b"".join(parts)


def _sum(number: int, data: bytes) -> int:
    return zlib.crc32(data, zlib.crc32(number.to_bytes(8, "little")))


def _lock(file: BinaryIO, path: Path) -> None:
    try:
        import fcntl
    except ImportError:  # a system without: two sweeps in one folder are then not noticed
        return
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise FileError(f"{path} is in use by another sweep; wait for it or stop it") from None
    except OSError:
        return  # a file system without locks


def _header(file: BinaryIO, path: Path) -> dict[str, Any]:
    start = _read_all(file, _LONGEST_HEADER)
    line, newline, _ = start.partition(b"\n")
    try:
        header = json.loads(line) if newline else None
    except ValueError:
        header = None
    if not isinstance(header, dict) or header.get("format") != FORMAT:
        raise FileError(f"{path} holds no results of a sweep, or its first line is damaged")
    if header.get("version") != VERSION:
        raise FileError(f"{path}: version must be {VERSION}, got {header.get('version')!r}")
    block = header.get("block")
    if type(block) is not int or not 1 <= block <= 10**9:
        raise FileError(f"{path} is damaged: blocks of {block!r} members")
    file.seek(len(line) + 1)
    return header


def _check_same(path: Path, then: dict[str, Any], now: dict[str, Any]) -> None:
    """Raise `SettingError` unless the file belongs to this sweep."""
    before = then.get("settings")
    for name, wanted in now["settings"].items():
        found = before.get(name) if isinstance(before, dict) else None
        if found != wanted:
            raise SettingError(
                f"{path} was made with {name} = {_short(found)}, not {_short(wanted)}; "
                "resume with the same, or name another folder"
            )
    if then.get("patterns") != now["patterns"]:
        raise SettingError(f"{path} was made with another pattern table; resume with the same")


def _short(item: Any) -> str:
    text = json.dumps(item)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _check_room(path: Path, members: int) -> None:
    """Raise `FileError` if the disk cannot hold the results."""
    needed = members * (ROW.itemsize + _CSV_ROW)
    folder = next(parent for parent in path.absolute().parents if parent.exists())
    free = shutil.disk_usage(folder).free
    if needed > free:
        raise FileError(
            f"{members:,} members need {needed / 1e9:.1f} GB in {folder}, "
            f"{free / 1e9:.1f} GB are free; use fewer seeds or another disk"
        )
