from __future__ import annotations

import math
import signal
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rovernav.learn import (
    BatchSettings,
    BatchTraining,
    Patterns,
    Progress,
    StopReason,
    _batch_engine,
    advance_batches,
    train_batches,
)
from rovernav.learn._batch_engine import Engine
from rovernav.nets import Network
from tests.bits import assert_same_bits
from tests.naive import backprop as naive_order
from tests.naive import batch as naive

XOR = Patterns(
    x=np.array([[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]]),
    y=np.array([[0.0], [1.0], [1.0], [0.0]]),
    inputs=("a", "b"),
    outputs=("c",),
)


def small_network(dtype: Any = np.float32, names: Any = ("tanh", "linear")) -> Network:
    return Network.seeded((2, 4, 1), names, np.random.default_rng(0), dtype=dtype)


def sines(rows: int = 300) -> Patterns:
    """A smooth function of two inputs."""
    x = np.random.default_rng(5).uniform(-2.0, 2.0, (rows, 2))
    return Patterns(x=x, y=np.sin(x[:, :1]) * np.cos(x[:, 1:]), inputs=("a", "b"), outputs=("c",))


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize(("optimizer", "eta"), [("sgd", 0.05), ("adam", 0.02)])
def test_xor_is_learnt(optimizer: str, eta: float, dtype: Any) -> None:
    settings = BatchSettings(optimizer=optimizer, eta=eta, epochs=2000, tolerance=1e-4, batch=4)
    done = train_batches(small_network(dtype), XOR, settings)
    assert done.stop is StopReason.TOLERANCE
    assert done.loss < 1e-4
    assert done.updates == done.epoch < 2000
    assert done.network.parameters.dtype == dtype
    assert_allclose(done.network.forward(XOR.x), XOR.y, rtol=0, atol=0.05)


def test_binary_xor_is_learnt() -> None:
    settings = BatchSettings(loss="binary", eta=0.05, epochs=2000, tolerance=0.01)
    done = train_batches(small_network(), XOR, settings)
    assert done.stop is StopReason.TOLERANCE
    assert ((done.network.forward(XOR.x) > 0) == (XOR.y > 0.5)).all()


def test_three_classes_are_learnt(rng: np.random.Generator) -> None:
    kinds = rng.integers(0, 3, 300)
    middles = np.array([[0.0, 2.0], [-2.0, -1.0], [2.0, -1.0]])
    patterns = Patterns(
        x=middles[kinds] + 0.5 * rng.normal(size=(300, 2)),
        y=np.eye(3)[kinds],
        inputs=("a", "b"),
        outputs=("p", "q", "r"),
    )
    network = Network.seeded((2, 8, 3), ("relu", "linear"), rng, dtype=np.float32)
    settings = BatchSettings(loss="softmax", eta=0.01, batch=32, epochs=40, validation=0.2)
    done = train_batches(network, patterns, settings)
    held = done.network.forward(patterns.x[240:]).argmax(1)
    assert done.validation < 0.1
    assert np.mean(held == kinds[240:]) >= 0.98


@pytest.mark.parametrize("order", ["shuffled", "cyclic"])
@pytest.mark.parametrize("optimizer", ["sgd", "adam"])
@pytest.mark.parametrize("schedule", ["constant", "cosine"])
def test_training_equals_the_twin(optimizer: str, order: str, schedule: str) -> None:
    # Seven rows in batches of three: the last of each epoch has one.
    patterns, network, rows = sines(7), small_network(np.float64), 7
    settings = BatchSettings(
        optimizer=optimizer, order=order, schedule=schedule, eta=0.05, batch=3, epochs=4, seed=11
    )
    done = train_batches(network, patterns, settings)
    w, moments, step = network.parameters.tolist(), np.zeros((2, 17)).tolist(), 0
    for epoch in range(4):
        losses = 0.0
        eta = 0.025 * (1 + math.cos(math.pi * epoch / 4)) if schedule == "cosine" else 0.05
        places = naive_order.order(rows, 11 if order == "shuffled" else None, epoch)
        for batch in (places[:3], places[3:6], places[6:]):
            matrices = [m.tolist() for m in network.with_parameters(np.array(w)).matrices]
            x, y = patterns.x[batch].tolist(), patterns.y[batch].tolist()
            mean, change = naive.mean_gradient(matrices, network.activations, x, y, "mse")
            g, step = [g for matrix in change for row in matrix for g in row], step + 1
            losses += mean * len(batch)
            if optimizer == "sgd":
                naive.sgd(w, moments[0], g, eta, 0.9)
            else:
                naive.adam(w, moments, g, eta, step)
    assert (done.epoch, done.updates, done.stop) == (4, step, StopReason.EPOCHS)
    assert_allclose(done.network.parameters, w, rtol=1e-10, atol=1e-12)
    assert_allclose(done.moments, moments, rtol=1e-10, atol=1e-12)
    assert_allclose(done.loss, losses / rows, rtol=1e-10, atol=0)


def test_every_row_once_per_epoch_and_anew_each_time() -> None:
    settings = BatchSettings(batch=4, seed=2)
    engine = Engine(small_network(), sines(11), settings)
    seen = []
    for number in (0, 1, 0):
        assert [rows for rows, _ in engine.epoch(number, 0)] == [11]
        seen.append(engine._table.order.tolist())
        assert sorted(seen[-1]) == list(range(11))
    assert seen[0] == seen[2] != seen[1]
    assert engine.updates_of(11) == 3


def test_a_batch_larger_than_the_table_is_the_table() -> None:
    one, all_of_them = (
        train_batches(small_network(), XOR, BatchSettings(batch=batch, epochs=9, order="cyclic"))
        for batch in (4, 1000)
    )
    assert one.updates == all_of_them.updates == 9
    assert_same_bits(one.network.parameters, all_of_them.network.parameters)


def test_one_step_at_a_time_has_the_same_bits(monkeypatch: pytest.MonkeyPatch) -> None:
    settings = BatchSettings(batch=16, epochs=12, seed=1, validation=0.1)
    patterns = sines(100)
    whole = train_batches(small_network(), patterns, settings)
    steps = BatchTraining.fresh(small_network())
    while steps.stop is None:
        steps = advance_batches(steps, patterns, settings, 5)
    monkeypatch.setattr(_batch_engine, "SLICE", 1)  # a look at the listener after every batch
    slices = train_batches(small_network(), patterns, settings, on_event=lambda event: None)
    for other in (steps, slices):
        assert_same_bits(other.network.parameters, whole.network.parameters)
        assert_same_bits(other.moments, whole.moments)
        assert (other.epoch, other.updates) == (whole.epoch, whole.updates) == (12, 72)
        assert (other.loss, other.validation) == (whole.loss, whole.validation)


def test_held_out_rows_are_measured_and_not_learnt() -> None:
    patterns, settings = sines(100), BatchSettings(epochs=3, validation=0.2, order="cyclic")
    spoilt = Patterns(
        x=patterns.x,
        y=np.vstack([patterns.y[:80], patterns.y[80:] + 1.0]),
        inputs=("a", "b"),
        outputs=("c",),
    )
    done, other = (train_batches(small_network(), table, settings) for table in (patterns, spoilt))
    assert_same_bits(done.network.parameters, other.network.parameters)
    for training, table in ((done, patterns), (other, spoilt)):
        error = training.network.forward(table.x[80:]) - table.y[80:]
        assert_allclose(training.validation, 0.5 * np.mean(error**2), rtol=1e-5, atol=0)
    assert math.isnan(train_batches(small_network(), patterns, BatchSettings(epochs=1)).validation)


def test_events_tell_the_loss_and_the_weights() -> None:
    events: list[Progress] = []
    settings = BatchSettings(epochs=6, batch=50)
    done = train_batches(small_network(), sines(), settings, on_event=events.append)
    assert [e.epoch for e in events] == [0, 1, 2, 3, 4, 5, 6]
    assert [e.updates for e in events] == [6 * k for k in range(7)]
    error = small_network().forward(sines().x) - sines().y
    assert_allclose(events[0].loss, 0.5 * np.mean(error**2), rtol=1e-5, atol=0)
    assert events[-1].loss == done.loss < events[1].loss
    assert all(math.isnan(e.worst) for e in events)
    assert_same_bits(events[-1].parameters, done.network.parameters)


def test_a_listener_ends_it_between_epochs() -> None:
    settings = BatchSettings(epochs=50)
    ended = train_batches(small_network(), XOR, settings, on_event=lambda e: e.epoch < 3)
    assert (ended.stop, ended.epoch) == (StopReason.INTERRUPTED, 3)
    assert_same_bits(
        train_batches(ended, XOR, settings).network.parameters,
        train_batches(small_network(), XOR, settings).network.parameters,
    )


def leave(how: str) -> bool:
    if how == "signal":
        signal.raise_signal(signal.SIGINT)
    return False


@pytest.mark.parametrize("how", ["listener", "signal"])
def test_within_an_epoch_it_goes_back_to_the_beginning(
    how: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_batch_engine, "SLICE", 1)
    settings, told = BatchSettings(epochs=9, batch=50), []

    def listen(event: Progress) -> bool:
        told.append((event.epoch, event.updates))
        return leave(how) if told[-1] == (2, 15) else True

    ended = train_batches(small_network(), sines(), settings, on_event=listen)
    assert told[-3:] == [(2, 14), (2, 15), (2, 12)]
    assert (ended.stop, ended.epoch, ended.updates) == (StopReason.INTERRUPTED, 2, 12)
    two = train_batches(small_network(), sines(), BatchSettings(epochs=2, batch=50))
    assert_same_bits(ended.network.parameters, two.network.parameters)
    assert_same_bits(ended.moments, two.moments)


@pytest.mark.parametrize("where", ["in a later epoch", "at once"])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_divergence_keeps_the_last_good_network(where: str, dtype: Any) -> None:
    eta = 3.0 if where == "in a later epoch" else 1e300
    settings = BatchSettings(optimizer="sgd", eta=eta, epochs=10_000, batch=2)
    network = small_network(dtype, ("relu", "linear"))
    done = train_batches(network, sines(10), settings)
    assert done.stop is StopReason.DIVERGED
    assert (done.epoch > 0) == (where == "in a later epoch")
    assert np.isfinite(done.network.parameters).all()
    assert np.isfinite(done.moments).all()
    again = train_batches(network, sines(10), BatchSettings(
        optimizer="sgd", eta=eta, epochs=done.epoch, batch=2
    ))  # fmt: skip
    assert_same_bits(done.network.parameters, again.network.parameters)
    assert train_batches(done, sines(10), settings) is done


def test_no_epochs_change_nothing() -> None:
    done = train_batches(small_network(), XOR, BatchSettings(epochs=0))
    assert (done.stop, done.epoch, done.updates) == (StopReason.EPOCHS, 0, 0)
    assert math.isnan(done.loss)
    assert_same_bits(done.network.parameters, small_network().parameters)


def test_the_card_stays() -> None:
    network = small_network()
    done = train_batches(network, XOR, BatchSettings(epochs=1))
    assert done.network.card is network.card
    assert done.network.activations == network.activations
