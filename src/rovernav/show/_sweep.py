"""How rates decide over learning: share solved and epochs needed, over eta and momentum."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..core import F64, InputError
from ..learn import SettingScore, SweepResult
from ._canvas import INK, footer, heading, picture, plain
from ._words import BLUE, VERMILION, amount

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_WORDS = 12
"""Rates along the axis of a curve of which each has its own tick."""
ROOM = 68
"""Letters that fit side by side into a map; cells say their numbers if those fit."""
LARGEST_ERROR = 10.0
"""Errors beyond share one colour."""
_NONE = "#E4E4E4"


class _Panel(NamedTuple):
    """One of the two quantities: its name, numbers, range, and how a number is written."""

    name: str
    number: Callable[[SettingScore], float]
    ends: Callable[[SettingScore], tuple[float, float]]
    words: Callable[[float], str]
    logarithmic: bool
    nothing: str


_SOLVED = _Panel(
    "share of networks that met the tolerance",
    lambda s: s.success, lambda s: (s.low, s.high), lambda n: f"{100 * n:.3g} %", False, "",
)  # fmt: skip
_EPOCHS = _Panel(
    "median epochs to tolerance",
    lambda s: s.epochs[1], lambda s: (s.epochs[0], s.epochs[2]), lambda n: f"{n:,.0f}", True,
    "none met it",
)  # fmt: skip
_DIVERGED = _Panel(
    "share of networks that diverged",
    lambda s: s.diverged / s.members, lambda s: (s.diverged / s.members, s.diverged / s.members),
    lambda n: f"{100 * n:.3g} %", False, "",
)  # fmt: skip
_ERROR = _Panel(
    "|error| of the best network",
    lambda s: s.least_error, lambda s: (s.least_error, s.least_error),
    lambda n: f"{n:.2g}", True, "none",
)  # fmt: skip


def draw_sweep(result: SweepResult, path: Path, *, tolerance: float, title: str = "Sweep") -> Path:
    """Draw what came out of a sweep: two maps over eta and momentum, or two curves over one.

    Args:
        result: Of a finished sweep.
        path: The PNG file.
        tolerance: The sweep's; with 0, shares that diverged and errors are drawn instead.
        title: What was swept.

    Returns:
        `path`.

    Raises:
        InputError: No setting has ended.
    """
    scores = result.settings
    if not scores:
        raise InputError("there is nothing to draw: no setting of this sweep has ended")
    etas = sorted({s.eta for s in scores})
    momenta = sorted({s.momentum for s in scores})
    panels = (_SOLVED, _EPOCHS) if tolerance > 0.0 else (_DIVERGED, _ERROR)
    maps = len(etas) > 1 and len(momenta) > 1

    def draw(figure: Figure) -> None:
        heading(figure, title)
        for axes, panel in zip(figure.subplots(1, 2), panels, strict=True):
            if maps:
                _map(figure, axes, panel, scores, etas, momenta)
            else:
                _curve(axes, panel, scores, along_eta=len(etas) > 1)
        figure.subplots_adjust(left=0.085, right=0.975, top=0.86, bottom=0.16, wspace=0.28)
        footer(figure, _small_print(result, tolerance, maps))

    height = 4.8 if not maps else min(9.5, max(4.4, 2.4 + 0.28 * len(etas)))
    return picture(path, (10.6, height), draw)


def _small_print(result: SweepResult, tolerance: float, maps: bool) -> str:
    each = amount(result.settings[0].members, "network")
    words = f"{each} for each eta and momentum, {result.updates:,} weight updates in all"
    if tolerance > 0.0:
        words += f", tolerance {tolerance:g}"
        if not maps:
            words += "; bars: 95 % intervals (Wilson) on the left, quartiles on the right"
    return words


def _map(
    figure: Figure,
    axes: Axes,
    panel: _Panel,
    scores: Sequence[SettingScore],
    etas: list[float],
    momenta: list[float],
) -> None:
    from matplotlib.colors import LogNorm, Normalize

    cells = np.full((len(etas), len(momenta)), np.nan)
    for score in scores:
        cells[etas.index(score.eta), momenta.index(score.momentum)] = panel.number(score)
    known = cells[np.isfinite(cells) & ((cells > 0.0) | (not panel.logarithmic))]
    norm: Any = Normalize(0.0, 1.0)
    if panel.logarithmic:
        low, high = (known.min(), known.max()) if known.size else (1.0, 10.0)
        high = max(low, min(high, LARGEST_ERROR)) if panel is _ERROR else high
        norm = LogNorm(low, high if high > low else 1.5 * low)
    axes.set_facecolor(_NONE)
    colours = "viridis" if not panel.logarithmic else "viridis_r"
    image = axes.imshow(cells, origin="lower", aspect="auto", cmap=colours, norm=norm)
    _ticks(axes, momenta, etas)
    axes.set_title(panel.name)
    axes.set(xlabel="momentum", ylabel="eta, the learning rate")
    words = [panel.words(n) if np.isfinite(n) else panel.nothing for n in cells.ravel().tolist()]
    if len(etas) <= 24 and len(momenta) * (1 + max(map(len, words))) <= ROOM:
        _say_cells(axes, cells, words, image)
    bar = figure.colorbar(image, ax=axes, pad=0.02)
    if panel.logarithmic:
        _plain_numbers(bar.ax.yaxis)


def _say_cells(axes: Axes, cells: F64, words: list[str], image: Any) -> None:
    """Each cell's number, dark on light and light on dark."""
    for ((row, column), number), said in zip(np.ndenumerate(cells), words, strict=True):
        colour = "#555555"
        if np.isfinite(number):
            red, green, blue, _ = image.cmap(image.norm(number))
            colour = INK if 0.3 * red + 0.59 * green + 0.11 * blue > 0.5 else "white"
        axes.text(column, row, said, ha="center", va="center", color=colour, fontsize=8.0)


def _plain_numbers(axis: Any) -> None:
    """2,000 rather than 2 x 10^3, along a logarithmic axis."""
    from matplotlib.ticker import FuncFormatter, LogFormatter

    class Plain(LogFormatter):
        """Leaves out the numbers that stand too close, as its parent does."""

        def __call__(self, x: float, pos: int | None = None) -> str:
            return f"{x:,.6g}" if super().__call__(x, pos) else ""

    axis.set_major_formatter(FuncFormatter(lambda number, _: f"{number:,.6g}"))
    axis.set_minor_formatter(Plain(minor_thresholds=(1.0, 0.4)))


def _ticks(axes: Axes, momenta: list[float], etas: list[float]) -> None:
    """The rates themselves along both axes, not more of them than can be read."""
    for numbers, put, most in ((momenta, axes.set_xticks, 12), (etas, axes.set_yticks, 24)):
        step = -(-len(numbers) // most)
        places = list(range(0, len(numbers), step))
        put(places, [f"{numbers[k]:g}" for k in places])


def _curve(axes: Axes, panel: _Panel, scores: Sequence[SettingScore], *, along_eta: bool) -> None:
    """One quantity over the rate that was varied."""
    scores = sorted(scores, key=lambda s: s.eta if along_eta else s.momentum)
    x = np.array([s.eta if along_eta else s.momentum for s in scores])
    y = np.array([panel.number(s) for s in scores])
    ends = np.array([panel.ends(s) for s in scores])
    there = np.isfinite(y)
    bars = np.abs(ends - y[:, None])[there].T
    axes.errorbar(x[there], y[there], bars, color=BLUE, ecolor=BLUE, marker="o", ms=5.5,
                  lw=1.4, elinewidth=1.2, capsize=3.5)  # fmt: skip
    if panel.logarithmic and bool((y[there] > 0.0).any()):
        axes.set_yscale("log")
        _plain_numbers(axes.yaxis)
    elif not panel.logarithmic:
        axes.set_ylim(-0.03, 1.05)
    for rate in x[~there]:
        axes.axvline(rate, color=VERMILION, lw=0.9, ls=":")
        axes.text(rate, 0.03, f" {panel.nothing}", color=VERMILION, rotation=90, fontsize=8.0,
                  transform=axes.get_xaxis_transform(), va="bottom", ha="right")  # fmt: skip
    if len(x) <= MOST_WORDS:
        axes.set_xticks(x, [f"{rate:g}" for rate in x])
    if len(x) == 1:
        axes.set_xlim(x[0] - 0.5, x[0] + 0.5)
        for rate, number in zip(x[there], y[there], strict=True):
            axes.annotate(panel.words(float(number)), (rate, number), (9, -3),
                          textcoords="offset points")  # fmt: skip
    other = f"momentum {scores[0].momentum:g}" if along_eta else f"eta {scores[0].eta:g}"
    axes.set_xlabel(f"{'eta, the learning rate' if along_eta else 'momentum'} ({other})")
    axes.set_title(plain(panel.name))
    axes.grid(color="#e6e6e6")
