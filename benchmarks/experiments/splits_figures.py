"""The three figures of one small training split among threads."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

GREY, BLUE, ORANGE = "#555555", "#0072b2", "#d55e00"


@dataclasses.dataclass(frozen=True)
class Run:
    """One training: seconds, weight updates, and whether it met the tolerance."""

    seconds: float
    updates: int
    solved: bool


def draw(
    runs: dict[str, list[Run]], sizes: dict[int, dict[int, float]], folder: Path
) -> list[Path]:
    """Write split-averaging.png, split-lock-free.png and split-nodes.png."""
    averaging = [name for name in runs if name.startswith(("serial", "averaging"))]
    free = [name for name in runs if name.startswith(("serial", "lock-free"))]
    nodes = [name for name in runs if name.startswith(("serial", "node"))]

    def first(figure: Figure) -> None:
        _to_tolerance(figure.subplots(), {name: runs[name] for name in averaging})
        figure.subplots_adjust(left=0.3, right=0.97, bottom=0.17, top=0.9)
        figure.suptitle("Two threads that average their networks every k epochs", fontsize=11)

    def second(figure: Figure) -> None:
        _to_tolerance(figure.subplots(), {name: runs[name] for name in free})
        figure.subplots_adjust(left=0.3, right=0.97, bottom=0.25, top=0.86)
        figure.suptitle("Threads that change one network without a lock", fontsize=11)

    def third(figure: Figure) -> None:
        left, right = figure.subplots(1, 2, width_ratios=(1.1, 1))
        _to_tolerance(left, {name: runs[name] for name in nodes})
        _per_update(right, sizes)
        figure.subplots_adjust(left=0.12, right=0.985, bottom=0.2, top=0.84, wspace=0.28)
        figure.suptitle("Two threads that share the units of every layer", fontsize=11)

    return [
        _write(folder / "split-averaging.png", (7.2, 3.4), first),
        _write(folder / "split-lock-free.png", (7.2, 2.3), second),
        _write(folder / "split-nodes.png", (9.4, 3.0), third),
    ]


def _write(path: Path, size: tuple[float, float], fill: Callable[[Figure], None]) -> Path:
    figure = Figure(figsize=size, dpi=130, facecolor="white")
    fill(figure)
    figure.savefig(path)
    return path


def _to_tolerance(axes: Axes, runs: dict[str, list[Run]]) -> None:
    """Quartiles as bars, medians as dots, single networks as small dots; serial in grey."""
    for row, found in enumerate(runs.values()):
        times = np.array([run.seconds * 1e3 for run in found if run.solved])
        colour = GREY if row == 0 else BLUE
        if len(times):
            low, mid, high = np.percentile(times, (25, 50, 75))
            axes.plot(times, np.full(len(times), row), ".", color=colour, alpha=0.35, ms=4)
            axes.plot((low, high), (row, row), "-", color=colour, lw=5, alpha=0.6)
            axes.plot(mid, row, "o", color=colour, mec="white", ms=8)
            if row == 0:
                axes.axvline(mid, color=GREY, lw=0.8, ls="--", zorder=0)
        if len(times) < len(found):
            where = axes.get_yaxis_transform()
            words = f"{len(times)} of {len(found)} met it"
            axes.text(0.16, row, words, transform=where, ha="left", va="center", color=ORANGE)
    axes.set_xscale("log")
    axes.xaxis.set_major_formatter("{x:g}")
    axes.set_yticks(range(len(runs)), _labels(runs))
    axes.set_ylim(len(runs) - 0.5, -0.5)
    axes.set_xlabel("time to tolerance [ms]: every network, quartiles, median")
    axes.grid(axis="x", color="#dddddd", lw=0.6)


def _labels(names: Any) -> Sequence[str]:
    return [
        name.replace("averaging every ", "averaged every ").replace("serial", "one thread")
        for name in names
    ]


def _per_update(axes: Axes, sizes: dict[int, dict[int, float]]) -> None:
    """Time of one update over the width of the hidden layer."""
    widths = list(sizes)
    for threads, colour, name in ((1, GREY, "one thread"), (2, BLUE, "two threads")):
        times = [sizes[width][threads] * 1e6 for width in widths]
        axes.plot(widths, times, "o-", color=colour, ms=4, label=name)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("hidden units, of 16 inputs and 16 outputs")
    axes.set_ylabel("time of one update [µs]")
    axes.grid(color="#dddddd", lw=0.6)
    axes.legend(loc="upper left")
