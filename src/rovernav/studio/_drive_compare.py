"""Kept drives in the Runs tab: result, picture, and several on top of each other."""

from __future__ import annotations

import csv
import io
import tempfile
import threading
from collections.abc import Sequence
from html import escape
from pathlib import Path

import numpy as np
from nicegui import ui

from ..core import F64, Outcome, RovernavError
from ..scenes import Ground, read_scenario, set_scene
from ..show import draw_drive, draw_worlds
from ..sim import RangeFan, load_trace
from ._drive_keep import SCENARIO, TERRAIN, world_from
from ._drive_map import (
    COLOURS,
    DASHES,
    HIGH,
    WIDE,
    View,
    end_mark,
    ends_layer,
    frame_layer,
    ground_layer,
    world_layer,
)
from ._drive_setup import swatch
from ._drive_world import World
from ._library import Library, Run

COLUMNS = {
    "controller": "controller",
    "rover": "rover",
    "world": "world",
    "outcome": "outcome",
    "length_m": "length [m]",
    "detour": "detour",
    "time_s": "time [s]",
    "clearance_m": "clearance [m]",
    "max_slope_deg": "steepest [°]",
}
"""Keys of a drive's summary that a comparison shows."""
_DRAWING = threading.Lock()  # the plotting library keeps its settings for the whole process


def drive_result(run: Run) -> str:
    """What came out, in a few words."""
    told = run.summary
    return (
        f"{str(told.get('outcome', '')).replace('_', ' ')}, {told.get('length_m', 0.0):.2f} m, "
        f"{told.get('time_s', 0.0):.0f} s"
    )


def drive_png(library: Library, run: Run) -> bytes:
    """The picture that ``rovernav drive`` makes of it.

    Raises:
        RovernavError: Its ground cannot be read any more.
    """
    with tempfile.TemporaryDirectory() as name, _DRAWING:
        folder = Path(name)
        for file in (SCENARIO, TERRAIN, "trace.npz"):
            if file in run.files:
                (folder / file).write_bytes(library.file(run.id, file))
        scene, trace = set_scene(read_scenario(folder / SCENARIO)), load_trace(folder / "trace.npz")
        picture = folder / "drive.png"
        if not isinstance(scene, Ground):
            draw_worlds(trace, scene.worlds, picture, columns=1)
            return picture.read_bytes()
        fans = [each for each in scene.scene.sensors if isinstance(each, RangeFan)]
        steps = int(trace.steps[0])
        sensed = None
        if fans and steps:
            sensed = fans[0].points(trace.pose[:steps, 0], trace.channels[fans[0].name][:steps, 0])
        draw_drive(
            trace, picture, terrain=scene.terrain, standing=scene.standing, sensed=sensed,
            worlds=scene.scene.worlds,
        )  # fmt: skip
        return picture.read_bytes()


def compare_drives(library: Library, runs: Sequence[Run]) -> None:
    """Tracks on top of each other, with the obstacles where all drove in the same world."""
    tracks = [_track(library, run) for run in runs]
    worlds = [_world(run) for run in runs]
    same = worlds[0] if all(w is not None and w == worlds[0] for w in worlds) else None
    ui.html(overlay(tracks, [run.summary.get("outcome", "") for run in runs], same)).classes(
        "w-full rnd-canvas"
    )
    with ui.row().classes("gap-4"):
        for i, run in enumerate(runs):
            with ui.row().classes("items-center gap-1 no-wrap"):
                ui.html(swatch(i))
                ui.label(run.title).classes("rn-note")


def overlay(tracks: Sequence[F64], outcomes: Sequence[str], world: World | None) -> str:
    """Tracks (k, 2) [m] on top of each other, as SVG."""
    every = np.concatenate([track for track in tracks if len(track)] or [np.zeros((1, 2))])
    low, high = every.min(axis=0), every.max(axis=0)
    view = View.around((*low.tolist(), *high.tolist()), margin=0.35)
    parts = [ground_layer(view, "", None)]
    if world is not None:
        parts.append(world_layer(view, world))
    for i, (track, outcome) in enumerate(zip(tracks, outcomes, strict=True)):
        if not len(track):
            continue
        parts.append(
            f'<polyline points="{view.points(track)}" fill="none" stroke-width="3" '
            f'stroke="var(--rn-{COLOURS[i % 8]})" stroke-dasharray="{DASHES[i % 8]}" '
            'stroke-linejoin="round"/>'
        )
        known = {each.label: each for each in Outcome}
        parts.append(end_mark(*view.at(*track[-1]), known.get(outcome, Outcome.DRIVING)))
    if world is not None:
        parts.append(ends_layer(view, world))
    parts.append(frame_layer(view))
    words = escape(f"{len(tracks)} tracks")
    return (
        f'<svg viewBox="0 0 {WIDE:g} {HIGH:g}" width="100%" role="img" aria-label="{words}">'
        f"{''.join(parts)}</svg>"
    )


def _track(library: Library, run: Run) -> F64:
    """The path of a kept drive (k, 2), in the local frame [m]."""
    try:
        rows = csv.DictReader(io.StringIO(library.file(run.id, "path.csv").decode()))
        points = [(float(row["x_m"]), float(row["y_m"])) for row in rows]
    except (RovernavError, KeyError, ValueError):
        return np.empty((0, 2))
    return np.array(points, dtype=np.float64).reshape(-1, 2)


def _world(run: Run) -> World | None:
    try:
        return world_from(dict(run.settings), {})[0]
    except RovernavError:
        return None
