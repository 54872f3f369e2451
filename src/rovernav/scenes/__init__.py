"""Named scenes and suites: worlds, missions and rovers, without a controller."""

from ..core import FRAMES
from ._bassil import (
    BOUNDS,
    OBSTACLE,
    PAPER_POINTS,
    STEP,
    A,
    B,
    Scene,
    bassil_scene,
    draw_rectangles,
    random_rectangles,
    rectangle_scene,
    scenario_names,
)
from ._embodied import embodied
from ._generated import GENERATORS, Hills, generate
from ._ground import (
    Ground,
    among,
    check_end,
    equip,
    fenced,
    ground_scene,
    nearest_free,
    to_local,
)
from ._named import named_scene, scene_names
from ._practice import another_task, free_pairs, pair_mission, practice_grid, practice_task
from ._scenario import (
    Scenario,
    carry,
    obstacles,
    on_terrain,
    read_scenario,
    scenario_text,
    set_scene,
    strewn,
)
from ._sensing import SENSING, sensed

__all__ = [
    "BOUNDS",
    "FRAMES",
    "GENERATORS",
    "OBSTACLE",
    "PAPER_POINTS",
    "SENSING",
    "STEP",
    "A",
    "B",
    "Ground",
    "Hills",
    "Scenario",
    "Scene",
    "among",
    "another_task",
    "bassil_scene",
    "carry",
    "check_end",
    "draw_rectangles",
    "embodied",
    "equip",
    "fenced",
    "free_pairs",
    "generate",
    "ground_scene",
    "named_scene",
    "nearest_free",
    "obstacles",
    "on_terrain",
    "pair_mission",
    "practice_grid",
    "practice_task",
    "random_rectangles",
    "read_scenario",
    "rectangle_scene",
    "scenario_names",
    "scenario_text",
    "scene_names",
    "sensed",
    "set_scene",
    "strewn",
    "to_local",
]
