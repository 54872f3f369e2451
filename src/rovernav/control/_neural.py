"""The network as a driver: codec, forward pass, codec."""

from __future__ import annotations

from typing import final

import numpy as np

from ..core import Codec, Command, Mission, Observation, SettingError
from ..kernels import network as kernels
from ..nets import Network, topology_text
from ..nets import explain as take_apart
from ._codecs import build_codec
from ._why import ReadsOutputs, Why, said


@final
class NeuralController:
    """Any network with a codec, as an ordinary controller. It remembers nothing.

    Args:
        network: Its card must name a codec.

    Raises:
        SettingError: The network has no codec, or one that does not fit it.
    """

    def __init__(self, network: Network) -> None:
        if network.card.codec is None:
            raise SettingError(
                "this network names no codec, so nothing says what its outputs mean to motors; "
                "drive with a network trained for driving"
            )
        self.network = network
        self.codec: Codec = build_codec(network.card.codec)
        _check_fit(self.codec, network)
        self._layers = network.layers
        self._weights = np.ascontiguousarray(network.parameters)

    def __reduce__(self) -> tuple[type[NeuralController], tuple[Network]]:
        return NeuralController, (self.network,)  # one copy of the weights, as in this process

    def start(self, mission: Mission, rng: np.random.Generator) -> None:
        """Nothing to remember."""
        return

    def act(self, observation: Observation, memory: None) -> tuple[Command, None]:
        """Encode, run the network, decode: every row by itself."""
        inputs = self.codec.encode(observation)
        out = np.empty((len(inputs), self.network.topology[-1]), self._weights.dtype)
        kernels.forward(self._layers, self._weights, inputs, out)
        return self.codec.decode(out, observation), None

    def why(self, observation: Observation, memory: None) -> Why:
        """Its inputs by name, what each hidden unit added, and what the codec made of it."""
        command, _ = self.act(observation, memory)
        inputs = np.asarray(self.codec.encode(observation))
        outputs = self.network.forward(inputs[:1])
        words, headings = (said(command).capitalize(),), None
        asked = range(min(len(outputs[0]), MOST_ASKED))
        if isinstance(self.codec, ReadsOutputs):
            reading = self.codec.read(outputs, observation)
            words, headings = reading.words, reading.headings
        if headings is not None:
            asked = [headings.chosen]
        card = self.network.card
        numbers = inputs[0].tolist()
        names = card.inputs or tuple(f"input {i}" for i in range(len(numbers)))
        units = card.input_units or ("1",) * len(numbers)
        return Why(
            words=words,
            command=command.twist[0],
            inputs=tuple(zip(names, numbers, units, strict=True)),
            network=take_apart(self.network, inputs[0], asked=asked),
            output_names=card.outputs or tuple(f"output {k}" for k in range(len(outputs[0]))),
            headings=headings,
        )


MOST_ASKED = 8
"""Outputs for which the derivatives by all inputs are worked out, where none was chosen."""


def _check_fit(codec: Codec, network: Network) -> None:
    inputs, outputs = codec.sizes
    if (network.topology[0], network.topology[-1]) != codec.sizes:
        raise SettingError(
            f"codec {codec.settings()['name']} needs a network with {inputs} inputs and {outputs} "
            f"outputs, got {topology_text(network.topology)}"
        )
