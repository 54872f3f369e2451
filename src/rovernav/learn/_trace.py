"""The paper's trace: every weight after every pattern."""

from __future__ import annotations

from collections.abc import Callable
from typing import TextIO

import numpy as np

from ..core import F64
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


def trace_csv(file: TextIO, network: Network) -> Recorder:
    """A recorder that writes one CSV line per update: epoch, pattern, every weight."""
    file.write(",".join(["epoch", "pattern", *weight_names(network)]) + "\n")

    def write(epoch: int, patterns: np.ndarray, weights: F64) -> None:
        for number, (pattern, row) in enumerate(zip(patterns, weights, strict=True)):
            at = epoch + 1 + _epochs_before(number, patterns)
            file.write(f"{at},{pattern}," + ",".join(map(repr, row.tolist())) + "\n")

    return write


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
