"""The network: topology, weights, activations, forward pass, gradients and the weight file."""

from ._card import Card
from ._drawn import seeded_parameters
from ._file import load_network, save_network, weights_sha256
from ._gradient import LOSSES, Backward, check_loss, gradient
from ._network import (
    ACTIVATIONS,
    Network,
    default_activations,
    parameter_count,
    parse_topology,
    topology_text,
)

__all__ = [
    "ACTIVATIONS",
    "LOSSES",
    "Backward",
    "Card",
    "Network",
    "check_loss",
    "default_activations",
    "gradient",
    "load_network",
    "parameter_count",
    "parse_topology",
    "save_network",
    "seeded_parameters",
    "topology_text",
    "weights_sha256",
]
