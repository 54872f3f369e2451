from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rovernav.core import SettingError, ShapeError
from rovernav.nets import ACTIVATIONS, LOSSES, Backward, Network, gradient
from tests.bits import assert_same_bits
from tests.naive import batch as naive

DEPTHS = [(3, 2), (3, 4, 2), (2, 5, 3, 4, 2)]
CROSS_ENTROPIES = ["softmax", "binary"]


def network_of(topology: Sequence[int], names: Sequence[str], dtype: Any = np.float64) -> Network:
    network = Network.seeded(topology, names, np.random.default_rng(3))
    return network.with_parameters((1.5 * network.parameters).astype(dtype))


def table_for(topology: Sequence[int], loss: str, rows: int = 7) -> tuple[Any, Any]:
    """Inputs, and targets that suit the loss."""
    rng = np.random.default_rng(4)
    x, y = rng.normal(size=(rows, topology[0])), rng.normal(size=(rows, topology[-1]))
    if loss == "softmax":
        y = np.exp(y) / np.exp(y).sum(1, keepdims=True)
    if loss == "binary":
        y = 1 / (1 + np.exp(-y))
    return x, y


def check_by_central_differences(network: Network, x: Any, y: Any, loss: str) -> None:
    """Each component against the change of the loss when that weight is moved by +-h."""
    mean, exact = gradient(network, x, y, loss)
    assert np.isfinite(mean)
    h = 1e-5
    for k in range(len(network.parameters)):
        moved = network.parameters.copy()
        ends = []
        for step in (h, -h):
            moved[k] = network.parameters[k] + step
            ends.append(gradient(network.with_parameters(moved.copy()), x, y, loss)[0])
        assert_allclose(exact[k], (ends[0] - ends[1]) / (2 * h), rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("topology", DEPTHS)
@pytest.mark.parametrize("output", ACTIVATIONS)
@pytest.mark.parametrize("hidden", ACTIVATIONS)
def test_squared_error_by_central_differences(
    topology: tuple[int, ...], hidden: str, output: str
) -> None:
    network = network_of(topology, (hidden,) * (len(topology) - 2) + (output,))
    check_by_central_differences(network, *table_for(topology, "mse"), "mse")


@pytest.mark.parametrize("topology", DEPTHS)
@pytest.mark.parametrize("hidden", ACTIVATIONS)
@pytest.mark.parametrize("loss", CROSS_ENTROPIES)
def test_cross_entropies_by_central_differences(
    topology: tuple[int, ...], hidden: str, loss: str
) -> None:
    network = network_of(topology, (hidden,) * (len(topology) - 2) + ("linear",))
    check_by_central_differences(network, *table_for(topology, loss), loss)


@pytest.mark.kernels
@pytest.mark.parametrize("rows", [1, 3, 5])
@pytest.mark.parametrize("loss", LOSSES)
@pytest.mark.parametrize(
    ("topology", "names"),
    [
        ((1, 1), ("linear",)),
        ((2, 3, 2), ("tanh", "linear")),
        ((3, 2, 2, 1), ("sigmoid", "relu", "linear")),
    ],
)
def test_equals_the_plain_python_twin(
    topology: tuple[int, ...], names: tuple[str, ...], loss: str, rows: int
) -> None:
    network = network_of(topology, names)
    x, y = table_for(topology, loss, rows)
    mean, exact = gradient(network, x, y, loss)
    matrices = [m.tolist() for m in network.matrices]
    expected, change = naive.mean_gradient(matrices, names, x.tolist(), y.tolist(), loss)
    flat = [g for matrix in change for row in matrix for g in row]
    assert_allclose(mean, expected, rtol=1e-12, atol=1e-12)
    assert_allclose(exact, flat, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("topology", [(20, 70, 17, 3), (5, 16, 64, 64, 130)])
def test_wide_layers_equal_numpy(topology: tuple[int, ...]) -> None:
    # Whole tiles, parts of tiles, layers wider and narrower than those below them.
    names = ("tanh",) * (len(topology) - 2) + ("linear",)
    network = network_of(topology, names)
    x, y = table_for(topology, "mse", 37)
    outs = [x]
    for matrix, name in zip(network.matrices, names, strict=True):
        s = outs[-1] @ matrix[:, :-1].T + matrix[:, -1]
        outs.append(np.tanh(s) if name == "tanh" else s)
    d, parts = (outs[-1] - y) / len(x), []
    for layer in reversed(range(len(names))):
        parts.insert(0, np.hstack([d.T @ outs[layer], d.sum(0)[:, None]]).ravel())
        d = (d @ network.matrices[layer][:, :-1]) * (1 - outs[layer] ** 2)
    mean, exact = gradient(network, x, y)
    assert_allclose(mean, 0.5 * ((outs[-1] - y) ** 2).sum(1).mean(), rtol=1e-12, atol=0)
    assert_allclose(exact, np.concatenate(parts), rtol=1e-9, atol=1e-13)


@pytest.mark.parametrize("loss", LOSSES)
def test_float32_is_near_float64(loss: str) -> None:
    topology, names = (20, 33, 5), ("tanh", "linear")
    x, y = table_for(topology, loss, 30)
    single, double = (network_of(topology, names, kind) for kind in (np.float32, np.float64))
    mean, near = gradient(single, x, y, loss)
    expected, exact = gradient(double, x, y, loss)
    assert near.dtype == np.float32
    assert_allclose(mean, expected, rtol=1e-5, atol=0)
    assert_allclose(near, exact, rtol=1e-3, atol=1e-6)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_same_bits_again_and_in_any_layout(dtype: Any) -> None:
    topology = (9, 40, 20, 3)
    network = network_of(topology, ("relu", "tanh", "linear"), dtype)
    x, y = (a.astype(dtype) for a in table_for(topology, "mse", 21))
    mean, first = gradient(network, x, y)
    backward = Backward(network, 21, "mse")
    for inputs in (x, np.asfortranarray(x), x.tolist(), np.repeat(x, 2, axis=0)[::2]):
        assert backward(network.parameters, inputs, y) == mean
        assert_same_bits(backward.gradient, first)


def test_another_batch_before_leaves_no_trace() -> None:
    network = network_of((3, 5, 2), ("tanh", "linear"))
    x, y = table_for((3, 5, 2), "mse")
    backward = Backward(network, len(x), "mse")
    expected = backward(network.parameters, x, y)
    clean = backward.gradient.copy()
    assert np.isnan(backward(network.parameters, np.nan * x, y))
    assert backward(network.parameters, x, y) == expected
    assert_same_bits(backward.gradient, clean)


@pytest.mark.parametrize("loss", CROSS_ENTROPIES)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_huge_logits_overflow_nowhere(loss: str, dtype: Any) -> None:
    network = Network(
        topology=(1, 2),
        activations=("linear",),
        parameters=np.array([1e4, 0.0, -1e4, 0.0], dtype),
    )
    right = gradient(network, [[1.0]], [[1.0, 0.0]], loss)
    wrong = gradient(network, [[1.0]], [[0.0, 1.0]], loss)
    assert_allclose(right[0], 0.0, rtol=0, atol=1e-12)
    assert_allclose(wrong[0], 2e4, rtol=1e-6, atol=0)
    assert_allclose(right[1], 0.0, rtol=0, atol=1e-12)
    assert_allclose(wrong[1], [1.0, 1.0, -1.0, -1.0], rtol=1e-6, atol=0)


def test_what_cannot_be_computed_is_said() -> None:
    network = network_of((3, 2), ("sigmoid",))
    x, y = table_for((3, 2), "mse")
    with pytest.raises(SettingError, match=r"unknown loss 'mes'; did you mean 'mse'\?"):
        gradient(network, x, y, "mes")
    with pytest.raises(SettingError, match="loss 'softmax' takes linear outputs as logits"):
        gradient(network, x, y, "softmax")
    needed = r"inputs \(n, 3\) and targets \(n, 2\) are needed, got "
    for inputs, targets in ((x[:, :2], y), (x, y[:, :1]), (x[1:], y), (x[0], y[0]), (x[:0], y[:0])):
        with pytest.raises(ShapeError, match=needed):
            gradient(network, inputs, targets)
    with pytest.raises(ShapeError, match="a batch needs at least one row, got 0"):
        Backward(network, 0, "mse")
    with pytest.raises(ShapeError, match="this batch has 7 rows, 5 were announced"):
        Backward(network, 5, "mse")(network.parameters, x, y)
