"""What `rovernav inspect` says about elevation models and about maps of free and blocked cells."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ._console import print_pairs, say

if TYPE_CHECKING:
    from ..terrain import Raster

WHOLE = 25_000_000
"""A model with more cells is looked at in nine places."""
PLACE = 600
"""Cells along a side of such a place."""


def read_ground(file: Path, given: Mapping[str, Any]) -> dict[str, Any]:
    """What an elevation model holds, and how far its heights can be trusted."""
    import numpy as np

    from ..terrain import open_raster, quality

    raster = open_raster(
        file, cell=given["cell"], heights=given["heights"],
        south_first=bool(given["south-first"]),
    )  # fmt: skip
    seen = _seen(raster)
    degrees = seen["degrees"]
    at = np.percentile(degrees, (50, 95, 99)) if degrees.size else np.full(3, math.nan)
    told = raster.describe()
    found = quality(raster)
    return {
        **told,
        "lowest_m": seen["low"],
        "highest_m": seen["high"],
        "with_data": 1.0 - found.holes,
        "slope_deg": dict(zip(("p50", "p95", "p99"), map(float, at), strict=True)),
        "sampled": seen["sampled"],
        "crs": _crs_name(raster.frame.crs),
        "quality": found.report(),
    }


def _seen(raster: Raster) -> dict[str, Any]:
    """Slopes and heights of all of a model, or of nine places of a large one."""
    import numpy as np

    from ..core import InputError
    from ..terrain import Window, read_part, slope

    h, w = raster.frame.shape
    if h * w <= WHOLE:
        terrains = [read_part(raster, None, 1)]
    else:
        rows, columns = min(PLACE, h), min(PLACE, w)
        terrains: list[Any] = []
        for i in range(3):
            for j in range(3):
                window = Window(
                    row=round((h - rows) * (i + 0.5) / 3), rows=rows,
                    column=round((w - columns) * (j + 0.5) / 3), columns=columns,
                )  # fmt: skip
                try:
                    terrains.append(raster.read(window))
                except InputError:  # a hole
                    continue
    steep = [slope(terrain).ravel() for terrain in terrains]
    degrees = np.degrees(np.concatenate([*steep, np.empty(0, np.float32)]))
    spans = [terrain.span for terrain in terrains] or [(math.nan, math.nan)]
    return {
        "degrees": degrees[np.isfinite(degrees)],
        "low": min(low for low, _ in spans),
        "high": max(high for _, high in spans),
        "sampled": h * w > WHOLE,
    }


def print_ground(file: Path, report: dict[str, Any]) -> None:
    """The report on an elevation model in words."""
    say(f"{file}: an elevation model\n")
    x0, y0, x1, y1 = report["bounds"]
    width, height = report["size_m"]
    slopes = " / ".join(f"{deg:.1f}" for deg in report["slope_deg"].values())
    some = " (of nine places)" if report["sampled"] else ""
    pairs = [
        ("source", report["source"]),
        ("cells", f"{report['columns']:,} x {report['rows']:,} (columns x rows)"),
        ("cell", f"{report['cell_m']:.6g} m"),
        ("size", f"{width:.6g} m x {height:.6g} m"),
        ("x", f"{x0:.10g} to {x1:.10g}"),
        ("y", f"{y0:.10g} to {y1:.10g}"),
        ("heights", f"{report['lowest_m']:.6g} m to {report['highest_m']:.6g} m{some}"),
        ("with data", f"{report['with_data']:.2%}"),
        ("slope p50 / p95 / p99", f"{slopes} deg{some}"),
        ("coordinate system", report["crs"] or "none"),
    ]
    if report["resampled"]:
        columns, rows = report["posts"]
        pairs.insert(2, ("posts of the file", f"{columns:,} x {rows:,}"))
    pairs += [("note", note) for note in report["notes"]]
    flags = report["quality"]["flags"]
    pairs += [("beware" if n == 0 else "", flag) for n, flag in enumerate(flags)]
    print_pairs(pairs)


def read_map(file: Path, given: Mapping[str, Any]) -> dict[str, Any]:
    """What a map of free and blocked cells holds."""
    from ..terrain import read_occupancy

    found = read_occupancy(file, world=given["world"])
    frame = found.frame
    return {
        "source": found.source,
        "columns": frame.shape[1],
        "rows": frame.shape[0],
        "cell_m": frame.cell,
        "size_m": frame.extent,
        "origin": frame.origin,
        "blocked": found.share,
        "unknown": float(1.0 - found.known.mean()),
        "discs": len(found.discs),
    }


def print_map(file: Path, report: dict[str, Any]) -> None:
    """The report on a map in words."""
    say(f"{file}: a map of free and blocked cells\n")
    width, height = report["size_m"]
    x, y = report["origin"]
    pairs = [
        ("source", report["source"]),
        ("cells", f"{report['columns']:,} x {report['rows']:,} (columns x rows)"),
        ("cell", f"{report['cell_m']:.6g} m"),
        ("size", f"{width:.6g} m x {height:.6g} m"),
        ("south-west corner", f"({x:.6g}, {y:.6g})"),
        ("blocked or unknown", f"{report['blocked']:.2%}"),
        ("unknown", f"{report['unknown']:.2%}"),
    ]
    if report["discs"]:
        pairs.append(("discs", f"{report['discs']:,}"))
    print_pairs(pairs)


def _crs_name(wkt: str | None) -> str | None:
    """The name that stands first in a WKT."""
    if not wkt:
        return None
    parts = wkt.split('"')
    return parts[1] if len(parts) > 2 else wkt[:60]
