from __future__ import annotations

import io
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from PIL import Image

from rovernav.core import ShapeError
from rovernav.show import data_uri, png


@pytest.mark.parametrize("shape", [(1, 1, 3), (5, 7, 3), (64, 3, 4)])
def test_another_library_reads_the_same_pixels(
    shape: tuple[int, ...], rng: np.random.Generator
) -> None:
    pixels = rng.integers(0, 256, shape).astype(np.uint8)
    with Image.open(io.BytesIO(png(pixels))) as image:
        image.load()
        assert_array_equal(np.asarray(image), pixels)
    assert data_uri(png(pixels)).startswith("data:image/png;base64,iVBOR")


def test_other_arrays_are_refused() -> None:
    wrong: Any
    for wrong in (np.zeros((2, 2), np.uint8), np.zeros((2, 2, 3)), np.zeros((0, 2, 3), np.uint8)):
        with pytest.raises(ShapeError, match="a picture needs bytes"):
            png(wrong)
