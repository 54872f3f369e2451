"""`rovernav inspect`: what is in a file, in words."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from ._console import Json, print_json, print_table, say


def inspect(
    file: Annotated[Path, Parameter(help="A network, trace or terrain file.")],
    *,
    cell: Annotated[float | None, Parameter(help="Cell of a .npy terrain [m].")] = None,
    json: Json = False,
) -> int:
    """Say what a network, trace or terrain file holds.

    Example: rovernav inspect rovernav-paper/network.safetensors
    """
    readers = {".safetensors": _network, ".npz": _trace}
    reader = readers.get(file.suffix.lower())
    report = reader(file) if reader else _terrain(file, cell)
    if json:
        print_json(report)
        return 0
    kind = report.pop("kind")
    tables = {key: report.pop(key) for key in list(report) if isinstance(report[key], list)}
    say(f"{file}: {kind}")
    print_table("", ("", "value"), [(key, _shown(item)) for key, item in report.items()])
    for title, rows in tables.items():
        if rows and isinstance(rows[0], dict):
            columns = list(rows[0])
            print_table(title, columns, [[_shown(row[c]) for c in columns] for row in rows])
    return 0


def _network(file: Path) -> dict[str, Any]:
    from ..nets import load_network, topology_text, weights_sha256

    network = load_network(file)
    card = network.card
    return {
        "kind": f"a {topology_text(network.topology)} network",
        "topology": topology_text(network.topology),
        "activations": ", ".join(network.activations),
        "parameters": len(network.parameters),
        "precision": str(network.parameters.dtype),
        "inputs": ", ".join(_with_units(card.inputs, card.input_units)) or "unnamed",
        "outputs": ", ".join(_with_units(card.outputs, card.output_units)) or "unnamed",
        "codec": "none" if card.codec is None else _pairs(card.codec),
        "training": "not stated" if card.training is None else _pairs(card.training),
        "seed of initial weights": "none" if card.seed is None else card.seed,
        "weights_sha256": weights_sha256(network),
        "layers": [
            {
                "layer": number,
                "weights": f"{matrix.shape[0]} x {matrix.shape[1]}",
                "smallest": float(matrix.min()),
                "largest": float(matrix.max()),
                "rms": float((matrix.astype(float) ** 2).mean() ** 0.5),
            }
            for number, matrix in enumerate(network.matrices, 1)
        ],
    }


def _trace(file: Path) -> dict[str, Any]:
    import numpy as np

    from ..core import Outcome
    from ..sim import load_trace

    trace = load_trace(file)
    counts = np.bincount(trace.outcome, minlength=len(Outcome))
    return {
        "kind": f"a trace of {len(trace.outcome)} drive(s)",
        "rovers": len(trace.outcome),
        "steps": int(trace.steps.max()),
        "time": f"{float(trace.time[-1].max()):.1f} s",
        "outcomes": ", ".join(f"{o.label} {counts[o]}" for o in Outcome if counts[o]),
        "start of the first": _point(trace.pose[0, 0]),
        "end of the first": _point(trace.path()[-1]),
        "length of the first": f"{float(trace.length[0]):.3f} m",
        "sensors": ", ".join(sorted(trace.channels)) or "none recorded",
        "seed": trace.seed,
        "settings": _pairs(trace.settings) or "none",
        "rovernav": trace.version,
    }


def _terrain(file: Path, cell: float | None) -> dict[str, Any]:
    import numpy as np

    from ..terrain import read_terrain, slope

    terrain = read_terrain(file, cell=cell)
    frame = terrain.frame
    width, height = frame.extent
    low, high = terrain.span
    steep = slope(terrain)
    degrees = np.degrees(steep[np.isfinite(steep)])
    at = np.percentile(degrees, (50, 95, 99)) if degrees.size else np.full(3, math.nan)
    east, north = frame.to_map(width, height)
    return {
        "kind": "an elevation model",
        "source": terrain.source,
        "cells": f"{frame.shape[1]} x {frame.shape[0]} (columns x rows)",
        "cell": f"{frame.cell:.6g} m",
        "size": f"{width:.6g} m x {height:.6g} m",
        "map coordinates": f"x {frame.origin[0]:.10g} to {east:.10g}, "
        f"y {frame.origin[1]:.10g} to {north:.10g}",
        "heights": f"{low:.6g} m to {high:.6g} m",
        "with data": f"{terrain.finite:.2%}",
        "slope p50 / p95 / p99": " / ".join(f"{s:.1f}" for s in at) + " deg",
        "coordinate system": _crs_name(frame.crs),
    }


def _crs_name(wkt: str | None) -> str:
    """The name that stands first in a WKT."""
    if not wkt:
        return "none"
    parts = wkt.split('"')
    return parts[1] if len(parts) > 2 else wkt[:60]


def _with_units(names: tuple[str, ...], units: tuple[str, ...]) -> list[str]:
    return [f"{n} [{u}]" for n, u in zip(names, units, strict=True)] if units else list(names)


def _pairs(mapping: Any) -> str:
    return ", ".join(f"{key} {_shown(item)}" for key, item in mapping.items())


def _point(pose: Any) -> str:
    return f"({float(pose[0]):.3f}, {float(pose[1]):.3f}) m"


def _shown(item: Any) -> str:
    return f"{item:.6g}" if isinstance(item, float) else str(item)
