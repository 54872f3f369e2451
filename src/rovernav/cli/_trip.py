"""`rovernav route DEM`: a trip planned, written and told."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ._console import print_pairs, print_table, progress_bar, say, say_files
from ._files import claim_folder, keep_apart
from ._place import to_point

if TYPE_CHECKING:
    from ..core import Frame
    from ..plan import Trip, Zones
    from ..rover import Rover
    from ..terrain import Raster, Terrain

Tick = Callable[[float, str], None]

WHOLE = 20_000_000
"""A model with more cells is planned on in blocks first; all at once it would take a gigabyte."""

FILES = ("route.png", "route.csv", "route.geojson", "profile.png", "profile.csv")


class Asked(NamedTuple):
    """What was asked for, defaults filled in.

    Attributes:
        options: All options by name, as they were given.
        objective: What shall be least.
        order: "given" or "best".
        margin: [m].
    """

    options: Mapping[str, Any]
    objective: str
    order: str
    margin: float

    @classmethod
    def of(cls, given: Mapping[str, Any], scen: Path | None) -> Asked:
        """Options that go together.

        Raises:
            SettingError: They do not.
        """
        from ..core import SettingError, suggest
        from ..plan import OBJECTIVES, ORDERS

        if scen is not None:
            raise SettingError("--scen goes with a MovingAI .map only")
        for end in ("from", "to"):
            if given[end] is None:
                raise SettingError(f"a route needs --{end} X,Y as well")
        zones = given["avoid"] is not None or given["keep-in"] is not None
        if given["margin"] is not None and not zones:
            raise SettingError("--margin is kept from zones; give --avoid or --keep-in as well")
        for name, usual, known in (
            ("objective", "distance", OBJECTIVES),
            ("order", "given", ORDERS),
            ("require", "found", ("found",)),
        ):
            chosen = usual if given[name] is None else given[name]
            if chosen not in known:
                raise SettingError(f"--{name} has no {chosen!r}; {suggest(chosen, known)}")
        return cls(
            options=given,
            objective=given["objective"] or "distance",
            order=given["order"] or "given",
            margin=0.0 if given["margin"] is None else given["margin"],
        )


def plan_trip(path: Path, asked: Asked, out: Path, *, pictures: bool = True) -> dict[str, Any]:
    """Plan over an elevation model, write the files, and say how it went."""
    from ..rover import read_rover
    from ..terrain import open_raster

    options = asked.options
    files = [out / name for name in FILES if pictures or not name.endswith(".png")]
    read = [path, options["rover"], options["avoid"], options["keep-in"], options["soil"]]
    keep_apart({f"--out ({file.name})": file for file in files}, read)
    with progress_bar("planning") as tick:
        who = read_rover("research" if options["rover"] is None else options["rover"])
        raster = open_raster(
            path, cell=options["cell"], heights=options["heights"],
            south_first=bool(options["south-first"]),
        )  # fmt: skip
        large = raster.frame.shape[0] * raster.frame.shape[1] > WHOLE and not raster.plain
        plan = _plan_far if large else _plan_whole
        trip, terrain, why = plan(raster, who, asked, lambda: claim_folder(out), tick)
        files = _write(files, trip, terrain)
    return {**_told(trip, terrain), "why": why, "files": files}


def _plan_whole(
    raster: Raster, who: Rover, asked: Asked, ready: Callable[[], object], _tick: Tick
) -> tuple[Trip, Terrain, dict[str, Any] | None]:
    """Over all cells at once."""
    from ..plan import going, travel, why_here, within_zones
    from ..rover import hazards
    from ..terrain import read_part

    options = asked.options
    terrain = read_part(raster, None, 1)
    stops, place = _stops(terrain, options), _place(terrain, options)
    ready()
    ground = going(hazards(terrain, who, soil=options["soil"]), who, objective=asked.objective)
    zones = _zones(terrain.frame, asked)
    if zones is not None:
        ground = within_zones(ground, zones)
    trip = travel(ground, stops, order=asked.order, neighbours=options["neighbours"] or 16)
    explains = place is not None and trip.found and len(trip.points) > 1
    why = why_here(ground, trip.points, place) if explains else None
    return trip, terrain, why


def _plan_far(
    raster: Raster, who: Rover, asked: Asked, ready: Callable[[], object], tick: Tick
) -> tuple[Trip, Terrain, dict[str, Any] | None]:
    """Over blocks, and over the cells on the way; in memory that does not grow with the file."""
    from ..core import FileError, InputError, SettingError
    from ..plan import Errand, travel_far, why_far

    options = asked.options
    stops, place = _stops(raster, options), _place(raster, options)
    zones = _zones(raster.frame, asked)
    ready()
    errand = Errand(
        raster, who, asked.objective, options["soil"], zones, options["neighbours"] or 16
    )
    try:
        trip = travel_far(errand, stops, order=asked.order, on_progress=tick)
        explains = place is not None and trip.found and len(trip.points) > 1
        why = why_far(errand, trip.points, place) if explains else None
    except (FileError, SettingError):
        raise
    except InputError as error:
        text = str(error)
        named = text if raster.path.name in text else f"{raster.source}: {text}"
        raise FileError(named) from None
    assert trip.far is not None
    return trip, trip.far.terrain, why


def _zones(frame: Frame, asked: Asked) -> Zones | None:
    from ..plan import read_zones

    avoid, keep_in = asked.options["avoid"], asked.options["keep-in"]
    if avoid is None and keep_in is None:
        return None
    return read_zones(frame, avoid=avoid, keep_in=keep_in, margin=asked.margin)


def _stops(ground: Terrain | Raster, options: Mapping[str, Any]) -> list[tuple[float, float]]:
    start, goal = (to_point(ground, options, end) for end in ("from", "to"))
    via = [to_point(ground, {**options, "via": text}, "via") for text in options["via"] or []]
    return [start, *via, goal]


def _place(ground: Terrain | Raster, options: Mapping[str, Any]) -> tuple[float, float] | None:
    return None if options["why"] is None else to_point(ground, options, "why")


def _told(trip: Trip, terrain: Terrain) -> dict[str, Any]:
    ground, near, found = trip.ground, trip.nearest, trip.found
    legs = [_leg(number, told) for number, told in enumerate(trip.account())]
    whole = {
        key: sum(leg[key] for leg in legs) if found and ground.table is not None else None
        for key in ("time_s", "energy_j")
    }
    if found and ground.table is None:
        whole["time_s"] = sum(leg["time_s"] for leg in legs)
    steepest = max((leg["max_slope_deg"] for leg in legs), default=0.0) if found else None
    return {
        "status": trip.status,
        "way": str(trip.legs[-1].way),
        "reason": trip.reason or None,
        "objective": ground.objective,
        "rover": ground.rover.name,
        "soil": ground.hazards.soil,
        "length_m": trip.length,
        "cost": trip.cost,
        "unit": ground.unit,
        **whole,
        "max_slope_deg": steepest,
        "straight_m": sum(math.dist(a, b) for a, b in itertools.pairwise(trip.stops)),
        "points": len(trip.points),
        "order": list(trip.order),
        "legs": legs,
        "barriers": [_barrier(b, terrain) for b in trip.barriers],
        "nearest": near,
        "nearest_map": terrain.frame.to_map(*near) if near is not None else None,
        "nearest_off_m": _off(trip),
        "forbidden_share": trip.forbidden,
        "looked_share": trip.looked,
        "block": None if trip.far is None else trip.far.block,
    }


def _off(trip: Trip) -> float | None:
    """How far the nearest reachable point is from the stop that cannot be reached [m]."""
    if trip.nearest is None or trip.failed is None:
        return None
    return math.dist(trip.nearest, trip.stops[trip.failed + 1])


def _leg(number: int, told: dict[str, Any]) -> dict[str, Any]:
    return {
        "leg": number + 1,
        "length_m": told["length"],
        "cost": told["cost"],
        "terms": told["terms"],
        "time_s": told["time"],
        "energy_j": told["energy"],
        "max_slope_deg": math.degrees(told["steepest"]),
    }


def _barrier(barrier: Any, terrain: Terrain) -> dict[str, Any]:
    at = barrier.at
    return {
        "limit": barrier.limit, "now": barrier.now, "needed": barrier.needed,
        "unit": barrier.unit, "at": at, "words": barrier.words,
        "at_map": terrain.frame.to_map(*at) if at is not None else None,
    }  # fmt: skip


def _write(files: list[Path], trip: Trip, terrain: Terrain) -> list[Path]:
    """Write the files that are wanted; where there is no way, those of the profile are left out."""
    from ..export import write_profile_csv, write_route_csv, write_trip_geojson

    ground = trip.ground
    lone = len(trip.points) < 2
    told = None if lone else trip.profile(terrain)
    files = [path for path in files if told is not None or not path.name.startswith("profile")]
    for path in files:
        match path.name:
            case "route.csv":
                write_route_csv(trip.route, path, terrain=terrain, heights=trip.heights)
            case "route.geojson":
                write_trip_geojson(trip, path, terrain=terrain)
            case "route.png":
                from ..show import draw_trip

                draw_trip(trip, path, terrain=terrain)
            case "profile.csv" if told is not None:
                write_profile_csv(told, path, terrain=terrain)
            case _ if told is not None:
                from ..show import draw_profile

                title = f"{terrain.name}: least {ground.objective} for {ground.rover.name}"
                draw_profile(told, path, ground=ground, title=title)
            case _:
                pass
    return files


def print_trip(report: dict[str, Any]) -> None:
    """The trip in words: its table by leg, or why there is none; and why it runs where it does."""
    if report["status"] == "found":
        straight = report["straight_m"]
        ratio = f", {report['length_m'] / straight:.2f} times" if straight > 0 else ""
        say(f"Found a way of {report['length_m']:,.2f} m for {straight:,.2f} m in a straight line"
            f"{ratio}.")  # fmt: skip
        part = report["looked_share"]
        seen = "the map" if part == 1.0 else f"the {part:.0%} of the map that was looked at"
        share = f"{report['forbidden_share']:.0%} of {seen} is forbidden to {report['rover']}"
        say(f"Steepest ground on the way: {report['max_slope_deg']:.1f} deg; {share}.")
        if len(report["order"]) > 2:
            via = ", ".join(map(str, report["order"][1:-1]))
            say(f"Stops in the order {via} of those given.")
        _print_legs(report)
    else:
        say(f"There is no way: {report['reason']}.")
    if report["why"] is not None:
        _print_why(report["why"], report["unit"])
    say_files(report["files"])


def _print_legs(report: dict[str, Any]) -> None:
    unit = report["unit"] if report["unit"] != "1" else "risk"
    names = list(report["legs"][0]["terms"])
    several = len(names) > 1
    rows = [
        [
            str(leg["leg"]), f"{leg['length_m']:,.1f}", _clock(leg["time_s"]),
            "-" if leg["energy_j"] is None else f"{leg['energy_j'] / 1000.0:,.1f}",
            f"{leg['max_slope_deg']:.1f}",
            *([f"{round(leg['terms'][name], 6):,.6g}" for name in names] if several else []),
        ]
        for leg in report["legs"]
    ]  # fmt: skip
    terms = [f"{name} [{unit}]" for name in names] if several else []
    say()
    print_table(
        f"Least {report['objective']}, leg by leg",
        ["leg", "length [m]", "time [h:mm]", "energy [kJ]", "steepest [deg]", *terms],
        rows,
    )


def _clock(seconds: float) -> str:
    minutes = round(seconds / 60.0)
    return f"{minutes // 60}:{minutes % 60:02d}"


def _print_why(why: dict[str, Any], unit: str) -> None:
    x, y = why["at"]
    unit = unit if unit != "1" else "risk"
    stretch, straight = why["stretch"], why["straight"]
    say(f"At ({x:.6g}, {y:.6g}) m, {why['distance']:,.1f} m along the route, a metre costs:")
    print_pairs([(name, f"{cost:.6g} {unit}") for name, cost in why["per_metre"].items()])
    say(
        f"The {stretch['length']:,.1f} m of the route around it cost {stretch['cost']:,.6g} {unit}."
    )
    if math.isinf(straight["cost"]):
        metres = why["forbidden"]
        over = f"{metres:,.1f} m of it are forbidden ground" if metres > 0.0 else (
            "a limit of the rover forbids part of it in that direction"
        )  # fmt: skip
        say(f"The straight line in their place, {straight['length']:,.1f} m, cannot be driven: "
            f"{over}.")  # fmt: skip
    else:
        say(f"The straight line in their place, {straight['length']:,.1f} m, would cost "
            f"{straight['cost']:,.6g} {unit}, {why['dearer']:+,.4g} {unit}.")  # fmt: skip
    say()
