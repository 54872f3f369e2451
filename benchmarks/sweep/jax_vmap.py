"""JAX: one network's training as a compiled scan, gradients by `jax.grad`, mapped over all."""

from __future__ import annotations

from typing import Any

from harness.model import Result, Stopwatch, Trial

from . import task


def build(epochs: int) -> Trial:
    """`vmap` of the whole training."""
    task.hold_to_one_core()
    import jax
    import jax.numpy as jnp

    jax.config.update("jax_enable_x64", True)
    xs, ys = jnp.asarray(task.X), jnp.asarray(task.Y)

    def loss(p: Any, x: Any, y: Any) -> Any:
        w1, b1, w2, b2 = p
        return 0.5 * jnp.sum((w2 @ jax.nn.sigmoid(w1 @ x + b1) + b2 - y) ** 2)

    def step(carry: Any, pattern: Any) -> Any:
        p, v = carry
        gradient = jax.grad(loss)(p, *pattern)
        v = [task.MOMENTUM * a - task.ETA * g for a, g in zip(v, gradient, strict=True)]
        return ([a + b for a, b in zip(p, v, strict=True)], v), None

    def train(p: Any) -> Any:
        carry = (p, [jnp.zeros_like(a) for a in p])
        epoch = lambda _, c: jax.lax.scan(step, c, (xs, ys))[0]  # noqa: E731
        return jax.lax.fori_loop(0, epochs, epoch, carry)[0]

    every = jax.jit(jax.vmap(train))
    start = [jnp.asarray(a) for a in task.parts(task.start())]

    def trial(repeats: int) -> Result:
        watch, weights = Stopwatch(), start
        with watch:
            for _ in range(repeats):
                weights = jax.block_until_ready(every(start))
        return watch.result(repeats * epochs * task.PATTERNS * task.NETWORKS, task.rmse(*weights))

    return trial
