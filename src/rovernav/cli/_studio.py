"""`rovernav studio`: training engine and rover simulator as a local web page."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter

from ._console import say
from ._options import Cell, InFile, OutFile, Whole


def studio(
    *,
    host: Annotated[
        str, Parameter(help="Address to listen on; others than this machine's own need a token.")
    ] = "127.0.0.1",
    port: Annotated[Whole, Parameter(help="Port; 0 takes any free one.")] = 8137,
    library: Annotated[
        OutFile | None,
        Parameter(help="File in which runs are kept; default in the user's data folder."),
    ] = None,
    terrain: Annotated[
        list[InFile] | None,
        Parameter(negative="", help="Elevation model to offer for drives; may be given again."),
    ] = None,
    cell: Cell | None = None,
    browser: Annotated[
        bool, Parameter(name="--browser", negative="--no-browser", help="Open a browser.")
    ] = True,
) -> int:
    """Open the studio, a web page on this machine: train, drive, compare, learn.

    Runs until Ctrl-C. Finished runs are kept and found again the next time.

    Example: rovernav studio --no-browser
    """
    from ..studio import Options, serve

    serve(
        Options(
            host=host, port=port, library=library, terrain=tuple(terrain or ()), cell=cell,
            show=browser, say=_say_now,
        )
    )  # fmt: skip
    return 0


def _say_now(line: str) -> None:
    import sys

    say(line)
    sys.stdout.flush()  # whoever waits for the address reads it through a pipe
