"""`rovernav drive`: a controller drives a rover through a scene."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from ._console import Json, Out, Seed, print_json, progress_bar, say, say_files

if TYPE_CHECKING:
    from ..scenes import Ground, Scenario, Scene
    from ..sim import Trace

XY = Annotated[str | None, Parameter(allow_leading_hyphen=True)]


def drive(
    scenario: Annotated[
        str | None, Parameter(help="Named scenario such as bassil-v1, or a SCENARIO.yaml.")
    ] = None,
    *,
    terrain: Annotated[Path | None, Parameter(help="Elevation model: a GeoTIFF.")] = None,
    cell: Annotated[
        float | None, Parameter(help="Cell of a .npy terrain, which does not say its own [m].")
    ] = None,
    start: Annotated[
        str | None,
        Parameter(name="--from", allow_leading_hyphen=True, help="Start X,Y, like -3.5,1.2."),
    ] = None,
    goal: Annotated[
        str | None, Parameter(name="--to", allow_leading_hyphen=True, help="Goal X,Y.")
    ] = None,
    frame: Annotated[
        str, Parameter(help="What X,Y are: crs (the terrain's own), local [m] or pixel.")
    ] = "crs",
    controller: Annotated[
        str | None, Parameter(help="bassil (the paper's network) or a network file.")
    ] = None,
    rover: Annotated[str | None, Parameter(help="Preset or rover file.")] = None,
    require: Annotated[
        str | None, Parameter(help="Outcome to insist on, like reached; otherwise exit code 1.")
    ] = None,
    seed: Seed = 0,
    out: Out = Path("rovernav-drive"),
    json: Json = False,
) -> int:
    """Drive a rover from A to B; obstacles are the places where it cannot stand.

    Writes drive.png, path.csv, path.geojson and trace.npz. A drive that ends badly is a result,
    not an error: the exit code is 0 unless --require asks for more.

    Example: rovernav drive --terrain yard.tif --from 12,20 --to 35,30 --frame local
    """
    from ..scenes import Ground

    _check_outcome(require)
    options = {
        "terrain": terrain, "cell": cell, "from": start, "to": goal, "frame": frame,
        "rover": rover, "controller": controller, "seed": seed,
    }  # fmt: skip
    scene, settings = _scene(scenario, options)
    trace = _simulate(scene, settings)
    report = _report(scene, trace)
    report["files"] = _write(out, scene, trace)
    report["settings"] = dict(trace.settings)
    if json:
        print_json(report)
    else:
        _print(report, scene.terrain.name if isinstance(scene, Ground) else scene.name)
    return 0 if require is None or report["outcome"] == require else 1


def _check_outcome(require: str | None) -> None:
    from ..core import Outcome, SettingError, suggest

    names = [outcome.label for outcome in Outcome if outcome is not Outcome.DRIVING]
    if require is not None and require not in names:
        raise SettingError(f"--require {require!r} is no outcome; {suggest(require, names)}")


def _scene(scenario: str | None, options: dict[str, Any]) -> tuple[Scene | Ground, dict[str, Any]]:
    """The scene, and plain settings that describe it in the trace."""
    from ..core import SettingError
    from ..scenes import named_scene, scene_names, set_scene

    given = {key: item for key, item in options.items() if item is not None}
    on_ground = [key for key in ("terrain", "cell", "from", "to") if key in given]
    if scenario is None and "terrain" not in given:
        raise SettingError(
            "nothing to drive: name a scenario "
            f"({', '.join(scene_names())}), a SCENARIO.yaml, or --terrain FILE --from X,Y --to X,Y"
        )
    if scenario in scene_names():
        if on_ground or "rover" in given:
            odd = (on_ground or ["rover"])[0]
            raise SettingError(f"--{odd} does not go with the named scenario {scenario}")
        settings = {"scenario": scenario, "seed": options["seed"]}
        settings["controller"] = options["controller"] or "bassil"
        return named_scene(scenario, seed=options["seed"]), settings
    whole = _file_scenario(scenario, given, on_ground) if scenario else _options_scenario(given)
    settings = whole.model_dump(mode="json", by_alias=True, exclude_defaults=True)
    return set_scene(whole), {"controller": whole.controller, **settings}


def _file_scenario(scenario: str, given: dict[str, Any], on_ground: list[str]) -> Scenario:
    from ..core import FileError, SettingError, suggest
    from ..scenes import read_scenario, scene_names

    path = Path(scenario)
    if path.suffix.lower() not in (".yaml", ".yml") and not path.exists():
        raise FileError(
            f"there is no scenario {scenario!r} and no such file; {suggest(scenario, scene_names())}"
        )
    if on_ground:
        raise SettingError(f"--{on_ground[0]} does not go with a scenario file; write it there")
    changes = {key: given[key] for key in ("rover", "controller") if key in given}
    if given["seed"]:
        changes["seed"] = given["seed"]
    return read_scenario(path).model_copy(update=changes)


def _options_scenario(given: dict[str, Any]) -> Scenario:
    from ..core import SettingError, build
    from ..scenes import Scenario

    for end in ("from", "to"):
        if end not in given:
            raise SettingError(f"--terrain needs --{end} X,Y as well")
        given[end] = _point(f"--{end}", given[end])
    return build(Scenario, given, source="options")


def _point(option: str, text: str) -> tuple[float, float]:
    from ..core import SettingError

    try:
        x, y = (float(part) for part in text.split(","))
    except ValueError:
        raise SettingError(f"{option} must be two numbers X,Y like -3.5,1.2, got {text!r}") from None
    if not (math.isfinite(x) and math.isfinite(y)):
        raise SettingError(f"{option} must be finite numbers, got {text!r}")
    return x, y


def _simulate(scene: Scene | Ground, settings: dict[str, Any]) -> Trace:
    from ..learn import find_controller
    from ..scenes import Ground
    from ..sim import Drive, DriveState, simulate

    inner = scene.scene if isinstance(scene, Ground) else scene
    set_up = Drive(
        worlds=inner.worlds,
        mission=inner.mission,
        sensors=inner.sensors,
        controller=find_controller(settings["controller"]),
        motion=inner.motion,
    )
    limit = inner.mission.time_limit
    with progress_bar("driving") as update:

        def on_event(state: DriveState) -> None:
            now = float(state.rovers.time[0])
            update(now / limit, f"{now:.0f} s, {float(state.rovers.odometry[0]):.1f} m")

        return simulate(
            set_up, seed=int(settings.get("seed", 0)), on_event=on_event, settings=settings
        )


def _report(scene: Scene | Ground, trace: Trace) -> dict[str, Any]:
    from ..scenes import Ground
    from ..sim import clearance

    inner = scene.scene if isinstance(scene, Ground) else scene
    path = trace.path()
    steepest = None
    if isinstance(scene, Ground):
        steepest = math.degrees(scene.standing.steepest(path))
    return {
        "outcome": trace.ended().label,
        "length_m": float(trace.length[0]),
        "straight_m": math.dist(trace.mission.start[0, :2], trace.mission.goal[0]),
        "time_s": float(trace.time[-1, 0]),
        "steps": int(trace.steps[0]),
        "max_slope_deg": steepest,
        "closest_m": clearance(path, inner.worlds),
        "start": path[0],
        "end": path[-1],
        "to_goal_m": math.dist(path[-1], trace.mission.goal[0]),
        "forbidden_share": scene.standing.share if isinstance(scene, Ground) else None,
    }


def _write(out: Path, scene: Scene | Ground, trace: Trace) -> list[Path]:
    from ..export import write_path_csv, write_path_geojson
    from ..scenes import Ground
    from ..show import draw_drive, draw_worlds
    from ..sim import save_trace

    files = [out / name for name in ("drive.png", "path.csv", "path.geojson", "trace.npz")]
    terrain = scene.terrain if isinstance(scene, Ground) else None
    if isinstance(scene, Ground):
        draw_drive(trace, files[0], terrain=scene.terrain, standing=scene.standing)
    else:
        draw_worlds(trace, scene.worlds, files[0], columns=1)
    write_path_csv(trace, files[1], terrain=terrain)
    write_path_geojson(trace, files[2], terrain=terrain)
    save_trace(trace, files[3])
    return files


def _print(report: dict[str, Any], name: str) -> None:
    straight = report["straight_m"]
    ratio = f", {report['length_m'] / straight:.2f} times" if straight > 0 else ""
    say(f"{name}: {report['outcome'].replace('_', ' ')} after {report['time_s']:.0f} s, "
        f"{report['steps']} steps.")  # fmt: skip
    say(f"Drove {report['length_m']:.2f} m for {straight:.2f} m in a straight line{ratio}.")
    if report["outcome"] != "reached":
        say(f"Ended {report['to_goal_m']:.2f} m from the goal.")
    if math.isfinite(report["closest_m"]):
        say(f"Closest approach to forbidden ground or obstacles: {report['closest_m']:.2f} m.")
    if report["max_slope_deg"] is not None:
        say(f"Steepest ground on the way: {report['max_slope_deg']:.1f} deg; "
            f"{report['forbidden_share']:.0%} of the map is forbidden to this rover.")  # fmt: skip
    say_files(report["files"])
