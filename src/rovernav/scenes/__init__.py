"""Named scenes and suites: worlds, missions and rovers, without a controller."""

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
from ._ground import FRAMES, Ground, equip, fenced, ground_scene, to_local
from ._named import named_scene, scene_names
from ._practice import free_pairs, pair_mission, practice_grid
from ._scenario import Scenario, on_terrain, read_scenario, set_scene

__all__ = [
    "BOUNDS",
    "FRAMES",
    "OBSTACLE",
    "PAPER_POINTS",
    "STEP",
    "A",
    "B",
    "Ground",
    "Scenario",
    "Scene",
    "bassil_scene",
    "draw_rectangles",
    "equip",
    "fenced",
    "free_pairs",
    "ground_scene",
    "named_scene",
    "on_terrain",
    "pair_mission",
    "practice_grid",
    "random_rectangles",
    "read_scenario",
    "rectangle_scene",
    "scenario_names",
    "scene_names",
    "set_scene",
    "to_local",
]
