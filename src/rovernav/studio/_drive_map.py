"""The map of the Drive tab as layers of SVG: ground, obstacles, tracks, and the moment shown.

Everything in them is made of our numbers and of escaped words; nothing is loaded from elsewhere.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Sequence
from html import escape
from typing import Any

import numpy as np

from ..core import F64, Outcome
from ._drive_run import DriveRun
from ._drive_world import Obstacle, World

WIDE, HIGH = 1000.0, 620.0
"""Size of the drawing; the page scales it to the room there is."""
COLOURS = ("blue", "orange", "green", "purple", "vermilion", "sky", "yellow", "ink")
DASHES = ("", "14 5", "3 5", "14 4 3 4", "8 4", "2 3", "20 6", "6 6")
"""Tracks differ by colour and by dash, for all eyes."""
HALO = "var(--rn-panel)"
Window = tuple[float, float, float, float]


@dataclasses.dataclass(frozen=True)
class View:
    """Which part of the world the map shows.

    Attributes:
        west: Left edge [m].
        north: Upper edge [m].
        scale: Drawing units per metre.
    """

    west: float
    north: float
    scale: float

    @classmethod
    def around(cls, window: Window, *, margin: float = 0.0) -> View:
        """The view that shows all of a window, in its middle."""
        west, south, east, north = window
        width, height = max(east - west, 1e-6), max(north - south, 1e-6)
        scale = min(WIDE / (width * (1 + margin)), HIGH / (height * (1 + margin)))
        return cls(
            west=(west + east - WIDE / scale) / 2, north=(south + north + HIGH / scale) / 2,
            scale=scale,
        )  # fmt: skip

    @property
    def window(self) -> Window:
        """West, south, east, north [m]."""
        return (
            self.west,
            self.north - HIGH / self.scale,
            self.west + WIDE / self.scale,
            self.north,
        )

    def zoomed(self, factor: float, x: float = WIDE / 2, y: float = HIGH / 2) -> View:
        """Magnified by a factor; the place at the drawing's (x, y) stays where it is."""
        px, py = self.place(x, y)
        scale = min(max(self.scale * factor, 1e-4), 2000.0)
        return View(west=px - x / scale, north=py + y / scale, scale=scale)

    def moved(self, dx: float, dy: float) -> View:
        """Moved by drawing units."""
        return dataclasses.replace(
            self, west=self.west - dx / self.scale, north=self.north + dy / self.scale
        )

    def place(self, x: float, y: float) -> tuple[float, float]:
        """The place in the world at a point of the drawing [m]."""
        return self.west + x / self.scale, self.north - y / self.scale

    def at(self, x: Any, y: Any) -> tuple[Any, Any]:
        """The point of the drawing at a place, or the points at many."""
        return (x - self.west) * self.scale, (self.north - y) * self.scale

    def points(self, places: Iterable[Sequence[float]]) -> str:
        """Places as the points of an SVG line, one decimal each."""
        array = np.array([p[:2] for p in places], dtype=np.float64).reshape(-1, 2)
        x, y = (array[:, 0] - self.west) * self.scale, (self.north - array[:, 1]) * self.scale
        return " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))


def ground_layer(view: View, picture: str, window: Window | None) -> str:
    """What lies below everything: the relief where there is one, and a grid of round metres."""
    parts = [f'<rect width="{WIDE:g}" height="{HIGH:g}" fill="var(--rn-field)"/>']
    if picture and window is not None:
        (x0, y0), (x1, y1) = view.at(window[0], window[3]), view.at(window[2], window[1])
        parts.append(
            f'<image href="{picture}" x="{x0:.2f}" y="{y0:.2f}" width="{x1 - x0:.2f}" '
            f'height="{y1 - y0:.2f}" preserveAspectRatio="none" '
            f'style="image-rendering:{"pixelated" if view.scale > 30 else "auto"}"/>'
        )
    else:
        parts.append(_grid(view))
    return "".join(parts)


def frame_layer(view: View) -> str:
    """Numbers along the edges, and a scale bar with an arrow to the north."""
    step = _round_length(110.0 / view.scale)
    west, south, east, north = view.window
    parts = []
    for x in np.arange(math.ceil(west / step), math.floor(east / step) + 1) * step:
        px = view.at(x, 0)[0]
        if 18 < px < WIDE - 18:
            parts.append(_text(px, HIGH - 6, f"{x:g}", "middle"))
    for y in np.arange(math.ceil(south / step), math.floor(north / step) + 1) * step:
        py = view.at(0, y)[1]
        if 18 < py < HIGH - 26:
            parts.append(_text(5, py + 4, f"{y:g}", "start"))
    length = _round_length(0.16 * (east - west))
    wide = length * view.scale
    x, y = WIDE - 24 - wide, HIGH - 34
    words = f"{length / 1000:g} km" if length >= 1000 else f"{length:g} m"
    parts.append(
        f'<g opacity=".92"><rect x="{x - 12:.1f}" y="{y - 22}" width="{wide + 24:.1f}" height="32" '
        f'rx="4" fill="{HALO}"/><path d="M{x:.1f} {y - 3}v6h{wide:.1f}v-6" fill="none" '
        'stroke="var(--rn-ink)" stroke-width="2"/></g>'
        + _text(x + wide / 2, y - 6, words, "middle", halo=False)
    )
    parts.append(
        f'<g opacity=".92"><rect x="{WIDE - 42}" y="12" width="30" height="42" rx="4" '
        f'fill="{HALO}"/><path d="M{WIDE - 27} 18l6 14l-6 -3l-6 3z" fill="var(--rn-ink)"/></g>'
        + _text(WIDE - 27, 48, "N", "middle", halo=False)
    )
    return "".join(parts)


def world_layer(view: View, world: World, *, grown: float = 0.0, chosen: int | None = None) -> str:
    """Obstacles, and the straight line from start to goal."""
    parts = [
        obstacle_shape(view, each, grown=grown, chosen=i == chosen)
        for i, each in enumerate(world.obstacles)
    ]
    (ax, ay), (bx, by) = view.at(*world.start), view.at(*world.goal)
    parts.append(
        f'<line x1="{ax:.1f}" y1="{ay:.1f}" x2="{bx:.1f}" y2="{by:.1f}" stroke="var(--rn-ink)" '
        'stroke-width="1.2" stroke-dasharray="2 6" opacity=".75"/>'
    )
    return "".join(parts)


def ends_layer(view: View, world: World) -> str:
    """Start and goal, above the tracks."""
    start, goal = view.at(*world.start), view.at(*world.goal)
    return _mark(*start, "A", "start") + _mark(*goal, "B", "goal")


def obstacle_shape(
    view: View, obstacle: Obstacle, *, grown: float = 0.0, chosen: bool = False, draft: bool = False
) -> str:
    """An obstacle, and around it what the rover's middle keeps off."""
    edge = "var(--rn-vermilion)" if chosen else "var(--rn-ink)"
    style = (
        f'fill="var(--rn-muted)" fill-opacity="{0.25 if draft else 0.62}" stroke="{edge}" '
        f'stroke-width="{2.5 if chosen else 1.2}"' + (' stroke-dasharray="5 4"' if draft else "")
    )
    n = obstacle.numbers
    wide = 2 * grown * view.scale
    around = (
        f'fill="none" stroke="var(--rn-muted)" stroke-opacity=".3" stroke-width="{wide:.1f}" '
        'stroke-linejoin="round"'
    )
    if obstacle.kind == "circle":
        x, y = view.at(n[0], n[1])
        body = f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{n[2] * view.scale:.1f}" '
    else:
        corners = (
            [(n[0], n[1]), (n[2], n[1]), (n[2], n[3]), (n[0], n[3])]
            if obstacle.kind == "box"
            else list(zip(n[::2], n[1::2], strict=True))
        )
        body = f'<polygon points="{view.points(corners)}" fill-rule="evenodd" '
    return (f"{body}{around}/>" if wide > 1.0 else "") + f"{body}{style}/>"


def tracks_layer(view: View, runs: Sequence[DriveRun], focus: int) -> str:
    """All ways driven so far, thin; the end of each as a mark."""
    parts = []
    for i, run in enumerate(runs):
        colour, dash = f"var(--rn-{COLOURS[i % 8]})", DASHES[i % 8]
        points = view.points(_thinned(run.poses))
        wide = 3.0 if i == focus else 2.0
        parts.append(
            f'<polyline points="{points}" fill="none" stroke="{HALO}" stroke-width="{wide + 3}" '
            'stroke-linejoin="round" opacity=".7"/>'
            f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="{wide}" '
            f'stroke-dasharray="{dash}" stroke-linejoin="round" opacity=".55"/>'
        )
        if run.ended:
            parts.append(end_mark(*view.at(*run.poses[-1][:2]), run.outcome))
    return "".join(parts)


def moment_layer(view: View, runs: Sequence[DriveRun], seconds: float, focus: int) -> str:
    """The rovers at a time: the way so far, beams and what was sensed of the one in focus."""
    parts = []
    if 0 <= focus < len(runs):
        parts.append(_senses(view, runs[focus], runs[focus].step_at(seconds)))
    for i, run in enumerate(runs):
        step = run.step_at(seconds)
        colour = f"var(--rn-{COLOURS[i % 8]})"
        way = view.points(_thinned(run.poses[: step + 1]))
        parts.append(
            f'<polyline points="{way}" fill="none" stroke="{colour}" '
            f'stroke-width="{4 if i == focus else 3}" stroke-linejoin="round" '
            f'stroke-dasharray="{"" if i == focus else DASHES[i % 8]}"/>'
        )
        parts.append(_rover(view, run, step, colour))
    return "".join(parts)


def _senses(view: View, run: DriveRun, step: int) -> str:
    x, y = view.at(*run.poses[step][:2])
    dots = "".join(
        f'<circle cx="{px:.1f}" cy="{py:.1f}" r="1.8"/>'
        for px, py in (view.at(*p) for p in run.sensed(step))
    )
    parts = [f'<g fill="{_INK[run.ground is None]}" opacity=".85">{dots}</g>']
    rays = "".join(
        f'<line x1="{x:.1f}" y1="{y:.1f}" x2="{px:.1f}" y2="{py:.1f}" '
        f'stroke="var(--rn-{"vermilion" if met else "sky"})" opacity="{0.6 if met else 0.3}"/>'
        for (px, py), met in ((view.at(a, b), met) for a, b, met in run.beams(step))
    )
    parts.append(f'<g stroke-width="1">{rays}</g>')
    sight = run.moment(step).channels.get("clear_sight")
    if sight is not None:  # the paper's sensor looks along the straight line to the goal
        gx, gy = view.at(*run.scene.mission.goal[0])
        clear = sight[0] == 1.0
        parts.append(
            f'<line x1="{x:.1f}" y1="{y:.1f}" x2="{gx:.1f}" y2="{gy:.1f}" stroke-width="2.2" '
            f'stroke="var(--rn-{"green" if clear else "vermilion"})" '
            f'stroke-dasharray="{"" if clear else "7 5"}" opacity=".85"/>'
        )
    return "".join(parts)


_INK = {True: "var(--rn-ink)", False: "#111"}
"""What stands out: on the page's own colour, and on relief, which is light on any page."""


def _rover(view: View, run: DriveRun, step: int, colour: str) -> str:
    (x, y), heading = view.at(*run.poses[step][:2]), run.poses[step][2]
    turn = f'transform="translate({x:.1f} {y:.1f}) rotate({-math.degrees(heading):.1f})"'
    style = f'fill="{colour}" stroke="{HALO}" stroke-width="1.6"'
    if run.rover.is_point:
        return f'<g {turn}><circle r="7" {style}/><path d="M2 -3.5L7 0L2 3.5z" fill="{HALO}"/></g>'
    wide = max(run.rover.length * view.scale, 16.0)
    high = max(run.rover.width * view.scale, 11.0)
    nose = f'<path d="M{wide * 0.1:.1f} {-high * 0.3:.1f}L{wide * 0.42:.1f} 0L{wide * 0.1:.1f} '
    return (
        f'<g {turn}><rect x="{-wide / 2:.1f}" y="{-high / 2:.1f}" width="{wide:.1f}" '
        f'height="{high:.1f}" rx="3" {style}/>{nose}{high * 0.3:.1f}z" fill="{HALO}"/></g>'
    )


def end_mark(x: float, y: float, outcome: Outcome) -> str:
    """How a drive ended: a green disc, a red cross, or a blue square."""
    halo = f'stroke="{HALO}" stroke-width="1.5"'
    if outcome is Outcome.REACHED:
        return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="6" fill="var(--rn-green)" {halo}/>'
    if outcome in (Outcome.COLLIDED, Outcome.TIPPED, Outcome.HIGH_CENTRED):
        cross = f'<path d="M{x - 8:.1f} {y - 8:.1f}l16 16m0 -16l-16 16" fill="none" stroke-width='
        return f'{cross}"7" stroke="{HALO}"/>{cross}"4" stroke="var(--rn-vermilion)"/>'
    box = f'<rect x="{x - 5.5:.1f}" y="{y - 5.5:.1f}" width="11" height="11" '
    return f'{box}fill="var(--rn-blue)" {halo}/>'


def _mark(x: float, y: float, letter: str, words: str) -> str:
    return (
        f'<g><title>{words}</title><circle cx="{x:.1f}" cy="{y:.1f}" r="10.5" '
        f'fill="{HALO}" stroke="var(--rn-ink)" stroke-width="1.8"/>'
        f'<text x="{x:.1f}" y="{y + 4.6:.1f}" text-anchor="middle" font-size="13" '
        f'font-weight="700">{letter}</text></g>'
    )


def _text(x: float, y: float, words: str, anchor: str, *, halo: bool = True) -> str:
    around = f'style="paint-order:stroke;stroke:{HALO};stroke-width:3.5px"' if halo else ""
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" font-size="12.5" {around}>'
        f"{escape(words)}</text>"
    )


def _grid(view: View) -> str:
    step = _round_length(55.0 / view.scale)
    west, south, east, north = view.window
    lines = []
    for x in np.arange(math.ceil(west / step), math.floor(east / step) + 1) * step:
        lines.append(f"M{view.at(x, 0)[0]:.1f} 0V{HIGH:g}")
    for y in np.arange(math.ceil(south / step), math.floor(north / step) + 1) * step:
        lines.append(f"M0 {view.at(0, y)[1]:.1f}H{WIDE:g}")
    return f'<path d="{"".join(lines)}" stroke="var(--rn-line)" stroke-width="1" fill="none"/>'


def _round_length(length: float) -> float:
    """The largest of 1, 2 or 5 times a power of ten that is not above `length`."""
    power = 10.0 ** math.floor(math.log10(length))
    return next(n * power for n in (5.0, 2.0, 1.0) if n * power <= length * (1 + 1e-9))


def _thinned(poses: Sequence[tuple[float, float, float]], most: int = 600) -> F64:
    array = np.array(poses, dtype=np.float64)
    if len(array) <= most:
        return array
    every = math.ceil(len(array) / most)
    return np.concatenate([array[:-1:every], array[-1:]])
