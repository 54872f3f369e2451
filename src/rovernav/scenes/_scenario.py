"""Scenario files: a drive described in YAML."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from ..core import Mission, SettingError, build, read_yaml
from ..rover import Rover, read_rover
from ..sim import ClearSight, OffLine, TwoAxis, Worlds
from ..terrain import Terrain, read_terrain
from ._bassil import Scene
from ._ground import PATIENCE, Ground, ground_scene, to_local

Number = Annotated[float, Field(allow_inf_nan=False)]
Point = tuple[Number, Number]
Box = tuple[Number, Number, Number, Number]


class Scenario(BaseModel):
    """Everything about a drive; the same settings as ``rovernav drive`` takes as options.

    Attributes:
        terrain: Elevation model, relative to the scenario file; or give `boxes`.
        cell: Cell of a terrain file that does not say its own [m].
        boxes: Rectangles x0, y0, x1, y1 [m] on flat ground, where there is no terrain.
        start: Key ``from``: x, y in `frame`.
        goal: Key ``to``: x, y in `frame`.
        frame: How `start` and `goal` are given: ``crs``, ``local`` or ``pixel``.
        rover: Preset or rover file.
        controller: ``bassil`` or a network file.
        time_limit_s: Longest drive [s]; five times the straight line where not given.
        seed: Seed of everything random.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True)

    terrain: Path | None = None
    cell: Annotated[float, Field(gt=0, allow_inf_nan=False)] | None = None
    boxes: tuple[Box, ...] = ()
    start: Point = Field(alias="from")
    goal: Point = Field(alias="to")
    frame: Literal["crs", "local", "pixel"] = "crs"
    rover: str = "paper-point"
    controller: str = "bassil"
    time_limit_s: Annotated[float, Field(gt=0, le=1e9, allow_inf_nan=False)] | None = None
    seed: Annotated[int, Field(ge=0, lt=2**63)] = 0

    @model_validator(mode="after")
    def _one_ground(self) -> Scenario:
        if self.terrain is not None and self.boxes:
            raise ValueError("give a terrain or boxes, not both")
        return self


def read_scenario(path: Path) -> Scenario:
    """Read a scenario file.

    Raises:
        FileError: It cannot be read or is not YAML.
        SettingError: An unknown key or a value that is not allowed.
    """
    data: dict[str, Any] = read_yaml(path, what="scenario file")
    scenario = build(Scenario, data, source=str(path))
    if scenario.terrain is not None:
        return scenario.model_copy(update={"terrain": path.parent / scenario.terrain})
    return scenario


def set_scene(scenario: Scenario) -> Scene | Ground:
    """The scene that a scenario describes: on an elevation model, or flat with boxes.

    Raises:
        RovernavError: The terrain or rover cannot be read, or start or goal cannot be stood on.
    """
    rover = read_rover(scenario.rover)
    if scenario.terrain is None:
        return _flat(scenario, rover)
    return on_terrain(scenario, read_terrain(scenario.terrain, cell=scenario.cell), rover)


def on_terrain(scenario: Scenario, terrain: Terrain, rover: Rover) -> Ground:
    """The scene of a scenario on a terrain that has been read already."""
    return ground_scene(
        terrain,
        rover,
        to_local(terrain, scenario.start, scenario.frame),
        to_local(terrain, scenario.goal, scenario.frame),
        time_limit=scenario.time_limit_s,
    )


def _flat(scenario: Scenario, rover: Rover) -> Scene:
    if rover.drive != "two-axis":
        raise SettingError(f"rover {rover.name}: only two-axis rovers can drive among boxes")
    points = [scenario.start, scenario.goal, *[b[:2] for b in scenario.boxes]]
    points += [b[2:] for b in scenario.boxes]
    far = max(max(abs(x), abs(y)) for x, y in points)
    edge = max(20.0, 2.0 * far)
    mission = Mission.between(scenario.start, scenario.goal, goal_radius=1e-9, time_limit=1.0)
    straight = float(abs(complex(*(mission.goal - mission.start[:, :2])[0])))
    limit = scenario.time_limit_s or max(60.0, PATIENCE * straight / rover.step)
    return Scene(
        name="boxes",
        worlds=Worlds.single(scenario.boxes, bounds=(-edge, -edge, edge, edge)),
        mission=Mission.between(scenario.start, scenario.goal, goal_radius=1e-9, time_limit=limit),
        sensors=(ClearSight(), OffLine(rover.step / 2)),
        motion=TwoAxis(period=1.0),
    )
