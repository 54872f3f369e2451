"""Files that never end half-written, and texts that are read strictly."""

from __future__ import annotations

import hashlib
import json
import math
import os
import secrets
import stat
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, BinaryIO

from .errors import FileError


def write_atomic(path: Path, write: Callable[[BinaryIO], object]) -> None:
    """Write a file so that a crash leaves the old one or the new one, never a part.

    Args:
        path: Where the file shall be; its folder is made if needed.
        write: Called with a binary file open for writing, in the same folder.

    Raises:
        FileError: The file cannot be written there.
    """
    if not path.name or "\0" in path.name:
        raise FileError(f"cannot write {str(path)!r}: that is no file name")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        scratch = path.with_name(f".{path.name}.{secrets.token_hex(4)}.tmp")
        try:
            with scratch.open("xb") as file:
                write(file)
                file.flush()
                os.fsync(file.fileno())
            scratch.replace(path)
        except BaseException:
            scratch.unlink(missing_ok=True)
            raise
    except OSError as error:
        raise FileError(f"cannot write {path}: {error.strerror or error}") from error


def write_text(path: Path, text: str) -> None:
    """Write UTF-8 text atomically."""
    write_atomic(path, lambda file: file.write(text.encode()))


def read_bytes(path: Path, *, limit: int, what: str) -> bytes:
    """The bytes of a file that must not be larger than `limit`.

    Raises:
        FileError: Missing, a folder, unreadable or larger than `limit`; `what` names its kind.
    """
    try:
        status = path.stat()
        plain = stat.S_ISREG(status.st_mode)
        if plain and status.st_size <= limit:
            return path.read_bytes()
    except FileNotFoundError:
        raise FileError(f"there is no {what} at {path}; check the path") from None
    except (OSError, ValueError) as error:  # ValueError: a name with a NUL in it
        raise FileError(f"cannot read the {what} {str(path)!r}: {error}") from error
    if plain:
        raise FileError(
            f"{path} has {status.st_size:,} bytes, more than a {what} may have ({limit:,} bytes)"
        )
    kind = "a folder" if stat.S_ISDIR(status.st_mode) else "no ordinary file"
    raise FileError(f"{path} is {kind}; give the {what} itself")


def read_text(path: Path, *, limit: int, what: str) -> str:
    """UTF-8 text of a file of at most `limit` bytes; a byte-order mark is dropped.

    Raises:
        FileError: As `read_bytes`, or not UTF-8.
    """
    try:
        return read_bytes(path, limit=limit, what=what).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise FileError(
            f"{path} is not UTF-8 text (byte {error.start}); save the {what} as UTF-8"
        ) from None


def canonical_json(item: Any) -> str:
    """JSON with sorted keys and no spaces: the same value always gives the same text."""
    return json.dumps(item, sort_keys=True, separators=(",", ":"), allow_nan=False)


def plain_data(item: Any) -> Any:
    """Numbers, lists and texts that JSON knows; NaN and infinity become None."""
    if isinstance(item, Mapping):
        return {str(key): plain_data(part) for key, part in item.items()}
    if isinstance(item, list | tuple):
        return [plain_data(part) for part in item]
    if isinstance(item, Path):
        return str(item)
    if hasattr(item, "tolist"):
        return plain_data(item.tolist())
    if isinstance(item, float):
        return item if math.isfinite(item) else None
    return item


def sha256_of(*parts: bytes) -> str:
    """Hex SHA-256 of the parts, one after the other."""
    digest = hashlib.sha256()
    for part in parts:
        digest.update(part)
    return digest.hexdigest()
