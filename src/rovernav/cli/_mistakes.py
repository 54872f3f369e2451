"""What the command-line reader has to complain about, as one sentence each."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from cyclopts import (
    CoercionError,
    CycloptsError,
    MissingArgumentError,
    RepeatArgumentError,
    UnknownCommandError,
    UnknownOptionError,
    UnusedCliTokensError,
)

_ALONE = ("--help", "--version")


def sentence(error: CycloptsError, commands: Iterable[str]) -> str:
    """One sentence: what was wrong, what was got, and the nearest name that would have worked.

    Args:
        error: What cyclopts raised.
        commands: Names of all commands.
    """
    match error:
        case UnknownCommandError(unused_tokens=[str(word), *_]):
            return _unknown_command(word, commands)
        case UnknownOptionError():
            return _unknown_option(error)
        case UnusedCliTokensError(unused_tokens=[str(word), *_]):
            return (
                f"unexpected argument {word!r}; an option's value follows its name, as in --out X"
            )
        case MissingArgumentError():
            return _missing(error)
        case CoercionError():
            return _not_readable(error)
        case RepeatArgumentError():
            return f"{error.token.keyword} is given twice; give it once"
        case _:
            return str(error)


def _unknown_command(word: str, commands: Iterable[str]) -> str:
    from ..core import suggest

    if word.startswith("-"):
        return (
            f"there is no option {word} before a command; options follow it, as in rovernav drive "
            "bassil-v1 --json, and alone stand --help and --version"
        )
    if f"--{word}" in _ALONE:
        return f"there is no command {word!r}; did you mean --{word}?"
    return f"there is no command {word!r}; {suggest(word, commands)}"


def _unknown_option(error: UnknownOptionError) -> str:
    from difflib import get_close_matches

    word = str(error.token.keyword or error.token.value).partition("=")[0]
    known = sorted({name for one in error.argument_collection if one.parse for name in one.names})
    begun = [name for name in known if len(word) > 2 and name.startswith(word)]
    near = begun or get_close_matches(word, known, n=1)
    advice = f"did you mean {' or '.join(near)}?" if near else f"it takes {', '.join(known)}"
    return f"there is no option {word}; {advice}"


def _missing(error: MissingArgumentError) -> str:
    name = error.keyword or _name(error)
    if name.startswith("-"):
        return f"{name} needs a value after it"
    return f"{name} is missing; name it after the command"


def _not_readable(error: CoercionError) -> str:
    if error.msg is not None:  # our own converters: "must be ..., got ..."
        return f"{_name(error)} {error.msg}"
    got = error.token.value if error.token else ""
    if error.target_type is bool:
        return f"{_name(error)} takes no value, got {got!r}"
    wanted = "a number" if error.target_type is float else "of another kind"
    return f"{_name(error)} must be {wanted}, got {got!r}"


def _name(error: Any) -> str:
    return str(error.argument.name) if error.argument else "an argument"
