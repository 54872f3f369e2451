"""The two ways to train, the options of each, and how a training of either is run."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from ._console import note
from ._options import Whole

if TYPE_CHECKING:
    from ..core import Executor
    from ..learn import (
        BatchSettings,
        BatchTraining,
        Listener,
        OnlineSettings,
        Patterns,
        Progress,
        Recorder,
        Training,
    )
    from ..nets import Network
    from ._workers import Place

METHODS = ("batch", "online")
_ONLINE_MOMENTUM = 0.5
"""The paper's test case; the library itself begins without."""


@Parameter(name="*")
@dataclasses.dataclass(frozen=True, kw_only=True)
class BatchOptions:
    """What only mini-batch training knows; None where the user did not say."""

    optimizer: Annotated[str | None, Parameter(help="Batch: adam (usual) or sgd.")] = None
    loss: Annotated[
        str | None, Parameter(help="Batch: mse (usual), softmax or binary cross-entropy.")
    ] = None
    batch: Annotated[Whole | None, Parameter(help="Batch: patterns per update, usually 256.")] = (
        None
    )
    schedule: Annotated[
        str | None, Parameter(help="Batch: the rate is constant (usual) or falls along a cosine.")
    ] = None
    validation: Annotated[
        float | None,
        Parameter(help="Batch: share of the table, its last rows, only measured; usually 0."),
    ] = None
    shards: Annotated[
        Whole | None, Parameter(help="Batch: parts that workers can share out, usually 1.")
    ] = None


def settings_of(
    method: str, both: dict[str, Any], online: dict[str, Any], batch: BatchOptions, place: Place
) -> OnlineSettings | BatchSettings:
    """The settings of the method asked for; None stands for what is usual.

    Args:
        method: ``online`` or ``batch``.
        both: Options of both methods.
        online: Options of online training alone; those that are no setting are only checked.
        batch: Options of mini-batch training alone.
        place: Who does the work: mini-batch training alone asks.

    Raises:
        SettingError: Unknown method, an option of the other one, or a value that is not allowed.
    """
    from ..core import SettingError, suggest
    from ..learn import BatchSettings, OnlineSettings

    if method not in METHODS:
        raise SettingError(f"unknown --method {method!r}; {suggest(method, METHODS)}")
    only_batch = _given(dataclasses.asdict(batch))
    foreign = (
        _given(online)
        if method == "batch"
        else only_batch | _given({"workers": place.workers, "cluster": place.cluster})
    )
    if foreign:
        own = "online" if method == "batch" else "batch"
        name = f"--{next(iter(foreign)).replace('_', '-')}"
        raise SettingError(f"{name} goes with --method {own}, not with --method {method}")
    if method == "batch":
        return BatchSettings(**_given(both), **only_batch)
    usual: dict[str, Any] = {"momentum": _ONLINE_MOMENTUM}
    return OnlineSettings(**(usual | _given(both) | _given({"rule": online["rule"]})))


def fresh_training(
    network: Network, table: Patterns, settings: OnlineSettings | BatchSettings
) -> Training | BatchTraining:
    """A training that has not begun, of the settings' method.

    Raises:
        InputError: Network, table and settings do not fit each other.
    """
    from ..learn import BatchTraining, OnlineSettings, Training, check_fit
    from ..nets import check_loss

    check_fit(network, table)
    if isinstance(settings, OnlineSettings):
        return Training.fresh(network)
    check_loss(settings.loss, network.activations[-1])
    settings.learnt(len(table.x))
    return BatchTraining.fresh(network)


def run_training(
    start: Training | BatchTraining,
    table: Patterns,
    settings: OnlineSettings | BatchSettings,
    *,
    place: Place,
    on_event: Listener,
    keep: tuple[Path | None, Recorder | None],
) -> Training | BatchTraining:
    """Train to the end.

    Args:
        start: Where to begin.
        table: What to learn.
        settings: How.
        place: Who does the work of mini-batch training.
        on_event: Told of progress.
        keep: Checkpoint file and trace, where wanted.
    """
    from ..learn import BatchTraining, OnlineSettings, checkpointer, save_training, train
    from ..learn import train_batches as batches

    checkpoint, recorder = keep
    save: Callable[[Any], None] | None = None
    if checkpoint is not None:
        save = checkpointer(checkpoint, settings, table)
        save(start)
    if isinstance(settings, OnlineSettings):
        assert not isinstance(start, BatchTraining)
        ended: Training | BatchTraining = train(
            start, table, settings, on_event=on_event, recorder=recorder, on_step=save
        )
    else:
        assert isinstance(start, BatchTraining)
        with place.executor(threads=True) as executor:
            _tell_idle(executor, settings.shards)
            ended = batches(
                start, table, settings, on_event=on_event, on_step=save, workers=executor
            )
    if checkpoint is not None:
        save_training(ended, settings, table, checkpoint)
    return ended


def _tell_idle(executor: Executor, shards: int) -> None:
    if executor.workers > shards:
        note(
            f"note: {shards} of {executor.workers} workers have something to do; --shards "
            f"{executor.workers} feeds them all, with other last bits of the weights"
        )


def share_done(event: Progress, table: Patterns, settings: OnlineSettings | BatchSettings) -> float:
    """Which share of all updates is done."""
    from ..learn import OnlineSettings

    rows = len(table.x)
    if not isinstance(settings, OnlineSettings):
        learnt = settings.learnt(rows)
        rows = -(-learnt // min(settings.batch, learnt))
    return event.updates / max(1, settings.epochs * rows)


def progress_words(event: Progress) -> str:
    """How well it goes, in a few words."""
    if event.worst == event.worst:
        return f"max |error| {event.worst:.3g}"
    held = f", held out {event.validation:.3g}" if event.validation == event.validation else ""
    return f"loss {event.loss:.3g}{held}"


def _given(options: dict[str, Any]) -> dict[str, Any]:
    return {name: item for name, item in options.items() if item is not None}
