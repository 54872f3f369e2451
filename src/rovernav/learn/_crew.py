"""Threads that run one kernel side by side and meet inside it."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import final

from ..core import SettingError
from ..kernels.team import Team, give_up, make_board


@final
class Crew:
    """The calling thread and others, kept from run to run.

    Args:
        workers: How many, the calling thread included.
    """

    def __init__(self, workers: int) -> None:
        self.workers = workers
        self._pool: ThreadPoolExecutor | None = None

    def run(self, job: Callable[[Team], float]) -> float:
        """Run the job once for every worker, all at the same time.

        Returns:
            What the first worker, who is the calling thread, returned. When it returns or raises,
            no worker is at work any more.

        Raises:
            SettingError: The machine gives no more threads.
        """
        board = make_board()
        others: list[Future[float]] = []
        try:
            for me in range(1, self.workers):
                others.append(self._start(job, Team(me, self.workers, board)))
            result = job(Team(0, self.workers, board))
        except BaseException:
            give_up(board)  # nobody shall wait for who will not come
            _wait(others)
            raise
        _wait(others)
        for other in others:
            other.result()
        return result

    def close(self) -> None:
        """End the threads."""
        if self._pool is not None:
            self._pool.shutdown()
            self._pool = None

    def _start(self, job: Callable[[Team], float], team: Team) -> Future[float]:
        if self._pool is None:
            self._pool = ThreadPoolExecutor(self.workers - 1, thread_name_prefix="rovernav")
        try:
            return self._pool.submit(_guarded, job, team)
        except RuntimeError as error:
            raise SettingError(
                f"workers = {self.workers} threads cannot be started ({error}); ask for fewer"
            ) from None


def _guarded(job: Callable[[Team], float], team: Team) -> float:
    """The job; if it fails, the others learn of it."""
    try:
        return job(team)
    except BaseException:
        give_up(team.board)
        raise


def _wait(others: list[Future[float]]) -> None:
    """Return when all are done; Ctrl-C meanwhile is raised after that, not before."""
    interrupted = False
    for other in others:
        while not other.done():
            try:
                other.exception()
            except KeyboardInterrupt:
                interrupted = True
    if interrupted:
        raise KeyboardInterrupt
