from __future__ import annotations

import csv
import io
from typing import Any

import numpy as np
import pytest

from rovernav.kernels import backprop
from rovernav.learn import (
    OnlineSettings,
    Patterns,
    StopReason,
    Training,
    advance,
    paper_network,
    shipped_patterns,
    trace_csv,
    trace_text,
    train,
    weight_names,
)
from rovernav.learn import _online as engine
from tests.bits import assert_same_bits

TABLE = shipped_patterns("bassil-v1")


def traced(settings: OnlineSettings, table: Patterns = TABLE) -> tuple[Training, list[list[str]]]:
    file = io.StringIO(newline="")
    ended = train(paper_network(), table, settings, recorder=trace_csv(file, paper_network()))
    return ended, list(csv.reader(io.StringIO(file.getvalue())))


def order_of(settings: OnlineSettings, count: int, epoch: int) -> list[int]:
    order = np.arange(count)
    if settings.order == "shuffled":
        backprop.shuffle(order, settings.seed, epoch)
    return order.tolist()


def one_by_one(ended: Training, settings: OnlineSettings, table: Patterns) -> list[list[Any]]:
    """Epoch, pattern and weights of each update, made one at a time."""
    network, lines = paper_network(), []
    w, v = network.parameters.copy(), np.zeros(17)
    rates = backprop.OnlineSettings(settings.eta, settings.momentum, backprop.PAPER, 0.0, -1, 0, 1)
    for epoch in range(ended.epoch):
        for p in order_of(settings, len(table.x), epoch):
            row = slice(p, p + 1)
            backprop.train(
                network.layers, w, v, table.x[row], table.y[row], rates, np.empty((0, 17))
            )
            lines.append([epoch + 1, p, *w.tolist()])
    return lines


@pytest.mark.parametrize("order", ["cyclic", "shuffled"])
@pytest.mark.parametrize(
    ("changes", "stop"),
    [
        ({"tolerance": 0.3}, StopReason.TOLERANCE),
        ({"epochs": 13, "tolerance": 0.0}, StopReason.EPOCHS),
        ({"eta": 3.0}, StopReason.DIVERGED),
        ({"tolerance": 100.0}, StopReason.TOLERANCE),
    ],
)
def test_the_trace_is_every_update(
    order: str, changes: dict[str, Any], stop: StopReason, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(engine, "RECORDED", 5 * 4 * 17)  # slices of five epochs
    fields: dict[str, Any] = {"momentum": 0.5, "order": order, "seed": 3, "epochs": 200, **changes}
    settings = OnlineSettings(**fields)
    ended, lines = traced(settings)
    assert ended.stop is stop
    assert lines[0] == ["epoch", "pattern", *weight_names(paper_network())]
    expected = one_by_one(ended, settings, TABLE)
    assert len(lines) == 1 + ended.updates == 1 + len(expected)
    for line, (epoch, pattern, *weights) in zip(lines[1:], expected, strict=True):
        assert line[:2] == [str(epoch), str(pattern)]
        assert_same_bits([float(cell) for cell in line[2:]], weights)
    if ended.updates:
        assert_same_bits([float(cell) for cell in lines[-1][2:]], ended.network.parameters)


def test_one_pattern_alone() -> None:
    one = Patterns(x=TABLE.x[:1], y=TABLE.y[:1], inputs=TABLE.inputs, outputs=TABLE.outputs)
    _, lines = traced(OnlineSettings(epochs=3, tolerance=0.0), one)
    assert [line[:2] for line in lines[1:]] == [["1", "0"], ["2", "0"], ["3", "0"]]


def test_tracing_changes_no_bits() -> None:
    settings = OnlineSettings(momentum=0.5, tolerance=0.01)
    plain = train(paper_network(), TABLE, settings)
    ended, _ = traced(settings)
    assert ended.epoch == plain.epoch
    assert_same_bits(ended.network.parameters, plain.network.parameters)


def test_a_resumed_trace_goes_on_counting() -> None:
    settings = OnlineSettings(epochs=5, tolerance=0.0)
    half = advance(Training.fresh(paper_network()), TABLE, settings, 3)
    file = io.StringIO()
    train(half, TABLE, settings, recorder=trace_csv(file, paper_network()))
    rows = [line.split(",")[:2] for line in file.getvalue().splitlines()[1:]]
    assert rows == [[str(epoch), str(p)] for epoch in (4, 5) for p in range(4)]


def test_weights_have_the_listings_names() -> None:
    names = weight_names(paper_network())
    assert names[:4] == ["matrix1[0][0]", "matrix1[0][1]", "matrix1[0][2]", "matrix1[1][0]"]
    assert names[9:14] == [f"matrix2[0][{source}]" for source in range(4)] + ["matrix2[1][0]"]
    assert len(set(names)) == 17


def test_the_text_is_that_of_the_listing() -> None:
    said: list[str] = []
    settings = OnlineSettings(epochs=1, tolerance=0.0)
    train(paper_network(), TABLE, settings, recorder=trace_text(said.append, paper_network()))
    assert len(said) == 4
    first = said[0].splitlines()
    assert first[0] == "epoch 1, pattern 0"
    assert first[1] == (
        "matrix2[0][0] = 0.132230277  matrix2[0][1] = 0.053387513  "
        "matrix2[0][2] = 0.548200411  matrix2[0][3] = 0.452345063"
    )
    assert first[3].startswith("matrix1[0][0] = 0.17  matrix1[0][1] = 0.33  matrix1[0][2] = 0.0624")
    assert len(first) == 6
    assert said[3].startswith("epoch 1, pattern 3\n")
