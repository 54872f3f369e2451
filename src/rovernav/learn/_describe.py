"""Networks before and after: drawn from a seed; the card of what was learnt, how, for what."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np

from .._version import __version__
from ..nets import Card, Network
from ._batch_settings import BatchSettings
from ._minibatch import BatchTraining
from ._online import OnlineSettings, Training
from ._paper import codec_for
from ._patterns import Patterns


def seeded_network(
    topology: Sequence[int], activations: Sequence[str], seed: int, dtype: Any = np.float64
) -> Network:
    """A fresh network, its weights drawn from `seed`, which its card names.

    Raises:
        SettingError: No such network.
    """
    drawn = Network.seeded(topology, activations, np.random.default_rng(seed), dtype=dtype)
    return drawn.with_card(Card(seed=seed))


def describe(
    training: Training | BatchTraining,
    patterns: Patterns,
    settings: OnlineSettings | BatchSettings,
) -> Network:
    """The trained network with its card filled in.

    Names come from the patterns; the codec is the network's own or, for a table with the paper's
    sensors and motors, the paper's.

    Args:
        training: An ended training.
        patterns: What it learnt.
        settings: How, of the same kind.
    """
    card = training.network.card
    online = isinstance(settings, OnlineSettings)
    how: dict[str, Any] = {
        "method": "online back-propagation" if online else "mini-batch back-propagation",
        **dataclasses.asdict(settings),
        "epochs_done": training.epoch,
        "updates": training.updates,
        "stop": None if training.stop is None else str(training.stop),
        "patterns": patterns.source,
        "patterns_sha256": patterns.sha256,
        "rovernav": __version__,
    }
    codec = card.codec or codec_for(patterns)
    return training.network.with_card(
        Card(
            inputs=patterns.inputs,
            outputs=patterns.outputs,
            input_units=card.input_units,
            output_units=card.output_units,
            codec=codec,
            training=how,
            seed=card.seed,
        )
    )
