"""Routes over cost maps: the cheapest way, over the grid or in any direction."""

from ._any_angle import any_angle
from ._barriers import Barrier, barriers
from ._costs import CostMap
from ._directed import directed
from ._far import travel_far, why_far
from ._field import Field, cost_to_go, travel_time
from ._going import OBJECTIVES, Going, going
from ._lookout import survey
from ._movingai import Scenarios, read_map, read_scenarios, solve_scenarios
from ._profile import Profile, profile, waypoints, why_here
from ._route import Route, Way
from ._route_file import read_route
from ._shortest import shortest
from ._stretch import Errand
from ._survey import Survey
from ._trip import ORDERS, Far, Trip, cost_matrix, held_karp, travel
from ._zones import Zones, read_zones, within_zones

__all__ = [
    "OBJECTIVES",
    "ORDERS",
    "Barrier",
    "CostMap",
    "Errand",
    "Far",
    "Field",
    "Going",
    "Profile",
    "Route",
    "Scenarios",
    "Survey",
    "Trip",
    "Way",
    "Zones",
    "any_angle",
    "barriers",
    "cost_matrix",
    "cost_to_go",
    "directed",
    "going",
    "held_karp",
    "profile",
    "read_map",
    "read_route",
    "read_scenarios",
    "read_zones",
    "shortest",
    "solve_scenarios",
    "survey",
    "travel",
    "travel_far",
    "travel_time",
    "waypoints",
    "why_far",
    "why_here",
    "within_zones",
]
