from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from rovernav.core import Frame, InputError, ShapeError
from rovernav.terrain import Terrain
from tests.terrain.ground import ground, plane


def test_heights_keep_micrometres_far_from_the_datum() -> None:
    heights = -2600.0 + np.linspace(0.0, 1.0, 16).reshape(4, 4)
    terrain = ground(heights)
    assert terrain.height.dtype == np.float32
    assert terrain.offset == -2600.0
    assert_allclose(terrain.offset + terrain.height.astype(np.float64), heights, rtol=0, atol=1e-7)
    assert_allclose(terrain.span, (-2600.0, -2599.0), rtol=0, atol=1e-7)


def test_heights_cannot_be_changed() -> None:
    with pytest.raises(ValueError, match="read-only"):
        ground(np.zeros((3, 3))).height[0, 0] = 1.0


def test_elevation_at_is_exact_on_a_plane_between_cell_centres() -> None:
    terrain = plane(0.2, -0.1, shape=(5, 8), cell=0.5)
    x, y = np.meshgrid(np.linspace(0.25, 3.75, 29), np.linspace(0.25, 2.25, 17))
    expected = 0.2 * (x - 0.25) - 0.1 * (y - 0.25)
    assert_allclose(terrain.elevation_at(x, y), expected, rtol=0, atol=1e-6)


def test_elevation_at_goes_on_level_at_the_edge_and_stops_there() -> None:
    terrain = ground([[1, 2, 3], [4, 5, 6], [7, 8, 9]])
    assert terrain.elevation_at(0.0, 0.0) == 1.0
    assert terrain.elevation_at(3.0, 3.0) == 9.0
    assert np.isnan(terrain.elevation_at(3.01, 1.0))
    assert np.isnan(terrain.elevation_at(1.0, -0.01))
    assert np.isnan(terrain.elevation_at(np.nan, 1.0))


def test_elevation_at_is_missing_only_where_a_missing_cell_counts() -> None:
    terrain = ground([[1, 2, 3], [4, np.nan, 6], [7, 8, 9]])
    assert terrain.elevation_at(0.5, 1.5) == 4.0
    assert terrain.elevation_at(0.5, 1.0) == 2.5
    assert np.isnan(terrain.elevation_at(0.6, 1.0))
    assert terrain.finite == pytest.approx(8 / 9)


@pytest.mark.parametrize(
    ("heights", "error", "message"),
    [
        (np.zeros((1, 1)), ShapeError, r"at least 3 x 3 heights, got shape \(1, 1\)"),
        (np.zeros((2, 9)), ShapeError, r"at least 3 x 3 heights, got shape \(2, 9\)"),
        (np.zeros(9), ShapeError, r"give a two-dimensional grid"),
        (np.full((3, 3), np.nan), InputError, "every height is missing; check the file's nodata"),
        (np.diag([np.inf, 1, 2]), InputError, "1 heights are infinite; mark missing heights"),
        (np.diag([-3.4e38, 1, 2]), InputError, "-3.4e.38 to 2 m go beyond 100 km; if one of them"),
    ],
)
def test_heights_that_cannot_be_ground(
    heights: np.ndarray, error: type[Exception], message: str
) -> None:
    frame = Frame(cell=1.0, shape=(3, 3))
    with pytest.raises(error, match=message):
        Terrain.from_heights(heights, frame, name="t", source="here")


def test_heights_must_fit_their_frame() -> None:
    with pytest.raises(ShapeError, match=r"float32 of the frame's shape \(3, 4\), got float32 of"):
        Terrain.from_heights(np.zeros((3, 3)), Frame(cell=1.0, shape=(3, 4)), name="t", source="s")


def test_a_flipped_view_is_stored_row_by_row() -> None:
    heights = np.arange(12, dtype=np.float32).reshape(3, 4)[::-1]
    terrain = Terrain(
        frame=Frame(cell=1.0, shape=(3, 4)), height=heights, offset=0.0, name="t", source="s"
    )
    assert terrain.height.flags.c_contiguous
    assert not terrain.height.flags.writeable
    assert_array_equal(terrain.height, heights)
