"""Keras on the JAX backend: `fit` for one epoch."""

from __future__ import annotations

from typing import Any

import numpy as np
from harness.model import Result, Stopwatch, Trial

from . import task


def build(batches: int) -> Trial:
    """A Sequential of Dense layers, SGD with momentum, rows in order."""
    import keras

    x, y = task.data(batches)
    layers = keras.layers
    model = keras.Sequential(
        [
            keras.Input((48,)),
            *(layers.Dense(units, "tanh") for units in task.SIZES[1:-1]),
            layers.Dense(task.SIZES[-1]),
        ]
    )

    def loss(wanted: Any, outputs: Any) -> Any:
        return 0.5 * keras.ops.sum((outputs - wanted) ** 2, axis=-1)

    model.compile(keras.optimizers.SGD(task.ETA, momentum=task.MOMENTUM), loss)

    def trial(repeats: int) -> Result:
        watch = Stopwatch()
        for _ in range(repeats):
            model.set_weights(task.start())
            for velocity in model.optimizer.variables[2:]:  # after the step count and the rate
                velocity.assign(np.zeros(velocity.shape))
            with watch:
                model.fit(x, y, batch_size=task.BATCH, epochs=1, shuffle=False, verbose=0)
        return watch.result(repeats * len(x), task.error(model.get_weights(), x, y))

    return trial
