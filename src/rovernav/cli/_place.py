"""From the options of `rovernav drive` to a scene and the settings that describe it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..scenes import Ground, Scenario, Scene
    from ..terrain import Raster, Terrain

GROUND = (
    "terrain",
    "cell",
    "heights",
    "south_first",
    "from",
    "to",
    "frame",
    "rocks",
    "body",
    "soil",
    "sensing",
    "drift",
    "route",
)
"""Options that say where to drive; a scenario says it itself."""


def find_scene(
    scenario: str | None, options: Mapping[str, Any]
) -> tuple[Scene | Ground, dict[str, Any]]:
    """The scene, and plain settings that are enough to set it again.

    Args:
        scenario: A named scenario, a scenario file, or nothing.
        options: What the other options say, by name; None where not given.

    Raises:
        InputError: They do not make a drive.
    """
    from ..core import SettingError
    from ..learn import usual_rover
    from ..scenes import carry, named_scene, scene_names, set_scene
    from ..sim import TwoAxis

    given = {key: item for key, item in options.items() if item is not None}
    _check_options(given)
    if scenario is None and "terrain" not in given:
        raise SettingError(
            f"nothing to drive: name a scenario ({', '.join(scene_names())}), a SCENARIO.yaml, "
            "or --terrain FILE --from X,Y --to X,Y"
        )
    if scenario in scene_names():
        for option in (*GROUND, "rover"):
            if option in given:
                raise SettingError(
                    f"{_named(option)} does not go with the named scenario {scenario}"
                )
        seed = given.get("seed", 0)
        scene = carry(named_scene(scenario, seed=seed), given.get("carry", ()))
        usual = "bassil" if isinstance(scene.motion, TwoAxis) else "neural"
        settings = {"scenario": scenario, "seed": seed}
        settings["controller"] = given.get("controller", usual)
        if "carry" in given:
            settings["carry"] = given["carry"]
        return scene, settings
    whole = _from_options(given) if scenario is None else _from_file(scenario, given)
    if whole.rover is None:
        whole = whole.model_copy(update={"rover": usual_rover(whole.controller)})
    scene = set_scene(whole)
    if "controller" not in whole.model_fields_set and not isinstance(scene.motion, TwoAxis):
        raise SettingError(
            f"rover {whole.rover} is not for the paper's network, which drives where no other is "
            "named; add --controller neural, goal-seeker or planner"
        )
    return scene, whole.model_dump(mode="json", by_alias=True, exclude_none=True)


def _named(option: str) -> str:
    return "--" + option.replace("_", "-")


def _check_options(given: dict[str, Any]) -> None:
    """Read the two points; refuse an unknown frame and empty names."""
    from ..core import FRAMES, SettingError, suggest

    for end in ("from", "to"):
        if end in given:
            given[end] = _point(f"--{end}", given[end])
    frame = given.get("frame", FRAMES[0])
    if frame not in FRAMES:
        raise SettingError(f"--frame has no {frame!r}; {suggest(frame, FRAMES)}")
    for name in ("rover", "controller"):
        if given.get(name) == "":
            raise SettingError(f"--{name} must not be empty; leave it out for the usual one")


def _from_options(given: Mapping[str, Any]) -> Scenario:
    from ..core import SettingError, build
    from ..scenes import Scenario

    given = dict(given)
    if given.get("route", "plan") != "plan" and not {"from", "to", "frame"} & given.keys():
        given |= _ends_of(given)
    for end in ("from", "to"):
        if end not in given:
            raise SettingError(f"--terrain needs --{end} X,Y as well")
    return build(Scenario, given, source="the options")


def _ends_of(given: Mapping[str, Any]) -> dict[str, Any]:
    """Start and goal of a drive that follows a route from end to end."""
    from ..plan import read_route
    from ..terrain import open_raster

    raster = open_raster(
        given["terrain"], cell=given.get("cell"), heights=given.get("heights"),
        south_first=given.get("south_first", False),
    )  # fmt: skip
    points = read_route(given["route"], raster.frame).tolist()
    return {"from": tuple(points[0]), "to": tuple(points[-1]), "frame": "local"}


def _from_file(scenario: str, given: Mapping[str, Any]) -> Scenario:
    from ..core import FileError, SettingError, suggest
    from ..scenes import read_scenario, scene_names

    path = Path(scenario)
    if not scenario or (not path.suffix and not path.exists()):
        raise FileError(
            f"there is no scenario {scenario!r} and no such file; "
            f"{suggest(scenario, scene_names())}"
        )
    if path.suffix.lower() not in (".yaml", ".yml"):
        raise FileError(
            f"{scenario} is no scenario: its name does not end in .yaml; "
            "an elevation model is given as --terrain FILE --from X,Y --to X,Y"
        )
    for option in GROUND:
        if option in given:
            raise SettingError(f"{_named(option)} does not go with a scenario file; write it there")
    changes = {key: given[key] for key in ("rover", "controller", "seed", "carry") if key in given}
    return read_scenario(path).model_copy(update=changes)


def _point(option: str, text: str) -> tuple[float, float]:
    from ..core import SettingError

    try:
        x, y = (float(part) for part in text.split(","))
    except ValueError:
        x = y = math.nan
    if not (math.isfinite(x) and math.isfinite(y)):
        raise SettingError(f"{option} must be two numbers X,Y like -3.5,1.2, got {text!r}")
    return x, y


def to_point(ground: Terrain | Raster, options: Mapping[str, Any], end: str) -> tuple[float, float]:
    """The local point [m] that --from or --to names on a terrain, in the frame of --frame.

    Raises:
        SettingError: It is not two numbers, or there is no such frame.
    """
    from ..core import FRAMES, SettingError, suggest

    frame = options["frame"] or FRAMES[0]
    if frame not in FRAMES:
        raise SettingError(f"--frame has no {frame!r}; {suggest(frame, FRAMES)}")
    return ground.frame.place(*_point(f"--{end}", options[end]), frame)
