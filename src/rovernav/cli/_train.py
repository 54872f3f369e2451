"""`rovernav train`: the training engine."""

from __future__ import annotations

import contextlib
import dataclasses
import sys
from collections.abc import Callable, Generator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from ._console import note, print_json, progress_bar, say, say_files
from ._files import claim_folder, keep_apart
from ._options import Json, Out, OutFile, OutFileOrDash, Seed, Whole
from ._subject import initial_network, read_table, same_network

if TYPE_CHECKING:
    from ..learn import OnlineSettings, Patterns, Progress, Recorder, Training
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
    eta: Annotated[float, Parameter(help="Learning rate.")] = 0.25,
    momentum: Annotated[float, Parameter(help="Share of the last change repeated.")] = 0.5,
    tolerance: Annotated[
        float, Parameter(help="Stop once every |error| is below this; 0 does all epochs.")
    ] = 0.01,
    epochs: Annotated[Whole, Parameter(help="Epochs at most.")] = 5000,
    rule: Annotated[str, Parameter(help="paper or textbook.")] = "paper",
    order: Annotated[str, Parameter(help="cyclic or shuffled.")] = "cyclic",
    init: Annotated[
        str, Parameter(help="Network file, 'paper' for its weights, or 'seed' to draw them.")
    ] = "seed",
    seed: Seed = 0,
    trace: Annotated[
        OutFileOrDash | None,
        Parameter(help="CSV with every weight after every pattern; - prints them."),
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
    """Train a network by online back-propagation: one pattern, one update.

    Writes network.safetensors and training.png. Ctrl-C stops and keeps what was learnt. A training
    that diverges ends with exit code 1.

    Example: rovernav train bassil-v1 --topology 2-3-2 --init paper --momentum .5
    """
    from ..learn import OnlineSettings

    with progress_bar("training") as update:
        settings = OnlineSettings(
            eta=eta, momentum=momentum, rule=rule, tolerance=tolerance,
            epochs=epochs, order=order, seed=seed,
        )  # fmt: skip
        network = initial_network(topology, activations, init, seed)
        table = read_table(patterns, network.topology[0])
        files = [out / "network.safetensors", out / "training.png"]
        _check_files(files, [patterns, init], trace, checkpoint)
        start = _start(network, table, settings, checkpoint, resume)
        claim_folder(out)
        curve: list[Progress] = []
        with _recorder(trace, start, json) as recorder:
            if resume:
                _tell_start(start, checkpoint)
            training = _run(start, table, settings, curve, recorder, checkpoint, update)
        _write(files, training, table, settings, curve)
    report = _report(training, table, curve)
    report["files"] = files
    if json:
        print_json(report)
    else:
        _print(report)
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
    settings: OnlineSettings,
    checkpoint: Path | None,
    resume: bool,
) -> Training:
    """A fresh training, or the one in the checkpoint."""
    from ..core import FileError, SettingError
    from ..learn import Training, check_fit, load_training

    check_fit(network, table)
    fresh = Training.fresh(network)
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


def _tell_start(start: Training, checkpoint: Path | None) -> None:
    if checkpoint is not None and checkpoint.exists():
        note(f"Resumed from {checkpoint} at epoch {start.epoch:,}.")
    else:
        note(f"There is no checkpoint at {checkpoint} yet: training from the beginning.")


def _run(
    start: Training,
    table: Patterns,
    settings: OnlineSettings,
    curve: list[Progress],
    recorder: Recorder | None,
    checkpoint: Path | None,
    update: Callable[[float, str], None],
) -> Training:
    from ..learn import checkpointer, save_training, train

    def on_event(event: Progress) -> None:
        curve.append(dataclasses.replace(event, parameters=event.parameters[:0]))
        update(event.epoch / max(1, settings.epochs), f"max |error| {event.worst:.3g}")

    save = None if checkpoint is None else checkpointer(checkpoint, settings, table)
    if save:
        save(start)
    training = train(start, table, settings, on_event=on_event, recorder=recorder, on_step=save)
    if checkpoint is not None:
        save_training(training, settings, table, checkpoint)
    return training


@contextlib.contextmanager
def _recorder(trace: Path | None, start: Training, json: bool) -> Generator[Recorder | None]:
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


def _report(training: Training, table: Patterns, curve: list[Progress]) -> dict[str, Any]:
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
        "seconds": last.seconds,
        "weights": training.network.parameters,
        "weights_sha256": weights_sha256(training.network),
    }


def _write(
    files: list[Path],
    training: Training,
    table: Patterns,
    settings: OnlineSettings,
    curve: list[Progress],
) -> None:
    from ..learn import describe
    from ..nets import save_network, topology_text
    from ..show import draw_training

    network, picture = files
    save_network(describe(training, table, settings), network)
    title = f"Training a {topology_text(training.network.topology)} network on {table.source}"
    draw_training(curve, picture, tolerance=settings.tolerance, title=title)


_ENDS = {
    "tolerance": "Every error is within the tolerance",
    "epochs": "All epochs are done, the tolerance is not met",
    "interrupted": "Interrupted; what was learnt is kept",
    "diverged": "The training diverged and the last good network is kept",
}


def _print(report: dict[str, Any]) -> None:
    say(f"{_ENDS[report['stop']]}: epoch {report['epochs']:,}, {report['updates']:,} updates, "
        f"{report['seconds']:.2f} s.")  # fmt: skip
    if report["stop"] == "diverged":
        say("A weight became infinite or not a number: try a smaller --eta or --momentum.")
    say(f"Largest |error| {report['max_error']:.6g}, mean loss {report['loss']:.6g}.")
    say_files(report["files"])
