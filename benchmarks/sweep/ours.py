"""rovernav, through its public sweep; the drawing of weights and all counting is timed too."""

from __future__ import annotations

from harness.model import Result, Stopwatch, Trial

from . import task


def one_thread(epochs: int) -> Trial:
    """In the calling thread."""
    return _build(epochs, 1)


def two_threads(epochs: int) -> Trial:
    """On two threads."""
    return _build(epochs, 2)


def _build(epochs: int, workers: int) -> Trial:
    import numpy as np

    from rovernav.core import Serial, Threads
    from rovernav.learn import Patterns, SweepSettings, sweep, train_members

    patterns = Patterns(x=task.X, y=task.Y, inputs=("x", "y"), outputs=("along", "across"))
    settings = SweepSettings(
        etas=(task.ETA,),
        momenta=(task.MOMENTUM,),
        seeds=task.NETWORKS,
        rule="textbook",
        tolerance=0.0,
        epochs=epochs,
    )
    executor = Serial() if workers == 1 else Threads(workers)

    def trial(repeats: int) -> Result:
        watch, updates = Stopwatch(), 0
        with watch:
            for _ in range(repeats):
                updates += sweep(patterns, settings, executor=executor).updates
        ended = train_members(patterns, settings, range(task.NETWORKS))
        weights = np.array([training.network.parameters for training in ended])
        return watch.result(updates, task.flat_rmse(weights))

    return trial
