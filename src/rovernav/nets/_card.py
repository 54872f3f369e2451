"""What a network file says about its network besides the weights."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..core import ShapeError, value


@value
class Card:
    """Names, units, codec and origin of a network.

    Attributes:
        inputs: Name of each input; empty where unnamed.
        outputs: Name of each output; empty where unnamed.
        input_units: Unit of each input, ``1`` for a pure number; empty where unstated.
        output_units: Unit of each output; empty where unstated.
        codec: Name and parameters of the codec that turns observations into inputs and outputs
            into commands; None for a network that drives nothing.
        training: How it was trained, as plain settings and results.
        seed: Seed of its initial weights, if they were drawn.
    """

    inputs: tuple[str, ...] = ()
    outputs: tuple[str, ...] = ()
    input_units: tuple[str, ...] = ()
    output_units: tuple[str, ...] = ()
    codec: Mapping[str, Any] | None = None
    training: Mapping[str, Any] | None = None
    seed: int | None = None

    def check_sizes(self, inputs: int, outputs: int) -> None:
        """Raise `ShapeError` where names or units do not fit a network's inputs or outputs."""
        for what, names, count in (
            ("input names", self.inputs, inputs),
            ("input units", self.input_units, inputs),
            ("output names", self.outputs, outputs),
            ("output units", self.output_units, outputs),
        ):
            if names and len(names) != count:
                raise ShapeError(f"{len(names)} {what} do not fit a network with {count}")
