from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rovernav.kernels import batch, losses
from rovernav.kernels.product import BIAS, ON, VECTOR, ZERO, At, aligned, padded, product
from rovernav.kernels.turn import turn
from rovernav.nets import Network
from tests.bits import assert_same_bits
from tests.naive.arithmetic import fma

pytestmark = pytest.mark.kernels

SHAPES = [(1, 1, 1), (3, 2, 5), (5, 3, 17), (9, 1, 16), (10, 2, 33), (17, 2, 9)]
"""Rows, depth, columns: parts of tiles and whole ones."""


def chains(a: Any, b: Any, starts: Any) -> Any:
    """Each element by itself: fused multiply-adds over ascending k, from its own start."""
    out = np.empty((len(a), b.shape[1]), a.dtype)
    for i, row in enumerate(a):
        for j, column in enumerate(b.T):
            total = starts[i, j]
            for left, right in zip(row, column, strict=True):
                total = fma(left, right, total)
            out[i, j] = total
    return out


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("start", [ZERO, BIAS, ON])
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_product_has_the_bits_of_single_chains(
    dtype: Any, shape: tuple[int, int, int], start: int, turned: bool, rng: np.random.Generator
) -> None:
    rows, depth, columns = shape
    wide = padded(columns, np.dtype(dtype).itemsize)
    b = aligned((depth + 1) * wide, dtype).reshape(depth + 1, wide)
    b[:, :columns] = rng.normal(size=(depth + 1, columns))
    a = rng.normal(size=(rows, depth)).astype(dtype)
    flat = np.ascontiguousarray(a.T if turned else a).ravel()
    steps = (1, rows) if turned else (depth, 1)
    c = aligned(7 + rows * wide, dtype)
    c[7:] = rng.normal(size=rows * wide)
    before = c[7:].reshape(rows, wide)[:, :columns].copy()
    starts = {ZERO: 0 * before, BIAS: 0 * before + b[depth, :columns], ON: before}[start]
    product(c, flat, b.ravel(), At(7, wide, 0, *steps, 0, wide, depth, start), rows, columns)
    after = c[7:].reshape(rows, wide)[:, :columns]
    assert_same_bits(after, chains(a, b[:depth, :columns], starts))
    assert not c[:7].any()


def test_rows_are_whole_vectors_that_do_not_share_cache_sets() -> None:
    assert [padded(n, 4) for n in (1, 16, 17, 255, 256, 512)] == [16, 16, 32, 272, 272, 528]
    assert [padded(n, 8) for n in (1, 8, 9, 128)] == [8, 8, 16, 136]
    for size in range(1, 9):
        assert aligned(size, np.float32).ctypes.data % VECTOR == 0


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("names", [("tanh", "sigmoid", "linear"), ("relu", "linear", "tanh")])
def test_outputs_have_the_bits_of_the_network(
    names: tuple[str, ...], dtype: Any, rng: np.random.Generator
) -> None:
    network = Network.seeded((3, 18, 2, 4), names, rng, dtype=dtype)
    x = rng.normal(size=(5, 3)).astype(dtype)
    plan = batch.make_plan(network.layer_rows, 6, x.itemsize)
    w, scratch = batch.make_weights(plan, dtype), batch.make_scratch(plan, 6, dtype)
    batch.pack(plan, network.parameters.copy(), w)
    batch.inputs(plan, scratch, 5)[:] = x
    batch.forward(plan, w, scratch.o, 5)
    first, wide = plan[-1, batch.OUTPUTS], plan[-1, batch.WIDE]
    outputs = scratch.o[first : first + 5 * wide].reshape(5, wide)[:, :4]
    assert_same_bits(outputs, network.forward(x))


def test_packing_and_back_is_the_identity(rng: np.random.Generator) -> None:
    network = Network.seeded((3, 18, 2), ("tanh", "linear"), rng)
    plan = batch.make_plan(network.layer_rows, 1, 8)
    w, flat = batch.make_weights(plan, np.float64), np.empty(len(network.parameters))
    batch.pack(plan, network.parameters.copy(), w)
    batch.unpack(plan, w, flat)
    assert_same_bits(flat, network.parameters)
    assert np.count_nonzero(w) == len(flat)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("shape", [(1, 1), (2, 33), (16, 16), (18, 40), (33, 7)])
def test_turned_is_transposed(shape: tuple[int, int], dtype: Any, rng: np.random.Generator) -> None:
    rows, columns = shape
    a_row, b_row = columns + 3, rows + 5
    a, b = rng.normal(size=4 + rows * a_row).astype(dtype), np.zeros(6 + columns * b_row, dtype)
    turn(a, 4, a_row, b, 6, b_row, shape)
    inside = a[4:].reshape(rows, a_row)[:, :columns]
    whole = b[6:].reshape(columns, b_row)
    assert_same_bits(whole[:, :rows], inside.T)
    assert not whole[:, rows:].any()  # padding stays
    assert not b[:6].any()


@pytest.mark.parametrize("rows", [1, 5, batch.PANEL, batch.PANEL + 3])
def test_panels_add_up_to_the_batch(rows: int, rng: np.random.Generator) -> None:
    network = Network.seeded((3, 18, 2), ("tanh", "linear"), rng)
    plan = batch.make_plan(network.layer_rows, rows, 8)
    w, whole, parts = (batch.make_weights(plan, np.float64) for _ in range(3))
    batch.pack(plan, network.parameters.copy(), w)
    x, y = rng.normal(size=(rows, 3)), rng.normal(size=(rows, 2))
    scratch = batch.make_scratch(plan, rows, np.float64)

    def add(first: int, last: int, g: Any, on: int, total: float) -> float:
        batch.inputs(plan, scratch, last - first)[:] = x[first:last]
        scratch.y[: last - first] = y[first:last]
        part = batch.Part(losses.MSE, 1.0 / rows, on, total)
        return batch.gradient(plan, w, g, scratch, part, last - first)

    loss, middle = add(0, rows, whole, 0, 0.0), (rows + 1) // 2
    total = add(0, middle, parts, 0, 0.0)
    total = add(middle, rows, parts, 1, total) if middle < rows else total
    assert_same_bits(parts, whole)
    assert total == loss
