"""Every error that rovernav raises, in one tree.

::

    RovernavError
    ├── InputError            a value that was given cannot be used
    │   ├── SettingError      a setting, option or key
    │   ├── ShapeError        an array of the wrong shape or dtype
    │   ├── PatternError      a line of a pattern table
    │   └── FileError         a file is missing, damaged, foreign or too large
    ├── WorkerError           workers do not answer, do not fit or have gone
    ├── PluginError           an installed plug-in cannot be used
    ├── ContractError         a part of a drive does not keep the contract of its role
    └── MissingExtraError     an optional package is not installed

A message says what was wrong, what was got, what is allowed and what to do next.
Ordinary ends of a drive or a training (collided, timed out, diverged) are values, not errors:
see `rovernav.core.Outcome` and `rovernav.learn.StopReason`.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class RovernavError(Exception):
    """Root of all errors that rovernav raises on purpose."""


class InputError(RovernavError, ValueError):
    """A value that was given cannot be used."""


class SettingError(InputError):
    """A setting, option or configuration key has a value that is not allowed."""


class ShapeError(InputError):
    """An array has the wrong shape or dtype."""


class PatternError(InputError):
    """A line of a pattern table cannot be used."""


class FileError(InputError):
    """A file is missing, damaged, of a foreign format or too large."""


class WorkerError(RovernavError):
    """Workers do not answer, do not fit this machine, or ended before their work was done."""


class PluginError(RovernavError):
    """A part of a drive that an installed distribution offers cannot be used."""


class ContractError(RovernavError, AssertionError):
    """A part of a drive (a controller, a sensor) does not keep the contract of its role."""


class MissingExtraError(RovernavError, ImportError):
    """An optional package is not installed."""


def suggest(name: str, allowed: Iterable[str]) -> str:
    """The end of an error message: the nearest allowed name, and all of them.

    Args:
        name: What the user wrote.
        allowed: The names that would have worked.

    Returns:
        ``did you mean 'sigmoid'? Allowed: linear, relu, sigmoid, tanh.`` or the list alone.
    """
    names = sorted(allowed)
    near = difflib.get_close_matches(name, names, n=1)
    listed = f"Allowed: {', '.join(names)}."
    return f"did you mean '{near[0]}'? {listed}" if near else listed
