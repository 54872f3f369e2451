"""scikit-learn: `MLPRegressor.partial_fit` with one pattern at a time."""

from __future__ import annotations

from typing import Any

from harness.model import Result, Stopwatch, Trial

from . import task


def build(epochs: int) -> Trial:
    """Plain SGD with momentum, as the estimator offers it."""
    from sklearn.neural_network import MLPRegressor

    rows = [(task.X[p : p + 1], task.Y[p : p + 1]) for p in range(task.PATTERNS)]

    def trial(repeats: int) -> Result:
        watch, model = Stopwatch(), _fresh(MLPRegressor)
        for _ in range(repeats):
            model = _fresh(MLPRegressor)
            with watch:
                for _epoch in range(epochs):
                    for x, y in rows:
                        model.partial_fit(x, y)
        (w1, w2), (b1, b2) = model.coefs_, model.intercepts_
        return watch.result(repeats * epochs * task.PATTERNS, task.rmse(w1.T, b1, w2.T, b2))

    return trial


def _fresh(regressor: Any) -> Any:
    """An estimator with the workload's weights; `partial_fit` makes its arrays first."""
    model = regressor(
        hidden_layer_sizes=(3,), activation="logistic", solver="sgd", alpha=0.0, batch_size=1,
        learning_rate_init=task.ETA, momentum=task.MOMENTUM, nesterovs_momentum=False,
        shuffle=False, random_state=0,
    )  # fmt: skip
    model.partial_fit(task.X[:1], task.Y[:1])
    w1, b1, w2, b2 = task.parts(task.start())
    model.coefs_, model.intercepts_ = [w1.T.copy(), w2.T.copy()], [b1, b2]
    del model._optimizer  # it would go on with the arrays and the momentum of the first pattern
    return model
