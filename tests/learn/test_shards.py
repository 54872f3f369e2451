from __future__ import annotations

import itertools
import math
import pickle
import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rovernav.core import Processes, Serial, SettingError, Threads
from rovernav.learn import (
    BatchSettings,
    BatchTraining,
    Patterns,
    Progress,
    StopReason,
    _batch_engine,
    _crew,
    advance_batches,
    checkpointer,
    load_training,
    train_batches,
)
from rovernav.learn._shards import ShardWork
from rovernav.nets import Network
from tests.bits import assert_same_bits
from tests.naive import batch as naive


class Jobs:
    """An executor that is none of ours: jobs one by one, in the order of the items."""

    def __init__(self, workers: int) -> None:
        self.workers = workers
        self.shared: list[Any] = []
        self.items: list[Any] = []

    def map(
        self,
        job: Callable[[Any, Any], Any],
        items: Iterable[Any],
        *,
        shared: Any = None,
        on_done: Callable[[], object] | None = None,
    ) -> Iterator[Any]:
        self.shared.append(shared)
        for item in items:
            self.items.append(item)
            yield job(pickle.loads(pickle.dumps(shared)), pickle.loads(pickle.dumps(item)))


def table(rows: int = 307, loss: str = "mse") -> Patterns:
    x = np.random.default_rng(5).normal(size=(rows, 3))
    y: Any = np.column_stack([np.sin(x[:, 0]), x[:, 1] * x[:, 2]])
    if loss == "softmax":
        y = np.exp(y) / np.exp(y).sum(1, keepdims=True)
    if loss == "binary":
        y = (y > 0) * 1.0
    return Patterns(x=x, y=y, inputs=("a", "b", "c"), outputs=("d", "e"))


def network(dtype: Any = np.float32) -> Network:
    rng = np.random.default_rng(1)
    return Network.seeded((3, 20, 9, 2), ("tanh", "relu", "linear"), rng, dtype=dtype)


def settings_for(**changes: Any) -> BatchSettings:
    usual: dict[str, Any] = {"batch": 64, "epochs": 4, "seed": 3, "validation": 0.1, "shards": 3}
    return BatchSettings(**(usual | changes))


def assert_same(actual: BatchTraining, expected: BatchTraining) -> None:
    assert_same_bits(actual.network.parameters, expected.network.parameters)
    assert_same_bits(actual.moments, expected.moments)
    assert_same_bits([actual.loss, actual.validation], [expected.loss, expected.validation])
    for name in ("epoch", "updates", "stop"):
        assert getattr(actual, name) == getattr(expected, name)


# 307 rows, 31 of them held out: the last batch of each epoch has 20.
@pytest.mark.parametrize("shards", [1, 2, 3, 8])
@pytest.mark.parametrize(
    ("optimizer", "loss"), [("sgd", "mse"), ("adam", "mse"), ("adam", "softmax"), ("sgd", "binary")]
)
def test_the_bits_do_not_depend_on_the_workers(optimizer: str, loss: str, shards: int) -> None:
    settings = settings_for(optimizer=optimizer, loss=loss, eta=0.01, shards=shards)
    patterns = table(loss=loss)
    alone = train_batches(network(), patterns, settings)
    assert alone.updates == 20
    for workers in (2, 4, 8, Serial(), Threads(2), Jobs(1), Jobs(5)):
        assert_same(train_batches(network(), patterns, settings, workers=workers), alone)


def test_the_bits_depend_on_the_shards() -> None:
    ends = [train_batches(network(), table(), settings_for(shards=k)) for k in (1, 2, 3)]
    for one, other in itertools.combinations(ends, 2):
        assert not np.array_equal(one.network.parameters, other.network.parameters)
        assert_allclose(one.network.parameters, other.network.parameters, rtol=0, atol=1e-4)


@pytest.mark.parametrize("optimizer", ["sgd", "adam"])
@pytest.mark.parametrize(("rows", "shards"), [(10, 3), (9, 8)])
def test_training_equals_the_twin(rows: int, shards: int, optimizer: str) -> None:
    # Batches of six: the last has four rows, or three, of which five shards get none.
    patterns, start = table(rows), network(np.float64)
    settings = BatchSettings(
        optimizer=optimizer, eta=0.05, batch=6, epochs=2, order="cyclic", shards=shards
    )
    done = train_batches(start, patterns, settings, workers=2)
    w, moments, step = start.parameters.tolist(), np.zeros((2, 289)).tolist(), 0
    for first in (0, 6, 0, 6):
        matrices = [m.tolist() for m in start.with_parameters(np.array(w)).matrices]
        x, y = patterns.x[first : first + 6].tolist(), patterns.y[first : first + 6].tolist()
        names = start.activations
        _, change = naive.sharded_gradient(matrices, names, x, y, "mse", shards)
        g, step = [g for matrix in change for row in matrix for g in row], step + 1
        if optimizer == "sgd":
            naive.sgd(w, moments[0], g, 0.05, 0.9)
        else:
            naive.adam(w, moments, g, 0.05, step)
    assert done.updates == step
    assert_allclose(done.network.parameters, w, rtol=1e-9, atol=1e-11)


def test_large_batches_are_computed_in_panels() -> None:
    patterns = table(1500)
    settings = settings_for(batch=1100, epochs=3, shards=2)
    alone = train_batches(network(), patterns, settings)
    assert_same(train_batches(network(), patterns, settings, workers=2), alone)


@pytest.mark.parametrize(("then", "now"), [(1, 4), (4, 1), (3, 2)])
def test_resumed_by_other_workers(then: int, now: int, tmp_path: Path) -> None:
    settings, path = settings_for(epochs=12), tmp_path / "training.ckpt"
    save = checkpointer(path, settings, table(), every=0.0)
    train_batches(
        network(), table(), settings, on_event=lambda e: e.epoch < 5, on_step=save, workers=then
    )
    half = load_training(path, settings, table())
    assert half.epoch == 5
    whole = train_batches(network(), table(), settings)
    assert_same(train_batches(half, table(), settings, workers=now), whole)
    steps = half
    while steps.stop is None:
        steps = advance_batches(steps, table(), settings, 3, workers=now)
    assert_same(steps, whole)


def test_other_shards_do_not_resume(tmp_path: Path) -> None:
    path, settings = tmp_path / "training.ckpt", settings_for(shards=2)
    checkpointer(path, settings, table())(BatchTraining.fresh(network()))
    with pytest.raises(SettingError, match="made with shards = 2, not 4; resume with the same"):
        load_training(path, settings_for(shards=4), table())


@pytest.mark.parametrize("workers", [1, 2, 4])
def test_divergence_is_the_same_for_all(workers: int) -> None:
    settings = BatchSettings(optimizer="sgd", eta=2.0, epochs=1000, batch=20, shards=4)
    start = Network.seeded((3, 9, 2), ("relu", "linear"), np.random.default_rng(0))
    done = train_batches(start, table(50), settings, workers=workers)
    assert done.stop is StopReason.DIVERGED
    assert np.isfinite(done.network.parameters).all()
    assert_same(done, train_batches(start, table(50), settings))


def leave(how: str) -> bool:
    if how == "signal":
        signal.raise_signal(signal.SIGINT)
    return False


@pytest.mark.parametrize("how", ["listener", "signal"])
def test_within_an_epoch_it_goes_back_to_the_beginning(
    how: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_batch_engine, "SLICE", 1)
    settings, told = settings_for(epochs=9), []

    def listen(event: Progress) -> bool:
        told.append((event.epoch, event.updates))
        return leave(how) if told[-1] == (2, 13) else True

    ended = train_batches(network(), table(), settings, on_event=listen, workers=2)
    assert (ended.stop, ended.epoch, ended.updates) == (StopReason.INTERRUPTED, 2, 10)
    two = train_batches(network(), table(), settings_for(epochs=2))
    assert_same_bits(ended.network.parameters, two.network.parameters)


def test_events_tell_the_held_out_loss() -> None:
    events: list[Progress] = []
    done = train_batches(network(), table(), settings_for(), on_event=events.append, workers=2)
    assert math.isnan(events[0].validation)
    assert [e.epoch for e in events] == [0, 1, 2, 3, 4]
    assert events[-1].validation == done.validation
    assert all(e.validation > 0 for e in events[1:])


@pytest.mark.parametrize("who", [0, 1, 3])
def test_one_that_fails_leaves_nobody_waiting(who: int, monkeypatch: pytest.MonkeyPatch) -> None:
    real = _batch_engine.descent.descend

    def descend(*given: Any) -> float:
        if given[-1].me == who:
            raise ZeroDivisionError("a defect")
        return real(*given)

    monkeypatch.setattr(_batch_engine.descent, "descend", descend)
    with pytest.raises(ZeroDivisionError, match="a defect"):
        train_batches(network(), table(), settings_for(shards=4), workers=4)
    assert_nobody_left()


def test_no_more_threads_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    class Full(_crew.ThreadPoolExecutor):
        def submit(self, *given: Any, **more: Any) -> Any:
            if given[1:] and given[2].me == 2:
                raise RuntimeError("can't start new thread")
            return super().submit(*given, **more)

    monkeypatch.setattr(_crew, "ThreadPoolExecutor", Full)
    sentence = r"workers = 4 threads cannot be started \(can't start new thread\); ask for fewer"
    with pytest.raises(SettingError, match=sentence):
        train_batches(network(), table(), settings_for(shards=4), workers=4)
    assert_nobody_left()


def test_ctrl_c_in_the_calling_thread_ends_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    real, calls = _batch_engine.descent.descend, itertools.count()

    def descend(*given: Any) -> float:
        if given[-1].me == 0 and next(calls) == 3:
            raise KeyboardInterrupt
        return real(*given)

    monkeypatch.setattr(_batch_engine.descent, "descend", descend)
    ended = train_batches(network(), table(), settings_for(epochs=9), workers=3)
    assert (ended.stop, ended.epoch) == (StopReason.INTERRUPTED, 0)
    assert_nobody_left()


def assert_nobody_left() -> None:
    for thread in threading.enumerate():
        if thread.name.startswith("rovernav"):
            thread.join(10)
            assert not thread.is_alive()


@pytest.mark.parametrize("workers", [0, -1])
def test_no_workers_are_refused(workers: int) -> None:
    with pytest.raises(SettingError, match=f"workers must be 1 or more, got {workers}"):
        train_batches(network(), table(), settings_for(), workers=workers)


def test_jobs_share_one_value_and_split_the_shards() -> None:
    jobs = Jobs(2)
    train_batches(network(), table(100), settings_for(shards=5, epochs=1), workers=jobs)
    assert len(jobs.shared) == 2
    assert isinstance(jobs.shared[0], ShardWork)
    assert jobs.shared[0] is jobs.shared[1]
    asked = [(item.epoch, item.rows, item.shards) for item in jobs.items]
    assert asked == [
        (0, (0, 64), (0, 2)), (0, (0, 64), (2, 5)), (0, (64, 90), (0, 2)), (0, (64, 90), (2, 5)),
    ]  # fmt: skip


def test_processes_give_the_same_bits() -> None:
    settings = settings_for(epochs=2)
    alone = train_batches(network(), table(), settings)
    assert_same(train_batches(network(), table(), settings, workers=Processes(2)), alone)


@pytest.mark.long
def test_hundreds_of_races_end_alike(rng: np.random.Generator) -> None:
    expected = {
        shards: train_batches(network(), table(), settings_for(epochs=3, shards=shards))
        for shards in (2, 3, 5, 16)
    }
    for _ in range(400):
        shards, workers = int(rng.choice(list(expected))), int(rng.integers(2, 17))
        settings = settings_for(epochs=3, shards=shards)
        done = train_batches(network(), table(), settings, workers=workers)
        assert_same(done, expected[shards])
