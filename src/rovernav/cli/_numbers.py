"""Lists of numbers as options write them: ``0,0.5,0.9``, ``0.05..0.5``, ``0.05..0.5/20``."""

from __future__ import annotations

from fractions import Fraction

USUAL, MOST = 10, 10_000
"""Numbers of a range that does not say how many, and of a list at most."""


def numbers(option: str, text: str) -> tuple[float, ...]:
    """The numbers of a list, of ranges, or of both; ends of ranges belong to them.

    Args:
        option: Its name, for complaints.
        text: What was given.

    Raises:
        SettingError: It cannot be read, or a range is reversed, empty or too long.
    """
    from ..core import SettingError

    out: list[float] = []
    for part in text.split(","):
        out += _range(option, part.strip()) if ".." in part else [float(_one(option, part.strip()))]
        if len(out) > MOST:
            raise SettingError(f"{option} may list {MOST:,} numbers, got more; use fewer")
    return tuple(out)


def whole_numbers(option: str, text: str) -> list[int]:
    """Whole numbers with commas between them.

    Raises:
        SettingError: Something else.
    """
    from ..core import SettingError

    try:
        return [int(part) for part in text.split(",")]
    except ValueError:
        raise SettingError(
            f"{option} takes whole numbers with commas between them, like 0,17; got {text!r}"
        ) from None


def _range(option: str, text: str) -> list[float]:
    from ..core import SettingError

    ends, slash, many = text.partition("/")
    low, _, high = ends.partition("..")
    first, last = _one(option, low.strip()), _one(option, high.strip())
    if not first < last:
        raise SettingError(
            f"{option} {text}: a range goes from the smaller to the larger number, "
            f"like 0.05..0.5; write a single number as {low.strip()}"
        )
    try:
        count = int(many) if slash else USUAL
    except ValueError:
        count = 0
    if not 2 <= count <= MOST:
        raise SettingError(
            f"{option} {text}: after the slash stands how many numbers the range has, "
            f"from 2 to {MOST:,}, like 0.05..0.5/20; got {many!r}"
        )
    return [float(first + (last - first) * k / (count - 1)) for k in range(count)]


def _one(option: str, text: str) -> Fraction:
    """A number, exactly as written: 0.05..0.5 shall hold 0.15 and not its neighbour."""
    from ..core import SettingError

    try:
        if "/" not in text and "_" not in text and len(text) <= 30 and abs(float(text)) < 1e30:
            return Fraction(text)
    except ValueError:
        pass
    raise SettingError(
        f"{option} takes a list like 0,0.5,0.9 or a range like 0.05..0.5 or 0.05..0.5/20, "
        f"got {text[:40]!r}"
    )
