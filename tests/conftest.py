"""What all tests share: seeded randomness, the development data, Hypothesis profiles."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

import numpy as np
import pytest
from hypothesis import settings

ROOT = Path(__file__).resolve().parent.parent
UNDER_CI = os.environ.get("CI", "").lower() in {"1", "true", "yes"}

# No deadline: the first example of a kernel compiles it.
settings.register_profile("fast", deadline=None)
settings.register_profile("ci", deadline=None, derandomize=True, database=None)
settings.register_profile("long", deadline=None, max_examples=2000)
settings.load_profile("ci" if UNDER_CI else "fast")


@pytest.fixture
def rng() -> np.random.Generator:
    """Randomness that is the same in every run."""
    return np.random.default_rng(0)


@pytest.fixture(scope="session")
def root() -> Path:
    """The checkout."""
    return ROOT


@pytest.fixture(scope="session")
def data_dir() -> Path:
    """The development data: ROVERNAV_DATA, or shared/data beside the checkout."""
    named = os.environ.get("ROVERNAV_DATA")
    if named:
        if not Path(named).is_dir():
            pytest.fail(f"ROVERNAV_DATA is {named}, which is not a folder")
        return Path(named)
    beside = ROOT.parent / "shared"
    if not (beside / "data").is_dir():
        _missing("no development data: set ROVERNAV_DATA to their folder", failure=beside.is_dir())
    return beside / "data"


@pytest.fixture(scope="session")
def data_file(data_dir: Path) -> Callable[[str], Path]:
    """A function from a name like ``dem/moon_dem_33/dem_moon.tif`` to the file in `data_dir`."""

    def find(name: str) -> Path:
        path = data_dir / name
        if not path.exists():
            _missing(f"the development data have no {name}", failure=True)
        return path

    return find


def _missing(reason: str, *, failure: bool) -> NoReturn:
    """Skip; but under CI, where data are there, a test that needs them may not stay away."""
    if UNDER_CI and failure:
        pytest.fail(reason)
    pytest.skip(reason)
