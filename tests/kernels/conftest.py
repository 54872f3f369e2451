from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest


@pytest.fixture(autouse=True)
def silent_overflow() -> Iterator[None]:
    """Compiled code wraps and overflows without a warning; as plain Python it shall too."""
    with np.errstate(all="ignore"):
        yield
