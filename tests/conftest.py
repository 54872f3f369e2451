"""What all tests share: seeded randomness, the development data, Hypothesis profiles."""

from __future__ import annotations

import os
from pathlib import Path

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

WRAPS = "ignore:(overflow|invalid value|divide by zero) encountered:RuntimeWarning"


def pytest_configure(config: pytest.Config) -> None:
    """Compiled code wraps and overflows without a warning; as plain Python it shall too."""
    if os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0"):
        config.addinivalue_line("filterwarnings", WRAPS)


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
    """The development data: ROVERNAV_DATA, or shared/data beside the checkout.

    Where they are not at hand, the test is skipped; a place that should have them must have them.
    """
    named = os.environ.get("ROVERNAV_DATA")
    beside = ROOT.parent / "shared"
    folder = Path(named) if named else beside / "data"
    if folder.is_dir():
        return folder
    if named:
        pytest.fail(f"ROVERNAV_DATA is {named}, which is not a folder")
    if UNDER_CI and beside.is_dir():
        pytest.fail(f"{beside} has no folder data")
    pytest.skip("no development data; set ROVERNAV_DATA to their folder")
