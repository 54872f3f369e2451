"""What the commands print: words, tables, JSON, complaints, the progress bar."""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import sys
import textwrap
import threading
from collections.abc import Callable, Generator, Iterable, Sequence
from pathlib import Path
from typing import Any

PATIENCE = 2.0
"""A progress bar appears on work that lasts longer than this [s]."""


def print_json(data: dict[str, Any]) -> None:
    """One JSON object on standard output; NaN and infinity become null."""
    from ..core import plain_data

    print(json.dumps(plain_data(data), indent=2, allow_nan=False))


def print_table(title: str, columns: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """A small table on standard output: texts to the left, columns of numbers to the right.

    Where the terminal is too narrow for it, each row becomes a few lines; nothing is broken.
    """
    rows = [list(row) for row in rows]
    say(title)
    widths = [max(map(len, cells)) for cells in zip(columns, *rows, strict=True)]
    if 2 + sum(widths) + 3 * (len(widths) - 1) > _width():
        for name, *cells in rows:
            say(f"  {columns[0]} {name}".replace("   ", "  "))
            print_pairs([(f"  {c}", cell) for c, cell in zip(columns[1:], cells, strict=True)])
        say()
        return
    numeric = [all(map(_is_number, cells)) for cells in zip(*rows, strict=True)]
    for cells in (columns, ["-" * width for width in widths], *rows):
        line = "   ".join(
            cell.rjust(width) if number else cell.ljust(width)
            for cell, width, number in zip(cells, widths, numeric, strict=True)
        )
        say(f"  {line}".rstrip())
    say()


def print_pairs(pairs: Iterable[tuple[str, str]]) -> None:
    """Names and values, one pair a line; long values go on below themselves, words whole."""
    pairs = list(pairs)
    indent = min(max(len(name) for name, _ in pairs) + 4, _width() // 2)
    for name, text in pairs:
        lines = textwrap.wrap(
            text, max(_width() - indent, 20), break_long_words=False, break_on_hyphens=False
        )
        head = f"  {name}".ljust(indent)
        for number, line in enumerate(lines or [""]):
            lead = head if number == 0 else " " * indent
            say((lead if lead.endswith(" ") else f"{lead} ") + line)


def say(text: str = "") -> None:
    """A line on standard output."""
    print(text)


def note(text: str) -> None:
    """A line on the error stream: news that are no result."""
    if sys.stderr is not None:
        print(text, file=sys.stderr)


def announce_compiling() -> None:
    """Say on a terminal, once, that kernels are being compiled: the wait will not come again."""
    from ..kernels.news import LISTENERS

    def first(_kernel: str) -> None:
        LISTENERS.remove(first)
        if _is_terminal():
            note("compiling kernels for this machine; they are kept, so the next start is quick")

    LISTENERS[:] = [first]


def complain(message: str, code: int, *, hint: str = "") -> int:
    """One line on the error stream, red on a terminal; returns the exit code."""
    red, dim, end = ("\033[1;31m", "\033[2m", "\033[0m") if _has_colour() else ("", "", "")
    with contextlib.suppress(OSError):  # who closed the error stream wants to hear nothing
        note(f"{red}error:{end} {printable(' '.join(message.split()))}")
        if hint:
            note(f"{dim}{hint}{end}")
    return code


def printable(text: str) -> str:
    """The text with escapes for what no terminal or font can show."""
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)


def say_files(files: Sequence[Path]) -> None:
    """Where the results are."""
    say("Written:")
    for path in files:
        say(f"  {path}")


@contextlib.contextmanager
def progress_bar(what: str) -> Generator[Callable[[float, str], None]]:
    """A bar on the error stream, shown only on a terminal and once two seconds have passed.

    Yields:
        Call it with the share done (0 to 1) and a few words; until then the bar only moves.
    """
    if not _is_terminal():
        yield lambda share, words: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    bar = Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        TimeElapsedColumn(),
        TextColumn("{task.fields[words]}"),
        console=Console(stderr=True),
        redirect_stdout=False,  # results stay results
        transient=True,
    )
    task = bar.add_task(what, total=None, words="")
    timer = threading.Timer(PATIENCE, bar.start)  # whatever the work does: reading, compiling
    timer.daemon = True
    timer.start()
    try:
        yield lambda share, words: bar.update(task, total=1.0, completed=share, words=words)
    finally:
        timer.cancel()
        timer.join()
        bar.stop()


def _is_number(text: str) -> bool:
    try:
        float(text.replace(",", ""))
    except ValueError:
        return False
    return True


def _width() -> int:
    return max(20, shutil.get_terminal_size().columns)


def _is_terminal() -> bool:
    return sys.stderr is not None and sys.stderr.isatty() and os.environ.get("TERM") != "dumb"


def _has_colour() -> bool:
    return _is_terminal() and not os.environ.get("NO_COLOR")
