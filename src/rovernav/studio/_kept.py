"""A finished training as it is kept: its numbers, its files, the command that does it again."""

from __future__ import annotations

import csv
import dataclasses
import io
import shlex
from collections.abc import Callable, Mapping
from typing import Any

from ..core import value
from ..learn import StopReason, Training, describe, patterns_csv
from ..nets import Network, network_bytes, topology_text, weights_sha256
from ._curve import Point
from ._setup import Setup

NETWORK, TABLE, INITIAL, CURVE = (
    "network.safetensors", "patterns.csv", "initial.safetensors", "curve.csv"
)  # fmt: skip


@value
class Kept:
    """All that a run was, for its record.

    Attributes:
        setup: Table, network and settings.
        initial: The network that it began with.
        weights: Where those weights came from: ``paper``, ``seeded`` or ``given``.
        training: Where it ended.
        curve: Its error.
        exact: Whether its settings alone end it where it ended; not if a person let the end come
            earlier while it ran.
        seconds: Time that it trained [s].
    """

    setup: Setup
    initial: Network
    weights: str
    training: Training
    curve: tuple[Point, ...]
    exact: bool
    seconds: float


def keep_training(keep: Callable[..., str], kept: Kept) -> str:
    """Put a run into the library; returns its name there."""
    setup, last = kept.setup, kept.curve[-1]
    network = kept.training.network
    settings, name = setup.settings, setup.shipped or setup.table.source
    how = f"{settings.rule} rule, eta {settings.eta:g}, momentum {settings.momentum:g}"
    return keep(
        kind="training",
        title=f"{topology_text(setup.topology)} on {name[:40]}, {how}",
        command=command(kept),
        settings=plain_settings(setup, kept.weights),
        summary={
            "stop": None if kept.training.stop is None else str(kept.training.stop),
            "epochs": kept.training.epoch,
            "updates": kept.training.updates,
            "max_error": last.worst,
            "loss": last.loss,
            "tolerance": settings.tolerance,
            "patterns": len(setup.table.x),
            "topology": topology_text(setup.topology),
            "seconds": kept.seconds,
            "weights_sha256": weights_sha256(network),
        },
        files={
            NETWORK: network_bytes(describe(kept.training, setup.table, settings)),
            INITIAL: network_bytes(kept.initial),
            TABLE: patterns_csv(setup.table).encode(),
            CURVE: curve_csv(kept.curve),
        },
    )


def command(kept: Kept) -> str:
    """The command line that trains the same weights, in a folder with the run's files."""
    setup, settings = kept.setup, kept.setup.settings
    words: list[Any] = ["rovernav", "train", setup.shipped or TABLE]
    words += ["--topology", topology_text(setup.topology)]
    words += ["--activations", ",".join(setup.activations)]
    words += ["--init", _init(kept), "--rule", settings.rule, "--eta", repr(settings.eta)]
    words += ["--momentum", repr(settings.momentum), "--order", settings.order]
    words += ["--seed", settings.seed]
    words += ["--tolerance", repr(settings.tolerance) if kept.exact else 0]
    on_its_own = kept.exact and kept.training.stop not in (None, StopReason.INTERRUPTED)
    words += ["--epochs", settings.epochs if on_its_own else kept.training.epoch]
    words += ["--out", "again"]
    return shlex.join(map(str, words))


def plain_settings(setup: Setup, weights: str) -> dict[str, Any]:
    """The choices as plain data, in the words of `TrainModel.preset`; the table by name."""
    return {
        "table": setup.shipped or setup.table.source,
        "shipped": setup.shipped,
        "hidden": "-".join(map(str, setup.hidden)),
        "activations": list(setup.activations),
        "weights": weights,
        **dataclasses.asdict(setup.settings),
    }


def curve_csv(curve: tuple[Point, ...]) -> bytes:
    """The error curve as a table."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(["epoch", "max_error", "loss"])
    writer.writerows([point.epoch, repr(point.worst), repr(point.loss)] for point in curve)
    return out.getvalue().encode()


def read_curve(data: bytes) -> list[Point]:
    """The points of `curve_csv`."""
    rows: list[Mapping[str, str]] = list(csv.DictReader(io.StringIO(data.decode())))
    return [
        Point(epoch=int(r["epoch"]), worst=float(r["max_error"]), loss=float(r["loss"]))
        for r in rows
    ]


def _init(kept: Kept) -> str:
    """What ``--init`` needs: the paper's own network, a seed, or the file."""
    if kept.weights == "paper" and kept.setup.activations == ("sigmoid", "linear"):
        return "paper"
    return "seed" if kept.weights == "seeded" else INITIAL
