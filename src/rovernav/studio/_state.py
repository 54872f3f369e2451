"""A training as it stands, for whoever wants to look at it."""

from __future__ import annotations

from ..core import value
from ..learn import Training
from ._curve import Point, TraceLine
from ._setup import Setup


@value
class State:
    """A training as it stands, for whoever wants to look at it.

    Attributes:
        setup: What it was set up with.
        training: Network, epoch, why it ended.
        running: Whether it is at work.
        curve: Its error so far.
        before: The curve of the run before it.
        trace: The last weights that the trace wrote down, if it is on.
        said: A sentence about the last thing that went wrong; empty if nothing did.
        version: Rises with every change; the same number means the same state.
        rate: Updates per second while it runs, measured.
        kept: Name of the run in the library, once it is finished and kept.
    """

    setup: Setup
    training: Training
    running: bool
    curve: tuple[Point, ...]
    before: tuple[Point, ...]
    trace: tuple[TraceLine, ...]
    said: str
    version: int
    rate: float
    kept: str
