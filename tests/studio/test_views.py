"""What the Train tab draws, from states alone."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from rovernav.learn import Patterns, paper_network, shipped_patterns
from rovernav.nets import explain
from rovernav.studio import Library, TrainModel
from rovernav.studio._network_svg import WIDEST, network_svg
from rovernav.studio._surface import ABOVE, BELOW, MIDDLE, colours, surface_svg, surfaces
from rovernav.studio._train_view import (
    LINES,
    curve_options,
    figures,
    status_words,
    train_view,
)


@pytest.fixture
def model(tmp_path: Path) -> TrainModel:
    return TrainModel(keep=Library(tmp_path / "runs.sqlite3").add)


def drawing(model: TrainModel, selected: int = 0) -> ElementTree.Element:
    return ElementTree.fromstring(train_view(model.state(), selected).drawing)


def test_lines_are_the_weights(model: TrainModel) -> None:
    svg = drawing(model)
    lines = [line for line in svg.iter("path")]
    assert len(lines) == 17
    widths = [float(line.get("stroke-width", "0")) for line in lines]
    weights = [float((line.findtext("title") or "").split(": ")[1]) for line in lines]
    assert_allclose(sorted(weights), np.sort(paper_network().parameters), atol=1e-6)
    assert_allclose(
        widths, 0.6 + WIDEST * np.abs(weights) / max(1, np.abs(weights).max()), atol=5e-3
    )
    for line, weight in zip(lines, weights, strict=True):
        assert ("rn-plus" if weight >= 0 else "rn-minus") in (line.get("class") or "")
    assert sum("rn-bias" in (line.get("class") or "") for line in lines) == 5


def test_nodes_show_the_selected_pattern(model: TrainModel) -> None:
    table = shipped_patterns("bassil-v1")
    for selected in range(4):
        passed = explain(paper_network(), table.x[selected], asked=())
        shown = [t.text for t in drawing(model, selected).iter("text") if t.get("class") == "rn-in"]
        values = [*passed.inputs, *passed.activations[0], *passed.activations[1]]
        wanted = [f"{v:.2f}".replace("-", "−") for v in values]
        assert [text for text in shown if text != "1"] == wanted


@pytest.mark.parametrize("hidden", [(), (1,), (13,), (40, 3), (2, 2, 2, 2, 2, 2)])
def test_any_network_can_be_drawn(model: TrainModel, hidden: tuple[int, ...]) -> None:
    model.change(hidden=hidden, weights="seeded")
    svg = drawing(model)
    assert svg.get("aria-label") == "Network " + "-".join(map(str, (2, *hidden, 2)))
    ys = [float(t.get("cy", "0")) for t in svg.iter("circle")]
    assert min(ys) > 0
    assert max(ys) < 430
    if 40 in hidden:
        assert "(40, 12 drawn)" in train_view(model.state(), 0).drawing


def test_wild_numbers_do_not_break_the_drawing() -> None:
    wild = paper_network().with_parameters(np.array([1e300, -1e300, 0.0, *np.zeros(14)]))
    svg = network_svg(wild, (np.zeros(2), np.array([1.0, np.nan, np.inf]), np.zeros(2)),
                      ("x", "y"), ("u", "v"), np.zeros(2))  # fmt: skip
    assert ElementTree.fromstring(svg).tag == "svg"
    assert "nan" not in svg.lower()


def test_surfaces_are_the_network_s_answers() -> None:
    table, network = shipped_patterns("bassil-v1"), paper_network()
    first, second = surfaces(network, table, 0)
    assert (first.output, second.output) == ("motor_x", "motor_y")
    assert first.low == second.low == (-0.25, -0.25)
    assert first.high == (1.25, 1.25)
    assert {(round(x, 6), round(y, 6)) for x, y, _ in first.points} == {
        (x, y) for x in (0.166667, 0.833333) for y in (0.166667, 0.833333)
    }
    targets = {(round(x), round(1 - y)): want for x, y, want in second.points}
    assert targets == {(0, 0): 1, (0, 1): 1, (1, 1): -1, (1, 0): 0}
    assert ElementTree.fromstring(surface_svg(second, ("a<b", "c&d"))).tag == "svg"


def test_other_inputs_keep_the_selected_pattern_s_values() -> None:
    x = np.array([[0.0, 0.0, 0.0], [1.0, 1.0, 5.0]])
    table = Patterns(x=x, y=x[:, :1], inputs=("a", "b", "c"), outputs=("o",))
    from rovernav.nets import Network

    network = Network.from_matrices([[[0.0, 0.0, 1.0, 0.0]]], ["linear"])  # answers c
    shown = [surfaces(network, table, k, (0, 1))[0].image for k in (0, 1)]
    assert shown[0] != shown[1]
    varied = [surfaces(network, table, k, (2, 0))[0].image for k in (0, 1)]
    assert varied[0] == varied[1]
    one = Patterns(x=x[:, :1], y=x[:, :1], inputs=("a",), outputs=("o",))
    assert surfaces(Network.from_matrices([[[1.0, 0.0]]], ["linear"]), one, 0) == []


def test_colours_run_from_orange_over_white_to_blue() -> None:
    got = colours(np.array([-9.0, -2.0, 0.0, 2.0, 9.0, np.nan, np.inf]), 2.0)
    assert_array_equal(got[:5], [BELOW, BELOW, MIDDLE, ABOVE, ABOVE])
    assert_array_equal(got[5:], np.full((2, 3), 128))


def test_weights_trace_and_curve(model: TrainModel) -> None:
    model.trace(True)
    for _ in range(30):
        model.step_epoch()
    state = model.state()
    view = train_view(state, 0)
    numbers = [float(n) for n in re.findall(r'<td class="n[^>]*>(-?[\d.]+)</td>', view.weights)]
    assert_allclose(numbers, model.network.parameters, atol=1e-6)
    assert view.trace.startswith("epoch 30, pattern 3\nmatrix2[0][0] = ")
    assert view.trace.count("epoch ") == LINES
    options: dict[str, Any] = curve_options(state, view)
    worst = options["series"][0]
    assert worst["data"][-1] == [30.0, state.curve[-1].worst]
    assert worst["markLine"]["data"] == [{"yAxis": 0.01}]
    assert options["yAxis"]["type"] == "log"
    assert figures(state) == ("30", f"{state.curve[-1].worst:.4g}", "")


def test_what_the_status_says(model: TrainModel) -> None:
    assert status_words(model.state())[0] == "Ready"
    model.step_pattern()
    state = model.state()
    assert (status_words(state)[0], figures(state)[0]) == ("Paused", "0 + 1/4")
    assert train_view(state, 99).drawing  # a pattern that is no longer there
    model.change(epochs=1)
    model.step_epoch()
    assert status_words(model.state()) == (
        "All epochs are done, the tolerance is not met",
        "warn",
    )
    model.change(eta=1e100, epochs=9)
    while model.state().training.stop is None:
        model.step_epoch()
    words, tone = status_words(model.state())
    assert "diverged" in words
    assert tone == "bad"
