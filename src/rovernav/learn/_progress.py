"""What a training tells while it runs, and why it ended."""

from __future__ import annotations

import enum
import math
from collections.abc import Callable
from typing import TypeAlias

from ..core import Float, value


class StopReason(enum.StrEnum):
    """Why a training ended: an ordinary value, never an exception."""

    TOLERANCE = "tolerance"
    """Every error of every pattern came within the tolerance."""
    EPOCHS = "epochs"
    """The number of epochs asked for was done."""
    INTERRUPTED = "interrupted"
    """Ctrl-C or the listener's wish; the training can go on from here."""
    DIVERGED = "diverged"
    """A weight became infinite or not a number; the last good network was kept."""


@value
class Progress:
    """One progress event: the state of the training before epoch `epoch` + 1.

    Attributes:
        epoch: Epochs done.
        updates: Weight updates done.
        worst: Largest error of any output of any pattern; NaN where not known.
        loss: Mean loss: half the squared error summed over outputs, or the mini-batch loss.
        seconds: Time spent training since this process began it [s].
        parameters: The weights now (P,).
        validation: Mean loss of the patterns held out; NaN without any, and where not measured.
    """

    epoch: int
    updates: int
    worst: float
    loss: float
    seconds: float
    parameters: Float
    validation: float = math.nan


Listener: TypeAlias = Callable[[Progress], bool | None]
"""Called with each event; a listener that returns False ends the training as INTERRUPTED."""
