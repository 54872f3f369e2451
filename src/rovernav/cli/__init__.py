"""The command line: a thin shell over the rooms below. Heavy imports wait until they are needed."""

from __future__ import annotations

import collections.abc
import sys

__all__ = ["main"]


def main(arguments: collections.abc.Sequence[str] | None = None) -> int:
    """Run the program `rovernav`.

    Args:
        arguments: The words after ``rovernav``; the process's own where not given.

    Returns:
        0 on success, 1 on failure, 2 on bad input, 130 on Ctrl-C.
    """
    try:
        from ._app import run  # inside, so that Ctrl-C during the start is no traceback

        return run(arguments)
    except KeyboardInterrupt:
        print("error: interrupted", file=sys.stderr)
        return 130
