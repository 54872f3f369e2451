"""What the Runs tab knows about each kind of run; a new kind is one more entry."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from ._drive_compare import COLUMNS, compare_drives, drive_png, drive_result
from ._kept import CURVE, read_curve
from ._kept_files import initial_and_table, settings_of, training_png, training_trace
from ._library import Library, Run
from ._session import Session
from ._train_view import overlaid_options


class RunKind(NamedTuple):
    """A kind of run.

    Attributes:
        label: Its name in the plural.
        icon: Its icon.
        tab: The tab in which such a run is opened again.
        result: What came out, in a few words.
        columns: Keys of the summary that a comparison shows, with their headings.
        made: Files that are made when asked for, by name.
        reopen: Sets a session up as the run was.
        chart: Options of a chart that shows runs on top of each other; None without one.
        compare: Builds more elements that compare runs; None without any.
    """

    label: str
    icon: str
    tab: str
    result: Callable[[Run], str]
    columns: Mapping[str, str]
    made: Mapping[str, Callable[[Library, Run], bytes]]
    reopen: Callable[[Session, Run], None]
    chart: Callable[[Library, Sequence[Run]], dict[str, Any]] | None = None
    compare: Callable[[Library, Sequence[Run]], None] | None = None


def _training_result(run: Run) -> str:
    error = run.summary.get("max_error")
    shown = "not finite" if error is None else f"{error:.3g}"
    return f"{run.summary.get('stop') or 'paused'}, {run.summary['epochs']:,} epochs, error {shown}"


def _reopen_training(session: Session, run: Run) -> None:
    network, table = initial_and_table(session.library, run)
    settings = settings_of(run)
    session.train.change(
        table=table,
        shipped=run.settings["shipped"],
        hidden=network.topology[1:-1],
        activations=network.activations,
        weights=run.settings["weights"],
        given=network if run.settings["weights"] == "given" else None,
        eta=settings.eta,
        momentum=settings.momentum,
        rule=settings.rule,
        tolerance=settings.tolerance,
        epochs=settings.epochs,
        order=settings.order,
        seed=settings.seed,
    )
    session.train.reset()


def _training_chart(library: Library, runs: Sequence[Run]) -> dict[str, Any]:
    curves = {
        f"{number} {run.title}": read_curve(library.file(run.id, CURVE))
        for number, run in enumerate(runs, 1)
    }
    return overlaid_options(curves)


def _reopen_drive(session: Session, run: Run) -> None:
    files = {name: session.library.file(run.id, name) for name in run.files}
    session.drive.restore(dict(run.settings), files)


KINDS: dict[str, RunKind] = {
    "training": RunKind(
        label="Trainings",
        icon="psychology",
        tab="Train",
        result=_training_result,
        columns={
            "topology": "network",
            "stop": "ended by",
            "epochs": "epochs",
            "updates": "updates",
            "max_error": "largest |error|",
            "loss": "mean loss",
            "weights_sha256": "weights",
        },
        made={"training.png": training_png, "trace.csv": training_trace},
        reopen=_reopen_training,
        chart=_training_chart,
    ),
    "drive": RunKind(
        label="Drives",
        icon="explore",
        tab="Drive",
        result=drive_result,
        columns=COLUMNS,
        made={"drive.png": drive_png},
        reopen=_reopen_drive,
        compare=compare_drives,
    ),
}
