"""`rovernav export`: a trace in a form that other programs read."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from ._console import note, print_json, progress_bar, say_files
from ._files import keep_apart
from ._options import InFile, Json, OutFile, Whole

if TYPE_CHECKING:
    from ..rover import Rover
    from ..scenes import Ground, Scene
    from ..sim import Trace

Tell = Callable[[float, str], None]


def export(
    trace: Annotated[InFile, Parameter(help="The trace.npz of a drive, or its folder.")],
    /,
    *,
    to: Annotated[
        OutFile,
        Parameter(help="What to write, told by its ending: .csv, .geojson, .mcap, .gif or .html."),
    ],
    row: Annotated[Whole, Parameter(help="Which drive of several a .gif shows.")] = 0,
    json: Json = False,
) -> int:
    """Write a drive in a form that other programs read.

    A table of everything (.csv), the ways for a map program (.geojson), a ROS 2 bag that Foxglove
    opens (.mcap, extra ros), a movie (.gif), or a page that shows the drive in three dimensions
    and needs no network (.html).

    The ground is read or made again from the settings in the trace; where that cannot be done the
    drive is written without it, and a line says why.

    Example: rovernav export rovernav-drive/trace.npz --to drive.mcap
    """
    from ..core import SettingError, suggest
    from ..sim import load_trace

    suffix = to.suffix.lower()
    if suffix not in _WRITERS:
        raise SettingError(f"--to {to}: no such form {suffix!r}; {suggest(suffix, _WRITERS)}")
    trace = trace / "trace.npz" if trace.is_dir() else trace
    keep_apart({"--to": to}, [trace])
    with progress_bar("writing") as update:
        loaded = load_trace(trace)
        if not 0 <= row < len(loaded.outcome):
            last = len(loaded.outcome) - 1
            raise SettingError(f"--row must be from 0 to {last} in this trace, got {row}")
        scene = scene_of(loaded)
        _WRITERS[suffix](loaded, to, scene, row, update)
    if json:
        ground = _terrain(scene) is not None
        print_json({"trace": trace, "file": to, "bytes": to.stat().st_size, "ground": ground})
    else:
        say_files([to])
    return 0


def scene_of(trace: Trace) -> Scene | Ground | None:
    """The scene of a trace, set again from its settings; None, and a line that says why not."""
    from ..core import RovernavError, build
    from ..scenes import Scenario, carry, named_scene, set_scene

    settings = dict(trace.settings)
    try:
        if "scenario" in settings:
            scene = named_scene(str(settings["scenario"]), seed=int(settings.get("seed", 0)))
            return carry(scene, settings.get("carry", ()))
        if not {"from", "to"} <= set(settings):
            note("note: this trace does not say where it was driven; it is written without ground")
            return None
        return set_scene(build(Scenario, settings, source="the settings in the trace"))
    except RovernavError as error:
        note(f"note: written without ground: {error}")
        return None


def movie_of(trace: Trace, to: Path, scene: Scene | Ground | None, row: int, update: Tell) -> None:
    """Write the movie of a drive."""
    from ..show import draw_movie

    draw_movie(
        trace, to, k=row, on_event=lambda share: update(share, "frames"), **_around(scene, trace)
    )


def _table(trace: Trace, to: Path, scene: Scene | Ground | None, row: int, update: Tell) -> None:
    from ..export import write_trace_csv

    write_trace_csv(trace, to, terrain=_terrain(scene))


def _lines(trace: Trace, to: Path, scene: Scene | Ground | None, row: int, update: Tell) -> None:
    from ..export import write_path_geojson

    write_path_geojson(trace, to, terrain=_terrain(scene), k=None)


def _bag(trace: Trace, to: Path, scene: Scene | Ground | None, row: int, update: Tell) -> None:
    from ..adapters import write_bag

    sensors = () if scene is None else _inner(scene).sensors
    write_bag(trace, to, terrain=_terrain(scene), sensors=sensors)


def _page(trace: Trace, to: Path, scene: Scene | Ground | None, row: int, update: Tell) -> None:
    from ..show import write_page

    around = _around(scene, trace)
    around.pop("sensors")
    write_page(trace, to, **around)


def _around(scene: Scene | Ground | None, trace: Trace) -> dict[str, Any]:
    """What pictures show beside the drive itself."""
    from ..scenes import Ground

    if scene is None:
        return {"sensors": (), "rover": _rover(trace)}
    inner = _inner(scene)
    around: dict[str, Any] = {"worlds": inner.worlds, "sensors": inner.sensors}
    if isinstance(scene, Ground):
        return {
            **around, "terrain": scene.terrain, "standing": scene.standing, "rover": scene.rover
        }  # fmt: skip
    return {**around, "rover": _rover(trace)}


def _rover(trace: Trace) -> Rover | None:
    """The rover that the settings name."""
    from ..core import RovernavError
    from ..rover import read_rover

    try:
        return read_rover(str(trace.settings.get("rover", "")))
    except RovernavError:
        return None


def _inner(scene: Scene | Ground) -> Scene:
    from ..scenes import Ground

    return scene.scene if isinstance(scene, Ground) else scene


def _terrain(scene: Scene | Ground | None) -> Any:
    return getattr(scene, "terrain", None)


_WRITERS: dict[str, Callable[..., None]] = {
    ".csv": _table,
    ".geojson": _lines,
    ".gif": movie_of,
    ".html": _page,
    ".mcap": _bag,
}
"""What writes each form, by the ending of the file's name."""
