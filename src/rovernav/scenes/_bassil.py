"""The seed paper's test case, its replay, and the random-rectangle suite around it."""

from __future__ import annotations

import numpy as np

from ..core import F64, Controller, Mapper, Mission, Motion, Sensor, SettingError, suggest, value
from ..sim import ClearSight, Drive, OffLine, TwoAxis, Worlds

A = (0.0, 0.0)
B = (11.73, 0.0)
"""Start and goal of the paper's test case [m]."""
OBSTACLE = (4.365, -1.0, 7.365, 3.75)
"""The obstacle across the x axis; the paper gives none, its height is chosen here [m]."""
STEP = 0.8287
"""Step length, read off the paper's first point [m]."""
BOUNDS = (-20.0, -20.0, 20.0, 20.0)
STEPS = 60
PAPER_POINTS = {"first": (0.8287, 0.8287), "apex": (5.672, 5.898), "end": (11.73, 0.0)}
"""The points that the paper quotes [m]."""


@value
class Scene:
    """A named scene: everything about a drive but its controller.

    Attributes:
        name: Named and versioned; a change that alters results makes a new version.
        worlds: Obstacles.
        mission: Starts and goals.
        sensors: What the rover carries.
        motion: How it moves.
        mapper: Keeps what it sensed, if anything does.
        note: One sentence on what is the paper's and what is ours.
    """

    name: str
    worlds: Worlds
    mission: Mission
    sensors: tuple[Sensor, ...]
    motion: Motion
    mapper: Mapper | None = None
    note: str = ""

    def drive(self, controller: Controller) -> Drive:
        """The scene with somebody at the wheel."""
        return Drive(
            worlds=self.worlds,
            mission=self.mission,
            sensors=self.sensors,
            controller=controller,
            motion=self.motion,
            mapper=self.mapper,
        )


def bassil_scene(name: str = "bassil-v1", *, obstacle: str = "paper") -> Scene:
    """The paper's test case.

    Args:
        name: ``bassil-v1``, or ``bassil-replay-v1``, calibrated to the paper's three points.
        obstacle: ``paper``, ``mirrored`` below the line (a negative control), or ``none``.

    Raises:
        SettingError: Unknown name or obstacle.
    """
    if name not in _PARAMETERS:
        raise SettingError(f"unknown scenario {name!r}; {suggest(name, _PARAMETERS)}")
    if obstacle not in _OBSTACLES:
        raise SettingError(f"unknown obstacle {obstacle!r}; {suggest(obstacle, _OBSTACLES)}")
    step, radius, note = _PARAMETERS[name]
    return Scene(
        name=name,
        worlds=Worlds.single(_OBSTACLES[obstacle], bounds=BOUNDS),
        mission=Mission.between(A, B, goal_radius=radius, time_limit=float(STEPS)),
        sensors=(ClearSight(), OffLine(step / 2)),
        motion=TwoAxis(period=1.0),
        note=note,
    )


def random_rectangles(count: int, rng: np.random.Generator) -> Scene:
    """The suite ``random-rectangles-v1``: one rectangle across the line A-B in each world.

    Centre 3 to 8.7 m along the line, half-width 0.3 to 2.5 m, reaching 0.3 to 4.5 m above and
    below it, all uniform; otherwise the paper's test case.

    Args:
        count: Number of worlds.
        rng: Where the rectangles come from.
    """
    return rectangle_scene(draw_rectangles(count, rng))


def rectangle_scene(boxes: F64) -> Scene:
    """The test case with one rectangle (n, 4) of one's own in each of n worlds."""
    one = bassil_scene()
    n = len(boxes)
    return Scene(
        name="random-rectangles-v1",
        worlds=Worlds.one_box_each(boxes, bounds=BOUNDS),
        mission=Mission(
            start=np.tile(one.mission.start, (n, 1)),
            goal=np.tile(one.mission.goal, (n, 1)),
            goal_radius=one.mission.goal_radius,
            time_limit=one.mission.time_limit,
        ),
        sensors=one.sensors,
        motion=one.motion,
        note="The paper shows one obstacle; these show how far two bits reach.",
    )


def draw_rectangles(count: int, rng: np.random.Generator) -> F64:
    """Rectangles (count, 4) of the suite: x0, y0, x1, y1 [m]."""
    centre, half, above, below = rng.uniform(
        (3.0, 0.3, 0.3, 0.3), (8.7, 2.5, 4.5, 4.5), (count, 4)
    ).T
    return np.stack([centre - half, -below, centre + half, above], axis=1)


def scenario_names() -> list[str]:
    """Names of the paper's scenarios."""
    return sorted(_PARAMETERS)


_PARAMETERS = {
    "bassil-v1": (STEP, 1e-9, "Step and obstacle are ours; the end is exact by construction."),
    "bassil-replay-v1": (1.0, 0.05, "Calibrated: six numbers in, six out."),
}
_OBSTACLES: dict[str, tuple[tuple[float, ...], ...]] = {
    "paper": (OBSTACLE,),
    "mirrored": ((OBSTACLE[0], -OBSTACLE[3], OBSTACLE[2], -OBSTACLE[1]),),
    "none": (),
}
