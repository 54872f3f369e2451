"""`rovernav drive`: a controller drives a rover through a scene."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from ._beliefs import belief_report, say_belief
from ._bodies import body_report, say_body
from ._console import print_json, progress_bar, say, say_files
from ._export import movie_of
from ._files import claim_folder, keep_apart
from ._options import (
    Cell,
    FrameName,
    Goal,
    Grey,
    InFile,
    Json,
    Out,
    SeedValue,
    SouthFirst,
    Start,
    numbers,
)
from ._parts import measured, measures_of, names_in
from ._place import find_scene

if TYPE_CHECKING:
    from ..core import Mission
    from ..scenes import Ground, Scene
    from ..sim import Trace

FILES = ("drive.png", "path.csv", "path.geojson", "trace.npz")
MOVIE = "drive.gif"


def drive(
    scenario: Annotated[
        str | None, Parameter(help="Named scenario such as bassil-v1, or a SCENARIO.yaml.")
    ] = None,
    /,
    *,
    terrain: Annotated[
        InFile | None,
        Parameter(help="Elevation model: GeoTIFF, .npy, .png, meta.json; or a ROS map's .yaml."),
    ] = None,
    cell: Cell | None = None,
    heights: Grey | None = None,
    south_first: SouthFirst = False,
    start: Start | None = None,
    goal: Goal | None = None,
    frame: FrameName | None = None,
    controller: Annotated[
        str | None,
        Parameter(
            help="bassil (the paper's network, default), neural (the shipped driver), "
            "goal-seeker, planner, a plug-in, or a network file."
        ),
    ] = None,
    carry: Annotated[
        str | None, Parameter(help="Sensors of plug-ins to carry besides, joined by commas.")
    ] = None,
    rover: Annotated[
        str | None,
        Parameter(help="Preset or rover file; default paper-point for bassil, else research."),
    ] = None,
    body: Annotated[
        bool,
        Parameter(negative="", help="Drive a body: it settles on the ground and slips."),
    ] = False,
    soil: Annotated[
        str | None,
        Parameter(help="Soil under a body; the rover's own if not given."),
    ] = None,
    sensing: Annotated[
        str | None,
        Parameter(help="What it sees with: ideal (default), lidar, sonar, stereo or stereo+holes."),
    ] = None,
    drift: Annotated[
        bool,
        Parameter(negative="", help="Go by odometry that drifts, not by the true pose."),
    ] = False,
    route: Annotated[
        str | None,
        Parameter(help="Follow a route: a .geojson file, from end to end; or plan one first."),
    ] = None,
    rocks: Annotated[
        float | None, Parameter(help="Scatter rocks over this share of the ground, like 0.05.")
    ] = None,
    require: Annotated[
        str | None, Parameter(help="Outcome to insist on, like reached; otherwise exit code 1.")
    ] = None,
    seed: Annotated[
        SeedValue | None, Parameter(help="Seed of everything random; default 0 or the file's.")
    ] = None,
    metrics: Annotated[
        str | None,
        Parameter(help="What to measure: closest, detour, energy, length or plug-ins, by commas."),
    ] = None,
    movie: Annotated[
        bool, Parameter(negative="", help="Write the drive as an animated picture too: drive.gif.")
    ] = False,
    out: Out = Path("rovernav-drive"),
    json: Json = False,
) -> int:
    """Drive a rover from A to B; obstacles are the places where it cannot stand.

    Writes drive.png, path.csv, path.geojson and trace.npz; rovernav export turns the trace into
    other forms, such as a ROS 2 bag or a page in three dimensions. A drive that ends badly is a
    result, not an error: the exit code is 0 unless --require asks for more. For a scenario file to
    start from, see rovernav template.

    Example: rovernav drive --terrain yard.tif --from -3.5,1.2 --to 8,5 --controller neural
    """
    report, title = run_drive(
        scenario,
        {
            "terrain": terrain, "cell": cell, "heights": numbers("--heights", heights, 2),
            "south_first": south_first or None, "from": start, "to": goal, "frame": frame,
            "rover": rover, "controller": controller, "rocks": rocks, "seed": seed,
            "body": body or None, "soil": soil, "sensing": sensing, "drift": drift or None,
            "route": route, "carry": names_in(carry),
        },
        require=require,
        metrics=names_in(metrics) or (),
        out=out,
        movie=movie,
    )  # fmt: skip
    if json:
        print_json(report)
    else:
        print_drive(report, title)
    return 0 if require is None or report["outcome"] == require else 1


def run_drive(
    scenario: str | None,
    options: dict[str, Any],
    *,
    out: Path,
    require: str | None = None,
    movie: bool = False,
    metrics: Sequence[str] = (),
) -> tuple[dict[str, Any], str]:
    """Drive and write the files.

    Args:
        scenario: A named scenario, a scenario file, or nothing.
        options: The other options by name; None where not given.
        out: Folder for the files.
        require: The outcome that the user will insist on; only its name is checked here.
        movie: Whether to write a movie too.
        metrics: Names of what to measure besides.

    Returns:
        What there is to tell, and the name of the scene.
    """
    from ..scenes import Ground

    _check_outcome(require)
    measures = measures_of(metrics)
    with progress_bar("driving") as update:
        scene, settings = find_scene(scenario, options)
        files = [out / name for name in (*FILES, *([MOVIE] if movie else []))]
        keep_apart(
            {f"--out ({path.name})": path for path in files},
            [scenario, *(settings.get(key) for key in ("terrain", "controller", "rover", "route"))],
        )
        trace, way = _simulate(scene, settings, out, update)
        _write(files[: len(FILES)], scene, trace, way)
        if movie:
            movie_of(trace, files[-1], scene, 0, update)
        report = _report(scene, trace)
        if measures:
            report["metrics"] = measured(measures, trace, scene)
    report["files"] = files
    report["settings"] = dict(trace.settings)
    return report, scene.terrain.name if isinstance(scene, Ground) else scene.name


def _check_outcome(require: str | None) -> None:
    from ..core import Outcome, SettingError, suggest

    names = [outcome.label for outcome in Outcome if outcome is not Outcome.DRIVING]
    if require is not None and require not in names:
        raise SettingError(f"--require {require!r} is no outcome; {suggest(require, names)}")


def _simulate(
    scene: Scene | Ground,
    settings: dict[str, Any],
    out: Path,
    update: Callable[[float, str], None],
) -> tuple[Trace, Any]:
    """The trace, and the points of the route that was followed; None without one."""
    from ..control import RouteFollower
    from ..learn import find_controller, guarded, routed
    from ..scenes import Ground
    from ..sim import DriveState, simulate

    inner = scene.scene if isinstance(scene, Ground) else scene
    driver = find_controller(settings["controller"])
    if settings.get("route") is not None:
        driver = routed(driver, scene, settings["route"])
    way = driver.routes[0] if isinstance(driver, RouteFollower) else None
    _check_no_loop(way, inner.mission)
    set_up = inner.drive(guarded(driver, scene))
    claim_folder(out)
    limit = inner.mission.time_limit

    def on_event(state: DriveState) -> None:
        now = float(state.rovers.time[0])
        update(now / limit, f"{now:.0f} s, {float(state.rovers.odometry[0]):.1f} m")

    return simulate(set_up, seed=int(settings["seed"]), on_event=on_event, settings=settings), way


def _check_no_loop(way: Any, mission: Mission) -> None:
    """A rover that begins at its goal has arrived, so no round trip would be driven."""
    if way is None:
        return
    length = sum(math.dist(a, b) for a, b in itertools.pairwise(way))
    apart = math.dist(mission.start[0, :2], mission.goal[0])
    if apart <= mission.goal_radius < 0.5 * length:
        from ..core import SettingError

        raise SettingError(
            f"the route of {length:,.1f} m comes back to within {apart:.2f} m of its start, where "
            f"the rover counts as arrived ({mission.goal_radius:g} m); give it in two parts and "
            "drive one after the other"
        )


def _report(scene: Scene | Ground, trace: Trace) -> dict[str, Any]:
    from ..scenes import Ground
    from ..sim import Body, clearance

    ground, inner = (scene, scene.scene) if isinstance(scene, Ground) else (None, scene)
    path = trace.path()
    report = {
        "outcome": trace.ended().label,
        "length_m": float(trace.length[0]),
        "straight_m": math.dist(trace.mission.start[0, :2], trace.mission.goal[0]),
        "time_s": float(trace.time[-1, 0]),
        "steps": int(trace.steps[0]),
        "max_slope_deg": None,
        "closest_m": clearance(path, inner.worlds),
        "start": path[0],
        "end": path[-1],
        "to_goal_m": math.dist(path[-1], trace.mission.goal[0]),
        "forbidden_share": None,
        "start_map": None,
        "end_map": None,
        "energy_kj": None,
        "worst_tilt_deg": None,
        "mean_slip": None,
        "worst_slip": None,
        "soil": None,
        **body_report(trace),
        **belief_report(trace),
    }
    if ground is not None:
        frame = ground.terrain.frame
        report["max_slope_deg"] = math.degrees(ground.standing.steepest(path))
        report["forbidden_share"] = ground.standing.share
        if isinstance(inner.motion, Body):
            report["soil"] = inner.motion.soil
        report["start_map"], report["end_map"] = (frame.to_map(*path[k]) for k in (0, -1))
    return report


def _write(files: list[Path], scene: Scene | Ground, trace: Trace, way: Any) -> None:
    from ..export import write_path_csv, write_path_geojson
    from ..scenes import Ground
    from ..show import draw_drive, draw_worlds
    from ..sim import save_trace

    picture, table, line, whole = files
    terrain = scene.terrain if isinstance(scene, Ground) else None
    if isinstance(scene, Ground):
        draw_drive(
            trace, picture, terrain=scene.terrain, standing=scene.standing,
            sensed=_sensed(scene, trace), seen=_seen(scene, trace), worlds=scene.scene.worlds,
            route=way,
        )  # fmt: skip
    else:
        draw_worlds(trace, scene.worlds, picture, columns=1)
    write_path_csv(trace, table, terrain=terrain)
    write_path_geojson(trace, line, terrain=terrain)
    save_trace(trace, whole)


def _sensed(scene: Ground, trace: Trace) -> Any:
    """Where range beams met something, at most some ten thousand points; None without a fan."""
    from ..sim import NoisyFan, RangeFan

    fans = [each for each in scene.scene.sensors if isinstance(each, RangeFan | NoisyFan)]
    steps = int(trace.steps[0])
    if not fans or not steps:
        return None
    fan, every = fans[0], 1 + steps * len(fans[0].angles) // 20_000
    return fan.points(trace.pose[:steps:every, 0], trace.channels[fan.name][:steps:every, 0])


def _seen(scene: Ground, trace: Trace) -> Any:
    """Places whose heights the eyes told, at most some million; None without eyes."""
    import numpy as np

    from ..sim import Patch

    eyes = [each for each in scene.scene.sensors if isinstance(each, Patch)]
    steps = int(trace.steps[0])
    if not eyes or not steps:
        return None
    every = 1 + steps * len(eyes[0].places) // 1_000_000
    forward, left = eyes[0].places.T
    x, y, a = trace.pose[:steps:every, 0, :, None].transpose(1, 0, 2)
    c, s = np.cos(a), np.sin(a)
    places = np.stack([x + c * forward - s * left, y + s * forward + c * left], axis=2)
    return places[np.isfinite(trace.channels[eyes[0].name][:steps:every, 0])]


def print_drive(report: dict[str, Any], title: str) -> None:
    """A drive in words."""
    straight = report["straight_m"]
    ratio = f", {report['length_m'] / straight:.2f} times" if straight > 0 else ""
    say(f"{title}: {report['outcome'].replace('_', ' ')} after {report['time_s']:.0f} s, "
        f"{report['steps']} steps.")  # fmt: skip
    say(f"Drove {report['length_m']:.2f} m for {straight:.2f} m in a straight line{ratio}.")
    if report["outcome"] != "reached":
        say(f"Ended {report['to_goal_m']:.2f} m from the goal.")
    if report["believed_off_m"] is not None:
        say_belief(report)
    if math.isfinite(report["closest_m"]):
        say(f"Closest approach to forbidden ground or obstacles: {report['closest_m']:.2f} m.")
    if report["max_slope_deg"] is not None:
        say(f"Steepest ground on the way: {report['max_slope_deg']:.1f} deg; "
            f"{report['forbidden_share']:.0%} of the map is forbidden to this rover.")  # fmt: skip
    if report["energy_kj"] is not None:
        say_body(report)
    for name, (number, unit) in report.get("metrics", {}).items():
        words = "not told" if number is None else f"{number:.6g} {unit}".removesuffix(" 1")
        say(f"{name}: {words}")
    say_files(report["files"])
