"""The network as a driver: codec, forward pass, codec."""

from __future__ import annotations

from typing import final

import numpy as np

from ..core import Codec, Command, Mission, Observation, SettingError
from ..kernels import network as kernels
from ..nets import Network, topology_text
from ._codecs import build_codec


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


def _check_fit(codec: Codec, network: Network) -> None:
    inputs, outputs = codec.sizes
    if (network.topology[0], network.topology[-1]) != codec.sizes:
        raise SettingError(
            f"codec {codec.settings()['name']} needs a network with {inputs} inputs and {outputs} "
            f"outputs, got {topology_text(network.topology)}"
        )
