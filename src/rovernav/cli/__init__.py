"""The command line: a thin shell over the rooms below. Heavy imports wait until they are needed."""

from ._app import main

__all__ = ["main"]
