"""rovernav, through its public mini-batch training."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from harness.model import Result, Skipped, Stopwatch, Trial

from . import task


def epoch(batches: int, *, batch: int = task.BATCH, shards: int = 1, workers: int = 1) -> Trial:
    """One epoch of a training that has begun: the second, timed between two `on_step` calls.

    Args:
        batches: Batches of `task.BATCH` rows that an epoch has, however they are shown.
        batch: Rows per update.
        shards: Parts of a batch that are summed by themselves.
        workers: Threads that share them out.
    """
    train, network, patterns, settings = _prepared(batches, epochs=2, batch=batch, shards=shards)

    def trial(repeats: int) -> Result:
        wall = cpu = 0.0
        steps: list[tuple[float, float, Any]] = []

        def note(training: Any) -> None:
            steps.append((time.perf_counter(), time.process_time(), training))

        for _ in range(repeats):
            steps.clear()
            train(network, patterns, settings, on_step=note, workers=workers)
            (wall_1, cpu_1, _), (wall_2, cpu_2, _) = steps
            wall, cpu = wall + wall_2 - wall_1, cpu + cpu_2 - cpu_1
        return Result(wall, cpu, repeats * task.rows(batches), _error(steps[0][2], patterns))

    return trial


def whole_call(batches: int) -> Trial:
    """A call that trains one epoch, with all that it makes ready first."""
    train, network, patterns, settings = _prepared(batches, epochs=1)

    def trial(repeats: int) -> Result:
        watch, training = Stopwatch(), None
        with watch:
            for _ in range(repeats):
                training = train(network, patterns, settings)
        return watch.result(repeats * task.rows(batches), _error(training, patterns))

    return trial


def _prepared(
    batches: int, *, epochs: int, batch: int = task.BATCH, shards: int = 1
) -> tuple[Any, Any, Any, Any]:
    """The training function and its arguments."""
    import rovernav.learn as learn
    from rovernav.nets import Network

    if not hasattr(learn, "train_batches"):
        raise Skipped("this rovernav has no learn.train_batches")
    w1, b1, w2, b2, w3, b3 = task.start()
    layers = [np.column_stack((w.T, b)) for w, b in ((w1, b1), (w2, b2), (w3, b3))]
    network = Network(
        topology=task.SIZES,
        activations=("tanh", "tanh", "linear"),
        parameters=np.concatenate([layer.ravel() for layer in layers]),
    )
    x, y = task.data(batches)
    names = tuple(f"x{i}" for i in range(x.shape[1])), tuple(f"y{i}" for i in range(y.shape[1]))
    patterns = learn.Patterns(x=x, y=y, inputs=names[0], outputs=names[1])
    settings = learn.BatchSettings(
        optimizer="sgd", eta=task.ETA, momentum=task.MOMENTUM, loss="mse", batch=batch,
        epochs=epochs, order="cyclic", shards=shards,
    )  # fmt: skip
    return learn.train_batches, network, patterns, settings


def _error(training: Any, patterns: Any) -> float:
    weights: list[Any] = []
    for matrix in training.network.matrices:
        weights += [matrix[:, :-1].T, matrix[:, -1]]
    return task.error(
        weights, *(a[: task.SCORED].astype(np.float32) for a in (patterns.x, patterns.y))
    )
