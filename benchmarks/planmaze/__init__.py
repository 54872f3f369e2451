"""One route through a large maze; all but the map is that of `plan`."""

from plan import workload

WORKLOAD = workload("planmaze", "maze", "a maze with corridors 56 cells wide")
