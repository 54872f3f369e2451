"""`rovernav route`: the way over an elevation model, or all ways of a MovingAI file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ._console import print_json
from ._movingai import MAP, movingai, print_solved
from ._options import (
    Cell,
    FrameName,
    Goal,
    Grey,
    InFile,
    Json,
    Out,
    SouthFirst,
    Start,
    numbers,
)
from ._trip import Asked, plan_trip, print_trip


def route(
    ground: Annotated[
        InFile,
        Parameter(help="Elevation model (GeoTIFF, .npy, .png, meta.json), ROS .yaml or .map."),
    ],
    /,
    *,
    start: Start | None = None,
    goal: Goal | None = None,
    via: Annotated[
        list[str] | None,
        Parameter(
            negative="", allow_leading_hyphen=True, help="A stop X,Y on the way; may be repeated."
        ),
    ] = None,
    order: Annotated[
        str | None, Parameter(help="Stops in the order given (default), or in the best one.")
    ] = None,
    objective: Annotated[
        str | None, Parameter(help="distance (default), time, energy or risk: what shall be least.")
    ] = None,
    frame: FrameName | None = None,
    rover: Annotated[str | None, Parameter(help="Preset or rover file; default research.")] = None,
    soil: Annotated[
        str | None, Parameter(help="Soil for slip and energy; the rover's own if not given.")
    ] = None,
    avoid: Annotated[
        InFile | None, Parameter(help="GeoJSON polygons to keep out of (longitude, latitude).")
    ] = None,
    keep_in: Annotated[InFile | None, Parameter(help="GeoJSON polygons to stay within.")] = None,
    margin: Annotated[
        float | None, Parameter(allow_leading_hyphen=True, help="Distance to keep from zones [m].")
    ] = None,
    neighbours: Annotated[
        int | None, Parameter(help="Moves of the directed search: 8, 16 (default) or 32.")
    ] = None,
    why: Annotated[
        str | None,
        Parameter(
            allow_leading_hyphen=True,
            help="Explain the route at its point nearest to X,Y: cost terms, the straight line.",
        ),
    ] = None,
    require: Annotated[
        str | None, Parameter(help="found: exit with 1 where there is no way.")
    ] = None,
    cell: Cell | None = None,
    heights: Grey | None = None,
    south_first: SouthFirst = False,
    scen: Annotated[
        InFile | None, Parameter(help="MovingAI scenarios for a .map; solves every one.")
    ] = None,
    picture: Annotated[
        bool, Parameter(negative="--no-picture", help="Draw the pictures too; takes a second.")
    ] = True,
    out: Out = Path("rovernav-route"),
    json: Json = False,
) -> int:
    """Find the shortest, quickest, cheapest or safest way over ground on which a rover can drive.

    Writes route.png, route.csv, route.geojson and, where there is a way, profile.png and
    profile.csv. That there is no way is an answer, with its reason and what would open one: the
    exit code is 0 unless --require found. With a MovingAI map and --scen it solves every scenario
    of the file instead, over the eight neighbours without corner cutting, compares with the
    published lengths, and writes no file.

    Example: rovernav route yard.tif --from -3.5,1.2 --to 8,5 --rover sojourner --objective energy
    """
    given = {
        "from": start, "to": goal, "via": via, "order": order, "objective": objective,
        "frame": frame, "rover": rover, "soil": soil, "avoid": avoid, "keep-in": keep_in,
        "margin": margin, "neighbours": neighbours, "why": why, "require": require, "cell": cell,
        "heights": numbers("--heights", heights, 2), "south-first": south_first or None,
    }  # fmt: skip
    if ground.suffix.lower() == MAP:
        report = movingai(ground, scen, given)
        words = print_solved
    else:
        report = plan_trip(ground, Asked.of(given, scen), out, pictures=picture)
        words = print_trip
    if json:
        print_json(report)
    else:
        words(report)
    return 1 if require is not None and report["status"] != "found" else 0
