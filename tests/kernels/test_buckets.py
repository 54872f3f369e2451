from __future__ import annotations

import numpy as np
import pytest

from rovernav.kernels import buckets

pytestmark = pytest.mark.kernels


def test_every_item_comes_out_of_its_slice_once(rng: np.random.Generator) -> None:
    q = buckets.queue(16, 2000)
    expected: dict[int, list[int]] = {}
    for item in range(2000):
        slice_ = int(rng.integers(100, 116))
        assert buckets.push(q, slice_, item)
        expected.setdefault(slice_, []).append(item)
    for slice_ in range(100, 116):
        got: list[int] = []
        while (item := buckets.pop(q, slice_)) >= 0:
            got.append(item)
        assert sorted(got) == expected[slice_]
    assert buckets.is_empty(q)


def test_a_chunk_given_back_is_used_again() -> None:
    q = buckets.queue(2, 64)
    for turn in range(50):  # far more than fits at once
        for item in range(64):
            assert buckets.push(q, turn, item)
        for _ in range(64):
            assert buckets.pop(q, turn) >= 0
        assert buckets.pop(q, turn) == -1


def test_a_full_queue_says_so_and_can_be_cleared() -> None:
    q = buckets.queue(2, 1)
    pushed = 0
    while buckets.push(q, 0, pushed):
        pushed += 1
    assert pushed >= 1
    buckets.clear(q)
    assert buckets.is_empty(q)
    assert buckets.push(q, 5, 7)
    assert buckets.pop(q, 5) == 7
