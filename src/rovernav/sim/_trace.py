"""The trace of a drive: what is needed to redraw, score and replay it, saved without loss."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, final

import numpy as np

from .._version import __version__
from ..core import (
    F64,
    I8,
    I64,
    Command,
    FileError,
    Mission,
    Observation,
    Outcome,
    RovernavError,
    RoverState,
    SettingError,
    canonical_json,
    read_bytes,
    read_only,
    suggest,
    value,
    write_atomic,
)

FORMAT = "rovernav-trace"
VERSION = 2
"""Version 2 added the rovers' numbers, and how bodies stood, slipped and what they spent."""
READABLE = (1, 2)
MAX_BYTES = 4_000_000_000
RECORDS = ("all", "path", "none")
BODILY = ("attitude", "slip", "energy")
"""What only the trace of rovers with bodies has."""
_HEADER: dict[str, Any] = {
    "rovernav": str,
    "seed": int,
    "settings": dict,
    "goal_radius": (int, float),
    "time_limit": (int, float),
    "channels": list,
}


@value
class Trace:
    """What happened in a drive of n rovers over t steps.

    Attributes:
        time: Time of each rover at each step (t + 1, n) [s]; it stops when the rover ends.
        pose: Poses (t + 1, n, 3): x [m], y [m], heading [rad].
        commands: Body twists (t, n, 3) [m/s, m/s, rad/s].
        channels: Readings by sensor name, (t, n, b) each.
        mission: Starts and goals.
        outcome: `Outcome` codes (n,).
        steps: Steps each rover drove (n,).
        length: Distance each rover drove (n,) [m].
        seed: Seed of everything random in the drive.
        settings: Plain data that came with the drive.
        attitude: Height of the middle at the axles [m], pitch and roll [rad] (t + 1, n, 3);
            this and the next two are None for rovers without bodies.
        slip: Share of the wheels' way lost along, and that slides to the left (t + 1, n, 2).
        energy: Spent since the start (t + 1, n) [J].
        version: The rovernav that drove.
    """

    time: F64
    pose: F64
    commands: F64
    channels: Mapping[str, F64]
    mission: Mission
    outcome: I8
    steps: I64
    length: F64
    seed: int
    settings: Mapping[str, Any]
    attitude: F64 | None = None
    slip: F64 | None = None
    energy: F64 | None = None
    version: str = __version__

    def _check(self) -> None:
        frozen = {name: read_only(reading) for name, reading in self.channels.items()}
        object.__setattr__(self, "channels", MappingProxyType(frozen))

    def path(self, k: int = 0) -> F64:
        """Points (steps + 1, 2) of rover k [m], start and end included."""
        return self.pose[: int(self.steps[k]) + 1, k, :2]

    def believed(self, k: int = 0) -> F64 | None:
        """Where rover k thought it was at each step (steps, 2) [m]; None if it knew, by the truth.

        Point i belongs to point i of `path`. None too where the trace kept no readings.
        """
        told = self.channels.get("estimate")
        if told is None or not self.steps[k]:
            return None
        return told[: int(self.steps[k]), k, :2]

    def ended(self, k: int = 0) -> Outcome:
        """How rover k ended."""
        return Outcome(int(self.outcome[k]))


@final
class TraceBuilder:
    """Collects a trace step by step.

    Args:
        record: ``all``, ``path`` or ``none``.
        body: Whether the rovers have bodies, so that attitude, slip and energy are kept too.
    """

    def __init__(self, record: str, *, body: bool = False) -> None:
        if record not in RECORDS:
            raise SettingError(f"unknown record {record!r}; {suggest(record, RECORDS)}")
        self._record = record
        names = ("time", "pose", *BODILY) if body else ("time", "pose")
        self._states: dict[str, list[F64]] = {name: [] for name in names}
        self._commands: list[F64] = []
        self._channels: dict[str, list[F64]] = {}
        self._steps: I64 | None = None

    def add(
        self, rovers: RoverState, observation: Observation | None, command: Command | None
    ) -> None:
        """Keep one step; the first call is the start, without observation and command."""
        if self._steps is None:
            self._steps = np.zeros(len(rovers.pose), np.int64)
            self._driving = rovers.driving
        else:
            self._steps += self._driving
            self._driving = rovers.driving
        for name, rows in self._states.items():
            if self._record == "none":
                rows.clear()
            rows.append(getattr(rovers, name))
        if self._record == "all" and observation is not None and command is not None:
            self._commands.append(command.twist)
            for name, reading in observation.channels.items():
                self._channels.setdefault(name, []).append(reading)

    def join(self, others: Sequence[TraceBuilder]) -> None:
        """Add what was kept of the other parts of a batch, as if all had been kept together.

        A part whose rovers have ended stays as it is while others drive; commands and readings must
        be there for as many steps as the longest has.
        """
        parts = [self, *others]
        for name in self._states:
            self._states[name] = _side_by_side([part._states[name] for part in parts])
        for name in self._channels:
            self._channels[name] = _side_by_side([part._channels[name] for part in parts])
        self._commands = _side_by_side([part._commands for part in parts])
        steps = [part._steps for part in parts if part._steps is not None]
        self._steps = np.concatenate(steps)

    def finish(
        self, mission: Mission, rovers: RoverState, *, seed: int, settings: dict[str, Any]
    ) -> Trace:
        """The trace of all that was added."""
        assert self._steps is not None
        n = len(rovers.pose)
        states = {name: np.stack(rows) for name, rows in self._states.items()}
        return Trace(
            time=states["time"],
            pose=states["pose"],
            attitude=states.get("attitude"),
            slip=states.get("slip"),
            energy=states.get("energy"),
            commands=np.stack(self._commands) if self._commands else np.empty((0, n, 3)),
            channels={name: np.stack(rows) for name, rows in self._channels.items()},
            mission=mission,
            outcome=rovers.outcome,
            steps=self._steps,
            length=rovers.odometry,
            seed=seed,
            settings=settings,
        )


def _side_by_side(parts: Sequence[list[F64]]) -> list[F64]:
    """The rows of all parts at each step; those of a shorter part end with copies of its last."""
    count = max(len(rows) for rows in parts)
    out: list[F64] = []
    for step in range(count):
        at = [min(step, len(rows) - 1) for rows in parts]
        out.append(np.concatenate([rows[k] for rows, k in zip(parts, at, strict=True)]))
    return out


def save_trace(trace: Trace, path: Path) -> None:
    """Write a trace as ``.npz`` with a JSON header, atomically; nothing is lost.

    Raises:
        SettingError: The trace's settings are not plain data.
        FileError: The file cannot be written.
    """
    header = {
        "format": FORMAT,
        "version": VERSION,
        "rovernav": trace.version,
        "seed": trace.seed,
        "settings": dict(trace.settings),
        "goal_radius": trace.mission.goal_radius,
        "time_limit": trace.mission.time_limit,
        "channels": sorted(trace.channels),
        "units": {"time": "s", "pose": ["m", "m", "rad"], "commands": ["m/s", "m/s", "rad/s"],
                  "attitude": ["m", "rad", "rad"], "slip": ["1", "1"], "energy": "J"},
    }  # fmt: skip
    try:
        text = canonical_json(header)
    except (TypeError, ValueError) as error:
        raise SettingError(f"the settings of a trace must be plain data: {error}") from None
    arrays: dict[str, Any] = {
        "header": np.frombuffer(text.encode(), np.uint8),
        "time": trace.time,
        "pose": trace.pose,
        "commands": trace.commands,
        "start": trace.mission.start,
        "goal": trace.mission.goal,
        "number": trace.mission.number,
        "outcome": trace.outcome,
        "steps": trace.steps,
        "length": trace.length,
        **{f"channel:{name}": reading for name, reading in trace.channels.items()},
        **{name: getattr(trace, name) for name in BODILY if getattr(trace, name) is not None},
    }
    buffer = io.BytesIO()
    np.savez_compressed(buffer, allow_pickle=False, **arrays)
    write_atomic(path, lambda file: file.write(buffer.getvalue()) and None)


def load_trace(path: Path) -> Trace:
    """Read a trace that `save_trace` wrote.

    Raises:
        FileError: Missing, damaged, foreign or of another version.
    """
    header, arrays = _open(path, read_bytes(path, limit=MAX_BYTES, what="trace"))
    for field, kind in _HEADER.items():
        if not isinstance(header.get(field), kind):
            raise FileError(f"{path} is damaged: its header has no usable {field!r}")
    if header["version"] == 1:
        arrays["number"] = np.arange(len(np.atleast_1d(arrays.get("outcome", ()))))
    _check_arrays(path, header["channels"], arrays)
    try:
        return _from_arrays(header, arrays)
    except RovernavError as error:
        raise FileError(f"{path} is damaged: {error}") from None


def _open(path: Path, data: bytes) -> tuple[dict[str, Any], dict[str, Any]]:
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as file:
            if sum(member.file_size for member in file.zip.infolist()) > MAX_BYTES:
                raise FileError("unpacked, it is too large")
            arrays = {name: file[name] for name in file.files}
        header = json.loads(arrays.pop("header").tobytes())
        kind = header.get("format"), header.get("version")
    except Exception:  # zip, zlib, NumPy and JSON each have errors of their own for damage
        raise FileError(f"{path} is not a trace, or is damaged") from None
    if kind[0] != FORMAT or kind[1] not in READABLE:
        raise FileError(
            f"{path}: format must be {FORMAT!r} version {VERSION} or older, got "
            f"{kind[0]!r} version {kind[1]!r}"
        )
    return header, arrays


def _check_arrays(path: Path, channels: list[str], arrays: dict[str, Any]) -> None:
    """Raise `FileError` unless every array is there with its dtype and shape."""
    rows, n, steps = (
        len(np.atleast_1d(arrays.get(name, ()))) for name in ("time", "outcome", "commands")
    )
    wanted: dict[str, tuple[Any, tuple[int, ...]]] = {
        "time": (np.float64, (rows, n)),
        "pose": (np.float64, (rows, n, 3)),
        "commands": (np.float64, (steps, n, 3)),
        "start": (np.float64, (n, 3)),
        "goal": (np.float64, (n, 2)),
        "number": (np.int64, (n,)),
        "outcome": (np.int8, (n,)),
        "steps": (np.int64, (n,)),
        "length": (np.float64, (n,)),
        **{f"channel:{name}": (np.float64, (steps, n, -1)) for name in channels},
    }
    if any(name in arrays for name in BODILY):
        wanted |= {"attitude": (np.float64, (rows, n, 3)), "slip": (np.float64, (rows, n, 2)),
                   "energy": (np.float64, (rows, n))}  # fmt: skip
    for name in wanted:
        if name not in arrays:
            raise FileError(f"{path} is damaged: it has no {name!r}")
    for name, (dtype, shape) in wanted.items():
        got = arrays[name]
        same = all(a in (b, -1) for a, b in zip(shape, got.shape, strict=False))
        if got.dtype != dtype or got.ndim != len(shape) or not same:
            raise FileError(
                f"{path} is damaged: {name} must be {np.dtype(dtype)} {shape}, "
                f"got {got.dtype} {got.shape}"
            )
    if not np.isin(arrays["outcome"], list(Outcome)).all() or (arrays["steps"] < 0).any():
        raise FileError(f"{path} is damaged: an outcome or a number of steps is impossible")


def _from_arrays(header: dict[str, Any], arrays: dict[str, Any]) -> Trace:
    return Trace(
        time=arrays["time"],
        pose=arrays["pose"],
        commands=arrays["commands"],
        channels={name: arrays[f"channel:{name}"] for name in header["channels"]},
        mission=Mission(
            start=arrays["start"],
            goal=arrays["goal"],
            goal_radius=header["goal_radius"],
            time_limit=header["time_limit"],
            number=arrays["number"],
        ),
        outcome=arrays["outcome"],
        steps=arrays["steps"],
        length=arrays["length"],
        seed=header["seed"],
        settings=header["settings"],
        **{name: arrays[name] for name in BODILY if name in arrays},
        version=header["rovernav"],
    )
