"""scikit-learn: one `partial_fit` over all rows is one epoch of `MLPRegressor`."""

from __future__ import annotations

from typing import Any

from harness.model import Result, Stopwatch, Trial

from . import task


def build(batches: int) -> Trial:
    """Plain SGD with momentum, rows in order."""
    from sklearn.neural_network import MLPRegressor

    x, y = task.data(batches)

    def trial(repeats: int) -> Result:
        watch, model = Stopwatch(), _fresh(MLPRegressor, x, y)
        for _ in range(repeats):
            model = _fresh(MLPRegressor, x, y)
            with watch:
                model.partial_fit(x, y)
        pairs = zip(model.coefs_, model.intercepts_, strict=True)
        return watch.result(repeats * len(x), task.error([w for p in pairs for w in p], x, y))

    return trial


def _fresh(regressor: Any, x: Any, y: Any) -> Any:
    """An estimator with the workload's weights; `partial_fit` makes its arrays first."""
    model = regressor(
        hidden_layer_sizes=task.SIZES[1:-1], activation="tanh", solver="sgd", alpha=0.0,
        batch_size=task.BATCH, learning_rate_init=task.ETA, momentum=task.MOMENTUM,
        nesterovs_momentum=False, shuffle=False, random_state=0,
    )  # fmt: skip
    model.partial_fit(x[: task.BATCH], y[: task.BATCH])
    start = task.start()
    model.coefs_, model.intercepts_ = start[0::2], start[1::2]
    del model._optimizer  # it would go on with the arrays and the momentum of the first batch
    return model
