"""What a training begins with: the pattern table and the network."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..learn import Patterns
    from ..nets import Network

USUAL = "2-3-2"
"""The paper's topology."""


def read_table(patterns: str, inputs: int) -> Patterns:
    """The pattern table of a file or a shipped one.

    Raises:
        InputError: No such table, or one that cannot be used.
    """
    from ..core import FileError, suggest
    from ..learn import read_patterns, shipped_patterns, shipped_tables

    if patterns in shipped_tables():
        return shipped_patterns(patterns)
    if not patterns or not Path(patterns).exists():
        raise FileError(
            f"there is no pattern file {patterns!r} and no shipped table of that name; "
            f"{suggest(patterns, shipped_tables())}"
        )
    return read_patterns(Path(patterns), inputs=inputs)


def initial_network(
    topology: str | None, activations: str | None, init: str, seed: int, *, single: bool = False
) -> Network:
    """The network to begin with.

    Args:
        topology: Like ``2-3-2``; that of `init`, or the paper's, where not given.
        activations: Names with commas; those of `init`, or sigmoid and linear, where not given.
        init: ``seed``, ``paper`` or a network file.
        seed: Seed of drawn weights.
        single: Draw them in float32.

    Raises:
        InputError: No such network, or one that contradicts the other options.
    """
    import numpy as np

    from ..learn import seeded_network
    from ..nets import default_activations, parse_topology

    names = None if activations is None else tuple(a.strip() for a in activations.split(","))
    shape = None if topology is None else parse_topology(topology)
    if init == "seed":
        shape = shape or parse_topology(USUAL)
        wanted = names or default_activations(shape)
        return seeded_network(shape, wanted, seed, np.float32 if single else np.float64)
    network = _given(init)
    _check_same(f"--init {init}", network, shape, names)
    return network


def same_network(path: Path, saved: Network, wanted: Network) -> None:
    """Raise `SettingError` unless a checkpoint holds the kind of network that was asked for."""
    _check_same(str(path), saved, wanted.topology, wanted.activations)


def _given(init: str) -> Network:
    from ..core import FileError, suggest
    from ..learn import paper_network
    from ..nets import load_network

    if init == "paper":
        return paper_network()
    if not init or not Path(init).exists():
        raise FileError(
            f"--init {init!r} is neither a known name nor a file; "
            f"{suggest(init, ('paper', 'seed'))}"
        )
    return load_network(Path(init))


def _check_same(
    source: str, network: Network, topology: tuple[int, ...] | None, names: tuple[str, ...] | None
) -> None:
    from ..core import SettingError
    from ..nets import topology_text

    if topology is not None and network.topology != topology:
        raise SettingError(
            f"{source} holds a {topology_text(network.topology)} network, not the "
            f"{topology_text(topology)} one asked for; give the same --topology"
        )
    if names is not None and network.activations != names:
        raise SettingError(
            f"{source} holds a network with activations {','.join(network.activations)}, "
            f"not {','.join(names)}; give the same --activations"
        )
