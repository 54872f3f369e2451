"""The network as a drawing: lines as wide as the weights, blue for above 0, orange for below."""

from __future__ import annotations

import html
import math
from collections.abc import Iterator, Sequence

from ..core import F64
from ..nets import Network

WIDTH, HEIGHT = 600, 430
MOST = 12
"""Units drawn per layer; the others are counted in words."""
WIDEST = 9.0
_LEFT, _RIGHT, _TOP, _BOTTOM = 118, 166, 20, 34


def network_svg(
    network: Network,
    activations: Sequence[F64],
    inputs: Sequence[str],
    outputs: Sequence[str],
    target: F64,
) -> str:
    """The drawing as SVG; its colours come from the page's style.

    Args:
        network: What to draw.
        activations: The input of the pattern that is shown, then the outputs of each layer.
        inputs: Names of the inputs.
        outputs: Names of the outputs.
        target: What the outputs should be.
    """
    layers = [
        [(_x(level, len(activations)), y) for y in _heights(len(units), level, len(activations))]
        for level, units in enumerate(activations)
    ]
    parts = [
        f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" role="img" class="rn-net" '
        f'aria-label="Network {"-".join(map(str, network.topology))}">'
    ]
    largest = max(1.0, float(abs(network.parameters).max()))
    for level, matrix in enumerate(network.matrices):
        parts += _lines(level, matrix, layers, largest, len(network.matrices))
    for level, units in enumerate(activations):
        parts += _units(level, units, layers[level], network)
    parts += _ends(activations, layers, inputs, outputs, target)
    parts.append("</svg>")
    return "".join(parts)


def unit_name(level: int, number: int, last: int) -> str:
    """``x``-side units by number, ``h0`` or ``h1.0`` in hidden layers, ``O0`` in the last."""
    if level == last:
        return f"O{number}"
    return f"h{number}" if last == 2 else f"h{level}.{number}"


def _x(level: int, count: int) -> float:
    return _LEFT + (WIDTH - _LEFT - _RIGHT) * level / max(1, count - 1)


def _heights(units: int, level: int, count: int) -> list[float]:
    """Heights of the units that are drawn, and of the bias below them where there is one."""
    shown = min(units, MOST) + (level < count - 1)
    step = min(104.0, (HEIGHT - _TOP - _BOTTOM) / max(1, shown))
    middle = (HEIGHT - _BOTTOM + _TOP) / 2
    return [middle + step * (i - (shown - 1) / 2) for i in range(shown)]


def _lines(
    level: int, matrix: F64, layers: list[list[tuple[float, float]]], largest: float, last: int
) -> Iterator[str]:
    below, above = layers[level], layers[level + 1]
    units = min(len(matrix), MOST)
    sources = min(matrix.shape[1] - 1, MOST)
    columns = [*range(sources), matrix.shape[1] - 1]  # the bias stands last
    for unit in range(units):
        for place, column in enumerate(columns):
            weight = float(matrix[unit, column])
            (x1, y1), (x2, y2) = below[place], above[unit]
            share = min(1.0, abs(weight) / largest)
            bend = (x2 - x1) * 0.45
            kind = "rn-plus" if weight >= 0 else "rn-minus"
            dashed = " rn-bias" if column == matrix.shape[1] - 1 else ""
            source = "bias" if dashed else _source_name(level, column, last)
            yield (
                f'<path class="{kind}{dashed}" stroke-width="{0.6 + WIDEST * share:.2f}" '
                f'stroke-opacity="{0.25 + 0.7 * share:.2f}" '
                f'd="M{x1:.1f} {y1:.1f} C{x1 + bend:.1f} {y1:.1f} {x2 - bend:.1f} {y2:.1f} '
                f'{x2:.1f} {y2:.1f}"><title>{source} to {unit_name(level + 1, unit, last)}: '
                f"{weight:.6g}</title></path>"
            )


def _source_name(level: int, column: int, last: int) -> str:
    return f"input {column}" if level == 0 else unit_name(level, column, last)


def _units(
    level: int, units: F64, places: list[tuple[float, float]], network: Network
) -> Iterator[str]:
    last = len(network.topology) - 1
    crowded = len(places) > 8
    radius = 12 if crowded else 21
    for number, (x, y) in enumerate(places):
        if number == min(len(units), MOST):
            yield (
                f'<rect class="rn-one" x="{x - 10}" y="{y - 10:.1f}" width="20" height="20" '
                f'rx="4"/><text class="rn-in" x="{x}" y="{y + 4:.1f}">1</text>'
            )
            continue
        amount = float(units[number])
        share = min(1.0, abs(amount)) if math.isfinite(amount) else 0.0
        kind = "rn-hot" if amount >= 0 else "rn-cold"
        yield f'<circle class="rn-unit" cx="{x}" cy="{y:.1f}" r="{radius}"/>'
        yield (
            f'<circle class="{kind}" cx="{x}" cy="{y:.1f}" r="{radius - 1}" '
            f'fill-opacity="{0.06 + 0.5 * share:.2f}"/>'
        )
        yield f'<text class="rn-in" x="{x}" y="{y + 4:.1f}">{_short(amount)}</text>'
        if 0 < level < last:
            yield (
                f'<text class="rn-tag" x="{x}" y="{y - radius - 3:.1f}">'
                f"{unit_name(level, number, last)}</text>"
            )
    x = places[0][0]
    name = "inputs" if level == 0 else network.activations[level - 1]
    more = f" ({len(units)}, {MOST} drawn)" if len(units) > MOST else ""
    yield f'<text class="rn-layer" x="{x}" y="{HEIGHT - 6}">{name}{more}</text>'


def _ends(
    activations: Sequence[F64],
    layers: list[list[tuple[float, float]]],
    inputs: Sequence[str],
    outputs: Sequence[str],
    target: F64,
) -> Iterator[str]:
    """Names of inputs and outputs; what each output should be and by how much it misses."""
    for number, name in enumerate(inputs[:MOST]):
        x, y = layers[0][number]
        yield f'<text class="rn-name rn-end" x="{x - 28}" y="{y + 4:.1f}">{_cut(name)}</text>'
    for number, name in enumerate(outputs[:MOST]):
        x, y = layers[-1][number]
        error = float(target[number] - activations[-1][number])
        yield f'<text class="rn-name" x="{x + 28}" y="{y - 4:.1f}">{_cut(name)}</text>'
        yield (
            f'<text class="rn-aim" x="{x + 28}" y="{y + 11:.1f}">wanted {_short(target[number])}'
            f", error {_short(error)}</text>"
        )


def _cut(name: str) -> str:
    return html.escape(name if len(name) <= 13 else name[:12] + "…")


def _short(number: float) -> str:
    """A number in at most five letters or so."""
    number = float(number)
    if not math.isfinite(number):
        return "∞"
    if abs(number) >= 1000:
        return f"{number:.0e}".replace("e+0", "e")
    text = f"{number:.2f}" if abs(number) < 100 else f"{number:.0f}"
    return "0.00" if text == "-0.00" else text.replace("-", "−")
