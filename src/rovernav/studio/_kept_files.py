"""Files of a kept run: those in the library, those made when asked for, all in one archive."""

from __future__ import annotations

import dataclasses
import io
import tempfile
import zipfile
from pathlib import Path

from ..core import SettingError
from ..learn import (
    OnlineSettings,
    Patterns,
    Progress,
    Training,
    parse_patterns,
    trace_csv,
    train,
)
from ..nets import Network, parse_network
from ..show import draw_training
from ._kept import CURVE, INITIAL, TABLE, read_curve
from ._library import Library, Run

MAX_TRACE = 3_000_000
"""Numbers of a trace that is made here; longer ones are for the command line."""


def training_png(library: Library, run: Run) -> bytes:
    """The error curve as a printed figure."""
    nothing = parse_network(library.file(run.id, INITIAL), INITIAL).parameters[:0]
    updates = run.summary["updates"]
    points = read_curve(library.file(run.id, CURVE))
    curve = [
        Progress(
            epoch=point.epoch,
            updates=updates if point is points[-1] else 0,
            worst=point.worst,
            loss=point.loss,
            seconds=0.0,
            parameters=nothing,
        )
        for point in points
    ]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "training.png"
        draw_training(curve, path, tolerance=run.settings["tolerance"], title=run.title)
        return path.read_bytes()


def training_trace(library: Library, run: Run) -> bytes:
    """Every weight after every update as CSV, trained once more from the run's own files.

    Raises:
        SettingError: It would be too long; the sentence names the command that writes it.
    """
    network, table = initial_and_table(library, run)
    updates = int(run.summary["updates"])
    if updates * len(network.parameters) > MAX_TRACE:
        raise SettingError(
            f"a trace of {updates:,} updates is too long for the page; "
            f"write it with: {run.command} --trace trace.csv"
        )
    out = io.StringIO()
    settings = dataclasses.replace(
        settings_of(run), tolerance=0.0, epochs=int(run.summary["epochs"])
    )
    train(Training.fresh(network), table, settings, recorder=trace_csv(out, network))
    return out.getvalue().encode()


def initial_and_table(library: Library, run: Run) -> tuple[Network, Patterns]:
    """What a kept training began with."""
    source = str(run.settings["table"])
    table = parse_patterns(library.file(run.id, TABLE).decode(), source)
    return parse_network(library.file(run.id, INITIAL), INITIAL), table


def settings_of(run: Run) -> OnlineSettings:
    """The settings of a kept training."""
    names = [field.name for field in dataclasses.fields(OnlineSettings)]
    try:
        return OnlineSettings(**{name: run.settings[name] for name in names})
    except (KeyError, TypeError) as error:
        raise SettingError(f"these are not the settings of a training: {error}") from None


def archive(library: Library, run: Run) -> bytes:
    """All files of a run, and a text that says how to do it again."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as file:
        for name in run.files:
            file.writestr(name, library.file(run.id, name))
        file.writestr("README.txt", _readme(run))
    return out.getvalue()


def archive_name(run: Run) -> str:
    """A file name for the archive, of plain letters."""
    words = "".join(c if c.isascii() and c.isalnum() else "-" for c in run.title.lower())
    return "-".join(part for part in words.split("-") if part)[:60] or run.id


def _readme(run: Run) -> str:
    numbers = "\n".join(f"  {name}: {item}" for name, item in run.summary.items())
    return (
        f"{run.title}\n\nThe same again, in the folder with these files:\n\n  {run.command}\n\n"
        f"What came out:\n\n{numbers}\n"
    )
