"""The options that commands share, and how their words are read."""

from __future__ import annotations

import math
from collections.abc import Sequence
from decimal import Decimal
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

LARGEST_SEED = 2**63 - 1


def _file(_kind: Any, tokens: Sequence[Any]) -> Path:
    """A path; nothing at all is no path, though Python takes it for the present folder."""
    text = tokens[0].value
    if not text:
        raise ValueError("must not be empty; the present folder is written as .")
    if "://" in text:
        raise ValueError(f"must be on this machine, got {text!r}; download it first")
    return Path(text)


def _file_or_dash(kind: Any, tokens: Sequence[Any]) -> Path:
    """A path, or - for the terminal."""
    text = tokens[0].value
    if text.startswith("-") and text != "-":
        raise ValueError(
            f"needs a file, got {text!r}; a name that begins with - is written ./{text}"
        )
    return _file(kind, tokens)


def _whole(_kind: Any, tokens: Sequence[Any]) -> int:
    """A whole number; 1e6 is one, 1.5 is none."""
    text = tokens[0].value
    try:
        number = Decimal(text)
        if abs(number) < Decimal("1e30") and number == int(number):
            return int(number)
    except ArithmeticError:  # no number, NaN, or one beyond all bounds
        pass
    raise ValueError(f"must be a whole number, got {text!r}")


def _seed(kind: Any, tokens: Sequence[Any]) -> int:
    """A whole number that every generator takes."""
    seed = _whole(kind, tokens)
    if not 0 <= seed <= LARGEST_SEED:
        raise ValueError(f"must be from 0 to 2^63 - 1, got {tokens[0].value}")
    return seed


def _cell(_kind: Any, tokens: Sequence[Any]) -> float:
    """A length above 0."""
    text = tokens[0].value
    try:
        side = float(text)
    except ValueError:
        side = 0.0
    if not (math.isfinite(side) and side > 0.0):
        raise ValueError(f"must be a positive number of metres, got {text!r}")
    return side


def numbers(option: str, text: str | None, count: int) -> Any:
    """So many finite numbers with commas between them; None where nothing was given.

    Raises:
        SettingError: `text` is something else.
    """
    from ..core import SettingError

    if text is None:
        return None
    try:
        found = tuple(float(part) for part in text.split(","))
    except ValueError:
        found = ()
    if len(found) != count or not all(map(math.isfinite, found)):
        raise SettingError(f"{option} must be {count} numbers with commas between, got {text!r}")
    return found


InFile = Annotated[Path, Parameter(converter=_file)]
OutFile = Annotated[Path, Parameter(converter=_file)]
OutFileOrDash = Annotated[Path, Parameter(converter=_file_or_dash, allow_leading_hyphen=True)]
Whole = Annotated[int, Parameter(converter=_whole)]
Out = Annotated[
    Path, Parameter(converter=_file, help="Folder for what is written; made if needed.")
]
Json = Annotated[
    bool,
    Parameter(
        name="--json",
        negative="",
        show_default=False,
        help="Print one JSON object instead of words.",
    ),
]
SeedValue = Annotated[int, Parameter(converter=_seed)]
Seed = Annotated[SeedValue, Parameter(help="Seed of everything random; same seed, same result.")]
Cell = Annotated[
    float,
    Parameter(converter=_cell, help="Cell of a .npy, .png or .csv, which do not say it [m]."),
]
Start = Annotated[
    str, Parameter(name="--from", allow_leading_hyphen=True, help="Start X,Y, like -3.5,1.2.")
]
Goal = Annotated[str, Parameter(name="--to", allow_leading_hyphen=True, help="Goal X,Y.")]
FrameName = Annotated[
    str, Parameter(help="What X,Y are: crs (the model's own, default), local [m] or pixel.")
]
Grey = Annotated[
    str,
    Parameter(allow_leading_hyphen=True, help="Heights LOW,HIGH [m] of the greys of a picture."),
]
SouthFirst = Annotated[
    bool,
    Parameter(negative="", show_default=False, help="Row 0 of a table or array is the south edge."),
]
