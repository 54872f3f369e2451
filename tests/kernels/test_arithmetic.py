from __future__ import annotations

from decimal import Decimal, localcontext
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from rovernav.kernels import arithmetic, network
from rovernav.kernels._jit import JIT_DISABLED, kernel
from rovernav.nets import ACTIVATIONS
from tests.bits import assert_same_bits
from tests.naive import arithmetic as naive

pytestmark = pytest.mark.kernels
COUNT = 40 if JIT_DISABLED else 600
KINDS = [np.float64, np.float32]
SPECIAL = [0.0, -0.0, 1.0, -1.0, 1e-30, 700.0, -700.0, 1e30, -1e30, np.inf, -np.inf, np.nan]


@kernel()
def fma_each(a: Any, b: Any, c: Any, out: Any) -> None:
    for k in range(out.size):
        out[k] = arithmetic.fma(a[k], b[k], c[k])


@kernel()
def exp_each(x: Any, out: Any) -> None:
    for k in range(x.size):
        out[k] = arithmetic.exp(x[k])


def exp(x: Any) -> Any:
    out = np.empty_like(x)
    exp_each(x, out)
    return out


def activation(name: str, s: Any) -> Any:
    """The activation as networks use it: one input, weight 1, bias 0."""
    layers = np.array([[1, 1, ACTIVATIONS[name]]])
    out = np.empty((len(s), 1), s.dtype)
    network.forward(layers, np.array([1, 0], s.dtype), s.reshape(-1, 1), out)
    return out[:, 0]


def points(kind: Any, rng: np.random.Generator) -> Any:
    spread = np.concatenate([rng.normal(size=COUNT), rng.uniform(-750, 750, COUNT)])
    return np.concatenate([spread, SPECIAL]).astype(kind)


def exact(name: str, x: float) -> Decimal:
    """The function to 40 digits."""
    with localcontext(prec=40):
        s = Decimal(x)
        if name == "exp":
            return s.exp()
        return 1 / (1 + (-s).exp()) if name == "sigmoid" else 1 - 2 / (1 + (2 * s).exp())


@pytest.mark.parametrize(("kind", "letter"), [(np.float64, "C"), (np.float32, "F")])
def test_coefficients_are_taylors(kind: Any, letter: str) -> None:
    expected = naive.coefficients(kind)
    assert [getattr(arithmetic, f"_{letter}{i}") for i in range(len(expected))] == expected


@pytest.mark.parametrize("kind", KINDS)
def test_fma_rounds_once(kind: Any, rng: np.random.Generator) -> None:
    scale = np.ldexp(1.0, rng.integers(-20, 20, (2, COUNT)))
    a, b = (rng.normal(size=(2, COUNT)) * scale).astype(kind)
    c = np.where(rng.random(COUNT) < 0.5, -a * b, rng.normal(size=COUNT)).astype(kind)
    out = np.empty_like(a)
    fma_each(a, b, c, out)
    assert_same_bits(out, [naive.fma(*abc) for abc in zip(a, b, c, strict=True)])
    assert (out != a * b + c).any()


@pytest.mark.parametrize("kind", KINDS)
def test_fma_at_the_ends(kind: Any) -> None:
    tiny, huge = np.finfo(kind).smallest_subnormal, np.finfo(kind).max
    a = [0, -0.0, tiny, tiny, huge, -huge, huge, np.inf, np.inf, np.nan, 1, 3]
    b = [5, 0.0, 0.5, 0.75, 2.0, 2.00, 1.00, 0.000, -1.00, 1.000, 1, tiny]
    c = [0, -0.0, 0, tiny, -1, 1, huge, 1, np.inf, 1, -1, -tiny]
    x, y, z = (np.array(column, kind) for column in (a, b, c))
    out = np.empty(len(a), kind)
    fma_each(x, y, z, out)
    assert_same_bits(out, [naive.fma(*row) for row in zip(x, y, z, strict=True)])


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", ACTIVATIONS)
def test_activations_equal_the_twin(name: str, kind: Any, rng: np.random.Generator) -> None:
    s = points(kind, rng)
    assert_same_bits(activation(name, s), [getattr(naive, name)(x) for x in s + kind(0)])


@pytest.mark.parametrize("kind", KINDS)
def test_exp_equals_the_twin(kind: Any, rng: np.random.Generator) -> None:
    x = points(kind, rng)
    assert_same_bits(exp(x), [naive.exp(e) for e in x])


@pytest.mark.parametrize(("kind", "largest"), [(np.float64, 700.0), (np.float32, 85.0)])
def test_exp_is_as_exact_as_its_argument(
    kind: Any, largest: float, rng: np.random.Generator
) -> None:
    """x log2(e) is rounded, and the constant is: one eps of x becomes a relative error."""
    x = rng.uniform(-largest, largest, COUNT).astype(kind)
    eps = float(np.finfo(kind).eps)
    for given, got in zip(x.tolist(), exp(x).tolist(), strict=True):
        error = abs(Decimal(got) / exact("exp", given) - 1)
        assert error <= eps * (1.5 + abs(given)), given


@pytest.mark.parametrize(
    ("name", "kind", "bound"),
    [
        ("sigmoid", np.float64, 4e-16),
        ("tanh", np.float64, 6e-16),
        ("sigmoid", np.float32, 1.5e-7),
        ("tanh", np.float32, 3e-7),
    ],
)
def test_absolute_error(name: str, kind: Any, bound: float, rng: np.random.Generator) -> None:
    s = np.concatenate([rng.normal(size=COUNT) * 4, rng.uniform(-60, 60, COUNT)]).astype(kind)
    for given, got in zip(s.tolist(), activation(name, s).tolist(), strict=True):
        assert abs(Decimal(got) - exact(name, given)) <= bound, given


@pytest.mark.parametrize(("kind", "least"), [(np.float64, 2.0**-1022), (np.float32, 2.0**-126)])
def test_saturation(kind: Any, least: float) -> None:
    ends = np.array([-np.inf, -800.0, 800.0, np.inf], kind)
    assert exp(ends).tolist() == [least, least, 1 / least, 1 / least]
    assert activation("sigmoid", ends).tolist() == [least, least, 1.0, 1.0]
    assert activation("tanh", ends).tolist() == [-1.0, -1.0, 1.0, 1.0]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", ACTIVATIONS)
def test_nan_stays_nan(name: str, kind: Any) -> None:
    assert np.isnan(activation(name, np.array([np.nan], kind))).all()


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", ["sigmoid", "tanh"])
def test_rises(name: str, kind: Any, rng: np.random.Generator) -> None:
    grid = activation(name, np.sort(rng.uniform(-40, 40, 30 * COUNT).astype(kind)))
    assert (np.diff(grid) >= 0).all()
    beside = [rng.normal(size=COUNT).astype(kind)]
    for _ in range(20):
        beside.append(np.nextafter(beside[-1], kind(np.inf)))
    values = activation(name, np.stack(beside).ravel()).reshape(len(beside), COUNT)
    assert np.diff(values, axis=0).min() >= -np.finfo(kind).eps


@pytest.mark.parametrize("kind", KINDS)
def test_sigmoid_is_symmetric_to_one_ulp(kind: Any, rng: np.random.Generator) -> None:
    s = rng.normal(size=10 * COUNT).astype(kind) * kind(8)
    gap = activation("sigmoid", -s) - (kind(1) - activation("sigmoid", s))
    assert np.abs(gap).max() <= np.finfo(kind).eps


def test_plain_functions_equal_compiled_ones(rng: np.random.Generator) -> None:
    for kind in KINDS:
        s = points(kind, rng)[::37]
        for name in ("sigmoid", "tanh", "relu"):
            plain = [kind(getattr(arithmetic, name)(x)) for x in s]
            assert_array_equal(plain, activation(name, s + kind(0)))
        assert_array_equal([arithmetic.exp(x) for x in s], exp(s))
