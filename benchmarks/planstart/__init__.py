"""The wait at the shell: a fresh process that reads 512 x 512 heights and plans a route."""

from __future__ import annotations

import contextlib
import io
import json
import tempfile
from pathlib import Path

import numpy as np
from harness.model import Peer, Result, Stopwatch, Target, Trial, Workload

WARM, PICTURE = "rovernav route, kernels cached", "the same with its picture"


def _heights() -> np.ndarray:
    """Rolling ground that is steep in places, in metres at one metre."""
    y, x = np.mgrid[0:512, 0:512] / 40.0
    return (6.0 * np.sin(x) * np.cos(1.3 * y) + 2.0 * np.sin(3.1 * x + y)).astype(np.float32)


def _build(*more: str) -> Trial:
    folder = Path(tempfile.mkdtemp())
    ground = folder / "ground.npy"
    np.save(ground, _heights())

    def trial(repeats: int) -> Result:
        from rovernav.cli import main

        watch, said = Stopwatch(), io.StringIO()
        words = ["route", str(ground), "--cell", "1", "--frame", "local", "--json"]
        words += ["--from", "20,30", "--to", "490,480", "--out", str(folder / "out"), *more]
        with watch, contextlib.redirect_stdout(said):
            for _ in range(repeats):
                main(words)
        return watch.result(repeats, float(json.loads(said.getvalue())["status"] == "found"))

    return trial


def _found(_group: str, _size: int) -> float:
    return 1.0


WORKLOAD = Workload(
    name="planstart",
    title="From the start of a fresh Python process to a route over 512 x 512 heights, as files.",
    unit="s",
    peers=(
        Peer(name=WARM, build=lambda _size: _build("--no-picture"), cache="warm"),
        Peer(name=PICTURE, build=lambda _size: _build(), cache="warm"),
    ),
    targets=(Target(row=WARM, limit=1.0),),
    anchors={WARM: "cached"},
    size=1,
    quick=1,
    scale=1.0,
    check="found",
    expected=_found,
    tolerance=0.0,
    fresh=True,
)
