"""What the Train tab shows, made from a state alone: no page, no side effects."""

from __future__ import annotations

import html
import io
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..core import value
from ..learn import StopReason, trace_text
from ..nets import Network, explain
from ..show import PALETTE
from ._curve import Point, TraceLine
from ._network_svg import network_svg, unit_name
from ._state import State
from ._surface import Surface, surface_svg, surfaces

SHOWN = 400
"""Points of a curve that are sent to the browser."""
LINES = 40
"""Updates that the trace pane shows."""
WEIGHTS = 400
"""Weights that the table shows."""


@value
class TrainView:
    """Texts and pictures for one moment of a training."""

    drawing: str
    answers: str
    weights: str
    trace: str
    curve: list[list[float]]
    loss: list[list[float]]
    before: list[list[float]]


def train_view(state: State, selected: int, axes: tuple[int, int] = (0, 1)) -> TrainView:
    """Everything to show, for the pattern that is selected."""
    table, network = state.setup.table, state.training.network
    selected = min(selected, len(table.x) - 1)
    passed = explain(network, table.x[selected], asked=())
    drawing = network_svg(
        network,
        (passed.inputs, *passed.activations),
        table.inputs,
        table.outputs,
        table.y[selected],
    )
    answers = surfaces(network, table, selected, axes)
    names = (table.inputs[axes[0]], table.inputs[axes[1]]) if answers else None
    return TrainView(
        drawing=drawing,
        answers=_answers(answers, names),
        weights=weights_table(network, table.inputs),
        trace=trace_lines(network, state.trace[-LINES:]),
        curve=series(state.curve, "worst"),
        loss=series(state.curve, "loss"),
        before=series(state.before, "worst"),
    )


def series(points: tuple[Point, ...], field: str) -> list[list[float]]:
    """Epoch and value of at most some `SHOWN` points that a logarithmic axis can hold."""
    every = max(1, len(points) // SHOWN)
    chosen = [*points[:-1:every], *points[-1:]]
    pairs = [[float(point.epoch), float(getattr(point, field))] for point in chosen]
    return [[epoch, item] for epoch, item in pairs if 0.0 < item < 1e100]


def weights_table(network: Network, inputs: tuple[str, ...]) -> str:
    """One table of weights per layer, a row per unit, the bias last."""
    last = len(network.topology) - 1
    shown, tables = 0, []
    for level, matrix in enumerate(network.matrices, 1):
        shown += matrix.size
        if shown > WEIGHTS:
            left = len(network.parameters) - shown + matrix.size
            tables.append(f'<p class="rn-note">and {left:,} more weights; export the network.</p>')
            break
        names = (
            [html.escape(name[:16]) for name in inputs]
            if level == 1
            else [unit_name(level - 1, i, last) for i in range(matrix.shape[1] - 1)]
        )
        head = "".join(f'<th class="n" scope="col">{name}</th>' for name in (*names, "bias"))
        rows = "".join(
            f'<tr><th scope="row">{unit_name(level, unit, last)}</th>'
            + "".join(f'<td class="n {_sign(w)}">{w:.6f}</td>' for w in row)
            + "</tr>"
            for unit, row in enumerate(matrix.tolist())
        )
        kind = "Outputs" if level == last else ("Hidden" if last == 2 else f"Hidden {level}")
        tables.append(
            f'<table class="rn-table"><caption>{kind}, {network.activations[level - 1]}</caption>'
            f"<thead><tr><th></th>{head}</tr></thead><tbody>{rows}</tbody></table>"
        )
    return f'<div class="rn-weights">{"".join(tables)}</div>'


def trace_lines(network: Network, lines: tuple[TraceLine, ...]) -> str:
    """The last updates as the paper's listing prints them, the latest first."""
    texts: list[str] = []
    for line in reversed(lines):
        out = io.StringIO()
        if len(line.weights) != len(network.parameters):
            continue
        trace_text(out.write, network)(
            line.epoch - 1, np.array([line.pattern - 1]), line.weights[None]
        )
        texts.append(out.getvalue())
    return "\n".join(texts)


def curve_options(state: State, view: TrainView) -> dict[str, Any]:
    """What the chart library needs to draw the error curve."""
    tolerance = state.setup.settings.tolerance
    lines = [
        _line("largest |error|", view.curve, "worst"),
        _line("mean loss", view.loss, "loss"),
        _line("run before", view.before, "before"),
    ]
    if tolerance > 0:
        lines[0]["markLine"] = {
            "silent": True,
            "symbol": "none",
            "data": [{"yAxis": tolerance}],
            "lineStyle": {"color": COLOURS["tolerance"], "type": "dashed", "width": 1.5},
            "label": {"formatter": "tolerance", "position": "insideEndTop", "color": GREY},
        }
    return _frame(lines)


def overlaid_options(curves: Mapping[str, Sequence[Point]]) -> dict[str, Any]:
    """A chart with the error curves of several runs, by their names."""
    palette = list(PALETTE.values())
    lines = [
        {
            "name": name,
            "type": "line",
            "data": series(tuple(points), "worst"),
            "showSymbol": len(points) < 2,
            "lineStyle": {"width": 2, "color": palette[number % len(palette)]},
            "itemStyle": {"color": palette[number % len(palette)]},
        }
        for number, (name, points) in enumerate(curves.items())
    ]
    options = _frame(lines)
    options["legend"].update(type="scroll", orient="vertical", left=70, top=4)
    options["grid"]["top"] = 24 + 20 * len(lines)
    return options


GREY, FAINT = "#7b8894", "rgba(128,140,150,.22)"
COLOURS = {"worst": "#0072B2", "loss": "#E69F00", "before": "#9aa5af", "tolerance": "#009E73"}


def _line(name: str, data: list[list[float]], kind: str) -> dict[str, Any]:
    width = {"worst": 2.2, "loss": 1.6, "before": 1.4}[kind]
    return {
        "name": name,
        "type": "line",
        "data": data,
        "showSymbol": len(data) < 2,
        "lineStyle": {"width": width, "color": COLOURS[kind]},
        "itemStyle": {"color": COLOURS[kind]},
    }


def _answers(found: list[Surface], names: tuple[str, str] | None) -> str:
    if names is None:
        return '<p class="rn-note">A surface needs two inputs.</p>'
    return "".join(surface_svg(surface, names) for surface in found)


_ENDS = {
    StopReason.TOLERANCE: ("Learnt: every error is within the tolerance", "good"),
    StopReason.EPOCHS: ("All epochs are done, the tolerance is not met", "warn"),
    StopReason.DIVERGED: ("Diverged", "bad"),
}


def status_words(state: State) -> tuple[str, str]:
    """How the training stands, in words; and whether that is good, bad, a warning or plain."""
    if state.said:
        return state.said, "bad"
    if state.running:
        return "Training", "run"
    if state.training.stop is not None and state.training.stop in _ENDS:
        return _ENDS[state.training.stop]
    return ("Paused", "") if state.training.updates else ("Ready", "")


def figures(state: State) -> tuple[str, str, str]:
    """Epoch, largest error and speed, as they are shown."""
    worst = state.curve[-1].worst
    error = f"{worst:.4g}" if math.isfinite(worst) else "not finite"
    rate = f"{_amount(state.rate)} updates/s" if state.rate else ""
    return _epoch(state), error, rate


def _epoch(state: State) -> str:
    text = f"{state.training.epoch:,}"
    if state.training.pattern:
        text += f" + {state.training.pattern}/{len(state.setup.table.x)}"
    return text


def _amount(number: float) -> str:
    if number >= 1e6:
        return f"{number / 1e6:.1f} million"
    return f"{number:,.0f}"


def _sign(weight: float) -> str:
    return "rn-p" if weight >= 0 else "rn-m"


def _frame(lines: list[dict[str, Any]]) -> dict[str, Any]:
    """Axes and legend of an error chart."""
    return {
        "animation": False,
        "grid": {"left": 52, "right": 14, "top": 30, "bottom": 34},
        "legend": {"top": 0, "right": 4, "itemHeight": 8, "textStyle": {"color": GREY},
                   "data": [line["name"] for line in lines if line["data"]]},
        "tooltip": {"trigger": "axis", "confine": True},
        "xAxis": {"type": "value", "name": "epoch", "nameLocation": "middle", "nameGap": 22,
                  "min": 0, "nameTextStyle": {"color": GREY}, "axisLabel": {"color": GREY},
                  "splitLine": {"lineStyle": {"color": FAINT}}},
        "yAxis": {"type": "log", "axisLabel": {"color": GREY},
                  "splitLine": {"lineStyle": {"color": FAINT}}},
        "series": lines,
    }  # fmt: skip
