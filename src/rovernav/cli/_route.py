"""`rovernav route`: the way over an elevation model, or all ways of a MovingAI file."""

from __future__ import annotations

import math
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from ._console import print_json, progress_bar, say, say_files
from ._files import claim_folder, keep_apart
from ._options import Cell, InFile, Json, Out
from ._place import to_point

if TYPE_CHECKING:
    from ..plan import Route, Scenarios
    from ..rover import Standing
    from ..terrain import Terrain

PICTURE = "route.png"
FILES = ("route.csv", "route.geojson", PICTURE)
MAP = ".map"


def route(
    ground: Annotated[
        InFile, Parameter(help="Elevation model (GeoTIFF, .npy, meta.json) or a MovingAI .map.")
    ],
    /,
    *,
    start: Annotated[
        str | None,
        Parameter(name="--from", allow_leading_hyphen=True, help="Start X,Y, like -3.5,1.2."),
    ] = None,
    goal: Annotated[
        str | None, Parameter(name="--to", allow_leading_hyphen=True, help="Goal X,Y.")
    ] = None,
    frame: Annotated[
        str | None,
        Parameter(help="What X,Y are: crs (the model's own, default), local [m] or pixel."),
    ] = None,
    rover: Annotated[str | None, Parameter(help="Preset or rover file; default research.")] = None,
    cell: Cell | None = None,
    scen: Annotated[
        InFile | None, Parameter(help="MovingAI scenarios for a .map; solves every one.")
    ] = None,
    picture: Annotated[
        bool, Parameter(negative="--no-picture", help="Draw route.png too; takes half a second.")
    ] = True,
    out: Out = Path("rovernav-route"),
    json: Json = False,
) -> int:
    """Find the shortest way over ground on which a rover can stand.

    Writes route.png, route.csv and route.geojson. That there is no way is an answer, with its
    reason, and no error: the exit code is 0. With a MovingAI map and --scen it solves every
    scenario of the file instead, over the eight neighbours without corner cutting, compares with
    the published lengths, and writes no file.

    Example: rovernav route yard.tif --from -3.5,1.2 --to 8,5 --rover sojourner
    """
    options = {"from": start, "to": goal, "frame": frame, "rover": rover, "cell": cell}
    files = [out / name for name in FILES if picture or name != PICTURE]
    if ground.suffix.lower() == MAP:
        report, words = _solve(ground, scen, options), _solved
    else:
        report, words = _plan(ground, scen, options, files), _planned
    if json:
        print_json(report)
    else:
        words(report)
    return 0


def _solve(ground: Path, scen: Path | None, options: dict[str, Any]) -> dict[str, Any]:
    """Every scenario of a file."""
    from ..core import SettingError
    from ..plan import read_map, read_scenarios, solve_scenarios

    for name, item in options.items():
        if item is not None:
            raise SettingError(f"--{name} does not go with a MovingAI map; give --scen FILE alone")
    if scen is None:
        raise SettingError(f"{ground} is a MovingAI map; give its scenarios too: --scen FILE.scen")
    with progress_bar("solving") as update:
        costs = read_map(ground)
        scenarios = read_scenarios(scen, costs)
        begun = time.perf_counter()
        lengths = solve_scenarios(costs, scenarios, on_event=update)
        seconds = time.perf_counter() - begun
    return {
        "map": ground,
        "scen": scen,
        "scenarios": len(scenarios),
        "lengths": lengths,
        **_errors(lengths, scenarios),
        "seconds": seconds,
    }


def _errors(lengths: Any, scenarios: Scenarios) -> dict[str, Any]:
    import numpy as np

    off = np.abs(lengths - scenarios.optimal)
    relative = np.divide(
        off, scenarios.optimal, out=np.where(off > 0.0, np.inf, 0.0), where=scenarios.optimal > 0.0
    )
    return {
        "max_rel_error": float(relative.max()),
        "beyond_printed_digits": int((off > scenarios.tolerance).sum()),
    }


def _solved(report: dict[str, Any]) -> None:
    count, seconds, off = report["scenarios"], report["seconds"], report["beyond_printed_digits"]
    say(f"{report['map']}: {count:,} scenarios in {seconds:.2f} s, "
        f"{1e3 * seconds / count:.3g} ms each.")  # fmt: skip
    agree = "All lengths equal" if not off else f"{off:,} lengths differ from"
    say(f"{agree} the published ones to the digits printed; the largest relative difference is "
        f"{report['max_rel_error']:.2g}.")  # fmt: skip


def _plan(
    ground: Path, scen: Path | None, options: dict[str, Any], files: list[Path]
) -> dict[str, Any]:
    """A way over an elevation model."""
    from ..core import SettingError
    from ..plan import CostMap, any_angle
    from ..rover import read_rover, standing
    from ..terrain import read_terrain

    if scen is not None:
        raise SettingError(f"--scen goes with a MovingAI {MAP} only, and {ground} is none")
    for end in ("from", "to"):
        if options[end] is None:
            raise SettingError(f"a route needs --{end} X,Y as well")
    keep_apart({f"--out ({path.name})": path for path in files}, [ground, options["rover"]])
    with progress_bar("planning"):
        who = read_rover("research" if options["rover"] is None else options["rover"])
        terrain = read_terrain(ground, cell=options["cell"])
        ends = [to_point(terrain, options, end) for end in ("from", "to")]
        claim_folder(files[0].parent)
        where = standing(terrain, who)
        costs = CostMap.of(1.0, terrain.frame, forbidden=where.blocked)
        found = any_angle(costs, ends[0], ends[1])
        _write(files, terrain, where, found, ends)
    return {
        **_told(found, where, terrain),
        "rover": who.name,
        "forbidden_share": where.share,
        "straight_m": math.dist(*ends),
        "files": files,
    }


def _told(found: Route, where: Standing, terrain: Terrain) -> dict[str, Any]:
    near = found.nearest
    return {
        "status": found.status,
        "way": str(found.way),
        "reason": found.reason or None,
        "length_m": found.length,
        "max_slope_deg": math.degrees(where.steepest(found.points)) if found.found else None,
        "points": len(found.points),
        "nearest": near,
        "nearest_map": terrain.frame.to_map(*near) if near is not None else None,
    }


def _write(
    files: list[Path], terrain: Terrain, where: Standing, found: Route, ends: list[Any]
) -> None:
    from ..export import write_route_csv, write_route_geojson

    table, line, *picture = files
    write_route_csv(found, table, terrain=terrain)
    write_route_geojson(found, line, terrain=terrain)
    if picture:
        from ..show import draw_route

        draw_route(found, picture[0], terrain=terrain, standing=where, ends=(ends[0], ends[1]))


def _planned(report: dict[str, Any]) -> None:
    if report["status"] == "found":
        straight = report["straight_m"]
        ratio = f", {report['length_m'] / straight:.2f} times" if straight > 0 else ""
        say(f"Found a way of {report['length_m']:,.2f} m for {straight:,.2f} m in a straight line"
            f"{ratio}.")  # fmt: skip
        share = f"{report['forbidden_share']:.0%} of the map is forbidden to {report['rover']}"
        say(f"Steepest ground on the way: {report['max_slope_deg']:.1f} deg; {share}.")
    else:
        say(f"There is no way: {report['reason']}.")
    say_files(report["files"])
