"""Checkpoints: a training saved atomically, to go on with the same bits after a crash."""

from __future__ import annotations

import dataclasses
import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from ..core import FileError, SettingError, canonical_json, read_bytes, sha256_of, write_atomic
from ..nets import Card, Network
from ._online import OnlineSettings, Training
from ._patterns import Patterns
from ._progress import StopReason

FORMAT = "rovernav-training"
VERSION = 1
MAX_BYTES = 2_000_000_000
_MAY_CHANGE = ("epochs", "tolerance")
"""Settings that may differ when a training is resumed: only when it stops."""


def save_training(
    training: Training, settings: OnlineSettings, patterns: Patterns, path: Path
) -> None:
    """Write a checkpoint: network, last changes, epoch, settings and the hash of the patterns."""
    from safetensors.numpy import save

    tensors = {"parameters": training.network.parameters, "deltas": training.deltas}
    header = {
        "format": FORMAT,
        "version": VERSION,
        "topology": list(training.network.topology),
        "activations": list(training.network.activations),
        "seed": training.network.card.seed,
        "epoch": training.epoch,
        "updates": training.updates,
        "stop": training.stop,
        "settings": dataclasses.asdict(settings),  # pyright: ignore[reportArgumentType]
        "patterns": patterns.sha256,
    }
    header["sha256"] = _hash(header, tensors)
    plain = {name: np.ascontiguousarray(tensor) for name, tensor in tensors.items()}
    data = save(plain, {"rovernav": canonical_json(header)})
    write_atomic(path, lambda file: file.write(data) and None)


def load_training(path: Path, settings: OnlineSettings, patterns: Patterns) -> Training:
    """Read a checkpoint and check that it belongs to these settings and patterns.

    Raises:
        FileError: The file is missing, damaged or no checkpoint.
        SettingError: It was made with other patterns or settings; names the first that differs.
            Only `epochs` and `tolerance` may change.
    """
    header, tensors = _open(path)
    for name, now in dataclasses.asdict(settings).items():  # pyright: ignore[reportArgumentType]
        then = header["settings"].get(name)
        if name not in _MAY_CHANGE and then != now:
            raise SettingError(
                f"{path} was made with {name} = {then!r}, not {now!r}; resume with the same"
            )
    if header["patterns"] != patterns.sha256:
        raise SettingError(f"{path} was made with another pattern table; resume with the same")
    network = Network(
        topology=tuple(header["topology"]),
        activations=tuple(header["activations"]),
        parameters=tensors["parameters"],
        card=Card(inputs=patterns.inputs, outputs=patterns.outputs, seed=header["seed"]),
    )
    stop = header["stop"]
    return Training(
        network=network,
        deltas=tensors["deltas"],
        epoch=header["epoch"],
        updates=header["updates"],
        stop=None if stop is None else StopReason(stop),
    )


def checkpointer(
    path: Path, settings: OnlineSettings, patterns: Patterns, *, every: float = 1.0
) -> Callable[[Training], None]:
    """A step listener that saves at most once in `every` seconds, and whenever a training ends."""
    last = 0.0

    def save_now_and_then(training: Training) -> None:
        nonlocal last
        if training.stop is not None or time.monotonic() - last >= every:
            save_training(training, settings, patterns, path)
            last = time.monotonic()

    return save_now_and_then


def _open(path: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    from safetensors.numpy import load

    data = read_bytes(path, limit=MAX_BYTES, what="checkpoint")
    try:
        size = int.from_bytes(data[:8], "little")
        header = json.loads(json.loads(data[8 : 8 + size])["__metadata__"]["rovernav"])
        tensors = load(data)
        digest = header.pop("sha256")
    except Exception:  # safetensors and json raise many kinds; all mean the same to a reader
        raise FileError(f"{path} is not a checkpoint, or is damaged") from None
    if (header.get("format"), header.get("version")) != (FORMAT, VERSION):
        raise FileError(
            f"{path}: format must be {FORMAT!r} version {VERSION}, got "
            f"{header.get('format')!r} version {header.get('version')!r}"
        )
    if digest != _hash(header, tensors):
        raise FileError(f"{path} is damaged: sha256 does not fit its contents")
    return header, tensors


def _hash(header: dict[str, Any], tensors: dict[str, Any]) -> str:
    plain = {key: item for key, item in header.items() if key != "sha256"}
    weights = [tensors[name].tobytes() for name in ("parameters", "deltas")]
    return sha256_of(canonical_json(plain).encode(), *weights)
