"""Where a command's work is done: in this process, in several, or on a cluster."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Generator
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from ._console import note
from ._options import Whole

if TYPE_CHECKING:
    from ..core import Executor


@Parameter(name="*")
@dataclasses.dataclass(frozen=True, kw_only=True)
class Place:
    """The options that say who does the work; they never change a result.

    Attributes:
        workers: Threads or processes on this machine; None for the command's own choice.
        cluster: Address of a Dask scheduler, or ``local``.
        cluster_timeout: How long the cluster may take to answer [s].
    """

    workers: Annotated[
        Whole | None,
        Parameter(help="How many share the work here; 0 for one per processor."),
    ] = None
    cluster: Annotated[
        str | None,
        Parameter(help="Dask scheduler that shares out the work, tcp://HOST:PORT; or local."),
    ] = None
    cluster_timeout: Annotated[
        float, Parameter(help="How long the cluster may take to answer [s].")
    ] = 10.0

    @contextlib.contextmanager
    def executor(self, *, usual: int = 1, threads: bool = False) -> Generator[Executor]:
        """Who does the work, for as long as it lasts.

        Args:
            usual: Workers where the user does not say; 0 for one per processor.
            threads: Whether the work is all kernels, so that threads do as well as processes.

        Raises:
            RovernavError: No such place, or no cluster that can be used.
        """
        if self.cluster is not None:
            with _on_cluster(self) as executor:
                yield executor
            return
        from ..core import Processes, Serial, SettingError, Threads, cores

        count = usual if self.workers is None else self.workers
        if not 0 <= count <= 1024:
            raise SettingError(f"--workers must be from 0 to 1024, got {count}")
        count = count or cores()
        yield Serial() if count == 1 else (Threads if threads else Processes)(count)


@contextlib.contextmanager
def _on_cluster(place: Place) -> Generator[Executor]:
    from ..core import SettingError

    cluster = place.cluster or ""
    if place.workers is not None and cluster != "local":
        raise SettingError("--workers goes with --cluster local; other clusters have their own")
    from ..adapters import open_executor

    workers = place.workers or None
    with open_executor(cluster, workers=workers, timeout=place.cluster_timeout) as executor:
        yield executor
        notes = executor.notes
    for text in notes:
        note(f"note: {text}")
