"""What the commands share: tables, JSON, the progress bar, the common options."""

from __future__ import annotations

import contextlib
import json
import math
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

PATIENCE = 2.0
"""A progress bar appears on work that lasts longer than this [s]."""

Out = Annotated[Path, Parameter(help="Folder for what is written; made if needed.")]
Json = Annotated[
    bool, Parameter(name="--json", negative="", help="Print one JSON object instead of words.")
]
Seed = Annotated[int, Parameter(help="Seed of everything random; same seed, same result.")]


def print_json(data: dict[str, Any]) -> None:
    """One JSON object on standard output; NaN and infinity become null."""
    print(json.dumps(_plain(data), indent=2, allow_nan=False))


def print_table(title: str, columns: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """A small table on standard output; the first column to the left, numbers to the right."""
    from rich import box
    from rich.console import Console
    from rich.table import Table

    table = Table(title=title, box=box.SIMPLE_HEAD, title_justify="left", title_style="bold")
    for number, column in enumerate(columns):
        table.add_column(column, justify="left" if number == 0 else "right", overflow="fold")
    for row in rows:
        table.add_row(*row)
    Console(highlight=False, markup=False).print(table)


def say(text: str = "") -> None:
    """A line on standard output."""
    print(text)


def note(text: str) -> None:
    """A line on the error stream: news that are no result."""
    print(text, file=sys.stderr)


def say_files(files: Sequence[Path]) -> None:
    """Where the results are."""
    say("Written:")
    for path in files:
        say(f"  {path}")


@contextlib.contextmanager
def progress_bar(what: str) -> Iterator[Callable[[float, str], None]]:
    """A bar on the error stream, shown only once the work has lasted two seconds.

    Yields:
        Call it with the share done (0 to 1) and a few words.
    """
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    console = Console(stderr=True)
    bar = Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %"),
        TimeElapsedColumn(),
        TextColumn("{task.fields[words]}"),
        console=console,
        transient=True,
    )
    task = bar.add_task(what, total=1.0, words="")
    began, shown = time.monotonic(), False

    def update(share: float, words: str) -> None:
        nonlocal shown
        if not shown and console.is_terminal and time.monotonic() - began > PATIENCE:
            bar.start()
            shown = True
        bar.update(task, completed=share, words=words)

    try:
        yield update
    finally:
        if shown:
            bar.stop()


def _plain(item: Any) -> Any:
    """Numbers, lists and texts that JSON knows."""
    if isinstance(item, dict):
        return {str(key): _plain(value) for key, value in item.items()}
    if isinstance(item, (list, tuple)):
        return [_plain(value) for value in item]
    if isinstance(item, Path):
        return str(item)
    if hasattr(item, "tolist"):
        return _plain(item.tolist())
    if isinstance(item, float):
        return item if math.isfinite(item) else None
    return item
