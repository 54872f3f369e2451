"""PyTorch: a Sequential in inference mode, tensor in and tensor out."""

from __future__ import annotations

from typing import Any

from harness.model import Result, Trial

from . import task


def build(size: int) -> Trial:
    """One vector, double precision, one thread."""
    import torch

    torch.set_num_threads(1)
    layers = (torch.nn.Linear(2, 3), torch.nn.Sigmoid(), torch.nn.Linear(3, 2))
    network = torch.nn.Sequential(*layers).double().eval()
    with torch.no_grad():
        for weight, array in zip(network.parameters(), task.parts(), strict=True):
            weight.copy_(torch.from_numpy(array))
    x = torch.from_numpy(task.X)
    inner = task.calls(size, lambda: network(x), _array)

    def trial(repeats: int) -> Result:
        with torch.inference_mode():
            return inner(repeats)

    return trial


def _array(answer: Any) -> Any:
    return answer.numpy()
