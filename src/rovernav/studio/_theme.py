"""Colours, spacing and type of all pages: light and dark, the palette of the printed figures."""

from __future__ import annotations

from pathlib import Path

from ..show import PALETTE

LOGO = Path(__file__).parent / "static" / "rovernav.svg"
RULES = Path(__file__).parent / "static" / "studio.css"
DARK = {
    "blue": "#4FA8E0",
    "orange": "#F0B23E",
    "green": "#2FC79B",
    "vermilion": "#FF8A4C",
    "sky": "#8CCDF2",
    "purple": "#E39CC0",
    "yellow": "#F0E442",
}
"""The same hues, lighter, for a dark page."""
_SHADES = {
    "light": {
        "ink": "#1d2630", "muted": "#5b6875", "line": "#d9dfe5", "panel": "#ffffff",
        "page": "#f3f5f7", "field": "#ffffff", "soft": "#eaf3f9",
    },
    "dark": {
        "ink": "#e8edf2", "muted": "#9fadba", "line": "#36414c", "panel": "#1b232b",
        "page": "#12181e", "field": "#232d37", "soft": "#1d3040",
    },
}  # fmt: skip


def style() -> str:
    """The style sheet of every page."""
    light = _variables(PALETTE, "light")
    dark = _variables(DARK, "dark")
    return f":root {{ {light} }}\nbody.body--dark {{ {dark} }}\n{RULES.read_text(encoding='utf-8')}"


def _variables(colours: dict[str, str], shade: str) -> str:
    names = {**colours, "red": colours["vermilion"], **_SHADES[shade]}
    return " ".join(f"--rn-{name}: {colour};" for name, colour in names.items())
