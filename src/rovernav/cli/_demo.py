"""`rovernav demo`: everything once, in under a minute."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from ._console import Out, Seed, say

if TYPE_CHECKING:
    from ..nets import Network

YARD = Path("dem/earth_marsyard2021_9cm/marsyard_terrain_hm.tif")


def demo(
    *,
    out: Out = Path("rovernav-demo"),
    data: Annotated[
        Path | None, Parameter(help="Folder of real terrain; default $ROVERNAV_DATA if set.")
    ] = None,
    seed: Seed = 1,
) -> int:
    """Train the paper's network and drive it: its test case, rectangles, hills, real ground.

    Example: rovernav demo --out demo
    """
    from ..learn import trained_paper_network
    from ._drive import drive
    from ._paper import paper

    began = time.monotonic()
    say("1. The paper's training and test case")
    paper(out=out / "paper")
    network = trained_paper_network()
    say("\n2. Three random rectangles across its way")
    _rectangles(network, out / "rectangles.png")
    say("\n3. Generated hills, obstacles that nobody drew")
    drive("hills-v1", seed=seed, out=out / "hills")
    say("\n4. Real ground: the Mars Yard, 9 cm posts")
    _yard(data or _data_folder(), out)
    say(f"\nDone in {time.monotonic() - began:.0f} s. Pictures:")
    for picture in sorted(out.rglob("*.png")):
        say(f"  {picture}")
    return 0


def _rectangles(network: Network, picture: Path) -> None:
    """Three worlds of the suite: two that end well and one that does not, and the share of each."""
    import numpy as np

    from ..control import NeuralController
    from ..core import Outcome
    from ..scenes import draw_rectangles, rectangle_scene
    from ..show import draw_worlds
    from ..sim import Drive, simulate

    boxes = draw_rectangles(5000, np.random.default_rng(0))

    def run(rectangles: np.ndarray, record: str):  # noqa: ANN202
        scene = rectangle_scene(rectangles)
        return scene, simulate(
            Drive(
                worlds=scene.worlds,
                mission=scene.mission,
                sensors=scene.sensors,
                controller=NeuralController(network),
                motion=scene.motion,
            ),
            record=record,
        )

    _, whole = run(boxes, "none")
    good = np.flatnonzero(whole.outcome == Outcome.REACHED)[:2]
    bad = np.flatnonzero(whole.outcome == Outcome.COLLIDED)[:1]
    scene, trace = run(boxes[np.concatenate([good, bad])], "all")
    draw_worlds(trace, scene.worlds, picture, columns=3)
    share = {o: float(np.mean(whole.outcome == o)) for o in Outcome}
    reached, collided = share[Outcome.REACHED], share[Outcome.COLLIDED]
    say("It passes two of the three and runs into the third: two bits cannot tell on which side")
    say(f"to pass. Of {len(boxes):,} random rectangles it passes {reached:.1%}, collides with")
    say(f"{collided:.1%} and is lost in {1 - reached - collided:.1%}.")
    say(f"Written:\n  {picture}")


def _data_folder() -> Path | None:
    named = os.environ.get("ROVERNAV_DATA")
    return Path(named) if named else None


def _yard(data: Path | None, out: Path) -> None:
    from ._drive import drive

    if data is None or not (data / YARD).exists():
        say("Skipped: no Mars Yard model here; --data FOLDER names a folder that has " + str(YARD))
        return
    for name, start, goal in (
        ("yard-reached", "12,20", "35,20"),
        ("yard-collided", "12,20", "35,15"),
    ):
        drive(terrain=data / YARD, start=start, goal=goal, frame="local", out=out / name)
