"""`rovernav train`: the training engine."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from ._console import Json, Out, Seed, note, print_json, progress_bar, say, say_files

if TYPE_CHECKING:
    from ..learn import OnlineSettings, Patterns, Progress, Recorder, Training
    from ..nets import Network


def train(
    patterns: Annotated[str, Parameter(help="CSV file, or a shipped table such as bassil-v1.")],
    *,
    topology: Annotated[str, Parameter(help="Units per layer, inputs first.")] = "2-3-2",
    activations: Annotated[
        str | None,
        Parameter(help="One per layer after the inputs, like tanh,linear; default sigmoid, linear."),
    ] = None,
    eta: Annotated[float, Parameter(help="Learning rate.")] = 0.25,
    momentum: Annotated[float, Parameter(help="Share of the last change repeated.")] = 0.5,
    tolerance: Annotated[
        float, Parameter(help="Stop once every |error| is below this; 0 does all epochs.")
    ] = 0.01,
    epochs: Annotated[int, Parameter(help="Epochs at most.")] = 5000,
    rule: Annotated[str, Parameter(help="paper or textbook.")] = "paper",
    order: Annotated[str, Parameter(help="cyclic or shuffled.")] = "cyclic",
    init: Annotated[
        str, Parameter(help="Network file, 'paper' for its weights, or 'seed' to draw them.")
    ] = "seed",
    seed: Seed = 0,
    trace: Annotated[
        Path | None, Parameter(help="CSV with every weight after every pattern; - prints them.")
    ] = None,
    checkpoint: Annotated[
        Path | None, Parameter(help="Save the training here every second.")
    ] = None,
    resume: Annotated[
        bool, Parameter(negative="", help="Go on from the checkpoint, to the same bits.")
    ] = False,
    out: Out = Path("rovernav-train"),
    json: Json = False,
) -> int:
    """Train a network by online back-propagation: one pattern, one update.

    Writes network.safetensors and training.png. Ctrl-C stops and keeps what was learnt.

    Example: rovernav train bassil-v1 --topology 2-3-2 --init paper --momentum .5
    """
    from ..learn import OnlineSettings

    settings = OnlineSettings(
        eta=eta, momentum=momentum, rule=rule, tolerance=tolerance,
        epochs=epochs, order=order, seed=seed,
    )  # fmt: skip
    table, network = _subject(patterns, topology, activations, init, seed)
    start = _start(network, table, settings, checkpoint, resume)
    curve: list[Progress] = []
    with _recorder(trace, network, json) as recorder:
        training = _run(start, table, settings, curve, recorder, checkpoint)
    report = _report(training, table, curve)
    report["files"] = _write(out, training, table, settings, curve)
    if json:
        print_json(report)
    else:
        _print(report)
    return {"diverged": 1, "interrupted": 130}.get(report["stop"], 0)


def _subject(
    patterns: str, topology: str, activations: str | None, init: str, seed: int
) -> tuple[Patterns, Network]:
    """The pattern table and the network to begin with."""
    from ..learn import read_patterns, shipped_patterns, shipped_tables
    from ..nets import parse_topology

    shape = parse_topology(topology)
    if patterns in shipped_tables():
        table = shipped_patterns(patterns)
    else:
        table = read_patterns(Path(patterns), inputs=shape[0])
    return table, _initial(shape, activations, init, seed)


def _initial(
    topology: tuple[int, ...], activations: str | None, init: str, seed: int
) -> Network:
    import numpy as np

    from ..core import SettingError
    from ..learn import paper_network
    from ..nets import Card, Network, default_activations, load_network, topology_text

    names = tuple(a.strip() for a in activations.split(",")) if activations else None
    if init == "seed":
        wanted = names or default_activations(topology)
        drawn = Network.seeded(topology, wanted, np.random.default_rng(seed))
        return drawn.with_card(Card(seed=seed))
    network = paper_network() if init == "paper" else load_network(Path(init))
    if network.topology != topology:
        raise SettingError(
            f"--init {init} is a {topology_text(network.topology)} network, "
            f"--topology says {topology_text(topology)}"
        )
    if names is not None and names != network.activations:
        raise SettingError(f"--init {init} has activations {','.join(network.activations)}")
    return network


def _start(
    network: Network,
    table: Patterns,
    settings: OnlineSettings,
    checkpoint: Path | None,
    resume: bool,
) -> Training:
    """A fresh training, or the one in the checkpoint."""
    from ..core import SettingError
    from ..learn import Training, check_fit, load_training

    check_fit(network, table)
    if resume and checkpoint is None:
        raise SettingError("--resume needs --checkpoint FILE: where the training was saved")
    if checkpoint is None or not checkpoint.exists():
        if resume:
            note(f"There is no checkpoint at {checkpoint} yet: training from the beginning.")
        return Training.fresh(network)
    if not resume:
        raise SettingError(
            f"{checkpoint} exists; go on from it with --resume, or name another file"
        )
    training = load_training(checkpoint, settings, table)
    if training.network.layer_rows != network.layer_rows:
        raise SettingError(f"{checkpoint} holds another topology or other activations")
    note(f"Resumed from {checkpoint} at epoch {training.epoch:,}.")
    return training


def _run(
    start: Training,
    table: Patterns,
    settings: OnlineSettings,
    curve: list[Progress],
    recorder: Recorder | None,
    checkpoint: Path | None,
) -> Training:
    from ..learn import checkpointer, save_training, train

    with progress_bar("training") as update:

        def on_event(event: Progress) -> None:
            curve.append(event)
            update(event.epoch / max(1, settings.epochs), f"max |error| {event.worst:.3g}")

        save = None if checkpoint is None else checkpointer(checkpoint, settings, table)
        if save:
            save(start)
        training = train(
            start, table, settings, on_event=on_event, recorder=recorder, on_step=save
        )
    if checkpoint is not None:
        save_training(training, settings, table, checkpoint)
    return training


@contextlib.contextmanager
def _recorder(trace: Path | None, network: Network, json: bool) -> Iterator[Recorder | None]:
    from ..core import FileError
    from ..learn import trace_csv, trace_text

    if trace is None:
        yield None
    elif str(trace) == "-":
        yield trace_text((sys.stderr if json else sys.stdout).write, network)
    else:
        try:
            trace.parent.mkdir(parents=True, exist_ok=True)
            with trace.open("w", encoding="utf-8", newline="") as file:
                yield trace_csv(file, network)
        except OSError as error:
            raise FileError(f"cannot write the trace {trace}: {error.strerror}") from None


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
    out: Path,
    training: Training,
    table: Patterns,
    settings: OnlineSettings,
    curve: list[Progress],
) -> list[Path]:
    from ..learn import describe
    from ..nets import save_network, topology_text
    from ..show import draw_training

    files = [out / "network.safetensors", out / "training.png"]
    save_network(describe(training, table, settings), files[0])
    title = f"Training a {topology_text(training.network.topology)} network on {table.source}"
    draw_training(curve, files[1], tolerance=settings.tolerance, title=title)
    return files


_ENDS = {
    "tolerance": "Every error is within the tolerance",
    "epochs": "All epochs are done, the tolerance is not met",
    "interrupted": "Interrupted; what was learnt is kept",
    "diverged": "The training diverged (a weight became infinite or not a number); the last good "
    "network is kept. Try a smaller eta or momentum",
}


def _print(report: dict[str, Any]) -> None:
    say(f"{_ENDS[report['stop']]}: epoch {report['epochs']:,}, {report['updates']:,} updates, "
        f"{report['seconds']:.2f} s.")  # fmt: skip
    say(f"Largest |error| {report['max_error']:.6g}, mean loss {report['loss']:.6g}.")
    say_files(report["files"])
