"""One pattern at a time: the same bits as whole epochs, wherever the steps fall."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rovernav.core import ShapeError
from rovernav.kernels import backprop
from rovernav.learn import (
    RULES,
    OnlineSettings,
    Patterns,
    StopReason,
    Training,
    advance,
    load_training,
    paper_network,
    save_training,
    shipped_patterns,
    step_patterns,
    train,
    worked_example,
)
from rovernav.learn import _online as engine
from rovernav.nets import Network
from tests.bits import assert_same_bits
from tests.kernels.nets import CASES, random_network, scalars

TABLE = shipped_patterns("bassil-v1")
PLAIN = OnlineSettings(eta=0.25, momentum=0.5, tolerance=0.0, epochs=40)
SHUFFLED = OnlineSettings(eta=0.25, momentum=0.5, tolerance=0.0, epochs=40, order="shuffled")


def assert_same_training(a: Training, b: Training) -> None:
    assert_same_bits(a.network.parameters, b.network.parameters)
    assert_same_bits(a.deltas, b.deltas)
    assert (a.epoch, a.updates, a.stop, a.pattern) == (b.epoch, b.updates, b.stop, b.pattern)


@pytest.mark.kernels
@pytest.mark.parametrize("case", CASES)
def test_parts_of_an_epoch_have_the_bits_of_the_whole(
    case: tuple[tuple[int, ...], tuple[str, ...]], rng: np.random.Generator
) -> None:
    network = random_network(case, rng)
    x = rng.normal(size=(5, network.topology[0]))
    y = rng.normal(size=(5, network.topology[-1]))
    s = scalars(momentum=0.5, seed=3, epochs=1)
    whole, parts = (network.parameters.copy() for _ in range(2))
    v_whole, v_parts = np.zeros_like(whole), np.zeros_like(parts)
    every = np.empty((5, len(whole)))
    backprop.train(network.layers, whole, v_whole, x, y, s, every)
    seen: list[np.ndarray] = []
    for first, count in ((0, 2), (2, 0), (2, 1), (3, 2)):
        record = np.empty((count, len(parts)))
        backprop.train_part(network.layers, parts, v_parts, x, y, s, first, record)
        seen.extend(record)
    assert_same_bits(parts, whole)
    assert_same_bits(v_parts, v_whole)
    assert_same_bits(np.array(seen), every)


@settings(max_examples=40)
@given(
    chosen=st.sampled_from([PLAIN, SHUFFLED]),
    moves=st.lists(st.tuples(st.booleans(), st.integers(0, 6)), max_size=20),
)
def test_steps_and_epochs_may_take_turns(
    chosen: OnlineSettings, moves: list[tuple[bool, int]]
) -> None:
    now = Training.fresh(paper_network())
    for single, count in moves:
        step = step_patterns if single else advance
        now = step(now, TABLE, chosen, count)
        assert now.updates == now.epoch * len(TABLE.x) + now.pattern
    now = advance(now, TABLE, chosen, chosen.epochs)
    assert_same_training(now, train(paper_network(), TABLE, chosen))


@pytest.mark.parametrize("rule", RULES)
def test_the_first_step_is_the_paper_s_worked_example(rule: str) -> None:
    plain = OnlineSettings(eta=0.25, momentum=0.0, rule=rule)
    after = step_patterns(Training.fresh(paper_network()), TABLE, plain)
    example = worked_example(rule)
    assert (after.epoch, after.pattern, after.updates) == (0, 1, 1)
    assert_same_bits(after.network.matrices[0], example.w1)
    assert_same_bits(after.network.matrices[1], example.w2)


def test_steps_stop_where_epochs_stop() -> None:
    chosen = OnlineSettings(eta=0.25, momentum=0.5, tolerance=0.1)
    now = Training.fresh(paper_network())
    while now.stop is None:
        now = step_patterns(now, TABLE, chosen)
    whole = train(paper_network(), TABLE, chosen)
    assert whole.stop is StopReason.TOLERANCE
    assert_same_training(now, whole)
    few = OnlineSettings(tolerance=0.0, epochs=2)
    now = step_patterns(Training.fresh(paper_network()), TABLE, few, 99)
    assert (now.epoch, now.pattern, now.stop) == (1, 0, None)
    now = step_patterns(now, TABLE, few, 4)
    assert now.stop is StopReason.EPOCHS
    assert_same_training(step_patterns(now, TABLE, few), now)


def test_fewer_epochs_than_were_begun_end_within_the_epoch() -> None:
    now = step_patterns(Training.fresh(paper_network()), TABLE, PLAIN, 2)
    ended = advance(now, TABLE, OnlineSettings(epochs=0), 5)
    assert (ended.stop, ended.pattern, ended.updates) == (StopReason.EPOCHS, 2, 2)


def test_a_step_that_diverges_is_not_made() -> None:
    wild = OnlineSettings(eta=1e100, tolerance=0.0)
    begun = Training.fresh(paper_network())
    now = begun
    while now.stop is None:
        before, now = now, step_patterns(now, TABLE, wild)
    assert now.stop is StopReason.DIVERGED
    assert_same_bits(now.network.parameters, before.network.parameters)
    assert np.isfinite(now.network.parameters).all()
    assert 0 < now.updates < 100


def test_every_step_is_recorded_once(monkeypatch: pytest.MonkeyPatch) -> None:
    def recorded(by: list[int]) -> tuple[list[tuple[int, int]], np.ndarray]:
        rows: list[tuple[int, int]] = []
        weights: list[np.ndarray] = []

        def record(epoch: int, patterns: np.ndarray, w: np.ndarray) -> None:
            for number, pattern in enumerate(patterns):
                rows.append((epoch + number // 4, int(pattern)))
            weights.append(w.copy())

        now = Training.fresh(paper_network())
        for count in by:
            now = step_patterns(now, TABLE, SHUFFLED, count, recorder=record)
        advance(now, TABLE, SHUFFLED, 2 if now.pattern == 0 else 3, recorder=record)
        return rows, np.concatenate(weights)

    whole_rows, whole = recorded([4])
    monkeypatch.setattr(engine, "RECORDED", 2 * 17)  # two updates at once
    rows, weights = recorded([1, 1, 1])
    assert rows[:12] == whole_rows[:12]
    assert_same_bits(weights[:12], whole[:12])


def test_a_checkpoint_within_an_epoch_goes_on(tmp_path: Path) -> None:
    path = tmp_path / "c.safetensors"
    now = step_patterns(advance(Training.fresh(paper_network()), TABLE, SHUFFLED, 3),
                        TABLE, SHUFFLED, 3)  # fmt: skip
    save_training(now, SHUFFLED, TABLE, path)
    back = load_training(path, SHUFFLED, TABLE)
    assert back.pattern == 3
    assert_same_training(train(back, TABLE, SHUFFLED), train(paper_network(), TABLE, SHUFFLED))


def test_a_shorter_table_cannot_go_on_within_the_epoch() -> None:
    now = step_patterns(Training.fresh(paper_network()), TABLE, PLAIN, 3)
    short = Patterns(x=TABLE.x[:2], y=TABLE.y[:2], inputs=TABLE.inputs, outputs=TABLE.outputs)
    with pytest.raises(ShapeError, match="3 patterns of this epoch are done, but the table has 2"):
        step_patterns(now, short, PLAIN)
    with pytest.raises(ShapeError, match="the network has 1 inputs"):
        step_patterns(
            Training.fresh(Network.from_matrices([[[1.0, 0.0]]], ["linear"])), TABLE, PLAIN
        )
