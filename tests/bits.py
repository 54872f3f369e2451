"""Comparison bit by bit."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.testing import assert_array_equal


def assert_same_bits(actual: Any, expected: Any) -> None:
    """Equal dtype, shape and bits; one NaN is as good as another."""
    a, b = np.asarray(actual), np.asarray(expected)
    assert a.dtype == b.dtype
    assert_array_equal(a, b)
    assert_array_equal(np.signbit(a) & ~np.isnan(a), np.signbit(b) & ~np.isnan(b))
