"""The network: topology, weights, activations, forward pass, gradients and the weight file."""

from ._card import Card
from ._drawn import seeded_parameters
from ._explain import Explanation, explain
from ._file import load_network, network_bytes, parse_network, save_network, weights_sha256
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
    "Explanation",
    "Network",
    "check_loss",
    "default_activations",
    "explain",
    "gradient",
    "load_network",
    "network_bytes",
    "parameter_count",
    "parse_network",
    "parse_topology",
    "save_network",
    "seeded_parameters",
    "topology_text",
    "weights_sha256",
]
