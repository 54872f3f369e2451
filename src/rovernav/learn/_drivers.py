"""Trained networks by name, as controllers."""

from __future__ import annotations

from pathlib import Path

from ..control import NeuralController
from ..core import FileError, suggest
from ..nets import load_network
from ._paper import trained_paper_network

NAMED = ("bassil",)


def find_controller(name: str) -> NeuralController:
    """The controller of that name, or of that network file.

    Args:
        name: ``bassil`` (the paper's network, trained on the spot) or the path of a network file.

    Raises:
        FileError: Neither a known name nor a readable network file.
        SettingError: The network names no codec.
    """
    if name == "bassil":
        return NeuralController(trained_paper_network())
    path = Path(name)
    if not path.exists():
        raise FileError(
            f"there is no controller {name!r} and no such network file; {suggest(name, NAMED)}"
        )
    return NeuralController(load_network(path))
