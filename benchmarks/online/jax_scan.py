"""JAX: the whole training as one compiled scan over patterns, gradients by `jax.grad`."""

from __future__ import annotations

from typing import Any

from harness.model import Result, Stopwatch, Trial

from . import task


def plain(epochs: int) -> Trial:
    """The scan as it is."""
    return _build(epochs, unroll=1)


def unrolled(epochs: int) -> Trial:
    """Sixteen patterns to a turn of the compiled loop."""
    return _build(epochs, unroll=16)


def _build(epochs: int, *, unroll: int) -> Trial:
    import jax
    import jax.numpy as jnp

    jax.config.update("jax_enable_x64", True)

    def loss(p: Any, x: Any, y: Any) -> Any:
        w1, b1, w2, b2 = p
        hidden = jax.nn.sigmoid(w1 @ x + b1)
        return 0.5 * jnp.sum((w2 @ hidden + b2 - y) ** 2)

    def step(carry: Any, pattern: Any) -> Any:
        p, v = carry
        gradient = jax.grad(loss)(p, *pattern)
        v = [task.MOMENTUM * a - task.ETA * g for a, g in zip(v, gradient, strict=True)]
        return ([a + b for a, b in zip(p, v, strict=True)], v), None

    @jax.jit
    def train(p: Any, xs: Any, ys: Any) -> Any:
        still = [jnp.zeros_like(a) for a in p]
        return jax.lax.scan(step, (p, still), (xs, ys), unroll=unroll)[0][0]

    start = [jnp.asarray(a) for a in task.parts(task.start())]
    xs, ys = jnp.tile(jnp.asarray(task.X), (epochs, 1)), jnp.tile(jnp.asarray(task.Y), (epochs, 1))

    def trial(repeats: int) -> Result:
        watch, weights = Stopwatch(), start
        with watch:
            for _ in range(repeats):
                weights = jax.block_until_ready(train(start, xs, ys))
        return watch.result(repeats * epochs * task.PATTERNS, task.rmse(*weights))

    return trial
