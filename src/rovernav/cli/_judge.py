"""`rovernav inspect FILE --rover NAME`: a terrain judged for a rover."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ._console import print_json, print_pairs, print_table, progress_bar, say, say_files

if TYPE_CHECKING:
    from ..rover import Hazards
    from ..terrain import Terrain

WHOLE = 30_000_000
"""Cells whose layers are told; they take 1.6 GB."""
_DEGREES = 180.0 / math.pi


@dataclass(frozen=True, kw_only=True)
class Judging:
    """What was asked for beyond the file: all None or 0 without a rover."""

    rover: str | None
    soil: str | None
    heading: float | None
    turns: int
    pictures: Path | None

    def needs_a_rover(self, *, explain: bool) -> None:
        """Refuse options that say nothing without a rover.

        Raises:
            SettingError: One of them was given.
        """
        from ..core import SettingError

        given = {
            "--soil": self.soil is not None,
            "--heading": self.heading is not None,
            "--turns": self.turns != 0,
            "--layers": self.pictures is not None,
            "--explain": explain,
        }
        for name, was_given in given.items():
            if was_given:
                raise SettingError(f"{name} needs a rover to judge the terrain for; add --rover")


def judge(
    file: Path, given: Mapping[str, Any], asked: Judging, *, explain: bool, json: bool
) -> int:
    """Judge a terrain, say how, and draw its layers if asked to."""
    from ..core import FileError, SettingError
    from ..rover import hazards, read_rover
    from ..terrain import open_raster, read_part

    if asked.turns < 0:
        raise SettingError(f"--turns must be at least 0, got {asked.turns}")
    if asked.heading is not None and not math.isfinite(asked.heading):
        raise SettingError(f"--heading must be a finite number of degrees, got {asked.heading}")
    rover = read_rover(asked.rover or "")
    heading = None if asked.heading is None else math.radians(asked.heading)
    with progress_bar("judging"):
        raster = open_raster(
            file, cell=given["cell"], heights=given["heights"],
            south_first=bool(given["south-first"]),
        )  # fmt: skip
        h, w = raster.frame.shape
        if h * w > WHOLE:
            raise FileError(
                f"{file} has {w:,} x {h:,} cells, and layers are told of at most {WHOLE:,}; cut a "
                f"part out (rovernav terrain export {file.name} --window WEST,SOUTH,EAST,NORTH "
                "--out part.tif), or average (--factor N)"
            )
        terrain = read_part(raster, None, 1)
        found = hazards(terrain, rover, soil=asked.soil, heading=heading, turns=asked.turns)
        report = _report(file, terrain, found)
    files: list[Path] = []
    if asked.pictures is not None:
        files = _draw(terrain, found, asked.pictures)
        report["files"] = files
    if json:
        print_json(report)
    else:
        _print(report, found, explain=explain)
        if files:
            say_files(files)
    return 0


def _report(file: Path, terrain: Terrain, found: Hazards) -> dict[str, Any]:
    return {
        "kind": "hazards",
        "file": file,
        "rover": found.rover,
        "soil": found.soil,
        "heading_deg": None if found.heading is None else found.heading * _DEGREES,
        "cell_m": terrain.frame.cell,
        "forbidden_share": found.standing.share,
        "share_by_reason": found.standing.share_by_reason(),
        "layers": [layer.summary() for layer in found.layers.values()],
    }


def _print(report: dict[str, Any], found: Hazards, *, explain: bool) -> None:
    say(f"{report['file']}: judged for {found.rover}\n")
    shares = report["share_by_reason"]
    why = ", ".join(
        f"{name.replace('_', ' ')} {share:.1%}" for name, share in shares.items() if name != "free"
    )
    print_pairs(
        [
            ("free", f"{shares['free']:.1%}"),
            ("forbidden", f"{report['forbidden_share']:.1%} ({why})"),
            ("soil", found.soil or "none: the rover's file says nothing of mass and motors"),
            ("slip, energy", "uphill" if found.heading is None else "at the heading given"),
        ]
    )
    say()
    print_table(
        "layers",
        ["layer", "unit", "5 %", "median", "95 %", "highest", "known"],
        [_row(layer) for layer in report["layers"]],
    )
    if explain:
        for layer in report["layers"]:
            say(f"{layer['name']} [{layer['unit']}]")
            print_pairs([(key, layer[key]) for key in ("words", "formula", "source")])
            say()


def _row(layer: dict[str, Any]) -> list[str]:
    scale, unit = (_DEGREES, "deg") if layer["unit"] == "rad" else (1.0, layer["unit"])
    numbers = [f"{scale * layer[key]:.4g}" for key in ("p5", "median", "p95", "highest")]
    return [layer["name"], unit, *numbers, f"{layer['known']:.1%}"]


def _draw(terrain: Terrain, found: Hazards, folder: Path) -> list[Path]:
    from ..show import draw_layer, draw_terrain

    files: list[Path] = []
    with progress_bar("drawing") as tick:
        title = f"{terrain.name} judged for {found.rover}"
        path = folder / "standing.png"
        files.append(draw_terrain(terrain, path, standing=found.standing, title=title))
        for n, layer in enumerate(found.layers.values()):
            tick((n + 1) / (len(found.layers) + 1), layer.name)
            files.append(draw_layer(terrain, layer, folder / f"{layer.name}.png"))
    return files
