"""Checkpoints: a training saved atomically, to go on with the same bits after a crash."""

from __future__ import annotations

import dataclasses
import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, overload

import numpy as np

from ..core import (
    FileError,
    SettingError,
    ShapeError,
    canonical_json,
    read_bytes,
    sha256_of,
    write_atomic,
)
from ..nets import Card, Network
from ._batch_settings import BatchSettings
from ._minibatch import BatchTraining
from ._online import OnlineSettings, Training
from ._patterns import Patterns
from ._progress import StopReason

FORMAT = "rovernav-training"
VERSION = 1
MAX_BYTES = 2_000_000_000
_MAY_CHANGE = ("epochs", "tolerance")
"""Settings that may differ when a training is resumed: only when it stops."""
_KINDS = {"online": "online back-propagation", "batch": "mini-batch training"}


def save_training(
    training: Training | BatchTraining,
    settings: OnlineSettings | BatchSettings,
    patterns: Patterns,
    path: Path,
) -> None:
    """Write a checkpoint: network, moments, epoch, settings and the hash of the patterns.

    Args:
        training: What to write.
        settings: Its settings, of the same kind.
        patterns: What it learns.
        path: Where; the folder is made if needed.
    """
    _save(training, settings, patterns.sha256, path)


def _save(
    training: Training | BatchTraining,
    settings: OnlineSettings | BatchSettings,
    patterns_sha256: str,
    path: Path,
) -> None:
    from safetensors.numpy import save

    header = {
        "format": FORMAT,
        "version": VERSION,
        "kind": _kind(settings),
        "topology": list(training.network.topology),
        "activations": list(training.network.activations),
        "card": _card(training.network.card),
        "epoch": training.epoch,
        "updates": training.updates,
        "stop": training.stop,
        "settings": dataclasses.asdict(settings),
        "patterns": patterns_sha256,
    }
    tensors = {"parameters": training.network.parameters}
    if isinstance(training, BatchTraining):
        tensors["moments"] = training.moments
        tensors["losses"] = np.array([training.loss, training.validation])
    else:
        tensors["deltas"] = training.deltas
        header["pattern"] = training.pattern
    header["sha256"] = _hash(header, tensors)
    plain = {name: np.ascontiguousarray(tensor) for name, tensor in tensors.items()}
    data = save(plain, {"rovernav": canonical_json(header)})
    write_atomic(path, lambda file: file.write(data) and None)


@overload
def load_training(path: Path, settings: OnlineSettings, patterns: Patterns) -> Training: ...
@overload
def load_training(path: Path, settings: BatchSettings, patterns: Patterns) -> BatchTraining: ...
def load_training(
    path: Path, settings: OnlineSettings | BatchSettings, patterns: Patterns
) -> Training | BatchTraining:
    """Read a checkpoint and check that it belongs to these settings and patterns.

    Raises:
        FileError: The file is missing, damaged or no checkpoint.
        SettingError: It was made with other patterns or settings; names the first that differs.
            Only `epochs` and `tolerance` may change, and under a cosine schedule not `epochs`.
    """
    header, tensors = _open(path)
    try:
        _check_same(path, header, settings, patterns)
        return _training(header, tensors, patterns, batch=isinstance(settings, BatchSettings))
    except SettingError:
        raise
    except ShapeError as error:
        raise FileError(f"{path} is damaged: {error}") from None
    except (KeyError, TypeError, ValueError, AttributeError):
        raise FileError(f"{path} is damaged: its header cannot be read") from None


def _training(
    header: dict[str, Any], tensors: dict[str, Any], patterns: Patterns, *, batch: bool
) -> Training | BatchTraining:
    """The training that a checkpoint holds."""
    card = header["card"]
    network = Network(
        topology=tuple(header["topology"]),
        activations=tuple(header["activations"]),
        parameters=tensors["parameters"],
        card=Card(
            inputs=patterns.inputs,
            outputs=patterns.outputs,
            input_units=tuple(card["input_units"]),
            output_units=tuple(card["output_units"]),
            codec=card["codec"],
            seed=card["seed"],
        ),
    )
    epoch, updates = _count(header["epoch"]), _count(header["updates"])
    stop = None if header["stop"] is None else StopReason(header["stop"])
    if not batch:
        return Training(
            network=network,
            deltas=tensors["deltas"],
            epoch=epoch,
            updates=updates,
            stop=stop,
            pattern=_count(header.get("pattern", 0)),  # earlier checkpoints lie between epochs
        )
    loss, validation = tensors["losses"].tolist()
    return BatchTraining(
        network=network,
        moments=tensors["moments"],
        epoch=epoch,
        updates=updates,
        loss=loss,
        validation=validation,
        stop=stop,
    )


def _card(card: Card) -> dict[str, Any]:
    """What a training does not learn but its network must keep."""
    return {
        "input_units": list(card.input_units),
        "output_units": list(card.output_units),
        "codec": None if card.codec is None else dict(card.codec),
        "seed": card.seed,
    }


def _count(item: Any) -> int:
    if type(item) is not int or not 0 <= item < 2**62:
        raise ValueError(f"{item!r} is no count")
    return item


@overload
def checkpointer(
    path: Path, settings: OnlineSettings, patterns: Patterns, *, every: float = 1.0
) -> Callable[[Training], None]: ...
@overload
def checkpointer(
    path: Path, settings: BatchSettings, patterns: Patterns, *, every: float = 1.0
) -> Callable[[BatchTraining], None]: ...
def checkpointer(
    path: Path, settings: OnlineSettings | BatchSettings, patterns: Patterns, *, every: float = 1.0
) -> Callable[[Any], None]:
    """A step listener that saves at most once in `every` seconds, and whenever a training ends."""
    last, digest = 0.0, patterns.sha256

    def save_now_and_then(training: Training | BatchTraining) -> None:
        nonlocal last
        if training.stop is not None or time.monotonic() - last >= every:
            _save(training, settings, digest, path)
            last = time.monotonic()

    return save_now_and_then


def _kind(settings: OnlineSettings | BatchSettings) -> str:
    return "online" if isinstance(settings, OnlineSettings) else "batch"


def _check_same(
    path: Path,
    header: dict[str, Any],
    settings: OnlineSettings | BatchSettings,
    patterns: Patterns,
) -> None:
    """Raise `SettingError` unless the checkpoint belongs to these settings and patterns."""
    kind = header.get("kind", "online")
    if kind != _kind(settings):
        then, now = _KINDS.get(kind, kind), _KINDS[_kind(settings)]
        raise SettingError(f"{path} is a checkpoint of {then}, not of {now}; resume with the same")
    may_change = _MAY_CHANGE
    if isinstance(settings, BatchSettings) and settings.schedule != "constant":
        may_change = ("tolerance",)  # the rates follow from the number of epochs
    usual = dataclasses.asdict(type(settings)())  # of settings that came after the checkpoint
    for name, now in dataclasses.asdict(settings).items():
        then = header["settings"].get(name, usual[name])
        if name not in may_change and then != now:
            raise SettingError(
                f"{path} was made with {name} = {then!r}, not {now!r}; resume with the same"
            )
    if header["patterns"] != patterns.sha256:
        raise SettingError(f"{path} was made with another pattern table; resume with the same")


def _open(path: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    from safetensors.numpy import load

    data = read_bytes(path, limit=MAX_BYTES, what="checkpoint")
    try:
        size = int.from_bytes(data[:8], "little")
        header = json.loads(json.loads(data[8 : 8 + size])["__metadata__"]["rovernav"])
        tensors = load(data)
        fits = header.pop("sha256") == _hash(header, tensors)
    except Exception:  # safetensors and json raise many kinds; all mean the same to a reader
        raise FileError(f"{path} is not a checkpoint, or is damaged") from None
    if (header.get("format"), header.get("version")) != (FORMAT, VERSION):
        raise FileError(
            f"{path}: format must be {FORMAT!r} version {VERSION}, got "
            f"{header.get('format')!r} version {header.get('version')!r}"
        )
    if not fits:
        raise FileError(f"{path} is damaged: sha256 does not fit its contents")
    return header, tensors


def _hash(header: dict[str, Any], tensors: dict[str, Any]) -> str:
    plain = {key: item for key, item in header.items() if key != "sha256"}
    names = ["parameters", *sorted(tensors.keys() - {"parameters"})]
    weights = [tensors[name].tobytes() for name in names]
    return sha256_of(canonical_json(plain).encode(), *weights)
