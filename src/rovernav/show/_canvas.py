"""One way to make a picture: no window, no global state, the same bytes for the same input."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Callable, Generator
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from .._version import __version__
from ..core import write_atomic

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DPI = 130
INK = "#222222"
STYLE: dict[str, Any] = {
    "axes.edgecolor": "#888888",
    "axes.labelcolor": INK,
    "axes.titlesize": 11.0,
    "font.family": ["DejaVu Sans"],
    "font.size": 9.0,
    "hatch.linewidth": 0.6,
    "legend.fontsize": 8.5,
    "legend.framealpha": 1.0,
    "text.color": INK,
    "text.usetex": False,
    "xtick.labelsize": 8.5,
    "ytick.labelsize": 8.5,
}
"""What a user's own matplotlib settings must not change."""


def picture(path: Path, size: tuple[float, float], draw: Callable[[Figure], None]) -> Path:
    """Write a PNG file atomically.

    Args:
        path: Where it shall be.
        size: Width and height [inch]; a picture has 130 dots per inch.
        draw: Draws onto the empty figure.

    Returns:
        `path`.
    """
    data = io.BytesIO()
    with canvas(size) as sheet:
        draw(sheet.figure)
        sheet.print_png(data, metadata={"Software": f"rovernav {__version__}"})
    write_atomic(path, lambda file: cast(None, file.write(data.getvalue())))
    return path


@contextlib.contextmanager
def canvas(size: tuple[float, float], *, dpi: float = DPI) -> Generator[Any]:
    """An empty figure on a canvas without a window; our style holds as long as it is open.

    Args:
        size: Width and height [inch].
        dpi: Dots per inch.
    """
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with matplotlib.rc_context(cast(Any, STYLE)):
        yield FigureCanvasAgg(Figure(figsize=size, dpi=dpi, facecolor="white"))


def in_metres(axes: Axes) -> None:
    """Equal scales, and axes that say metres."""
    axes.set_aspect("equal", adjustable="box")
    axes.set_xlabel("x, east [m]")
    axes.set_ylabel("y, north [m]")


def heading(figure: Figure, text: str) -> None:
    """One line over everything, in smaller letters where it is long."""
    inches = figure.get_figwidth()
    size = min(12.0, 130.0 * inches / max(len(text), 1) * 0.9)
    y = 1 - 0.17 / figure.get_figheight()
    figure.text(0.5, y, plain(text), fontsize=size, ha="center", va="top", parse_math=False)


def plain(text: str) -> str:
    """The text without what no font has: a file's name may hold bytes that are no letters.

    Draw it with ``parse_math=False``, or dollars in it begin a formula.
    """
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)


def footer(figure: Figure, text: str) -> None:
    """Small print along the lower edge."""
    figure.text(0.015, 0.012, text, fontsize=7.5, color="#555555", va="bottom", ha="left")
