"""Finished runs, kept in one SQLite file that survives a killed server."""

from __future__ import annotations

import json
import secrets
import sqlite3
import time
from collections.abc import Generator, Mapping
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any, final

from ..core import FileError, SettingError, canonical_json, plain_data, value

APPLICATION = 0x726F7672  # "rovr": what SQLite files say that a studio wrote
VERSION = 1
MAX_TITLE = 120
MAX_FILE = 64_000_000
"""Bytes of one file of a run at most."""
PATIENCE = 10.0
"""How long to wait for another studio that writes the same library [s]."""
_TABLES = """
CREATE TABLE run (
    id TEXT PRIMARY KEY, kind TEXT NOT NULL, title TEXT NOT NULL, created REAL NOT NULL,
    command TEXT NOT NULL, settings TEXT NOT NULL, summary TEXT NOT NULL
) STRICT;
CREATE TABLE file (
    run TEXT NOT NULL REFERENCES run (id) ON DELETE CASCADE,
    name TEXT NOT NULL, content BLOB NOT NULL, PRIMARY KEY (run, name)
) STRICT;
CREATE INDEX newest ON run (created DESC);
"""


@value
class Run:
    """A finished training or drive.

    Attributes:
        id: Its name in the library.
        kind: ``training`` or ``drive``.
        title: What people call it.
        created: When it was kept [s since 1970].
        command: The command line that does it again, in a folder with its files.
        settings: Plain data that it was made from.
        summary: Plain numbers that came out.
        files: Names of its files.
    """

    id: str
    kind: str
    title: str
    created: float
    command: str
    settings: Mapping[str, Any]
    summary: Mapping[str, Any]
    files: tuple[str, ...]


def usual_library() -> Path:
    """Where runs are kept if nobody says otherwise: the user's data folder."""
    from platformdirs import user_data_path

    return user_data_path("rovernav", appauthor=False) / "studio.sqlite3"


@final
class Library:
    """Kept runs. Each call is a transaction of its own, so threads and servers may share a file.

    Args:
        path: The file; made with its folder if needed.

    Raises:
        FileError: It cannot be made, is no library, or is one of a later rovernav.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise FileError(f"cannot keep runs in {path}: {error.strerror}") from error
        if path.exists() and not path.is_file():
            raise FileError(f"{path} is no file; name a file for the library")
        with self._open() as connection:
            connection.execute("BEGIN IMMEDIATE")  # two studios may be started at once
            _prepare(connection, path)
        with self._open() as connection:  # now that it is known to be ours
            connection.execute("PRAGMA journal_mode = WAL")

    def add(
        self,
        *,
        kind: str,
        title: str,
        command: str,
        settings: Mapping[str, Any],
        summary: Mapping[str, Any],
        files: Mapping[str, bytes],
    ) -> str:
        """Keep a run; once this returns, killing the server does not lose it.

        Args:
            kind: ``training`` or ``drive``.
            title: What people call it.
            command: The command line that does it again, in a folder with its files.
            settings: Plain data that it was made from.
            summary: Plain numbers that came out; NaN becomes null.
            files: Contents by name.

        Returns:
            Its name in the library.

        Raises:
            SettingError: A title or file name that cannot be used, or data that are not plain.
        """
        row = (secrets.token_hex(8), kind, _title(title), time.time(), command,
               _json(settings), _json(summary))  # fmt: skip
        for name, content in files.items():
            _check_file(name, content)
        with self._open() as connection:
            connection.execute("BEGIN IMMEDIATE")
            connection.execute("INSERT INTO run VALUES (?, ?, ?, ?, ?, ?, ?)", row)
            connection.executemany(
                "INSERT INTO file VALUES (?, ?, ?)",
                [(row[0], name, content) for name, content in files.items()],
            )
        return row[0]

    def list(self, *, kind: str | None = None, limit: int = 1000) -> list[Run]:
        """The latest runs first, at most `limit` of them, of one kind or all."""
        with self._open() as connection:
            rows = connection.execute(
                "SELECT id, kind, title, created, command, settings, summary, "
                "(SELECT json_group_array(name) FROM file WHERE run = run.id) "
                "FROM run WHERE ? IS NULL OR kind = ? ORDER BY created DESC, rowid DESC LIMIT ?",
                (kind, kind, limit),
            ).fetchall()
        return [_run(row) for row in rows]

    def get(self, run: str) -> Run:
        """One run.

        Raises:
            SettingError: The library has none of that name.
        """
        with self._open() as connection:
            row = connection.execute(
                "SELECT id, kind, title, created, command, settings, summary, "
                "(SELECT json_group_array(name) FROM file WHERE run = run.id) "
                "FROM run WHERE id = ?",
                (run,),
            ).fetchone()
        if row is None:
            raise SettingError("this run is no longer in the library")
        return _run(row)

    def file(self, run: str, name: str) -> bytes:
        """A file of a run.

        Raises:
            SettingError: There is none of that name.
        """
        with self._open() as connection:
            row = connection.execute(
                "SELECT content FROM file WHERE run = ? AND name = ?", (run, name)
            ).fetchone()
        if row is None:
            raise SettingError(f"this run has no file {name!r}")
        return row[0]

    def rename(self, run: str, title: str) -> None:
        """Call a run something else.

        Raises:
            SettingError: An empty or overlong title, or no such run.
        """
        with self._open() as connection:
            done = connection.execute(
                "UPDATE run SET title = ? WHERE id = ?", (_title(title), run)
            ).rowcount
        if not done:
            raise SettingError("this run is no longer in the library")

    def delete(self, run: str) -> None:
        """Forget a run and its files; one that is gone already does no harm."""
        with self._open() as connection:
            connection.execute("DELETE FROM run WHERE id = ?", (run,))

    @contextmanager
    def _open(self) -> Generator[sqlite3.Connection]:
        """A connection; what is done in it counts as a whole or not at all."""
        try:
            with closing(sqlite3.connect(self.path, timeout=PATIENCE)) as connection, connection:
                connection.execute("PRAGMA foreign_keys = ON")
                connection.execute("PRAGMA synchronous = FULL")
                connection.execute("PRAGMA trusted_schema = OFF")  # the file may be another's
                yield connection
        except sqlite3.DatabaseError as error:
            raise FileError(
                f"the library {self.path} cannot be used ({error}); "
                "name another file with --library"
            ) from error


def _prepare(connection: sqlite3.Connection, path: Path) -> None:
    """Make the tables of a new library; refuse a foreign or later file."""
    application, version = (
        connection.execute(f"PRAGMA {name}").fetchone()[0]
        for name in ("application_id", "user_version")
    )
    tables = connection.execute("SELECT count(*) FROM sqlite_schema").fetchone()[0]
    if application == 0 and tables == 0:
        for statement in _TABLES.split(";"):
            connection.execute(statement)
        connection.execute(f"PRAGMA application_id = {APPLICATION}")
        connection.execute(f"PRAGMA user_version = {VERSION}")
    elif application != APPLICATION:
        raise FileError(f"{path} is not a library of runs; name another file with --library")
    elif version != VERSION:
        raise FileError(
            f"{path} is a library of version {version}, this rovernav knows {VERSION}; "
            "name another file with --library"
        )


def _title(text: str) -> str:
    """A title as it is kept: one line, of what can be shown."""
    plain = " ".join("".join(c if c.isprintable() else " " for c in text).split())
    if not plain:
        raise SettingError("a run needs a name; write a few words")
    if len(plain) > MAX_TITLE:
        raise SettingError(f"a name may have {MAX_TITLE} letters, this one has {len(plain)}")
    return plain


def _check_file(name: str, content: bytes) -> None:
    plain = name.replace(".", "").replace("-", "").replace("_", "")
    if not (plain.isascii() and plain.isalnum()) or name.startswith(".") or len(name) > 80:
        raise SettingError(f"a run's file needs a plain name like trace.csv, got {name!r}")
    if len(content) > MAX_FILE:
        raise SettingError(f"{name} has {len(content):,} bytes, more than {MAX_FILE:,}")


def _json(data: Mapping[str, Any]) -> str:
    try:
        return canonical_json(plain_data(data))
    except (TypeError, ValueError) as error:
        raise SettingError(f"a run's settings and summary must be plain data: {error}") from None


def _run(row: tuple[Any, ...]) -> Run:
    *plain, settings, summary, files = row
    return Run(
        id=plain[0],
        kind=plain[1],
        title=plain[2],
        created=plain[3],
        command=plain[4],
        settings=json.loads(settings),
        summary=json.loads(summary),
        files=tuple(sorted(json.loads(files))),
    )
