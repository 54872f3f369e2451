"""The results of a sweep as CSV."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import BinaryIO

from ..core import write_atomic, write_text
from ._sweep import SweepResult
from ._sweep_block import STOPS, Rows
from ._sweep_settings import SweepSettings
from ._sweep_store import SweepStore

_MEMBERS = "member,eta,momentum,seed,epochs,updates,stop,max_error\n"
_SETTINGS = (
    "eta", "momentum", "members", "solved", "success", "success_low", "success_high",
    "epochs_q1", "epochs_median", "epochs_q3", "updates_q1", "updates_median", "updates_q3",
    "diverged", "diverged_share", "least_error",
)  # fmt: skip


def write_members_csv(
    store: SweepStore, settings: SweepSettings, patterns: int, path: Path
) -> Path:
    """One line for each member of a sweep.

    Args:
        store: Where its rows are.
        settings: The sweep's.
        patterns: Patterns of its table.
        path: Where to write.

    Returns:
        `path`.
    """

    def write(file: BinaryIO) -> None:
        file.write(_MEMBERS.encode())
        member = 0
        for rows in store.rows():
            file.write(_lines(settings, patterns, member, rows).encode())
            member += len(rows)

    write_atomic(path, write)
    return path


def _lines(settings: SweepSettings, patterns: int, member: int, rows: Rows) -> str:
    starts = [f"{eta!r},{momentum!r}" for eta, momentum in settings.rates]
    seeds, first = settings.seeds, settings.first_seed
    return "".join(
        f"{k},{starts[k // seeds]},{first + k % seeds},{epochs},{epochs * patterns},"
        f"{STOPS[stop]},{error!r}\n"
        for k, (epochs, error, stop) in enumerate(rows.tolist(), member)
    )


def write_settings_csv(result: SweepResult, path: Path) -> Path:
    """One line for each eta and momentum of a sweep: share solved, epochs, updates, diverged.

    Args:
        result: What came out.
        path: Where to write.

    Returns:
        `path`.
    """
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(_SETTINGS)
    for s in result.settings:
        numbers = (
            s.eta, s.momentum, s.members, s.solved, s.success, s.low, s.high,
            *s.epochs, *s.updates, s.diverged, s.diverged / s.members, s.least_error,
        )  # fmt: skip
        writer.writerow("" if number != number else repr(number) for number in numbers)
    write_text(path, out.getvalue())
    return path
