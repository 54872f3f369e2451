"""Routes over cost maps: the cheapest way, over the grid or in any direction."""

from ._any_angle import any_angle
from ._costs import CostMap
from ._field import Field, cost_to_go, travel_time
from ._movingai import Scenarios, read_map, read_scenarios, solve_scenarios
from ._route import Route, Way
from ._shortest import shortest

__all__ = [
    "CostMap",
    "Field",
    "Route",
    "Scenarios",
    "Way",
    "any_angle",
    "cost_to_go",
    "read_map",
    "read_scenarios",
    "shortest",
    "solve_scenarios",
    "travel_time",
]
