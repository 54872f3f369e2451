from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rovernav.core import SettingError, read_yaml
from rovernav.learn import (
    W1,
    W2,
    OnlineSettings,
    StopReason,
    literal_pass,
    paper_network,
    paper_training,
    shipped_patterns,
    train,
    trained_paper_network,
    worked_example,
)

GOLDEN = Path(__file__).parent.parent / "golden" / "bassil2012"


def golden(name: str) -> dict[str, Any]:
    return read_yaml(GOLDEN / f"{name}.yaml", what="table of golden numbers")


@pytest.mark.parametrize("rule", ["paper", "textbook"])
def test_worked_example_in_full_precision(rule: str) -> None:
    table, example = golden("worked_example"), worked_example(rule)
    for quantity, expected in {**table["both rules"], **table[rule]}.items():
        actual = getattr(example, quantity)
        assert_allclose(actual, expected, rtol=0, atol=table["tolerance"], err_msg=quantity)


def test_worked_example_as_printed() -> None:
    table, example = golden("as_printed"), worked_example()
    outputs, weights = table["tolerance"]["outputs"], table["tolerance"]["weights"]
    assert_allclose(example.hidden, table["hidden"], rtol=0, atol=outputs)
    for printed in table["outputs"]:
        assert_allclose(example.outputs, printed, rtol=0, atol=outputs)
    assert_allclose(np.abs(example.errors), table["absolute_errors"], rtol=0, atol=outputs)
    for output, source, printed in table["weights"]:
        assert_allclose(example.w2[output, source], printed, rtol=0, atol=weights)


def test_worked_example_knows_two_rules() -> None:
    with pytest.raises(SettingError, match="unknown rule 'papper'; did you mean 'paper'"):
        worked_example("papper")


@pytest.mark.parametrize("row", golden("epochs")["epochs"], ids=str)
def test_epochs_until_every_error_is_small(row: dict[str, Any]) -> None:
    table = golden("epochs")
    for tolerance, expected in zip(table["largest error below"], row["done"], strict=True):
        settings = OnlineSettings(
            rule=row["rule"], momentum=row["momentum"], tolerance=tolerance, epochs=50_000
        )
        ended = train(paper_network(), shipped_patterns("bassil-v1"), settings)
        assert ended.stop is StopReason.TOLERANCE
        assert abs(ended.epoch - expected) <= table["tolerance"], (tolerance, ended.epoch)


@pytest.mark.parametrize(("scenario", "epochs"), [("bassil-v1", 215), ("bassil-replay-v1", 402)])
def test_scenarios_are_learnt(scenario: str, epochs: int) -> None:
    network, patterns, settings = paper_training(scenario)
    ended = train(network, patterns, settings)
    assert ended.stop is StopReason.TOLERANCE
    assert abs(ended.epoch - epochs) <= 1
    assert np.abs(ended.network.forward(patterns.x) - patterns.y).max() < settings.tolerance
    assert trained_paper_network(scenario).parameters.tolist() == ended.network.parameters.tolist()


def test_taken_literally_it_forgets() -> None:
    """Each pattern to tolerance once, then the next: the first one is lost."""
    network = literal_pass()
    assert_allclose(network.forward([[0.0, 0.0]]), [[0.970, 0.003]], rtol=0, atol=1e-3)
    assert_allclose(network.forward([[1.0, 0.0]]), [[1.0, 0.0]], rtol=0, atol=0.01)


def test_the_paper_network() -> None:
    network = paper_network()
    assert network.topology == (2, 3, 2)
    assert network.activations == ("sigmoid", "linear")
    assert network.matrices[0].tolist() == [list(row) for row in W1]
    assert network.matrices[1].tolist() == [list(row) for row in W2]
    assert network.card.inputs == ("clear_sight", "off_line")
    with pytest.raises(SettingError, match=r"no scenario 'bassil'; did you mean 'bassil-"):
        paper_network("bassil")
    with pytest.raises(SettingError, match="the paper has no scenario 'x'; Allowed: bassil-re"):
        paper_training("x")
