"""PyTorch over all networks at once: eager with autograd, compiled, and `torch.func.vmap`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from harness.model import Result, Stopwatch, Trial

from . import task

TABLE = np.hstack([task.X, task.Y]).tolist()


def eager(epochs: int) -> Trial:
    """Batched products, backward, SGD, as its tutorials write it."""
    import torch

    torch.set_num_threads(1)
    xs, ys = torch.from_numpy(task.X), torch.from_numpy(task.Y)

    def run() -> Any:
        w1, b1, w2, b2 = weights = [torch.from_numpy(a).requires_grad_() for a in _start()]
        optimizer = torch.optim.SGD(weights, lr=task.ETA, momentum=task.MOMENTUM)
        for _ in range(epochs):
            for x, y in zip(xs, ys, strict=True):
                optimizer.zero_grad()
                column = x.expand(task.NETWORKS, 2).unsqueeze(2)
                hidden = torch.sigmoid(torch.baddbmm(b1.unsqueeze(2), w1, column))
                outputs = torch.baddbmm(b2.unsqueeze(2), w2, hidden).squeeze(2)
                (0.5 * ((outputs - y) ** 2).sum()).backward()
                optimizer.step()
        return [weight.detach().numpy() for weight in weights]

    return _trial(epochs, run)


def func_vmap(epochs: int) -> Trial:
    """The gradient of one network's loss, mapped over all of them."""
    import torch
    from torch.func import grad, vmap

    torch.set_num_threads(1)
    xs, ys = torch.from_numpy(task.X), torch.from_numpy(task.Y)

    def loss(weights: Any, x: Any, y: Any) -> Any:
        w1, b1, w2, b2 = weights
        return 0.5 * ((w2 @ torch.sigmoid(w1 @ x + b1) + b2 - y) ** 2).sum()

    gradient = vmap(grad(loss), in_dims=(0, None, None))

    def run() -> Any:
        weights = tuple(torch.from_numpy(a) for a in _start())
        changes = tuple(torch.zeros_like(w) for w in weights)
        with torch.no_grad():
            for _ in range(epochs):
                for x, y in zip(xs, ys, strict=True):
                    for w, v, g in zip(weights, changes, gradient(weights, x, y), strict=True):
                        v.mul_(task.MOMENTUM).sub_(g, alpha=task.ETA)
                        w.add_(v)
        return [w.numpy() for w in weights]

    return _trial(epochs, run)


def compiled(epochs: int) -> Trial:
    """An epoch with the gradient written out, network on the last axis, by `torch.compile`."""
    task.hold_to_one_core()
    import torch

    torch.set_num_threads(1)
    epoch = torch.compile(_epoch, fullgraph=True, dynamic=False)

    def run() -> Any:
        weights = [torch.from_numpy(a).movedim(0, -1).contiguous() for a in _start()]
        changes = [torch.zeros_like(w) for w in weights]
        with torch.no_grad():
            for _ in range(epochs):
                weights, changes = epoch(weights, changes)
        return [w.movedim(-1, 0).numpy() for w in weights]

    return _trial(epochs, run)


def _epoch(weights: Any, changes: Any) -> Any:
    """The weights (..., n) and their last changes after the four patterns."""
    import torch

    w1, b1, w2, b2 = weights
    v1, c1, v2, c2 = changes
    for x0, x1, y0, y1 in TABLE:
        h = torch.sigmoid(w1[:, 0] * x0 + w1[:, 1] * x1 + b1)
        o = w2[:, 0] * h[0] + w2[:, 1] * h[1] + w2[:, 2] * h[2] + b2
        e = task.ETA * torch.stack([y0 - o[0], y1 - o[1]])
        d = (e[0] * w2[0] + e[1] * w2[1]) * h * (1.0 - h)
        v2, c2 = task.MOMENTUM * v2 + e[:, None] * h, task.MOMENTUM * c2 + e
        v1 = task.MOMENTUM * v1 + torch.stack([d * x0, d * x1], 1)
        c1 = task.MOMENTUM * c1 + d
        w1, b1, w2, b2 = w1 + v1, b1 + c1, w2 + v2, b2 + c2
    return [w1, b1, w2, b2], [v1, c1, v2, c2]


def _start() -> Any:
    return task.parts(task.start())


def _trial(epochs: int, run: Callable[[], Any]) -> Trial:
    def trial(repeats: int) -> Result:
        watch, weights = Stopwatch(), None
        with watch:
            for _ in range(repeats):
                weights = run()
        return watch.result(repeats * epochs * task.PATTERNS * task.NETWORKS, task.rmse(*weights))

    return trial
