from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rovernav.core import Frame, InputError, ShapeError
from rovernav.plan import CostMap


def test_what_is_no_number_is_forbidden() -> None:
    costs = CostMap.of([[1.0, np.nan], [np.inf, 2.5]], forbidden=[[0, 0], [0, 0]])
    np.testing.assert_array_equal(costs.forbidden, [[False, True], [True, False]])
    assert (costs.least, costs.most, costs.unit) == (1.0, 2.5, "m")


@pytest.mark.parametrize("wrong", [0.0, -1.0, -np.inf])
def test_a_cost_must_be_above_nothing(wrong: float) -> None:
    with pytest.raises(InputError, match=r"cost of row 1, column 0 is .*must be above 0"):
        CostMap.of([[1.0, 2.0], [wrong, 2.0]])


def test_shapes_must_fit() -> None:
    with pytest.raises(ShapeError, match="rows and columns"):
        CostMap.of(np.ones((2, 2, 2)))
    with pytest.raises(ShapeError, match=r"forbidden cells have shape \(2, 3\)"):
        CostMap.of(np.ones((3, 2)), forbidden=np.ones((2, 3)))
    with pytest.raises(ShapeError, match=r"float32 of the frame's shape \(3, 3\)"):
        CostMap.of(np.ones((2, 2)), Frame(cell=1.0, shape=(3, 3)))
    with pytest.raises(ShapeError, match=r"a path must have shape \(k, 2\)"):
        CostMap.of(np.ones((2, 2))).pieces(np.ones(4))


def test_pieces_are_counted_in_metres() -> None:
    costs = CostMap.of([[1.0, 3.0]], cell=2.0)
    assert_allclose(costs.pieces([(0.5, 1.0), (2.5, 1.0), (3.5, 1.0)]), [1.5 + 1.5, 3.0])
    assert_allclose(costs.cost_of([(0.5, 1.0), (3.5, 1.0)]), 6.0)
    assert costs.cost_of([(0.5, 1.0)]) == 0.0


def test_it_does_not_change_with_the_array_it_came_from() -> None:
    array = np.ones((2, 2), np.float32)
    costs = CostMap.of(array)
    array[0, 0] = 9.0
    assert costs.cost[0, 0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        costs.cost[0, 0] = 2.0
