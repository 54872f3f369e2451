"""Where a command's work runs: the one place that chooses an executor."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from ._options import Whole

if TYPE_CHECKING:
    from ..core import Executor

MOST_WORKERS = 1024

Workers = Annotated[Whole | None, Parameter(help="Threads to work on; default: one per processor.")]


def choose_executor(workers: int | None) -> Executor:
    """What runs the blocks of a command's work.

    Args:
        workers: How many work side by side; as many as there are processors where not given.

    Raises:
        SettingError: Not a usable number of workers.
    """
    from ..core import SettingError, Threads

    if workers is not None and not 1 <= workers <= MOST_WORKERS:
        raise SettingError(f"--workers must be from 1 to {MOST_WORKERS}, got {workers}")
    return Threads(workers)
