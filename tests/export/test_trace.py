from __future__ import annotations

import csv
import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rovernav.core import Frame, InputError
from rovernav.export import write_trace_csv
from rovernav.sim import ClearSight, RangeFan, Trace, simulate
from rovernav.terrain import Terrain
from tests.sim.drives import Always, drive

STARTS = ((1.0, 2.0, 0.3), (9.0, 0.0, 0.0), (10.0, 0.0, 0.0))
COMMANDS = ["command_forward_m_s", "command_left_m_s", "command_turn_rad_s"]


def driven(**more: Any) -> Trace:
    """Three rovers whose drives are of different lengths; the last is there already."""
    sensors = (RangeFan(reach=4.0, beams=3), ClearSight())
    boxes = ((3.0, 1.0, 4.0, 4.0), (9.9, -1.0, 9.95, 1.0))
    return simulate(
        drive(Always(0.25, 0.1, 0.0), *boxes, starts=STARTS, limit=6.0, sensors=sensors), **more
    )


def read(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def test_every_bit_of_every_rover_comes_back(tmp_path: Path) -> None:
    trace = driven()
    write_trace_csv(trace, tmp_path / "deep/t.csv")
    rows = read(tmp_path / "deep/t.csv")
    beams = [f"beams_{i}" for i in range(3)]
    assert list(rows[0]) == [
        "rover", "step", "time_s", "x_m", "y_m", "heading_rad", *COMMANDS, *beams,
        "clear_sight_0", "outcome",
    ]  # fmt: skip
    assert len(set(trace.steps.tolist())) == 3
    for k in range(3):
        mine = [row for row in rows if row["rover"] == str(k)]
        last = int(trace.steps[k])
        assert [int(row["step"]) for row in mine] == list(range(last + 1))
        got = np.array([[float(row[c]) for c in ("x_m", "y_m", "heading_rad")] for row in mine])
        assert np.array_equal(got, trace.pose[: last + 1, k])
        assert [float(row["time_s"]) for row in mine] == trace.time[: last + 1, k].tolist()
        for columns, wanted in ((COMMANDS, trace.commands), (beams, trace.channels["beams"])):
            got = [[float(row[c]) for c in columns] for row in mine[:-1]]
            assert np.array_equal(np.reshape(got, (last, 3)), wanted[:last, k])
            assert {mine[-1][c] for c in columns} == {""}
        assert [row["outcome"] for row in mine[:-1]] == ["driving"] * last
        assert mine[-1]["outcome"] == trace.ended(k).label


def test_a_path_alone_has_neither_commands_nor_readings(tmp_path: Path) -> None:
    frame = Frame(cell=0.5, shape=(24, 40), origin=(100.25, -7.5))
    ground = Terrain.from_heights(np.ones((24, 40)), frame, name="flat", source="a test")
    write_trace_csv(driven(record="path"), tmp_path / "t.csv", terrain=ground)
    rows = read(tmp_path / "t.csv")
    assert list(rows[0])[6:] == ["map_x", "map_y", "elevation_m", "outcome"]
    assert (rows[0]["map_x"], rows[0]["map_y"]) == ("101.25", "-5.5")


def test_rovers_with_bodies_tell_how_they_stood_slipped_and_spent(tmp_path: Path) -> None:
    trace = driven()
    rng = np.random.default_rng(0)
    shape = trace.time.shape
    trace = dataclasses.replace(
        trace, attitude=rng.normal(size=(*shape, 3)), slip=rng.normal(size=(*shape, 2)),
        energy=rng.normal(size=shape),
    )  # fmt: skip
    write_trace_csv(trace, tmp_path / "t.csv")
    rows = [row for row in read(tmp_path / "t.csv") if row["rover"] == "1"]
    names = ["height_m", "pitch_rad", "roll_rad", "slip_along", "slip_left", "energy_j"]
    assert list(rows[0])[6:12] == names
    got = np.array([[float(row[name]) for name in names] for row in rows])
    last = int(trace.steps[1]) + 1
    assert trace.attitude is not None
    assert trace.slip is not None
    assert trace.energy is not None
    kept = (trace.attitude[:last, 1], trace.slip[:last, 1], trace.energy[:last, 1, None])
    assert np.array_equal(got, np.concatenate(kept, axis=1))


def test_ends_alone_are_no_table(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="record 'path' or 'all'"):
        write_trace_csv(driven(record="none"), tmp_path / "t.csv")
    assert list(tmp_path.iterdir()) == []
