"""What a network answers over two of its inputs: one small picture for each output."""

from __future__ import annotations

import html

import numpy as np

from ..core import F64, U8, value
from ..learn import Patterns
from ..nets import Network
from ..show import data_uri, png

CELLS = 49
MARGIN = 0.25
BELOW, MIDDLE, ABOVE = (230, 159, 0), (247, 247, 245), (0, 114, 178)
"""Colours of -1, 0 and 1 times the largest value: orange, nearly white, blue."""
MOST = 4
"""Outputs that get a picture."""


@value
class Surface:
    """The response of one output.

    Attributes:
        output: Its name.
        image: The picture, as an address for ``<img>``.
        scale: The value that full blue stands for; full orange is its negative.
        points: x and y in shares of the picture, y from the top, and the target, per pattern.
        low: Values of both inputs at the lower left.
        high: Values of both inputs at the upper right.
    """

    output: str
    image: str
    scale: float
    points: tuple[tuple[float, float, float], ...]
    low: tuple[float, float]
    high: tuple[float, float]


def surfaces(
    network: Network, table: Patterns, selected: int, axes: tuple[int, int] = (0, 1)
) -> list[Surface]:
    """One surface for each of the first outputs; none where a network has a single input.

    Args:
        network: Whose answers.
        table: Says over which range the inputs vary.
        selected: The pattern whose values the other inputs keep.
        axes: The inputs that vary, to the right and upwards.
    """
    if table.x.shape[1] < 2:
        return []
    low, high = _range(table.x[:, axes[0]]), _range(table.x[:, axes[1]])
    across = np.linspace(*low, CELLS)
    up = np.linspace(*high, CELLS)[::-1]
    x = np.repeat(table.x[selected][None], CELLS * CELLS, axis=0)
    x[:, axes[0]], x[:, axes[1]] = np.tile(across, CELLS), np.repeat(up, CELLS)
    answers = network.forward(x)
    shown = min(MOST, answers.shape[1])
    return [_surface(table, k, answers[:, k], axes, (low, high)) for k in range(shown)]


def colours(values: F64, scale: float) -> U8:
    """Colours (..., 3) of values between -scale and scale; what is no number is grey."""
    share = np.clip(np.nan_to_num(values / scale, nan=0.0), -1.0, 1.0)[..., None]
    ends = np.where(share < 0, np.array(BELOW), np.array(ABOVE))
    rgb = np.array(MIDDLE) + np.abs(share) * (ends - np.array(MIDDLE))
    rgb[~np.isfinite(values)] = 128
    return rgb.round().astype(np.uint8)


def surface_svg(surface: Surface, names: tuple[str, str]) -> str:
    """The picture with its axes and the patterns on it."""
    dots = "".join(
        f'<circle class="rn-dot" cx="{14 + 150 * x:.1f}" cy="{4 + 150 * y:.1f}" r="5.5" '
        f'style="fill:{_css(target, surface.scale)}"><title>wanted {target:g}</title></circle>'
        for x, y, target in surface.points
    )
    low, high = surface.low, surface.high
    across, up = (html.escape(name[:16]) for name in names)
    title = html.escape(surface.output[:24])
    return (
        f'<svg viewBox="0 0 170 186" role="img" class="rn-surface" aria-label="Response of {title} '
        f'over {across} and {up}">'
        f'<image href="{surface.image}" x="14" y="4" width="150" height="150" '
        'preserveAspectRatio="none"/>'
        f'<rect class="rn-frame" x="14" y="4" width="150" height="150"/>{dots}'
        f'<text class="rn-axis" x="14" y="165">{low[0]:.3g}</text>'
        f'<text class="rn-axis rn-mid" x="89" y="165">{across}</text>'
        f'<text class="rn-axis rn-end" x="164" y="165">{high[0]:.3g}</text>'
        f'<text class="rn-axis rn-mid" transform="translate(10 79) rotate(-90)">{up}</text>'
        f'<text class="rn-axis" x="14" y="181" style="font-weight:650">{title}</text>'
        f'<text class="rn-axis rn-end" x="164" y="181">±{surface.scale:.3g}</text></svg>'
    )


def _surface(
    table: Patterns,
    k: int,
    answers: F64,
    axes: tuple[int, int],
    ranges: tuple[tuple[float, float], tuple[float, float]],
) -> Surface:
    scale = max(float(np.abs(table.y[:, k]).max()), 1e-9)
    image = colours(answers.reshape(CELLS, CELLS), scale)
    (x0, x1), (y0, y1) = ranges
    points = {
        (float((row[axes[0]] - x0) / (x1 - x0)), float(1 - (row[axes[1]] - y0) / (y1 - y0))): want
        for row, want in list(zip(table.x, table.y[:, k], strict=True))[:200]
    }
    return Surface(
        output=table.outputs[k],
        image=data_uri(png(image)),
        scale=scale,
        points=tuple((x, y, float(want)) for (x, y), want in points.items()),
        low=(x0, y0),
        high=(x1, y1),
    )


def _range(column: F64) -> tuple[float, float]:
    """From a little below the smallest to a little above the largest."""
    low, high = float(column.min()), float(column.max())
    span = (high - low) or max(1.0, abs(high))
    return low - MARGIN * span, high + MARGIN * span


def _css(target: float, scale: float) -> str:
    return "rgb({},{},{})".format(*colours(np.array([target]), scale)[0])
