"""A whole trace as one table: poses, commands and readings of every rover."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..core import F64, Outcome, write_text
from ..terrain import Terrain
from ._path import check_path

if TYPE_CHECKING:
    from ..sim import Trace

COMMANDS = ("command_forward_m_s", "command_left_m_s", "command_turn_rad_s")
BODY = ("height_m", "pitch_rad", "roll_rad", "slip_along", "slip_left", "energy_j")


def write_trace_csv(trace: Trace, path: Path, *, terrain: Terrain | None = None) -> None:
    """Write one line per rover and step, rover by rover, the start first.

    A line holds the pose at `time_s`, what was read and commanded there, and the outcome: that of
    the drive in a rover's last line, ``driving`` before. Columns: rover, step, time_s, x_m, y_m,
    heading_rad; with a terrain map_x, map_y, elevation_m; of rovers with bodies height_m (of the
    middle at the axles), pitch_rad (nose up), roll_rad (left side up), slip_along, slip_left and
    energy_j; where the trace keeps them
    command_forward_m_s, command_left_m_s, command_turn_rad_s and each reading of each sensor, like
    beams_0; outcome. The last line of a rover has no command and no readings. Numbers have all
    their digits.

    Args:
        trace: The drives.
        path: Where to write.
        terrain: The ground that was driven, if any.

    Raises:
        InputError: The trace keeps no path.
        FileError: The file cannot be written there.
    """
    for k in range(len(trace.outcome)):
        check_path(trace, k)
    header = ["rover", "step", "time_s", "x_m", "y_m", "heading_rad"]
    if terrain is not None:
        header += ["map_x", "map_y", "elevation_m"]
    if trace.attitude is not None:
        header += BODY
    if len(trace.commands):
        header += COMMANDS
        for name, reading in sorted(trace.channels.items()):
            header += [f"{name}_{i}" for i in range(reading.shape[2])]
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow([*header, "outcome"])
    for k in range(len(trace.outcome)):
        writer.writerows(_lines(trace, k, terrain))
    write_text(path, out.getvalue())


def _lines(trace: Trace, k: int, terrain: Terrain | None) -> Iterator[list[str]]:
    """The lines of rover k."""
    steps = int(trace.steps[k])
    poses = [trace.time[: steps + 1, k], *trace.pose[: steps + 1, k].T]
    if terrain is not None:
        x, y = trace.path(k).T
        poses += [*terrain.frame.to_map(x, y), terrain.elevation_at(x, y)]
    body = (trace.attitude, trace.slip, trace.energy)
    for of in body:
        if of is not None:
            poses += [*of[: steps + 1, k].reshape(steps + 1, -1).T]
    before = _numbers(np.stack([np.asarray(column, np.float64) for column in poses], axis=1))
    after: list[list[str]] = []
    if len(trace.commands):
        kept = [trace.commands[:steps, k]]
        kept += [reading[:steps, k] for _, reading in sorted(trace.channels.items())]
        both = np.concatenate(kept, axis=1)
        after = [*_numbers(both), [""] * both.shape[1]]
    driving, ended = Outcome.DRIVING.label, trace.ended(k).label
    for step in range(steps + 1):
        more = after[step] if after else []
        yield [str(k), str(step), *before[step], *more, ended if step == steps else driving]


def _numbers(rows: F64) -> list[list[str]]:
    return [[repr(cell) for cell in row] for row in rows.tolist()]
