from __future__ import annotations

import threading
from typing import Any

import numpy as np
import pytest

from rovernav.kernels import descent
from rovernav.kernels.team import Team, give_up, make_board, meet

pytestmark = pytest.mark.kernels


def at_once(calls: list[Any]) -> None:
    threads = [threading.Thread(target=call, daemon=True) for call in calls]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
        assert not thread.is_alive(), "a worker waits for ever"


@pytest.mark.parametrize("workers", [2, 3, 8])
def test_nobody_goes_on_before_all_are_there(workers: int) -> None:
    board, rounds = make_board(), 50
    came = np.zeros((workers, 1 + rounds), np.int64)
    early: list[int] = []

    def work(me: int) -> None:
        team = Team(me, workers, board)
        for turn in range(1, rounds + 1):
            came[me, turn] = came[:, turn - 1].sum() + 1
            assert meet(team)
            early.extend([turn] * (not came[:, turn].all()))
            assert meet(team)

    at_once([lambda me=me: work(me) for me in range(workers)])
    assert not early
    assert (came[:, 1:] == came[0, 1:]).all()  # each saw all that the others had written


@pytest.mark.parametrize("workers", [2, 4])
def test_who_waits_for_somebody_who_gave_up_goes_home(workers: int) -> None:
    board, met = make_board(), []

    def wait(me: int) -> None:
        met.append(meet(Team(me, workers, board)))

    at_once([
        *(lambda me=me: wait(me) for me in range(1, workers)),
        lambda: give_up(board),
    ])  # fmt: skip
    assert met == [False] * (workers - 1)
    assert not meet(Team(0, workers, board))  # who comes late does not wait either


def test_one_alone_need_not_wait() -> None:
    assert meet(Team(0, 1, make_board()))


@pytest.mark.parametrize("strange", [np.inf, -np.inf, np.nan, 1e39])
def test_numbers_that_a_precision_does_not_hold_are_told(strange: float) -> None:
    a = np.array([1.1, strange, -3e38])
    for dtype in (np.float32, np.float64):
        b = np.zeros(3, dtype)
        held = descent.narrow(a, b)
        assert held == bool(np.isfinite(a.astype(dtype)).all())
        assert b[0] == dtype(1.1)
        assert b[2] == dtype(-3e38)
