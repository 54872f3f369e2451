from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rovernav.core import SettingError, ShapeError
from rovernav.learn import (
    RULES,
    OnlineSettings,
    Patterns,
    Progress,
    StopReason,
    Training,
    advance,
    checkpointer,
    load_training,
    paper_network,
    save_training,
    shipped_patterns,
    train,
)
from rovernav.learn import _online as engine
from rovernav.nets import Network
from tests.bits import assert_same_bits

TABLE = shipped_patterns("bassil-v1")
LONG = OnlineSettings(order="shuffled", seed=5, momentum=0.5, tolerance=0.0, epochs=300)


def assert_same_training(a: Training, b: Training) -> None:
    assert_same_bits(a.network.parameters, b.network.parameters)
    assert_same_bits(a.deltas, b.deltas)
    assert (a.epoch, a.updates, a.stop) == (b.epoch, b.updates, b.stop)


def changed(plain: OnlineSettings, **changes: Any) -> OnlineSettings:
    fields = {name: getattr(plain, name) for name in plain.__dataclass_fields__}
    return OnlineSettings(**{**fields, **changes})


@pytest.fixture(scope="module")
def uninterrupted() -> Training:
    return train(paper_network(), TABLE, LONG)


@settings(max_examples=20)
@given(steps=st.lists(st.integers(1, 120), max_size=8))
def test_slices_do_not_change_bits(steps: list[int]) -> None:
    now = Training.fresh(paper_network())
    for step in steps:
        now = advance(now, TABLE, LONG, step)
    now = advance(now, TABLE, LONG, 300)
    assert_same_training(now, train(paper_network(), TABLE, LONG))


@pytest.mark.parametrize("order", ["cyclic", "shuffled"])
@pytest.mark.parametrize("rule", RULES)
def test_one_epoch_at_a_time_stops_at_the_same_place(rule: str, order: str) -> None:
    chosen = changed(LONG, rule=rule, order=order, tolerance=0.1)
    now = Training.fresh(paper_network())
    while now.stop is None:
        now = advance(now, TABLE, chosen, 1)
    whole = train(paper_network(), TABLE, chosen)
    assert whole.stop is StopReason.TOLERANCE
    assert 50 < whole.epoch < 300
    assert_same_training(now, whole)


def test_the_frozen_kernel_takes_over_unseen(monkeypatch: pytest.MonkeyPatch) -> None:
    generic = train(paper_network(), TABLE, LONG)
    monkeypatch.setattr(engine, "FREEZE_AFTER", 400)
    monkeypatch.setattr(engine, "SLICE", 150 * 17)
    assert_same_training(train(paper_network(), TABLE, LONG), generic)


@settings(max_examples=15)
@given(cut=st.integers(0, 300), chosen=st.sampled_from(["cyclic", "shuffled"]))
def test_resuming_from_a_file_changes_nothing(
    cut: int, chosen: str, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.mktemp("c") / "c.safetensors"
    wanted = changed(LONG, order=chosen)
    save_training(advance(Training.fresh(paper_network()), TABLE, wanted, cut), wanted, TABLE, path)
    resumed = train(load_training(path, wanted, TABLE), TABLE, wanted)
    assert_same_training(resumed, train(paper_network(), TABLE, wanted))


def test_a_seed_fixes_the_order(uninterrupted: Training) -> None:
    assert_same_training(train(paper_network(), TABLE, LONG), uninterrupted)
    other = train(paper_network(), TABLE, changed(LONG, seed=6))
    cyclic = train(paper_network(), TABLE, changed(LONG, order="cyclic"))
    weights = {t.network.parameters.tobytes() for t in (uninterrupted, other, cyclic)}
    assert len(weights) == 3
    assert_same_training(
        cyclic, train(paper_network(), TABLE, changed(LONG, order="cyclic", seed=6))
    )


def test_tolerance_0_does_all_epochs() -> None:
    solved = Patterns(x=np.zeros((1, 1)), y=np.zeros((1, 1)), inputs=("x",), outputs=("y",))
    network = Network.from_matrices([[[1.0, 0.0]]], ["linear"])
    ended = train(network, solved, OnlineSettings(tolerance=0.0, epochs=7))
    assert (ended.epoch, ended.updates, ended.stop) == (7, 7, StopReason.EPOCHS)
    ended = train(network, solved, OnlineSettings(tolerance=1e-300, epochs=7))
    assert (ended.epoch, ended.updates, ended.stop) == (0, 0, StopReason.TOLERANCE)
    ended = train(network, solved, OnlineSettings(epochs=0))
    assert (ended.epoch, ended.updates, ended.stop) == (0, 0, StopReason.EPOCHS)


def interrupt() -> None:
    raise KeyboardInterrupt


@pytest.mark.parametrize("how", [interrupt, lambda: False])
@pytest.mark.parametrize("epoch", [0, 1, 150, 260])
def test_interrupted_and_gone_on(
    epoch: int, how: Callable[[], Any], uninterrupted: Training, tmp_path: Path
) -> None:
    stopped: list[int] = []

    def listener(event: Progress) -> Any:
        if event.epoch < epoch or stopped:
            return None
        stopped.append(event.epoch)
        return how()

    path = tmp_path / "c.safetensors"
    save = checkpointer(path, LONG, TABLE, every=1e9)
    half = train(paper_network(), TABLE, LONG, on_event=listener, on_step=save)
    assert half.stop is StopReason.INTERRUPTED
    assert half.epoch == stopped[0] < 300
    assert_same_training(train(half, TABLE, LONG), uninterrupted)
    saved = load_training(path, LONG, TABLE)
    assert_same_training(saved, half)


def test_ctrl_c_ends_a_long_training_soon() -> None:
    endless = changed(LONG, epochs=10**12)
    steps: list[int] = []

    def on_step(now: Training) -> None:
        steps.append(now.epoch)
        if len(steps) == 1:
            threading.Timer(0.05, os.kill, (os.getpid(), signal.SIGINT)).start()

    ended = train(paper_network(), TABLE, endless, on_step=on_step)
    assert ended.stop is StopReason.INTERRUPTED
    assert_same_training(advance(Training.fresh(paper_network()), TABLE, endless, ended.epoch),
                         Training(network=ended.network, deltas=ended.deltas, epoch=ended.epoch,
                                  updates=ended.updates))  # fmt: skip


def test_large_networks_are_trained_in_short_slices() -> None:
    """Ctrl-C is seen between slices: each is some 10^7 changes of single weights."""
    rng = np.random.default_rng(0)
    x, y = rng.normal(size=(10, 100)), rng.normal(size=(10, 100))
    names = tuple(f"n{k}" for k in range(100))
    table = Patterns(x=x, y=y, inputs=names, outputs=names)
    network = Network.seeded((100, 100, 100), ("tanh", "linear"), rng)
    wanted = OnlineSettings(eta=1e-6, tolerance=0.0, epochs=100)
    steps: list[int] = []
    train(network, table, wanted, on_step=lambda now: steps.append(now.updates))
    assert np.diff([0, *steps]).max() * len(network.parameters) <= 2e7


def test_events_tell_the_state_before_each_epoch_and_at_the_end() -> None:
    events: list[Progress] = []
    ended = train(paper_network(), TABLE, LONG, on_event=events.append)
    epochs = [event.epoch for event in events]
    assert epochs[:201] == list(range(201))
    assert epochs[-1] == 300
    assert len(epochs) < 300
    assert [event.updates for event in events] == [4 * epoch for epoch in epochs]
    first = events[0]
    errors = TABLE.y - paper_network().forward(TABLE.x)
    assert first.worst == np.abs(errors).max()
    np.testing.assert_allclose(first.loss, 0.5 * (errors**2).sum() / 4, rtol=1e-14, atol=0)
    assert_same_bits(first.parameters, paper_network().parameters)
    assert_same_bits(events[-1].parameters, ended.network.parameters)
    assert all(a.seconds <= b.seconds for a, b in pairwise(events))


def test_an_ended_training_goes_on_when_more_is_asked() -> None:
    short = train(paper_network(), TABLE, changed(LONG, epochs=120))
    assert short.stop is StopReason.EPOCHS
    assert_same_training(train(short, TABLE, LONG), train(paper_network(), TABLE, LONG))
    coarse = train(paper_network(), TABLE, changed(LONG, tolerance=0.2))
    assert coarse.stop is StopReason.TOLERANCE
    assert_same_training(train(coarse, TABLE, LONG), train(paper_network(), TABLE, LONG))
    assert_same_training(train(short, TABLE, changed(LONG, epochs=120)), short)


def test_asking_for_fewer_epochs_than_were_done_keeps_them() -> None:
    """Once the count went back and the weights did not."""
    half = advance(Training.fresh(paper_network()), TABLE, LONG, 100)
    ended = train(half, TABLE, changed(LONG, epochs=50))
    assert (ended.epoch, ended.updates, ended.stop) == (100, 400, StopReason.EPOCHS)
    assert_same_bits(ended.network.parameters, half.network.parameters)


@pytest.mark.parametrize("order", ["cyclic", "shuffled"])
def test_divergence_keeps_the_last_good_network(order: str) -> None:
    wild = changed(LONG, eta=5.0, order=order)
    ended = train(paper_network(), TABLE, wild)
    assert ended.stop is StopReason.DIVERGED
    assert np.isfinite(ended.network.parameters).all()
    assert 0 < ended.epoch < 300
    now = Training.fresh(paper_network())
    for _ in range(ended.epoch):
        now = advance(now, TABLE, wild, 1)
        assert now.stop is None
    assert_same_bits(now.network.parameters, ended.network.parameters)
    assert_same_bits(now.deltas, ended.deltas)
    assert advance(now, TABLE, wild, 1).stop is StopReason.DIVERGED
    assert train(ended, TABLE, wild) is ended


def test_divergence_in_the_first_epoch() -> None:
    ended = train(paper_network(), TABLE, changed(LONG, eta=1e300))
    assert (ended.epoch, ended.updates, ended.stop) == (0, 0, StopReason.DIVERGED)
    assert_same_bits(ended.network.parameters, paper_network().parameters)


def test_what_does_not_fit_is_refused() -> None:
    network = Network.seeded((3, 2), ("linear",), np.random.default_rng(0))
    expected = "the network has 3 inputs and 2 outputs, the patterns have 2 inputs and 2 targets"
    with pytest.raises(ShapeError, match=expected):
        train(network, TABLE, LONG)
    with pytest.raises(ShapeError, match=expected):
        advance(Training.fresh(network), TABLE, LONG, 1)
    with pytest.raises(ShapeError, match=r"8 weights have as many last .* float64 of shape \(7,\)"):
        Training(network=network, deltas=np.zeros(7))
    with pytest.raises(ShapeError, match=r"8 weights have .* got float32 of shape \(8,\)"):
        Training(network=network, deltas=np.zeros(8).astype("f4"))
    short = network.with_parameters(network.parameters.astype(np.float32))
    with pytest.raises(ShapeError, match="float64; this network is float32: train it by mini-ba"):
        train(short, TABLE, LONG)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"eta": 0.0}, "eta must be a number above 0, got 0.0"),
        ({"eta": float("nan")}, "eta must be a number above 0, got nan"),
        ({"eta": float("inf")}, "eta must be a number above 0, got inf"),
        ({"momentum": 1.0}, "momentum must be from 0 to below 1, got 1.0"),
        ({"momentum": -0.1}, "momentum must be from 0 to below 1, got -0.1"),
        ({"momentum": float("nan")}, "momentum must be from 0 to below 1, got nan"),
        ({"tolerance": -1e-9}, "tolerance must be 0 or above, got -1e-09"),
        ({"tolerance": float("inf")}, "tolerance must be 0 or above, got inf"),
        ({"epochs": -1}, "epochs must be from 0 to 10^12, got -1"),
        ({"epochs": 10**13}, "epochs must be from 0 to 10^12, got 10000000000000"),
        ({"rule": "papr"}, "unknown rule 'papr'; did you mean 'paper'? Allowed: paper, textbook."),
        ({"order": "random"}, "unknown order 'random'; Allowed: cyclic, shuffled."),
        ({"seed": -1}, "seed must be from 0 to 2^63 - 1, got -1"),
        ({"seed": 2**63}, "seed must be from 0 to 2^63 - 1, got 9223372036854775808"),
    ],
)
def test_settings_say_what_is_allowed(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(SettingError) as caught:
        OnlineSettings(**changes)
    assert str(caught.value) == message
