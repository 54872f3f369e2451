"""Pattern tables: inputs and targets with names, read from CSV with exact complaints."""

from __future__ import annotations

import csv
import dataclasses
import io
import math
from collections.abc import Iterator
from importlib import resources
from pathlib import Path

import numpy as np

from ..core import (
    F64,
    PatternError,
    canonical_json,
    read_only,
    read_text,
    sha256_of,
    suggest,
    value,
    write_text,
)

MAX_BYTES = 2_000_000_000
_INPUT, _TARGET = ("in:", "input:"), ("out:", "target:")


@value
class Patterns:
    """What a network shall learn.

    Attributes:
        x: Inputs (p, i).
        y: Targets (p, o).
        inputs: Name of each input.
        outputs: Name of each target.
        source: Where the table came from.
    """

    x: F64
    y: F64
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    source: str = "memory"

    def _check(self) -> None:
        for name in ("x", "y"):  # one dtype and layout, whatever was given
            plain = np.ascontiguousarray(getattr(self, name), dtype=np.float64)
            object.__setattr__(self, name, read_only(plain))
        rows = self.x.shape[:1]
        wanted = ((*rows, len(self.inputs)), (*rows, len(self.outputs)))
        if self.x.ndim != 2 or (self.x.shape, self.y.shape) != wanted:
            raise PatternError(
                f"patterns need x (p, {len(self.inputs)}) and y (p, {len(self.outputs)}), "
                f"got {self.x.shape} and {self.y.shape}"
            )
        if not len(self.x):
            raise PatternError("a pattern table needs at least one pattern")
        if not (np.isfinite(self.x).all() and np.isfinite(self.y).all()):
            raise PatternError("patterns must be finite numbers")

    @property
    def sha256(self) -> str:
        """SHA-256 of names and numbers, for checkpoints and network files."""
        names = canonical_json([self.inputs, self.outputs]).encode()
        return sha256_of(names, self.x.tobytes(), self.y.tobytes())


def read_patterns(path: Path, *, inputs: int | None = None) -> Patterns:
    """Read a pattern table from a CSV file.

    The first line names the columns. ``in:NAME`` marks inputs and ``out:NAME`` targets, in any
    order; without such marks the first `inputs` columns are inputs and the others targets.
    Empty lines and lines that begin with ``#`` are passed over.

    Args:
        path: The file, UTF-8.
        inputs: Number of inputs, for headers without marks; also checked against marked ones.

    Raises:
        PatternError: The first line that cannot be used, by number, and what is wrong with it.
        FileError: The file cannot be read.
    """
    text = read_text(path, limit=MAX_BYTES, what="pattern table")
    table = parse_patterns(text, path, inputs=inputs)
    return dataclasses.replace(table, source=str(path.name))


def parse_patterns(text: str, source: Path | str, *, inputs: int | None = None) -> Patterns:
    """The pattern table in the text of a CSV file.

    Args:
        text: The whole file.
        source: What error messages call it.
        inputs: As for `read_patterns`.

    Raises:
        PatternError: As `read_patterns`.
    """
    rows = _rows(source, text)
    if not rows:
        raise PatternError(f"{source} is empty; line 1 must name the columns, like in:x,out:y")
    line, header = rows[0]
    names = [name.strip() for name in header]
    sources, targets = _columns(source, line, names, inputs)
    if len(rows) == 1:
        raise PatternError(
            f"{source} has a header but no pattern; add at least one line of numbers"
        )
    table = np.array([_numbers(source, line, names, row) for line, row in rows[1:]])
    return Patterns(
        x=np.ascontiguousarray(table[:, sources]),
        y=np.ascontiguousarray(table[:, targets]),
        inputs=tuple(_bare(names[c]) for c in sources),
        outputs=tuple(_bare(names[c]) for c in targets),
        source=str(source),
    )


def shipped_patterns(name: str) -> Patterns:
    """A pattern table that comes with the package: see `shipped_tables`.

    Raises:
        PatternError: No table has that name.
    """
    if name not in shipped_tables():
        raise PatternError(f"there is no pattern table {name!r}; {suggest(name, shipped_tables())}")
    with resources.as_file(resources.files("rovernav.learn") / "tables" / f"{name}.csv") as path:
        return read_patterns(path)


def shipped_tables() -> list[str]:
    """Names of the pattern tables that come with the package."""
    folder = resources.files("rovernav.learn") / "tables"
    return sorted(item.name[:-4] for item in folder.iterdir() if item.name.endswith(".csv"))


def write_patterns(patterns: Patterns, path: Path) -> None:
    """Write a table that `read_patterns` reads back without loss."""
    write_text(path, patterns_csv(patterns))


def patterns_csv(patterns: Patterns) -> str:
    """The text of a table, as `write_patterns` writes it."""
    header = [f"in:{n}" for n in patterns.inputs] + [f"out:{n}" for n in patterns.outputs]
    table = np.hstack([patterns.x, patterns.y]).tolist()
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(header)
    writer.writerows([repr(float(cell)) for cell in row] for row in table)
    return out.getvalue()


def parse_number(cell: str) -> float:
    """The number in a cell of a table.

    Raises:
        PatternError: It is empty, no number, or not a finite one.
    """
    if not _is_number(cell):
        shown = cell.strip()[:40]
        raise PatternError(f"{shown!r} is not a number" if shown else "the cell is empty")
    number = float(cell)
    if not math.isfinite(number):
        raise PatternError(f"{cell.strip()} is not finite")
    return number


def _rows(path: Path | str, text: str) -> list[tuple[int, list[str]]]:
    """Line numbers and cells of the lines that count."""
    rows: list[tuple[int, list[str]]] = []
    begun = 0  # line at which the present row begins; a cell in quotes may span lines

    def lines() -> Iterator[str]:
        nonlocal begun
        for number, line in enumerate(io.StringIO(text, newline=""), 1):
            if begun == 0 and line.lstrip().startswith("#"):
                continue
            begun = begun or number
            yield line

    try:
        for row in csv.reader(lines(), strict=True):
            if any(cell.strip() for cell in row):
                rows.append((begun, row))
            begun = 0
    except csv.Error as error:
        raise PatternError(f"{path}, line {begun}: {error}") from None
    return rows


def _columns(
    path: Path | str, line: int, names: list[str], inputs: int | None
) -> tuple[list[int], list[int]]:
    """Which columns are inputs and which targets."""
    where = f"{path}, line {line}"
    _check_names(where, names)
    sources = [c for c, n in enumerate(names) if n.lower().startswith(_INPUT)]
    targets = [c for c, n in enumerate(names) if n.lower().startswith(_TARGET)]
    unmarked = [n for c, n in enumerate(names) if c not in sources and c not in targets]
    if not sources and not targets:
        if inputs is None:
            raise PatternError(
                f"{where}: mark the columns as in:NAME or out:NAME, or give the topology"
            )
        columns = list(range(len(names)))
        sources, targets = columns[: max(0, inputs)], columns[max(0, inputs) :]
    elif unmarked:
        raise PatternError(f"{where}: column {unmarked[0]!r} is marked neither in: nor out:")
    if not sources or not targets:
        raise PatternError(
            f"{where}: a table needs inputs and targets, got {len(sources)} and {len(targets)}"
        )
    if inputs is not None and len(sources) != inputs:
        raise PatternError(f"{where}: {len(sources)} inputs, but the topology has {inputs}")
    return sources, targets


def _check_names(where: str, names: list[str]) -> None:
    bare = [(name.lower().startswith(_INPUT), _bare(name)) for name in names]
    for number, (name, kind_and_name) in enumerate(zip(names, bare, strict=True), 1):
        if not kind_and_name[1]:
            raise PatternError(f"{where}: column {number} has no name")
        if bare.count(kind_and_name) > 1:
            raise PatternError(f"{where}: column name {name!r} stands twice")
    if all(_is_number(name) for name in names):
        raise PatternError(f"{where}: the first line must name the columns, got numbers")


def _numbers(path: Path | str, line: int, names: list[str], row: list[str]) -> list[float]:
    if len(row) != len(names):
        raise PatternError(f"{path}, line {line}: {len(names)} cells needed, got {len(row)}")
    out: list[float] = []
    for name, cell in zip(names, row, strict=True):
        try:
            number = parse_number(cell)
        except PatternError as error:
            raise PatternError(f"{path}, line {line}, column {name!r}: {error}") from None
        out.append(number)
    return out


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return "_" not in cell


def _bare(name: str) -> str:
    for mark in (*_INPUT, *_TARGET):
        if name.lower().startswith(mark):
            return name[len(mark) :].strip()
    return name
