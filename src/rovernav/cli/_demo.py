"""`rovernav demo`: everything once, in under a minute."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from ._console import print_json, progress_bar, say
from ._drive import print_drive, run_drive
from ._files import claim_folder
from ._options import InFile, Json, Out, Seed
from ._paper import print_paper, run_paper

if TYPE_CHECKING:
    import numpy as np

    from ..scenes import Scene
    from ..sim import Trace

YARD = Path("dem/earth_marsyard2021_9cm/marsyard_terrain_hm.tif")
JEZERO = Path("dem/mars_jezero_hirise/meta.json")
REAL_DRIVES = (
    ("yard-paper-reached", YARD, "11,22", "35,19", "bassil"),
    ("yard-paper-collided", YARD, "20,34", "35,13", "bassil"),
    ("yard-neural", YARD, "20,34", "35,13", "neural"),
    ("jezero-neural", JEZERO, "1054,2494", "1257,1493", "neural"),
)
"""Name, terrain, from, to [m], controller."""


def demo(
    *,
    out: Out = Path("rovernav-demo"),
    data: Annotated[
        InFile | None, Parameter(help="Folder of real terrain; default $ROVERNAV_DATA if set.")
    ] = None,
    seed: Seed = 1,
    json: Json = False,
) -> int:
    """Drive the paper's network and the neural driver: test case, rectangles, hills, real ground.

    Example: rovernav demo --out demo
    """
    began = time.monotonic()
    folder = _data_folder(data)
    claim_folder(out)
    tell: Callable[[str], None] = (lambda text: None) if json else say
    report: dict[str, Any] = {}

    tell("1. The paper's training and test case")
    report["paper"] = run_paper("bassil-v1", out / "paper")
    if not json:
        print_paper(report["paper"])
    tell("\n2. Three random rectangles across its way")
    report["rectangles"] = _rectangles(out / "rectangles.png")
    tell(_rectangles_in_words(report["rectangles"]))
    tell("\n3. Generated hills, obstacles that nobody drew: the paper's network")
    report["hills"] = _driven("hills-v1", {"seed": seed}, out / "hills", json=json)
    tell("\n4. Generated hills with rocks: the neural driver, which learnt by imitation")
    report["rocky_hills"] = _driven("rocky-hills-v1", {"seed": seed}, out / "rocky", json=json)
    tell("\n5. Real ground: the Mars Yard (9 cm posts) and Jezero crater (3.7 m posts)")
    if folder is None:
        tell(f"Skipped: no real terrain here; --data FOLDER names a folder that has {YARD}")
    for name, terrain, start, goal, controller in REAL_DRIVES if folder else ():
        if folder is None or not (folder / terrain).is_file():
            continue
        tell(f"\n{name.replace('-', ', ')}: {start} to {goal}")
        options = {"terrain": folder / terrain, "from": start, "to": goal, "frame": "local"}
        options["controller"] = controller
        report[name] = _driven(None, options, out / name, json=json)

    report["seconds"] = time.monotonic() - began
    report["pictures"] = sorted(out.rglob("*.png"))
    if json:
        print_json(report)
    else:
        say(f"\nDone in {report['seconds']:.0f} s. Pictures:")
        for picture in report["pictures"]:
            say(f"  {picture}")
    return 0


def _driven(
    scenario: str | None, options: dict[str, Any], out: Path, *, json: bool
) -> dict[str, Any]:
    report, title = run_drive(scenario, options, out=out)
    if not json:
        print_drive(report, title)
    return report


def _rectangles(picture: Path) -> dict[str, Any]:
    """Three worlds of the suite: two that end well and one that does not, and the share of each."""
    import numpy as np

    from ..core import Outcome
    from ..scenes import draw_rectangles
    from ..show import draw_worlds

    with progress_bar("rectangles"):
        boxes = draw_rectangles(5000, np.random.default_rng(0))
        _, whole = _among(boxes, "none")
        good = np.flatnonzero(whole.outcome == Outcome.REACHED)[:2]
        bad = np.flatnonzero(whole.outcome == Outcome.COLLIDED)[:1]
        scene, trace = _among(boxes[np.concatenate([good, bad])], "all")
        draw_worlds(trace, scene.worlds, picture, columns=3)
    share = {o: float(np.mean(whole.outcome == o)) for o in Outcome}
    reached, collided = share[Outcome.REACHED], share[Outcome.COLLIDED]
    return {
        "worlds": len(boxes),
        "reached": reached,
        "collided": collided,
        "neither": 1.0 - reached - collided,
        "files": [picture],
    }


def _among(boxes: np.ndarray[Any, Any], record: str) -> tuple[Scene, Trace]:
    """The paper's network among rectangles, one in each world."""
    from ..control import NeuralController
    from ..learn import trained_paper_network
    from ..scenes import rectangle_scene
    from ..sim import simulate

    scene = rectangle_scene(boxes)
    drive = scene.drive(NeuralController(trained_paper_network()))
    return scene, simulate(drive, record=record)


def _rectangles_in_words(report: dict[str, Any]) -> str:
    return (
        "It passes two of the three and runs into the third: two bits cannot tell on which\n"
        f"side to pass. Of {report['worlds']:,} random rectangles it passes "
        f"{report['reached']:.1%}, collides with\n{report['collided']:.1%} and is lost in "
        f"{report['neither']:.1%}.\nWritten:\n  {report['files'][0]}"
    )


def _data_folder(data: Path | None) -> Path | None:
    """The folder of real terrain; whoever names one without the Mars Yard is told at once."""
    from ..core import FileError

    named = os.environ.get("ROVERNAV_DATA")
    folder = data or (Path(named) if named else None)
    if folder is None:
        return None
    if not (folder / YARD).is_file():
        if data is not None:
            raise FileError(f"--data {data} has no {YARD}; name the folder that holds it")
        return None
    return folder
