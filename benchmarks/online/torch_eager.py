"""PyTorch as its tutorials write it: Sequential, backward, SGD."""

from __future__ import annotations

from harness.model import Result, Stopwatch, Trial

from . import task


def build(epochs: int) -> Trial:
    """One pattern at a time, eager mode."""
    import torch

    torch.set_num_threads(1)
    layers = (torch.nn.Linear(2, 3), torch.nn.Sigmoid(), torch.nn.Linear(3, 2))
    network = torch.nn.Sequential(*layers).double()
    weights = list(network.parameters())
    xs = [torch.from_numpy(task.X[p : p + 1]) for p in range(task.PATTERNS)]
    ys = [torch.from_numpy(task.Y[p : p + 1]) for p in range(task.PATTERNS)]

    def trial(repeats: int) -> Result:
        watch = Stopwatch()
        for _ in range(repeats):
            with torch.no_grad():
                for weight, array in zip(weights, task.parts(task.start()), strict=True):
                    weight.copy_(torch.from_numpy(array))
            optimizer = torch.optim.SGD(weights, lr=task.ETA, momentum=task.MOMENTUM)
            with watch:
                for _epoch in range(epochs):
                    for x, y in zip(xs, ys, strict=True):
                        optimizer.zero_grad()
                        (0.5 * ((network(x) - y) ** 2).sum()).backward()
                        optimizer.step()
        error = task.rmse(*(weight.detach().numpy() for weight in weights))
        return watch.result(repeats * epochs * task.PATTERNS, error)

    return trial
