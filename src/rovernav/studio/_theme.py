"""Colours, spacing and type of all pages: light and dark, the palette of the printed figures."""

from __future__ import annotations

from pathlib import Path

from ..show import PALETTE

LOGO = Path(__file__).parent / "static" / "rovernav.svg"
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

_RULES = """
body { background: var(--rn-page); color: var(--rn-ink); }
.nicegui-content { padding: 0; }
.rn-page { width: 100%; max-width: 1880px; margin: 0 auto; padding: 10px 14px 20px; gap: 10px; }
.rn-head { background: var(--rn-panel); color: var(--rn-ink); border-bottom: 1px solid
  var(--rn-line); padding: 0 14px; gap: 14px; height: 48px; flex-wrap: nowrap;
  align-items: center; box-shadow: none; }
.rn-brand { font-weight: 650; font-size: 16px; letter-spacing: -.01em; white-space: nowrap; }
.rn-card { background: var(--rn-panel); border: 1px solid var(--rn-line); border-radius: 8px;
  padding: 10px 12px; gap: 8px; box-shadow: none; color: var(--rn-ink); }
.rn-title { font-size: 13px; font-weight: 650; letter-spacing: .01em; line-height: 1.3; margin: 0; }
.rn-note { font-size: 12px; line-height: 1.4; color: var(--rn-muted); }
.rn-num { font-variant-numeric: tabular-nums; }
.rn-mono { font-family: ui-monospace, "DejaVu Sans Mono", monospace; font-size: 12px; }
.rn-bad { color: var(--rn-red); }
.rn-good { color: var(--rn-green); }
.q-tab { min-height: 48px; text-transform: none; }
.q-tab__label { font-size: 14px; font-weight: 600; }
.q-btn { text-transform: none; font-weight: 600; letter-spacing: 0; }
.q-field--dense .q-field__control, .q-field--dense .q-field__marginal { min-height: 34px;
  height: 34px; }
.q-field--dense.q-field--labeled .q-field__control-container { padding-top: 14px; }
.q-field--dense .q-field__label { top: 8px; font-size: 13px; }
.q-field__native, .q-field__prefix, .q-field__suffix, .q-field__input { color: var(--rn-ink); }
.q-field__label { color: var(--rn-muted); }
.q-field__messages { line-height: 1.25; font-size: 11.5px; }
.q-tab-panels, .q-tab-panel { background: transparent; padding: 0; }
.q-menu, .q-dialog .q-card { background: var(--rn-panel); color: var(--rn-ink); }
.q-table__card { background: transparent; color: var(--rn-ink); }
:focus-visible { outline: 2px solid var(--rn-blue) !important; outline-offset: 1px; }
table.rn-table { border-collapse: collapse; font-size: 12.5px; font-variant-numeric: tabular-nums; }
table.rn-table th { font-weight: 600; text-align: left; color: var(--rn-muted); }
table.rn-table th, table.rn-table td { padding: 3px 8px; border-bottom: 1px solid var(--rn-line);
  vertical-align: top; }
table.rn-table td.n, table.rn-table th.n { text-align: right; }
svg text { fill: var(--rn-ink); font-family: Roboto, "DejaVu Sans", sans-serif; }
.nicegui-error-popup { top: 0 !important; bottom: auto !important; left: 0 !important;
  right: 0 !important; width: 100% !important; max-width: none !important; border-radius: 0
  !important; transform: none !important; background: #8a3b00 !important; color: #fff
  !important; font-weight: 600; text-align: center; padding: 12px !important; z-index: 9999;
  margin: 0 !important; }
.nicegui-error-popup[aria-hidden="true"] { display: none !important; }
@media (prefers-reduced-motion: reduce) { * { transition: none !important;
  animation: none !important; } }
"""


def style() -> str:
    """The style sheet of every page."""
    light = _variables(PALETTE, "light")
    dark = _variables(DARK, "dark")
    return f":root {{ {light} }}\nbody.body--dark {{ {dark} }}\n{_RULES}"


def _variables(colours: dict[str, str], shade: str) -> str:
    names = {**colours, "red": colours["vermilion"], **_SHADES[shade]}
    return " ".join(f"--rn-{name}: {colour};" for name, colour in names.items())
