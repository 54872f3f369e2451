"""The numbers of the page about the paper, computed again."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rovernav.control import NeuralController
from rovernav.core import F64, Outcome
from rovernav.learn import (
    OnlineSettings,
    literal_pass,
    paper_network,
    paper_training,
    train,
    trained_paper_network,
    worked_example,
)
from rovernav.nets import Network
from rovernav.scenes import Scene, bassil_scene, random_rectangles
from rovernav.sim import Trace, clearance, simulate

PAGE = Path(__file__).resolve().parents[2] / "docs" / "the-paper.md"
NUMBER = re.compile(r"[-−]?\d+(?:\.\d+)?")


@cache
def table(heading: str) -> dict[str, list[str]]:
    """The first table under a heading: the cells after the first, by the first."""
    section = PAGE.read_text(encoding="utf-8").split(f"\n## {heading}\n")[1].split("\n## ")[0]
    lines = [line for line in section.splitlines() if line.startswith("|")]
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    return {row[0]: row[1:] for row in [rows[0], *rows[2:]]}


def numbers(text: str) -> list[float]:
    return [float(found.replace("−", "-")) for found in NUMBER.findall(text)]


def drive(network: Network, scene: Scene, record: str = "all") -> Trace:
    return simulate(scene.drive(NeuralController(network)), record=record)


def test_the_worked_example() -> None:
    ours, textbook = worked_example("paper"), worked_example("textbook")
    known: dict[str, F64] = {
        "sums into h0, h1, h2": ours.hidden_nets,
        "h0, h1, h2": ours.hidden,
        "O0, O1": ours.outputs,
        "errors": ours.errors,
        "new row 0 of W2": ours.w2[0],
        "new row 1 of W2": ours.w2[1],
        "error sums of h0, h1, h2, paper's rule": ours.back_sums,
        "error sums of h0, h1, h2, textbook rule": textbook.back_sums,
        "new biases of W1, paper's rule": ours.w1[:, 2],
        "new biases of W1, textbook rule": textbook.w1[:, 2],
        "outputs after the update, paper's rule": ours.outputs_after,
        "outputs after the update, textbook rule": textbook.outputs_after,
    }
    shown = table("The worked example")
    assert set(shown) == {"quantity", *known}
    for name, right in known.items():
        assert_allclose(numbers(shown[name][0]), right, rtol=0, atol=6e-9, err_msg=name)


def test_by_how_much_the_two_rules_differ() -> None:
    ours, textbook = worked_example("paper"), worked_example("textbook")
    formula = 0.25 * ours.hidden * (ours.errors**2).sum()
    assert_allclose(ours.back_sums - textbook.back_sums, formula, rtol=0, atol=1e-15)


ROWS = ("paper, 0", "paper, 0.5", "paper, 0.9", "textbook, 0", "textbook, 0.5")


@pytest.mark.parametrize("row", ROWS)
def test_epochs_to_a_tolerance(row: str) -> None:
    shown = table("Epochs to a tolerance")
    assert set(shown) == {"rule, momentum", *ROWS}
    network, patterns, _ = paper_training()
    rule, momentum = row.split(", ")
    got = [
        train(
            network,
            patterns,
            OnlineSettings(
                eta=0.25, rule=rule, momentum=float(momentum), tolerance=float(t), epochs=20_000
            ),
        ).epoch
        for t in shown["rule, momentum"]
    ]
    assert_allclose(numbers(" ".join(shown[row])), got, rtol=0, atol=1)


@pytest.mark.parametrize("scenario", ["bassil-v1", "bassil-replay-v1"])
def test_the_scenarios(scenario: str) -> None:
    shown = {name: cells[0] for name, cells in table(f"Scenario {scenario}").items()}
    training, scene = train(*paper_training(scenario)), bassil_scene(scenario)
    trace = drive(training.network, scene)
    path = trace.path()
    right = {
        "epochs": training.epoch,
        "first point [m]": path[1],
        "apex, at step 7 [m]": path[7],
        "before the last step [m]": path[-2],
        "end [m]": path[-1],
        "steps": trace.steps[0],
        "length [m]": trace.length[0],
        "clearance [m]": clearance(path, scene.worlds),
    }
    assert int(path[:, 1].argmax()) == 7
    assert trace.ended() is Outcome.REACHED
    for name in set(shown) - {"measured", "patterns met"}:
        assert_allclose(numbers(shown[name]), right[name], rtol=0, atol=6e-4, err_msg=name)


def test_how_near_the_paper_the_test_case_comes() -> None:
    path = drive(trained_paper_network(), bassil_scene()).path()
    assert_allclose(path[1], [0.8287, 0.8287], rtol=0, atol=0.01)
    assert_allclose(path[7], [5.672, 5.898], rtol=0, atol=0.15)


CONTROLS = {
    "untrained weights": (paper_network, "paper"),
    "the paper's procedure taken literally": (literal_pass, "paper"),
    "obstacle mirrored": (trained_paper_network, "mirrored"),
    "no obstacle": (trained_paper_network, "none"),
}


@pytest.mark.parametrize("change", CONTROLS)
def test_the_negative_controls(change: str) -> None:
    shown = table("Negative controls")
    assert len(shown) == 1 + len(CONTROLS)
    outcome, after = next(cells for name, cells in shown.items() if name.startswith(change))
    network, obstacle = CONTROLS[change]
    trace = drive(network(), bassil_scene(obstacle=obstacle))
    assert (trace.ended().label.replace("_", " "), trace.steps[0]) == (outcome, numbers(after)[0])


def test_the_honest_baseline(rng: np.random.Generator) -> None:
    shown = [
        numbers(cells[0])[0]
        for cells in table("The honest baseline").values()
        if cells[0][0].isdigit()
    ]
    outcome = drive(trained_paper_network(), random_rectangles(50_000, rng), "none").outcome
    reached, collided = (np.mean(outcome == o) for o in (Outcome.REACHED, Outcome.COLLIDED))
    got = 100.0 * np.array([reached, collided, 1.0 - reached - collided])
    assert_allclose(shown, got, rtol=0, atol=0.7)
