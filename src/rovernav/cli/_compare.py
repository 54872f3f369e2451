"""`rovernav compare`: controllers side by side on the same pairs of points."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from cyclopts import Parameter

from ._console import print_json, print_table, progress_bar, say
from ._options import Cell, Grey, InFile, Json, Seed, SouthFirst, Whole, numbers
from ._parts import measures_of, names_in
from ._workers import Place


def compare(
    terrain: Annotated[
        InFile, Parameter(help="Elevation model: GeoTIFF, .npy, .png, meta.json; or a ROS .yaml.")
    ],
    /,
    *,
    controllers: Annotated[
        str, Parameter(help="Names (those of plug-ins too) or network files, joined by commas.")
    ] = "neural,goal-seeker",
    carry: Annotated[
        str | None, Parameter(help="Sensors of plug-ins to carry besides, joined by commas.")
    ] = None,
    metrics: Annotated[
        str | None,
        Parameter(help="What to measure: closest, detour, energy, length or plug-ins, by commas."),
    ] = None,
    pairs: Annotated[Whole, Parameter(help="Start and goal pairs.")] = 50,
    rover: Annotated[str, Parameter(help="Preset or rover file.")] = "research",
    cell: Cell | None = None,
    heights: Grey | None = None,
    south_first: SouthFirst = False,
    nearest: Annotated[float | None, Parameter(help="Shortest straight line [m].")] = None,
    farthest: Annotated[float | None, Parameter(help="Longest straight line [m].")] = None,
    seed: Seed = 0,
    place: Place | None = None,
    json: Json = False,
) -> int:
    """Drive the same solvable pairs, whose straight line is blocked, with several controllers.

    Example: rovernav compare yard.tif --pairs 200 --controllers neural,goal-seeker,planner
    """
    from ..bench import carrying, draw_pairs, score
    from ..core import SettingError
    from ..learn import find_controller
    from ..rover import read_rover
    from ..terrain import read_terrain

    if not 1 <= pairs <= 10_000:
        raise SettingError(f"--pairs must be from 1 to 10000, got {pairs}")
    names = [name.strip() for name in controllers.split(",") if name.strip()]
    drivers = [(name, find_controller(name)) for name in names]
    if not drivers:
        raise SettingError("--controllers names nobody; give one or more, like neural,goal-seeker")
    measures = measures_of(names_in(metrics) or ())
    ground = read_terrain(
        terrain, cell=cell, heights=numbers("--heights", heights, 2), south_first=south_first
    )
    vehicle = read_rover(rover)
    scores = []
    with (place or Place()).executor() as executor:
        drawn = draw_pairs(ground, vehicle, pairs, seed=seed, nearest=nearest, farthest=farthest)
        drawn = carrying(drawn, names_in(carry) or ())
        for name, driver in drivers:
            with progress_bar(name) as update:
                scores.append(
                    score(drawn, name, driver, executor=executor, metrics=measures,
                          on_event=lambda share: update(share, "ended"))
                )  # fmt: skip
    if json:
        print_json({"terrain": str(terrain), "rover": rover, "pairs": pairs, "seed": seed,
                    "scores": [one.report() for one in scores]})  # fmt: skip
        return 0
    rows = [
        (one.name, f"{one.reached:.1%}", f"{one.low:.1%} to {one.high:.1%}",
         ", ".join(f"{count} {how.replace('_', ' ')}" for how, count in one.counts.items()),
         "" if one.detour != one.detour else f"{one.detour:.2f}", f"{one.seconds:.1f}")
        for one in scores
    ]  # fmt: skip
    title = f"{pairs} pairs on {ground.name}, rover {rover}, straight line blocked"
    print_table(title, ("", "reached", "95 % interval", "ends", "detour", "s"), rows)
    if measures:
        columns = ("", *(f"{one.name} [{one.unit}]" for one in measures))
        medians = [(one.name, *(_median(one.metrics[m.name]) for m in measures)) for one in scores]
        print_table("Medians of what was measured", columns, medians)
    say("Detour: driven over straight length, median of those that reached their goal.")
    return 0


def _median(found: Mapping[str, Any]) -> str:
    """The median, and of how many drives."""
    return "-" if found["median"] is None else f"{found['median']:.6g} of {found['drives']}"
