"""How a network learnt: its error over the epochs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..core import F64, InputError
from ..learn import Progress
from ._canvas import INK, footer, picture, plain
from ._words import BLUE, GREEN, ORANGE, VERMILION, amount

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HIGHEST = 1e100
"""Errors of a diverged training beyond this are not drawn: the axis' ticks would overflow."""

_WORST = "largest |error| of any output of any pattern"
_RMSE = "root mean square error"
_LOSS = "loss: half the squared error, summed over outputs, mean over patterns"
_BATCH = "loss, mean over the epoch's patterns, each before its update"
_HELD = "loss of the patterns held out, after the epoch"


def draw_training(
    curve: Sequence[Progress],
    path: Path,
    *,
    tolerance: float | None = None,
    outputs: int | None = None,
    title: str = "Training",
) -> Path:
    """Draw the error of a training over its epochs, on a logarithmic scale.

    Args:
        curve: The events of the training, in order.
        path: The PNG file.
        tolerance: The error below which the training was to stop.
        outputs: Outputs of the network, to draw the root mean square error instead of the loss.
        title: What was trained.

    Returns:
        `path`.

    Raises:
        InputError: No event at all.
    """
    if not curve:
        raise InputError("there is nothing to draw: the training told of no epoch")

    def draw(figure: Figure) -> None:
        axes = figure.add_axes((0.085, 0.24, 0.885, 0.68))
        _curves(axes, curve, outputs)
        if tolerance is not None and tolerance > 0.0:
            axes.axhline(tolerance, ls="--", lw=1.3, color=GREEN, label=f"tolerance {tolerance:g}")
        _end(axes, curve[-1], tolerance)
        axes.set(yscale="log", xlabel="epoch (one pass over all patterns)", ylabel="error")
        axes.set_xlim(left=0.0, right=max(1.0, 1.04 * curve[-1].epoch))
        axes.grid(color="#e6e6e6")
        axes.set_title(plain(title), parse_math=False)
        figure.legend(loc="lower center", bbox_to_anchor=(0.5, 0.045), ncols=2, frameon=False)
        footer(figure, f"{amount(curve[-1].updates, 'weight update')} in all")

    return picture(path, (8.6, 5.6), draw)


def _curves(axes: Axes, curve: Sequence[Progress], outputs: int | None) -> None:
    epochs = np.array([event.epoch for event in curve])
    worst = _positive([event.worst for event in curve])
    loss = _positive([event.loss for event in curve])
    held = _positive([event.validation for event in curve])
    dots: dict[str, Any] = {"marker": "o", "ms": 3.5} if len(curve) < 30 else {}
    if np.isfinite(worst).any():
        axes.plot(epochs, worst, color=BLUE, lw=1.8, label=_WORST, **dots)
    if outputs:
        axes.plot(epochs, np.sqrt(2.0 * loss / outputs), color=ORANGE, lw=1.4, label=_RMSE, **dots)
    else:
        label = _LOSS if np.isfinite(worst).any() else _BATCH
        axes.plot(epochs, loss, color=ORANGE, lw=1.4, label=label, **dots)
    if np.isfinite(held).any():
        axes.plot(epochs, held, color=BLUE, lw=1.8, label=_HELD, **dots)


def _end(axes: Axes, last: Progress, tolerance: float | None) -> None:
    """Where and with what error the training ended."""
    error = last.worst if np.isfinite(last.worst) else last.loss
    if not 0.0 < error < HIGHEST:  # True for NaN
        return
    met = tolerance is not None and error < tolerance
    plain_colour = BLUE if np.isfinite(last.worst) else ORANGE
    colour = GREEN if met else VERMILION if tolerance is not None else plain_colour
    words = "" if tolerance is None else ", within tolerance" if met else ", tolerance not met"
    said = (
        f"{'stopped' if met else 'ended'} after {amount(last.epoch, 'epoch')}: {error:.4g}{words}"
    )
    axes.axvline(last.epoch, color="#999999", lw=0.9, ls=":")
    axes.plot(
        last.epoch, error, "o", color=colour, mec=INK, ms=8, zorder=5, clip_on=False, label=said
    )


def _positive(numbers: Sequence[float]) -> F64:
    """The numbers that a logarithm has and an axis can hold; NaN for the others."""
    array = np.array(numbers, dtype=np.float64)
    return np.where((array > 0.0) & (array < HIGHEST), array, np.nan)
