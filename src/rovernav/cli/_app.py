"""The program `rovernav`: its commands, and how mistakes are answered."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from cyclopts import App, CycloptsError

from .._version import __version__
from ._demo import demo
from ._drive import drive
from ._inspect import inspect
from ._paper import paper
from ._train import train

OK, FAILURE, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130

app = App(
    name="rovernav",
    help="Neural path planning for planetary rovers: from an elevation model to a driven path.",
    version=__version__,
    help_format="plaintext",
    help_epilogue="Start with: rovernav paper, then rovernav drive --help.",
)
for command in (paper, train, drive, inspect, demo):
    app.command(command)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the program.

    Args:
        arguments: The words after ``rovernav``; the process's own where not given.

    Returns:
        0 on success, 1 on failure, 2 on bad input, 130 on Ctrl-C.
    """
    words = list(sys.argv[1:] if arguments is None else arguments)
    try:
        result = app(words, exit_on_error=False, print_error=False, result_action="return_value")
    except CycloptsError as error:
        return _say(str(error), BAD_INPUT, hint=_help_for(words))
    except KeyboardInterrupt:
        return _say("interrupted", INTERRUPTED)
    except BrokenPipeError:  # the reader of a pipe has gone: nothing is left to say
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return OK
    except MemoryError:
        return _say("not enough memory; use a smaller network, map or table", FAILURE)
    except Exception as error:
        if _is_mistake(error):
            return _say(str(error), BAD_INPUT)
        if os.environ.get("ROVERNAV_DEBUG"):
            raise
        kind = type(error).__name__
        message = f"a defect of rovernav: {kind}: {error}"
        return _say(message, FAILURE, hint="ROVERNAV_DEBUG=1 shows where")
    return result if isinstance(result, int) else OK


def _say(message: str, code: int, *, hint: str = "") -> int:
    """One red line on the error stream, and the exit code."""
    from rich.console import Console
    from rich.text import Text

    line = " ".join(message.split())
    console = Console(stderr=True, soft_wrap=True, highlight=False)
    console.print(Text.assemble(("error: ", "bold red"), line))
    if hint:
        console.print(Text(hint, style="dim"))
    return code


def _is_mistake(error: Exception) -> bool:
    """Whether the user can mend it; looked up late, because --help needs no room but this one."""
    from ..core import RovernavError

    return isinstance(error, RovernavError)


def _help_for(words: list[str]) -> str:
    known = [word for word in words[:1] if word in ("paper", "train", "drive", "inspect", "demo")]
    return " ".join(["See: rovernav", *known, "--help"])
