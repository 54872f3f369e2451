from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rovernav.learn import BatchSettings, Patterns, train_batches
from rovernav.nets import LOSSES, Network, gradient

pytestmark = pytest.mark.oracle

TOPOLOGY, NAMES = (10, 37, 16, 3), ("tanh", "sigmoid", "linear")


def torch() -> Any:
    return pytest.importorskip("torch", reason="PyTorch is not installed")


def in_torch(network: Network) -> list[Any]:
    """One leaf (units, inputs + 1) per layer."""
    return [torch().tensor(m.copy(), requires_grad=True) for m in network.matrices]


def outputs_of(leaves: Sequence[Any], names: Sequence[str], x: Any) -> Any:
    for leaf, name in zip(leaves, names, strict=True):
        x = x @ leaf[:, :-1].T + leaf[:, -1]
        x = x if name == "linear" else getattr(torch(), name)(x)
    return x


def loss_of(z: Any, y: Any, loss: str) -> Any:
    if loss == "mse":
        return 0.5 * ((z - y) ** 2).sum(1).mean()
    if loss == "softmax":
        return torch().nn.functional.cross_entropy(z, y)
    entropy = torch().nn.functional.binary_cross_entropy_with_logits
    return entropy(z, y, reduction="none").sum(1).mean()


def table(loss: str, rows: int = 100) -> tuple[Any, Any]:
    rng = np.random.default_rng(8)
    x, y = rng.normal(size=(rows, TOPOLOGY[0])), rng.normal(size=(rows, TOPOLOGY[-1]))
    if loss == "softmax":
        y = np.exp(y) / np.exp(y).sum(1, keepdims=True)
    return x, 1 / (1 + np.exp(-y)) if loss == "binary" else y


def network_of(dtype: Any, names: Sequence[str] = NAMES) -> Network:
    return Network.seeded(TOPOLOGY, names, np.random.default_rng(2), dtype=dtype)


@pytest.mark.parametrize("loss", LOSSES)
@pytest.mark.parametrize("hidden", ["tanh", "sigmoid", "relu", "linear"])
@pytest.mark.parametrize(("dtype", "near"), [(np.float64, 1e-12), (np.float32, 1e-5)])
def test_loss_and_gradient(loss: str, hidden: str, dtype: Any, near: float) -> None:
    names = (hidden, hidden, "linear")
    network = network_of(dtype, names)
    x, y = (a.astype(dtype) for a in table(loss))
    leaves = in_torch(network)
    expected = loss_of(outputs_of(leaves, names, torch().tensor(x)), torch().tensor(y), loss)
    expected.backward()
    mean, exact = gradient(network, x, y, loss)
    assert_allclose(mean, expected.item(), rtol=near, atol=0)
    theirs = np.concatenate([leaf.grad.numpy().ravel() for leaf in leaves])
    assert_allclose(exact, theirs, rtol=0, atol=near * np.abs(theirs).max())


@pytest.mark.parametrize("loss", LOSSES)
@pytest.mark.parametrize("optimizer", ["sgd", "adam"])
@pytest.mark.parametrize("shards", [1, 4])
@pytest.mark.parametrize(("dtype", "near"), [(np.float64, 1e-12), (np.float32, 1e-5)])
def test_twenty_steps(loss: str, optimizer: str, shards: int, dtype: Any, near: float) -> None:
    network = network_of(dtype)
    x, y = table(loss)
    names = [f"n{k}" for k in range(13)]
    patterns = Patterns(x=x, y=y, inputs=tuple(names[:10]), outputs=tuple(names[10:]))
    settings = BatchSettings(
        optimizer=optimizer, eta=0.01, loss=loss, batch=25, epochs=5, order="cyclic",
        shards=shards,
    )  # fmt: skip
    done = train_batches(network, patterns, settings, workers=2)
    assert done.updates == 20
    leaves = in_torch(network)
    if optimizer == "sgd":
        steps: Any = torch().optim.SGD(leaves, lr=0.01, momentum=0.9)
    else:
        steps = torch().optim.Adam(leaves, lr=0.01)
    sources, targets = (torch().tensor(a.astype(dtype)) for a in (x, y))
    for k in range(20):
        rows = slice(25 * k % 100, 25 * k % 100 + 25)
        steps.zero_grad()
        loss_of(outputs_of(leaves, NAMES, sources[rows]), targets[rows], loss).backward()
        steps.step()
    theirs = np.concatenate([leaf.detach().numpy().ravel() for leaf in leaves])
    assert_allclose(done.network.parameters, theirs, rtol=0, atol=near)
    assert np.abs(theirs - network.parameters).max() > 0.01
