"""`rovernav train`: the training engine."""

from __future__ import annotations

import contextlib
import dataclasses
import math
import sys
from collections.abc import Generator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from ._console import note, print_json, progress_bar, say, say_files
from ._files import claim_folder, keep_apart
from ._method import (
    BatchOptions,
    fresh_training,
    progress_words,
    run_training,
    settings_of,
    share_done,
)
from ._options import Json, Out, OutFile, OutFileOrDash, Seed, Whole
from ._subject import initial_network, read_table, same_network
from ._workers import Place

if TYPE_CHECKING:
    from ..learn import (
        BatchSettings,
        BatchTraining,
        OnlineSettings,
        Patterns,
        Progress,
        Recorder,
        Training,
    )
    from ..nets import Network


def train(
    patterns: Annotated[str, Parameter(help="CSV file, or a shipped table such as bassil-v1.")],
    /,
    *,
    topology: Annotated[
        str | None,
        Parameter(help="Units per layer, inputs first; default 2-3-2, or that of --init FILE."),
    ] = None,
    activations: Annotated[
        str | None,
        Parameter(help="One per layer after the inputs; default sigmoid, the outputs linear."),
    ] = None,
    method: Annotated[
        str, Parameter(help="online: an update per pattern; batch: one per mini-batch, in float32.")
    ] = "online",
    eta: Annotated[
        float | None, Parameter(help="Learning rate; usually 0.25, in batches 0.001.")
    ] = None,
    momentum: Annotated[
        float | None,
        Parameter(help="Share of the last change repeated; usually 0.5, in batches 0.9."),
    ] = None,
    tolerance: Annotated[
        float | None,
        Parameter(
            help="Stop once every |error|, in batches the mean loss, is below this; 0 does all "
            "epochs. Usually 0.01, in batches 0."
        ),
    ] = None,
    epochs: Annotated[
        Whole | None, Parameter(help="Epochs at most; usually 5000, in batches 100.")
    ] = None,
    rule: Annotated[str | None, Parameter(help="Online: paper (usual) or textbook.")] = None,
    order: Annotated[
        str | None,
        Parameter(help="cyclic or shuffled; usually cyclic, in batches shuffled."),
    ] = None,
    batches: BatchOptions | None = None,
    place: Place | None = None,
    init: Annotated[
        str, Parameter(help="Network file, 'paper' for its weights, or 'seed' to draw them.")
    ] = "seed",
    seed: Seed = 0,
    trace: Annotated[
        OutFileOrDash | None,
        Parameter(help="Online: CSV with every weight after every pattern; - prints them."),
    ] = None,
    checkpoint: Annotated[
        OutFile | None, Parameter(help="Save the training here every second.")
    ] = None,
    resume: Annotated[
        bool,
        Parameter(
            negative="", show_default=False, help="Go on from the checkpoint, to the same bits."
        ),
    ] = False,
    out: Out = Path("rovernav-train"),
    json: Json = False,
) -> int:
    """Train a network by back-propagation, one pattern or one mini-batch at a time.

    Writes network.safetensors and training.png. Ctrl-C stops and keeps what was learnt. A training
    that diverges ends with exit code 1. Workers never change a result.

    Example: rovernav train bassil-v1 --topology 2-3-2 --init paper --momentum .5
    """
    place = place or Place()
    with progress_bar("training") as update:
        both = {"eta": eta, "momentum": momentum, "tolerance": tolerance, "epochs": epochs,
                "order": order, "seed": seed}  # fmt: skip
        online = {"rule": rule, "trace": trace}
        settings = settings_of(method, both, online, batches or BatchOptions(), place)
        network = initial_network(topology, activations, init, seed, single=method == "batch")
        table = read_table(patterns, network.topology[0])
        files = [out / "network.safetensors", out / "training.png"]
        _check_files(files, [patterns, init], trace, checkpoint)
        start = _start(network, table, settings, checkpoint, resume)
        claim_folder(out)
        curve: list[Progress] = []
        with _recorder(trace, start, json) as recorder:
            if resume:
                _tell_start(start, checkpoint)

            def on_event(event: Progress) -> None:
                curve.append(dataclasses.replace(event, parameters=event.parameters[:0]))
                update(share_done(event, table, settings), progress_words(event))

            training = run_training(
                start, table, settings,
                place=place, on_event=on_event, keep=(checkpoint, recorder),
            )  # fmt: skip
        _write(files, training, table, settings, curve)
    report = _report(training, table, curve)
    report["files"] = files
    if json:
        print_json(report)
    else:
        _print(report, settings)
    return {"diverged": 1, "interrupted": 130}.get(report["stop"], 0)


def _check_files(
    files: list[Path], read: list[str], trace: Path | None, checkpoint: Path | None
) -> None:
    written = {f"--out ({path.name})": path for path in files}
    if trace is not None and str(trace) != "-":
        written["--trace"] = trace
    if checkpoint is not None:
        written["--checkpoint"] = checkpoint
    keep_apart(written, read)


def _start(
    network: Network,
    table: Patterns,
    settings: OnlineSettings | BatchSettings,
    checkpoint: Path | None,
    resume: bool,
) -> Training | BatchTraining:
    """A fresh training, or the one in the checkpoint."""
    from ..core import FileError, SettingError
    from ..learn import load_training

    fresh = fresh_training(network, table, settings)
    if resume and checkpoint is None:
        raise SettingError("--resume needs --checkpoint FILE: where the training was saved")
    if checkpoint is None or not checkpoint.exists():
        return fresh
    if checkpoint.is_dir():
        raise FileError(f"--checkpoint {checkpoint} is a folder; name a file")
    if not resume:
        raise SettingError(
            f"{checkpoint} exists; go on from it with --resume, or name another file"
        )
    training = load_training(checkpoint, settings, table)
    same_network(checkpoint, training.network, network)
    return training


def _tell_start(start: Training | BatchTraining, checkpoint: Path | None) -> None:
    if checkpoint is not None and checkpoint.exists():
        note(f"Resumed from {checkpoint} at epoch {start.epoch:,}.")
    else:
        note(f"There is no checkpoint at {checkpoint} yet: training from the beginning.")


@contextlib.contextmanager
def _recorder(
    trace: Path | None, start: Training | BatchTraining, json: bool
) -> Generator[Recorder | None]:
    """Where the trace goes; the lines that a resumed training has written already are kept."""
    from ..core import FileError
    from ..learn import trace_csv, trace_length, trace_text

    network = start.network
    if trace is None:
        yield None
        return
    if str(trace) == "-":
        yield trace_text((sys.stderr if json else sys.stdout).write, network)
        return
    try:
        trace.parent.mkdir(parents=True, exist_ok=True)
        goes_on = start.updates > 0 and trace.is_file()
        kept = trace_length(trace, network, start.updates) if goes_on else 0
        file = trace.open("r+" if goes_on else "w", encoding="utf-8", newline="")
        if goes_on:
            file.seek(kept)
            file.truncate()
    except OSError as error:
        raise FileError(f"cannot write the trace {trace}: {error.strerror}") from error
    with file:
        yield trace_csv(file, network, header=not goes_on)


def _report(
    training: Training | BatchTraining, table: Patterns, curve: list[Progress]
) -> dict[str, Any]:
    from ..nets import topology_text, weights_sha256

    last = curve[-1]
    return {
        "stop": str(training.stop),
        "epochs": training.epoch,
        "updates": training.updates,
        "patterns": len(table.x),
        "topology": topology_text(training.network.topology),
        "max_error": last.worst,
        "loss": last.loss,
        "validation": last.validation,
        "seconds": last.seconds,
        "weights": training.network.parameters,
        "weights_sha256": weights_sha256(training.network),
    }


def _write(
    files: list[Path],
    training: Training | BatchTraining,
    table: Patterns,
    settings: OnlineSettings | BatchSettings,
    curve: list[Progress],
) -> None:
    from ..learn import describe
    from ..nets import save_network, topology_text
    from ..show import draw_training

    network, picture = files
    save_network(describe(training, table, settings), network)
    title = f"Training a {topology_text(training.network.topology)} network on {table.source}"
    draw_training(curve, picture, tolerance=settings.tolerance or None, title=title)


_ENDS = {
    "tolerance": "Every error is within the tolerance",
    "epochs": "All epochs are done, the tolerance is not met",
    "interrupted": "Interrupted; what was learnt is kept",
    "diverged": "The training diverged and the last good network is kept",
}
_BATCH_ENDS = {**_ENDS, "tolerance": "The mean loss is within the tolerance"}
_DONE = "All epochs are done"


def _print(report: dict[str, Any], settings: OnlineSettings | BatchSettings) -> None:
    online = not math.isnan(report["max_error"])
    end = (_ENDS if online else _BATCH_ENDS)[report["stop"]]
    if report["stop"] == "epochs" and not settings.tolerance:
        end = _DONE
    say(f"{end}: epoch {report['epochs']:,}, {report['updates']:,} updates, "
        f"{report['seconds']:.2f} s.")  # fmt: skip
    if report["stop"] == "diverged":
        say("A weight became infinite or not a number: try a smaller --eta or --momentum.")
    if online:
        say(f"Largest |error| {report['max_error']:.6g}, mean loss {report['loss']:.6g}.")
    elif math.isnan(report["validation"]):
        say(f"Mean loss {report['loss']:.6g}.")
    else:
        say(f"Mean loss {report['loss']:.6g}, of the patterns held out "
            f"{report['validation']:.6g}.")  # fmt: skip
    say_files(report["files"])
