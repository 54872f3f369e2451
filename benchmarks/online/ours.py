"""rovernav, through its public training function."""

from __future__ import annotations

import numpy as np
from harness.model import Result, Stopwatch, Trial

from . import task


def generic(epochs: int) -> Trial:
    """`train` as anybody calls it: short trainings run in the kernel for all topologies."""
    return _build(epochs, "textbook", frozen=False)


def generic_paper(epochs: int) -> Trial:
    """The same with the paper's rule."""
    return _build(epochs, "paper", frozen=False)


def frozen(epochs: int) -> Trial:
    """`train` on a training so long that a kernel for its one topology has been compiled."""
    return _build(epochs, "textbook", frozen=True)


def frozen_paper(epochs: int) -> Trial:
    """The same with the paper's rule."""
    return _build(epochs, "paper", frozen=True)


def _build(epochs: int, rule: str, *, frozen: bool) -> Trial:
    from rovernav.learn import OnlineSettings, Patterns, Training, train
    from rovernav.nets import Network

    network = Network(
        topology=(2, 3, 2), activations=("sigmoid", "linear"), parameters=task.start()
    )
    patterns = Patterns(x=task.X, y=task.Y, inputs=("x", "y"), outputs=("along", "across"))
    settings = OnlineSettings(
        eta=task.ETA, momentum=task.MOMENTUM, rule=rule, tolerance=0.0, epochs=epochs
    )
    # A training knows how many updates it has behind it; after a million its kernel is frozen.
    before = Training(network=network, deltas=np.zeros(17), updates=1_000_000 if frozen else 0)

    def trial(repeats: int) -> Result:
        watch, ended = Stopwatch(), before
        with watch:
            for _ in range(repeats):
                ended = train(before, patterns, settings)
        return watch.result(
            repeats * epochs * task.PATTERNS, task.flat_rmse(ended.network.parameters)
        )

    return trial
