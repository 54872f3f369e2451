"""Tables are made once they pay, and go with what they are of."""

from __future__ import annotations

import gc

import numpy as np
import pytest

from rovernav.core import Frame
from rovernav.sim import Grid, _tables


def grid(side: int = 12) -> Grid:
    return Grid(frame=Frame(cell=0.5, shape=(side, side)), blocked=np.zeros((side, side), np.uint8))


def test_a_table_is_made_once_so_many_beams_were_cast() -> None:
    one = grid()
    assert not len(_tables.cones_of(one, beams=1).free)
    made = _tables.cones_of(one, beams=12 * 12 // _tables.CELLS_PER_BEAM)
    assert len(made.free) == 1
    assert not made.free.flags.writeable
    assert _tables.cones_of(one, beams=0).free is made.free
    assert not len(_tables.cones_of(grid(), beams=1).free)
    assert not len(_tables.cones_of(None, beams=10**9).free)


def test_a_table_too_large_is_not_made(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_tables, "MOST_ENTRIES", 100)
    assert not len(_tables.cones_of(grid(), beams=10**6).free)


def test_tables_go_with_their_grids() -> None:
    gc.collect()
    before = len(_tables._cones)
    one = grid()
    _tables.cones_of(one, beams=10**6)
    assert len(_tables._cones) == before + 1
    del one
    gc.collect()
    assert len(_tables._cones) == before
