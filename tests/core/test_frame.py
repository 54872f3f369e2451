from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from rovernav.core import Frame, InputError, SettingError

scale = st.floats(0.3, 3.0)
shear = st.floats(-0.2, 0.2)
place = st.floats(-1e5, 1e5)


@given(xx=scale, yy=scale, xy=shear, yx=shear, x=place, y=place)
def test_local_metres_and_map_go_both_ways(
    xx: float, yy: float, xy: float, yx: float, x: float, y: float
) -> None:
    frame = Frame(cell=1.0, shape=(9, 9), origin=(3.5e6, -2.1e6), axes=((xx, xy), (yx, yy)))
    assert_allclose(frame.to_local(*frame.to_map(x, y)), (x, y), rtol=0, atol=1e-6)
    dx, dy = np.subtract(frame.to_map(x + 1.0, y), frame.to_map(x, y))
    assert_allclose((dx, dy), (xx, yx), rtol=0, atol=1e-8)


def test_a_plain_frame_only_shifts() -> None:
    frame = Frame(cell=0.5, shape=(4, 6), origin=(100.0, -7.25))
    assert frame.to_map(1.5, 2.0) == (101.5, -5.25)
    assert frame.to_local(101.5, -5.25) == (1.5, 2.0)
    assert frame.map_cell == (0.5, 0.5)


def test_a_point_is_given_in_one_of_three_frames() -> None:
    frame = Frame(cell=0.5, shape=(4, 6), origin=(100.0, -7.25))
    assert frame.place(101.5, -5.25) == frame.place(1.5, 2.0, "local") == (1.5, 2.0)
    assert frame.place(0.0, 0.0, "pixel") == (0.25, 1.75)
    with pytest.raises(SettingError, match="no frame 'pixels'; did you mean 'pixel'"):
        frame.place(0.0, 0.0, "pixels")


def test_a_part_lies_where_it_was() -> None:
    frame = Frame(cell=2.0, shape=(50, 60), origin=(10.0, 20.0), axes=((1.5, 0.1), (0.0, 1.0)))
    part = frame.part(7, 9, (5, 4), factor=3)
    assert (part.cell, part.shape) == (6.0, (5, 4))
    assert part.to_map(1.0, 2.0) == pytest.approx(frame.to_map(19.0, 16.0), abs=1e-12)


@pytest.mark.parametrize("axes", [((1, 0), (0, 0)), ((0, 1), (1, 0)), ((math.nan, 0), (0, 1))])
def test_axes_must_span_an_area(axes: tuple[tuple[float, float], tuple[float, float]]) -> None:
    with pytest.raises(InputError, match="the axes of a frame must span an area, got"):
        Frame(cell=1.0, shape=(3, 3), axes=axes)
