"""What the lessons ask about, worked out by the engine and the simulator."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np

from ..control import NeuralController
from ..core import Outcome
from ..learn import (
    StopReason,
    find_controller,
    paper_training,
    train,
    trained_paper_network,
    worked_example,
)
from ..nets import gradient
from ..scenes import bassil_scene, random_rectangles
from ..sim import Trace, simulate

RATES = (0.25, 0.5, 0.75, 1.0, 2.0)
"""Learning rates that lesson 2 compares."""
MANY = 20_000
"""Epochs after which a training of lesson 2 gives up."""


@functools.cache
def trained(
    eta: float = 0.25, momentum: float = 0.5, rule: str = "paper", tolerance: float = 0.01
) -> tuple[int, StopReason | None]:
    """Epochs of the paper's training with other settings, and why it ended."""
    network, patterns, settings = paper_training()
    changed = dataclasses.replace(
        settings, eta=eta, momentum=momentum, rule=rule, tolerance=tolerance, epochs=MANY
    )
    done = train(network, patterns, changed)
    return done.epoch, done.stop


@functools.cache
def drive(obstacle: str) -> Trace:
    """The paper's network in its scene with an obstacle ``paper``, ``mirrored`` or ``none``."""
    controller = NeuralController(trained_paper_network())
    return simulate(bassil_scene(obstacle=obstacle).drive(controller))


def epochs(**settings: float | str) -> float:
    """Epochs of the paper's training with other settings."""
    return float(trained(**settings)[0])


def turn() -> float:
    """The step at which the paper's rover is highest."""
    return float(np.argmax(drive("paper").path()[:, 1]))


def outcome(obstacle: str) -> str:
    """How the drive ends."""
    return drive(obstacle).ended().label


def bits(obstacle: str) -> str:
    """What the two sensors read at the start, as ``x, y``."""
    channels = drive(obstacle).channels
    x, y = (int(channels[name][0, 0, 0]) for name in ("clear_sight", "off_line"))
    return f"{x}, {y}"


def first_move(obstacle: str) -> str:
    """To which side the first step goes."""
    across = drive(obstacle).path()[1, 1]
    return "up" if across > 0 else "down" if across < 0 else "neither"


def reached_share() -> float:
    """Percent of 2,000 random rectangles that the paper's network passes."""
    scene = random_rectangles(2000, np.random.default_rng(0))
    controller = NeuralController(trained_paper_network())
    trace = simulate(scene.drive(controller), record="none")
    return 100.0 * float(np.mean(trace.outcome == Outcome.REACHED))


def first_diverging(momentum: float) -> str:
    """The smallest of `RATES` with which training diverges."""
    found = (eta for eta in RATES if trained(eta, momentum)[1] is StopReason.DIVERGED)
    return f"{next(found):g}"


def best_momentum(tolerance: float) -> str:
    """Which of 0, 0.5 and 0.9 needs the fewest epochs."""
    return f"{min((0.0, 0.5, 0.9), key=lambda m: trained(momentum=m, tolerance=tolerance)[0]):g}"


def back_sum(rule: str) -> float:
    """The error sum of the first hidden neuron in the worked example."""
    return float(worked_example(rule).back_sums[0])


def finite_difference() -> str:
    """The rule whose change of the first hidden bias is minus eta times the error's slope."""
    network, _, _ = paper_training()
    target = np.ones((1, 2))

    def loss(shift: float) -> float:
        moved = network.parameters.copy()
        moved[2] += shift  # the bias of h0: the last of its three weights
        outputs = network.with_parameters(moved).forward(np.zeros((1, 2)))
        return 0.5 * float(((target - outputs) ** 2).sum())

    slope = (loss(1e-6) - loss(-1e-6)) / 2e-6
    change = {rule: float(worked_example(rule).w1[0, 2]) - 0.1 for rule in ("paper", "textbook")}
    return min(change, key=lambda rule: abs(change[rule] + 0.25 * slope))


def exact_gradient() -> float:
    """The same slope, by the backward pass."""
    network, _, _ = paper_training()
    return float(gradient(network, np.zeros((1, 2)), np.ones((1, 2)))[1][2])


def faster_rule(momentum: float, tolerance: float) -> str:
    """Which rule needs fewer epochs."""
    return min(
        ("paper", "textbook"),
        key=lambda rule: trained(momentum=momentum, rule=rule, tolerance=tolerance)[0],
    )


def neural_outcome() -> str:
    """How the shipped driver ends before the mirrored obstacle."""
    from ..scenes import Scenario, set_scene

    box = bassil_scene(obstacle="mirrored").worlds.row(0).boxes[0].tolist()
    data = {"from": [0.0, 0.0], "to": [11.73, 0.0], "boxes": [box], "rover": "research"}
    scene = set_scene(Scenario.model_validate(data))
    return simulate(scene.drive(find_controller("neural"))).ended().label  # type: ignore[union-attr]
