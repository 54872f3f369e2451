"""The program `rovernav`: its commands, and how mistakes are answered."""

from __future__ import annotations

import contextlib
import errno
import inspect as introspection
import os
import sys
from collections.abc import Callable, Sequence
from typing import Any

from cyclopts import App, CycloptsError

from .._version import __version__
from ._compare import compare
from ._console import announce_compiling, complain
from ._demo import demo
from ._drive import drive
from ._export import export
from ._inspect import inspect
from ._mistakes import sentence
from ._paper import paper
from ._plugins import plugins
from ._route import route
from ._studio import studio
from ._sweep import sweep
from ._teach import teach
from ._template import template
from ._terrain import TERRAIN, terrain
from ._train import train

OK, FAILURE, BAD_INPUT = 0, 1, 2

COMMANDS: dict[str, Callable[..., int]] = {
    "paper": paper,
    "train": train,
    "sweep": sweep,
    "drive": drive,
    "route": route,
    "compare": compare,
    "teach": teach,
    "template": template,
    "terrain": terrain,
    "inspect": inspect,
    "export": export,
    "plugins": plugins,
    "demo": demo,
    "studio": studio,
}
GROUPS: dict[str, dict[str, Callable[..., int]]] = {"terrain": TERRAIN}
"""Commands that only hold others; their own docstring is the help of the group."""
_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EIO, errno.EFBIG)
"""What a user's other words would not mend."""
_NO_NAME = (errno.ENAMETOOLONG, errno.ELOOP)
"""What they would: no file can have such a name."""


def run(arguments: Sequence[str] | None = None) -> int:
    """Run the program; answer every mistake with one sentence and an exit code."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    if words[:1] == ["help"]:
        words = [*words[1:], "--help"]
    _print_any_name()
    announce_compiling()
    try:
        result = _app()(words, exit_on_error=False, print_error=False, result_action="return_value")
        if sys.stdout is not None:
            sys.stdout.flush()
    except CycloptsError as error:
        return complain(
            sentence(error, GROUPS.get(words[0], COMMANDS) if words else COMMANDS),
            BAD_INPUT,
            hint=_help_for(words),
        )
    except BrokenPipeError:  # the reader of a pipe has gone: nothing is left to say
        _forget_output()
        return OK
    except MemoryError:
        return complain("not enough memory; use a smaller network, map or table", FAILURE)
    except Exception as error:
        return _answer(error)
    return result if isinstance(result, int) else OK


def _app() -> App:
    app = App(
        name="rovernav",
        help="Neural path planning for planetary rovers: from an elevation model to a driven path.",
        version=__version__,
        help_format="plaintext",
        suppress_keyboard_interrupt=False,  # it would end without a word
        help_epilogue="Start with: rovernav paper, then rovernav drive --help.",
    )
    for name, command in COMMANDS.items():
        text = _paragraphs(command)
        if name not in GROUPS:
            app.command(command, name=name, help=text, help_epilogue="")
            continue
        group = App(name=name, help=text, help_format="plaintext", help_epilogue="")
        for inner, one in GROUPS[name].items():
            group.command(one, name=inner, help=_paragraphs(one), help_epilogue="")
        app.command(group)
    return app


def _paragraphs(command: Callable[..., Any]) -> str:
    """A docstring with one line per paragraph, so that the terminal breaks the lines."""
    text = introspection.getdoc(command) or ""
    return "\n\n".join(" ".join(part.split()) for part in text.split("\n\n"))


def _answer(error: Exception) -> int:
    """Say what went wrong: a user's mistake, the machine's refusal, or a defect of ours."""
    # Late, because --help needs no room but this one.
    from ..core import RovernavError, WorkerError
    from ..core.plugins import USED

    if isinstance(error, RovernavError):
        cause = error.__cause__
        refused = isinstance(cause, OSError) and cause.errno in _FULL
        failed = refused or isinstance(error, WorkerError)
        return complain(str(error), FAILURE if failed else BAD_INPUT)
    if isinstance(error, OSError) and error.strerror:
        where = f" ({error.filename})" if error.filename else ""
        code = BAD_INPUT if error.errno in _NO_NAME else FAILURE
        return complain(f"the system refused: {error.strerror}{where}", code)
    if os.environ.get("ROVERNAV_DEBUG"):
        raise error
    used = ", ".join(dict.fromkeys(one.called for one in USED))
    if used:
        message = f"{used} may be at fault: {type(error).__name__}: {error}"
        return complain(message, FAILURE, hint="See: rovernav plugins --check")
    message = f"a defect of rovernav: {type(error).__name__}: {error}"
    return complain(message, FAILURE, hint="ROVERNAV_DEBUG=1 shows where")


def _forget_output() -> None:
    """Whatever is still to be printed goes nowhere, or Python would complain while it ends."""
    with contextlib.suppress(AttributeError, OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _print_any_name() -> None:
    """File names may hold what a terminal's encoding has not: print an escape instead."""
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(AttributeError, ValueError):
            stream.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]


def _help_for(words: list[str]) -> str:
    known = [word for word in words[:1] if word in COMMANDS]
    known += [word for word in words[1:2] if word in GROUPS.get(words[0], {})]
    return " ".join(["See: rovernav", *known, "--help"])
