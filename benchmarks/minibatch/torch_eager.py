"""PyTorch as its tutorials write it, without the data loader's cost."""

from __future__ import annotations

from harness.model import Result, Stopwatch, Trial

from . import task


def build(batches: int, *, batch: int = task.BATCH, threads: int = 1) -> Trial:
    """Sequential, backward, SGD on slices of one tensor.

    Args:
        batches: Batches of `task.BATCH` rows that an epoch has, however they are shown.
        batch: Rows per update.
        threads: Threads of PyTorch's matrix products.
    """
    import torch

    torch.set_num_threads(threads)
    modules = [torch.nn.Linear(a, b) for a, b in zip(task.SIZES[:-1], task.SIZES[1:], strict=True)]
    network = torch.nn.Sequential(
        modules[0], torch.nn.Tanh(), modules[1], torch.nn.Tanh(), modules[2]
    )
    weights = list(network.parameters())
    x, y = task.data(batches)
    xs, ys = torch.from_numpy(x).split(batch), torch.from_numpy(y).split(batch)

    def trial(repeats: int) -> Result:
        watch = Stopwatch()
        for _ in range(repeats):
            with torch.no_grad():
                for weight, array in zip(weights, task.start(), strict=True):
                    weight.copy_(torch.from_numpy(array.T))
            optimizer = torch.optim.SGD(weights, lr=task.ETA, momentum=task.MOMENTUM)
            with watch:
                for xb, yb in zip(xs, ys, strict=True):
                    optimizer.zero_grad()
                    (0.5 * ((network(xb) - yb) ** 2).sum() / len(xb)).backward()
                    optimizer.step()
        return watch.result(
            repeats * len(x), task.error([w.detach().numpy().T for w in weights], x, y)
        )

    return trial
