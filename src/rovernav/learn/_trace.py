"""The paper's trace: every weight after every pattern."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from pathlib import Path
from typing import TextIO

import numpy as np

from ..core import F64, FileError
from ..nets import Network
from ._online import Recorder


def weight_names(network: Network) -> list[str]:
    """The listing's names, one per weight: ``matrix1[0][0]`` is layer 1, unit 0, source 0."""
    return [
        f"matrix{layer}[{unit}][{source}]"
        for layer, (inputs, units, _) in enumerate(network.layer_rows, 1)
        for unit in range(units)
        for source in range(inputs + 1)
    ]


def trace_csv(file: TextIO, network: Network, *, header: bool = True) -> Recorder:
    """A recorder that writes one CSV line per update: epoch, pattern, every weight.

    Args:
        file: Where to write.
        network: Whose weights.
        header: Write the names of the columns first; not where a trace goes on.
    """
    if header:
        file.write(",".join(_columns(network)) + "\n")

    def write(epoch: int, patterns: np.ndarray, weights: F64) -> None:
        for number, (pattern, row) in enumerate(zip(patterns, weights, strict=True)):
            at = epoch + 1 + _epochs_before(number, patterns)
            file.write(f"{at},{pattern}," + ",".join(map(repr, row.tolist())) + "\n")
        file.flush()  # a checkpoint may follow, and a resumed trace needs all lines before it

    return write


def trace_length(path: Path, network: Network, updates: int) -> int:
    """Bytes of a trace file up to update number `updates`: where a resumed training goes on.

    Raises:
        FileError: It cannot be read, is no trace of such a network, or ends before that update.
    """
    try:
        with path.open("rb") as file:
            if file.readline().decode("utf-8", "replace").strip() != ",".join(_columns(network)):
                raise FileError(f"{path} is no trace of this network; name another file")
            for line in itertools.islice(file, updates):
                if line.endswith(b"\n"):
                    updates -= 1
            if updates:
                raise FileError(f"{path} ends before the checkpoint; name another file")
            return file.tell()
    except OSError as error:
        raise FileError(f"cannot read the trace {path}: {error.strerror}") from error


def _columns(network: Network) -> list[str]:
    return ["epoch", "pattern", *weight_names(network)]


def trace_text(write: Callable[[str], object], network: Network) -> Recorder:
    """A recorder that writes the lines of the paper's listing, output layer first."""
    layers = network.layer_rows

    def write_all(epoch: int, patterns: np.ndarray, weights: F64) -> None:
        for number, (pattern, row) in enumerate(zip(patterns, weights, strict=True)):
            at = epoch + 1 + _epochs_before(number, patterns)
            matrices = network.with_parameters(row).matrices
            lines = [f"epoch {at}, pattern {pattern}"]
            for layer in range(len(layers), 0, -1):
                for unit, line in enumerate(matrices[layer - 1]):
                    lines.append(
                        "  ".join(
                            f"matrix{layer}[{unit}][{j}] = {w:.9g}" for j, w in enumerate(line)
                        )
                    )
            write("\n".join(lines) + "\n")

    return write_all


def _epochs_before(number: int, patterns: np.ndarray) -> int:
    """Whole epochs before update `number` of a slice: each pattern comes once an epoch."""
    return number // (int(patterns.max()) + 1)
