"""The seed paper's network, its training and its worked example (Bassil 2012, section 6.3)."""

from __future__ import annotations

import numpy as np

from ..core import F64, SettingError, suggest, value
from ..kernels import backprop
from ..nets import Card, Network
from ._online import RULES, OnlineSettings, train
from ._patterns import Patterns, shipped_patterns

W1 = ((0.17, 0.33, 0.1), (0.3, 0.71, 0.21), (0.15, 0.43, 0.69))
"""The paper's initial weights, rows h0..h2, columns x, y, bias."""
W2 = ((0.11, 0.03, 0.52, 0.41), (0.93, 0.14, 0.79, 0.66))
"""The paper's initial weights, rows O0, O1, columns h0, h1, h2, bias."""

_SETTINGS = {
    "bassil-v1": OnlineSettings(eta=0.25, momentum=0.5, rule="paper", tolerance=0.01),
    "bassil-replay-v1": OnlineSettings(eta=0.25, momentum=0.5, rule="paper", tolerance=0.001),
}
_CODECS = {
    "bassil-v1": {"name": "bassil", "step": 0.8287, "period": 1.0, "stop_at_goal": True},
    "bassil-replay-v1": {"name": "bassil", "step": 1.0, "period": 1.0, "stop_at_goal": False},
}


def paper_network(scenario: str = "bassil-v1") -> Network:
    """The paper's 2-3-2 network with its initial weights, untrained.

    Args:
        scenario: ``bassil-v1`` or ``bassil-replay-v1``: which step its outputs are multiplied by.
    """
    _check_name(scenario)
    patterns = shipped_patterns(scenario)
    card = Card(
        inputs=patterns.inputs,
        outputs=patterns.outputs,
        input_units=("1", "1"),
        output_units=("step", "step"),
        codec=_CODECS[scenario],
    )
    return Network.from_matrices((W1, W2), ("sigmoid", "linear"), card)


def paper_training(scenario: str = "bassil-v1") -> tuple[Network, Patterns, OnlineSettings]:
    """Initial network, pattern table and settings of a scenario of the paper.

    eta and the first pattern are the paper's; momentum, tolerance, rule and the other patterns
    are read from its figure or chosen: see the docs, "The paper".
    """
    _check_name(scenario)
    return paper_network(scenario), shipped_patterns(scenario), _SETTINGS[scenario]


def trained_paper_network(scenario: str = "bassil-v1") -> Network:
    """The paper's network after its training: a few milliseconds, the same bits every time."""
    network, patterns, settings = paper_training(scenario)
    return train(network, patterns, settings).network


def codec_for(patterns: Patterns) -> dict[str, object] | None:
    """The paper's codec, if the table has the paper's two sensors and two motors."""
    names = (patterns.inputs, patterns.outputs)
    paper = (("clear_sight", "off_line"), ("motor_x", "motor_y"))
    return dict(_CODECS["bassil-v1"]) if names == paper else None


@value
class WorkedExample:
    """Every number of the paper's worked example, in full precision.

    Attributes:
        hidden_nets: Sums into h0..h2 (3,).
        hidden: Outputs of h0..h2 (3,).
        outputs: O0, O1 (2,).
        errors: Desired minus actual (2,).
        back_sums: Error sum of each hidden neuron (3,).
        w1: New weights of the hidden layer (3, 3).
        w2: New weights of the output layer (2, 4).
        outputs_after: O0, O1 with the new weights (2,).
    """

    hidden_nets: F64
    hidden: F64
    outputs: F64
    errors: F64
    back_sums: F64
    w1: F64
    w2: F64
    outputs_after: F64


def worked_example(rule: str = "paper") -> WorkedExample:
    """One update for the input [0, 0], desired [1, 1], eta 0.25, without momentum."""
    if rule not in RULES:
        raise SettingError(f"unknown rule {rule!r}; {suggest(rule, RULES)}")
    net = paper_network()
    w, v, o = net.parameters.copy(), np.zeros(17), np.zeros((3, 7))
    settings = backprop.OnlineSettings(0.25, 0.0, RULES[rule], 0.0, -1, 0, 1)
    backprop.update(net.layers, w, v, np.ones(2), o, settings)
    after = net.with_parameters(w)
    hidden = o[0, 2:5]
    return WorkedExample(
        hidden_nets=net.matrices[0] @ np.array([0.0, 0.0, 1.0]),
        hidden=hidden,
        outputs=o[0, 5:7],
        errors=1.0 - o[0, 5:7],
        back_sums=o[1, 2:5] / (hidden * (1.0 - hidden)),
        w1=after.matrices[0],
        w2=after.matrices[1],
        outputs_after=after.forward(np.zeros((1, 2)))[0],
    )


def literal_pass(scenario: str = "bassil-v1", *, limit: int = 100_000) -> Network:
    """The paper's steps taken literally: each pattern to tolerance once, then the next.

    Without momentum, for which the paper gives no value.
    It forgets what it learnt first: a negative control, and a reason to cycle.
    """
    net, patterns, settings = paper_training(scenario)
    w, v = net.parameters.copy(), np.zeros(len(net.parameters))
    for x, y in zip(patterns.x, patterns.y, strict=True):
        backprop.train(
            net.layers, w, v, x[None], y[None],
            backprop.OnlineSettings(
                settings.eta, 0.0, backprop.PAPER, settings.tolerance, -1, 0, limit
            ),
            np.empty((0, len(w))),
        )  # fmt: skip
    return net.with_parameters(w)


def _check_name(scenario: str) -> None:
    if scenario not in _SETTINGS:
        raise SettingError(
            f"the paper has no scenario {scenario!r}; {suggest(scenario, _SETTINGS)}"
        )
