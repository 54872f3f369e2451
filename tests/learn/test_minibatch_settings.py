from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rovernav.core import PatternError, SettingError, ShapeError
from rovernav.learn import BatchSettings, BatchTraining, Patterns, advance_batches, train_batches
from rovernav.nets import Network

WRONG = [
    ({"optimizer": "adm"}, r"unknown optimizer 'adm'; did you mean 'adam'\? Allowed: adam, sgd\."),
    ({"loss": "crossentropy"}, r"unknown loss 'crossentropy'; Allowed: binary, mse, softmax\."),
    ({"order": "cycle"}, r"unknown order 'cycle'; did you mean 'cyclic'\?"),
    ({"schedule": "cos"}, r"unknown schedule 'cos'; did you mean 'cosine'\?"),
    ({"eta": 0.0}, "eta must be a number above 0, got 0.0"),
    ({"eta": math.nan}, "eta must be a number above 0, got nan"),
    ({"momentum": 1.0}, "momentum must be from 0 to below 1, got 1.0"),
    ({"momentum": -0.1}, "momentum must be from 0 to below 1, got -0.1"),
    ({"tolerance": -1.0}, "tolerance must be 0 or above, got -1.0"),
    ({"tolerance": math.inf}, "tolerance must be 0 or above, got inf"),
    ({"validation": 1.0}, "validation must be from 0 to below 1, got 1.0"),
    ({"batch": 0}, r"batch must be from 1 to 10\^6, got 0"),
    ({"epochs": -1}, r"epochs must be from 0 to 10\^12, got -1"),
    ({"seed": -1}, r"seed must be from 0 to 2\^63 - 1, got -1"),
]


@pytest.mark.parametrize(("changes", "sentence"), WRONG)
def test_what_is_wrong_is_said(changes: dict[str, Any], sentence: str) -> None:
    with pytest.raises(SettingError, match=sentence):
        BatchSettings(**changes)


def test_cosine_falls_from_eta_to_nothing() -> None:
    settings = BatchSettings(eta=0.4, schedule="cosine", epochs=4)
    rates = [settings.eta_at(epoch) for epoch in range(5)]
    expected = [0.4, 0.2 + 0.2 * math.sqrt(0.5), 0.2, 0.2 - 0.2 * math.sqrt(0.5), 0.0]
    assert_allclose(rates, expected, rtol=0, atol=1e-15)
    assert BatchSettings(eta=0.4).eta_at(10**9) == 0.4


def test_how_many_rows_are_learnt() -> None:
    assert BatchSettings().learnt(1) == 1
    assert BatchSettings(validation=0.25).learnt(10) == 8
    for rows in (1, 2):
        with pytest.raises(SettingError, match=f"validation = 0.1 of {rows} patterns holds out 0"):
            BatchSettings(validation=0.1).learnt(rows)
    with pytest.raises(SettingError, match="both parts need at least one"):
        BatchSettings(validation=0.9).learnt(1)


def patterns_of(x: Any, y: Any) -> Patterns:
    inputs = tuple(f"x{k}" for k in range(np.shape(x)[1]))
    outputs = tuple(f"y{k}" for k in range(np.shape(y)[1]))
    return Patterns(x=np.array(x), y=np.array(y), inputs=inputs, outputs=outputs)


def test_what_does_not_fit_is_said(rng: np.random.Generator) -> None:
    network = Network.seeded((2, 1), ("sigmoid",), rng, dtype=np.float32)
    fitting = patterns_of([[0.0, 1.0]], [[1.0]])
    narrow, large = patterns_of([[0.0]], [[1.0]]), patterns_of([[0.0, 1e39]], [[1.0]])
    with pytest.raises(ShapeError, match="the network has 2 inputs and 1 outputs"):
        train_batches(network, narrow, BatchSettings())
    with pytest.raises(SettingError, match="loss 'binary' takes linear outputs as logits"):
        train_batches(network, fitting, BatchSettings(loss="binary"))
    with pytest.raises(PatternError, match="too large for a float32 network; scale it"):
        train_batches(network, large, BatchSettings())
    with pytest.raises(SettingError, match="holds out"):
        advance_batches(BatchTraining.fresh(network), fitting, BatchSettings(validation=0.5), 1)
    for moments in (np.zeros((2, 4)), np.zeros((1, 3), np.float32)):
        with pytest.raises(ShapeError, match=r"moments must be \(2, 3\) of float32"):
            BatchTraining(network=network, moments=moments)
