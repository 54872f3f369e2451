"""Trained networks by name, as controllers."""

from __future__ import annotations

from collections.abc import Callable
from importlib import resources
from pathlib import Path

from ..control import BassilCodec, GoalSeeker, NeuralController, SensedPlanner
from ..core import (
    Controller,
    FileError,
    Plugin,
    PluginError,
    SettingError,
    plugin,
    plugins,
    suggest,
)
from ..nets import load_network
from ._paper import trained_paper_network

NAMED = ("bassil", "goal-seeker", "neural", "planner")
SHIPPED = "headings-v1.safetensors"
_CLASSICAL: dict[str, Callable[[], Controller]] = {
    "goal-seeker": GoalSeeker,
    "planner": SensedPlanner,
}
_WORDS = {
    "bassil": "the paper's network, trained on the spot",
    "goal-seeker": "the baseline: straight at the goal",
    "neural": "the shipped neural driver",
    "planner": "plans on what was sensed; the neural driver's teacher",
}


def usual_rover(name: str) -> str:
    """The rover preset that a controller is made for.

    Args:
        name: As for `find_controller`.

    Raises:
        RovernavError: As `find_controller`.
    """
    return rover_of(find_controller(name))


def rover_of(controller: Controller) -> str:
    """The rover preset that a controller is made for; others with the same drive will do too."""
    paper = isinstance(controller, NeuralController) and isinstance(controller.codec, BassilCodec)
    return "paper-point" if paper else "research"


def controller_names() -> dict[str, str]:
    """Our controllers that need no file: their names, and what each is in a few words."""
    return {name: _WORDS[name] for name in NAMED}


def find_controller(name: str) -> Controller:
    """The controller of that name, or of that network file.

    Args:
        name: ``bassil`` (the paper's network, trained on the spot), ``neural`` (the shipped driver,
            learnt by imitation), ``goal-seeker`` (the baseline), ``planner`` (the neural driver's
            teacher), a controller that an installed distribution offers (entry point
            ``rovernav.controllers``), or the path of a network file.

    Raises:
        FileError: Neither a known name nor a readable network file.
        PluginError: The installed controller cannot be used.
        SettingError: The network names no codec.
    """
    if name == "bassil":
        return NeuralController(trained_paper_network())
    if name == "neural":
        with resources.as_file(resources.files("rovernav.learn") / "networks" / SHIPPED) as path:
            return NeuralController(load_network(path))
    if name in _CLASSICAL:
        return _CLASSICAL[name]()
    found = plugin("controller", name)
    if found is not None:
        return _offered(found)
    path = Path(name)
    if not path.exists():
        known = {*NAMED, *(one.name for one in plugins("controller"))}
        raise FileError(
            f"there is no controller {name!r} and no such network file; {suggest(name, known)}"
        )
    network = load_network(path)
    try:
        return NeuralController(network)
    except SettingError as error:  # the file is sound, but no driver
        raise SettingError(f"{name}: {error}") from None


def _offered(found: Plugin) -> Controller:
    made = found.make()
    if not isinstance(made, Controller):
        raise PluginError(f"{found.called} is no controller: it needs start and act")
    return made
