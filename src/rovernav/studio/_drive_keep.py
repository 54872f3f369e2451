"""A finished drive as the library keeps it, and back."""

from __future__ import annotations

import dataclasses
import json
import tempfile
from pathlib import Path
from typing import Any

from ..core import SettingError
from ..export import write_path_csv, write_path_geojson
from ..nets import network_bytes
from ..scenes import scenario_text
from ..sim import save_trace
from ._drive_run import DriveRun
from ._drive_world import Obstacle, World

SCENARIO, NETWORK, TERRAIN = "scenario.yaml", "network.safetensors", "terrain.tif"
UPLOADS = "rovernav-studio-"
"""How the folders for uploads begin."""
COMMAND = f"rovernav drive {SCENARIO}"
"""Run in a folder with the files of the drive, it gives the same trace."""


def kept_drive(run: DriveRun, world: World, group: str) -> dict[str, Any]:
    """What `Library.add` takes: command, settings, numbers and files of an ended drive.

    Args:
        run: The drive.
        world: Where it was driven.
        group: The same for all drives that were started together.
    """
    summary = run.summary()
    files, scenario = _files(run, world)
    files[SCENARIO] = scenario.encode()
    where = world.title or (world.ground if not world.flat else "flat ground")
    return {
        "kind": "drive",
        "title": f"{run.pick.label} on {where}: {summary['outcome'].replace('_', ' ')}"[:110],
        "command": COMMAND,
        "settings": {
            "world": plain(world),
            "key": run.pick.key,
            "label": run.pick.label,
            "group": group,
            "scenario": scenario,
        },
        "summary": {**summary, "world": where},
        "files": files,
    }


def _files(run: DriveRun, world: World) -> tuple[dict[str, bytes], str]:
    """All files but the scenario, and its text."""
    assert run.trace is not None
    terrain = None if run.ground is None else run.ground.terrain
    scenario, files = run.scenario, dict[str, bytes]()
    if run.entry.network is not None:
        files[NETWORK] = network_bytes(run.entry.network)
    if world.file is not None and _uploaded(world):
        files[TERRAIN] = world.file.read_bytes()
        scenario = scenario.model_copy(update={"terrain": Path(TERRAIN)})
    elif world.file is not None:
        scenario = scenario.model_copy(update={"terrain": world.file.absolute()})
    with tempfile.TemporaryDirectory() as folder:
        trace, table, line = (
            Path(folder) / name for name in ("trace.npz", "path.csv", "path.geojson")
        )
        save_trace(run.trace, trace)
        write_path_csv(run.trace, table, terrain=terrain)
        write_path_geojson(run.trace, line, terrain=terrain)
        files |= {path.name: path.read_bytes() for path in (trace, table, line)}
    return files, scenario_text(scenario)


def plain(world: World) -> dict[str, Any]:
    """A world as plain data."""
    data = dataclasses.asdict(world)
    data["made"] = dict(world.made)
    data["file"] = None if world.file is None else "uploaded" if _uploaded(world) else "offered"
    return json.loads(json.dumps(data))


def world_from(
    settings: dict[str, Any], offered: dict[str, tuple[Path, float | None]]
) -> tuple[World, str]:
    """The world and the controller's key of a kept drive.

    No path out of the settings is opened: an elevation model must be one that is offered now.

    Raises:
        SettingError: The settings are not those of a drive, or its elevation model is not there.
    """
    try:
        data = dict(settings["world"])
        file = data.pop("file")
        changed: dict[str, Any] = {
            "made": tuple(sorted(data["made"].items())),
            "title": str(data.get("title", ""))[:60],
            "rover": str(data.get("rover", "")),
            "start": tuple(data["start"]),
            "goal": tuple(data["goal"]),
            "obstacles": tuple(
                Obstacle(str(each["kind"]), tuple(map(float, each["numbers"])))
                for each in data["obstacles"]
            ),
        }
        world = World(**{**data, **changed})
        key = str(settings["key"])
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise SettingError(f"these are not the settings of a drive: {error!r}") from None
    if file == "offered" and world.title in offered:
        path, cell = offered[world.title]
        world = dataclasses.replace(world, file=path, cell=cell)
    elif file == "offered":
        raise SettingError(
            f"its elevation model {world.title!r} is not offered by this studio; "
            f"start it with: rovernav studio --terrain {world.title}"
        )
    return world, key


def _uploaded(world: World) -> bool:
    """Whether the elevation model came through the page: then the library holds it."""
    return world.file is not None and world.file.parent.name.startswith(UPLOADS)
