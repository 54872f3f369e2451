"""A drive as a movie: an animated GIF, small enough to send."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..core import F64, U8, InputError, Sensor, write_atomic
from ..rover import Rover, Standing
from ..sim import Trace, Worlds
from ..terrain import Terrain
from ._map import window_around
from ._relief import Window
from ._stage import Moment, Place, Stage
from ._words import path_of

FRAMES = 120
"""Frames at most; steps in between are left out."""
SECONDS = 8.0
"""How long a movie lasts, unless it has few frames [s]."""
QUICKEST, SLOWEST = 0.05, 0.25
"""How long a frame stays [s]."""
REST = 2.5
"""How long the last one stays [s]."""
COLOURS = 128


def draw_movie(  # noqa: PLR0913 - each is a layer of the picture, by keyword
    trace: Trace,
    path: Path,
    *,
    terrain: Terrain | None = None,
    standing: Standing | None = None,
    worlds: Worlds | None = None,
    rover: Rover | None = None,
    sensors: Sequence[Sensor] = (),
    k: int = 0,
    frames: int = FRAMES,
    on_event: Callable[[float], object] | None = None,
) -> Path:
    """Write the drive of one rover as an animated GIF.

    Each frame shows the rover's footprint, its way so far, and the beams of its range sensors
    where the trace keeps their readings.

    Args:
        trace: The drive, in the local metres of the terrain.
        path: The GIF file.
        terrain: The ground, if any.
        standing: Where the rover could stand, drawn by reason.
        worlds: Where it was driven, for obstacles.
        rover: Whose footprint.
        sensors: What it carried; those with `angles` and `reach` have beams.
        k: Which rover of the trace.
        frames: How many frames at most.
        on_event: Told the share of frames that are done.

    Returns:
        `path`.

    Raises:
        InputError: The trace kept no path, or fewer than two frames are asked for.
        FileError: The file cannot be written.
    """
    if frames < 2:
        raise InputError(f"a movie has two frames or more, got {frames}")
    driven = path_of(trace, k)
    where = {"terrain": terrain, "standing": standing, "worlds": worlds, "rover": rover}
    title = "" if terrain is None else terrain.name
    stage = Stage(_place(trace, k, driven, title=title, **where))
    fans = [each for each in sensors if _has_beams(each) and each.name in trace.channels]
    steps = _chosen(len(driven) - 1, frames)
    eyes = [each for each in sensors if hasattr(each, "places") and each.name in trace.channels]
    pictures = (_moment(trace, k, step, driven, [*fans, *eyes]) for step in steps)
    shown = _told((stage.frame(moment) for moment in pictures), len(steps), on_event)
    data = _gif(list(shown), _pace(len(steps)))
    write_atomic(path, lambda file: file.write(data))
    return path


def window_of(points: F64, terrain: Terrain | None) -> Window:
    """A window [m] around points (p, 2): inside the terrain where there is one."""
    if terrain is not None:
        return window_around(points, terrain.frame)
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 0.12 * max(float((high - low).max()), 1.0)
    size = np.maximum(high - low, 0.6 * float((high - low).max())) + 2.0 * margin
    west, south = ((low + high - size) / 2.0).tolist()
    return west, south, west + float(size[0]), south + float(size[1])


def _place(trace: Trace, k: int, driven: F64, **more: Any) -> Place:
    start, goal = trace.mission.start[k, :2], trace.mission.goal[k]
    points = [driven, start[None], goal[None]]
    worlds: Worlds | None = more["worlds"]
    if more["terrain"] is None and worlds is not None:
        boxes = worlds.row(k).boxes
        points += [boxes[:, :2], boxes[:, 2:]]
        points += [each for shape in worlds.shapes_of(k) for each in shape.outline()]
    window = window_of(np.concatenate(points), more["terrain"])
    radius = trace.mission.goal_radius
    return Place(window=window, start=start, goal=goal, goal_radius=radius, k=k, **more)


def _chosen(last: int, frames: int) -> list[int]:
    """Steps to show: the first and the last, the others evenly between."""
    return sorted({round(s) for s in np.linspace(0.0, last, min(last + 1, frames)).tolist()})


def _has_beams(sensor: Any) -> bool:
    return hasattr(sensor, "angles") and hasattr(sensor, "reach")


def _moment(trace: Trace, k: int, step: int, driven: F64, fans: Sequence[Any]) -> Moment:
    last = len(driven) - 1
    pose = trace.pose[step, k]
    ends: list[F64] = [np.empty((0, 2))]
    met: list[Any] = [np.empty(0, bool)]
    seen = None
    for fan in fans:
        if hasattr(fan, "places"):
            seen = _seen(trace, k, step, fan)
        elif step < len(trace.channels[fan.name]) and step < last:
            reading = np.nan_to_num(trace.channels[fan.name][step, k], nan=0.0)
            turn = pose[2] + fan.angles
            ends.append(pose[:2] + reading[:, None] * np.stack([np.cos(turn), np.sin(turn)], 1))
            met.append((reading < fan.reach) & (reading > 0.0))
    words, believed = "", trace.believed(k)
    if believed is not None:
        believed = believed[: step + 1]
        off = float(np.hypot(*(believed[-1] - trace.pose[len(believed) - 1, k, :2])))
        words = f" · its estimate, the orange mark, is {off:.1f} m off"
    time = float(trace.time[step, k])
    length = float(np.hypot(*np.diff(driven[: step + 1], axis=0).T).sum())
    more: dict[str, Any] = {"ended": trace.ended(k)} if step == last else {}
    return Moment(
        path=driven[: step + 1], heading=float(pose[2]),
        words=f"{time:,.0f} s, {length:,.1f} m{words}",
        beams=np.concatenate(ends), met=np.concatenate(met), seen=seen,
        believed=believed, **more,
    )  # fmt: skip


def _seen(trace: Trace, k: int, step: int, eyes: Any) -> F64 | None:
    """Places (m, 2) [m] whose heights a patch tells at a step, every fifth of them."""
    if step >= len(trace.channels[eyes.name]):
        return None
    x, y, a = trace.pose[step, k]
    known = np.isfinite(trace.channels[eyes.name][step, k])
    forward, left = eyes.places[known][::5].T
    c, s = np.cos(a), np.sin(a)
    return np.stack([x + c * forward - s * left, y + s * forward + c * left], axis=1)


def _told(
    frames: Iterator[U8], count: int, on_event: Callable[[float], object] | None
) -> Iterator[U8]:
    for number, frame in enumerate(frames, 1):
        if on_event is not None:
            on_event(number / count)
        yield frame


def _pace(count: int) -> list[int]:
    """How long each frame stays [ms]."""
    each = min(SLOWEST, max(QUICKEST, SECONDS / count))
    return [*[round(100 * each) * 10] * (count - 1), round(1000 * REST)]


def _gif(frames: list[U8], stay: list[int]) -> bytes:
    """The frames as an animated GIF with one palette; only what changes is stored."""
    from PIL import Image

    middle = frames[len(frames) // 2]
    both = Image.fromarray(np.concatenate([middle, frames[-1]]))
    palette = both.quantize(COLOURS, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
    drawn = [
        Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE)
        for frame in frames
    ]
    out = io.BytesIO()
    drawn[0].save(
        out, "GIF", save_all=True, append_images=drawn[1:], duration=stay, loop=0, disposal=1,
        optimize=True,  # what stays the same becomes transparent
    )  # fmt: skip
    return out.getvalue()
