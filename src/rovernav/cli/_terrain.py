"""`rovernav terrain`: make ground, refine it, and export parts and layers of it."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from ._console import print_json, print_pairs, progress_bar, say, say_files
from ._files import claim_folder, keep_apart
from ._options import Cell, Grey, InFile, Json, Out, OutFile, Seed, SouthFirst, numbers
from ._terrain_options import (
    Age,
    Baseline,
    BoundsOption,
    CliffSizes,
    CraterBody,
    DuneSizes,
    Factor,
    FineCell,
    HoleShare,
    Hurst,
    LayerName,
    LayerRover,
    MadeCell,
    PitNumber,
    Post,
    PostHurst,
    PostSlope,
    RecipeFile,
    RockCover,
    Size,
    Slope,
    Wind,
)  # fmt: skip

if TYPE_CHECKING:
    from ..rover import Layer
    from ..terrain import Refined, Terrain

MADE = ("terrain.tif", "terrain.png", "terrain.json")

LAYERS: dict[str, tuple[str, str, str, str]] = {
    "elevation": ("m", "Height of the ground.", "z", "the elevation model"),
    "slope": (
        "rad", "Angle of the ground between neighbouring posts.", "arctan(hypot(p, q))",
        "B. K. P. Horn, Hill shading and the reflectance map, Proc. IEEE 69 (1981)",
    ),
    "step": ("m", "Largest height difference to a neighbour.", "max |dz|", "the elevation model"),
    "shade": (
        "1", "Brightness under a sun 45 deg high in the north-west.", "cosine of incidence",
        "B. K. P. Horn, Hill shading and the reflectance map, Proc. IEEE 69 (1981)",
    ),
}  # fmt: skip
"""What `export` can write of a terrain by itself: unit, words, formula, source."""


def terrain() -> int:
    """Make ground, refine it below its posts, and export parts and layers of it.

    Example: rovernav terrain make --seed 1 --size 200,200 --rocks 0.05
    """
    return 0


def make(
    recipe: RecipeFile | None = None,
    /,
    *,
    size: Size | None = None,
    cell: MadeCell | None = None,
    hurst: Hurst | None = None,
    slope: Slope | None = None,
    baseline: Baseline | None = None,
    craters: CraterBody | None = None,
    age: Age | None = None,
    dunes: DuneSizes | None = None,
    wind: Wind | None = None,
    cliffs: CliffSizes | None = None,
    pits: PitNumber | None = None,
    rocks: RockCover | None = None,
    holes: HoleShare | None = None,
    seed: Seed = 0,
    out: Out = Path("rovernav-terrain"),
    json: Json = False,
) -> int:
    """Make ground by a seed: relief, craters, dunes, cliffs, pits, rocks and holes.

    Writes terrain.tif, terrain.png and terrain.json: the recipe, and its statistics measured on
    the result beside what was asked for. The same recipe and seed give the same ground.

    Example: rovernav terrain make --seed 1 --size 200,200 --craters mars --rocks 0.05
    """
    from ..show import draw_terrain
    from ..terrain import Ground, measured, read_recipe, recipe_data, recipe_of, write_terrain

    given = {
        "size_m": numbers("--size", size, 2), "cell_m": cell, "rocks": rocks, "holes": holes,
        "relief": _group(hurst=hurst, slope_deg=slope, baseline_m=baseline),
        "craters": _group(body=craters, age_gyr=age),
        "dunes": _group(_pair("--dunes", dunes, ("wavelength_m", "height_m")), wind_deg=wind),
        "cliffs": _pair("--cliffs", cliffs, ("height_m", "spacing_m")),
        "pits": None if pits is None else {"per_km2": pits},
    }  # fmt: skip
    data = {} if recipe is None else read_recipe(recipe)
    data = _merged(data, {key: item for key, item in given.items() if item is not None})
    whole = recipe_of(data, source="the options" if recipe is None else str(recipe))
    ground = Ground.made(whole, seed)
    files = [out / name for name in MADE]
    keep_apart({f"--out ({path.name})": path for path in files}, [recipe])
    claim_folder(out)
    with progress_bar("making") as tell:
        terrain = ground.read(on_progress=lambda share: tell(0.6 * share, "heights"))
        tell(0.6, "measuring")
        settings = {"recipe": recipe_data(whole), "seed": seed}
        report = {**settings, "source": terrain.source, "measured": measured(ground),
                  "files": files}  # fmt: skip
        tell(0.8, "writing")
        write_terrain(terrain, files[0], tags=settings)
        draw_terrain(terrain, files[1], title=terrain.source)
        _write_json(files[2], report)
    if json:
        print_json(report)
    else:
        _say_made(report)
        say_files(files)
    return 0


def refine(
    file: Annotated[InFile, Parameter(help="Elevation model.")],
    /,
    *,
    cell: FineCell = 0.1,
    window: BoundsOption | None = None,
    rocks: RockCover | None = None,
    hurst: PostHurst | None = None,
    slope: PostSlope | None = None,
    post: Post | None = None,
    heights: Grey | None = None,
    south_first: SouthFirst = False,
    seed: Seed = 0,
    out: Out = Path("rovernav-terrain"),
    json: Json = False,
) -> int:
    """Add relief and rocks between the posts of an elevation model, down to 0.1 m and less.

    What is added is invented, with the statistics that the model shows at its own posts; the mean
    over each post stays what it was. Writes terrain.tif, terrain.png and terrain.json. The same
    seed gives the same ground in any window.

    Example: rovernav terrain refine yard.tif --cell 0.05 --window 0,0,20,20 --rocks 0.03 --seed 2
    """
    from ..show import draw_terrain
    from ..terrain import open_raster, write_terrain
    from ..terrain import refine as refine_it

    files = [out / name for name in MADE]
    keep_apart({f"--out ({path.name})": path for path in files}, [file])
    bounds, greys = numbers("--window", window, 4), numbers("--heights", heights, 2)
    raster = open_raster(file, cell=post, heights=greys, south_first=south_first)
    if bounds is not None:
        raster.window(*bounds)
    with progress_bar("refining") as tell:
        fine: Refined = refine_it(
            raster, cell, seed=seed, rocks=rocks, hurst=hurst,
            slope=None if slope is None else math.radians(slope),
        )  # fmt: skip
        part = None if bounds is None else fine.window(*bounds)
        fine.check(part)
        claim_folder(out)
        ground: Terrain = fine.read(part, on_progress=lambda share: tell(0.8 * share, "heights"))
        settings = {"file": file.name, "seed": seed, "refined": fine.statistics()}
        report = {**settings, "source": ground.source, "columns": ground.frame.shape[1],
                  "rows": ground.frame.shape[0], "files": files}  # fmt: skip
        write_terrain(ground, files[0], tags=settings)
        draw_terrain(ground, files[1])
        _write_json(files[2], report)
    if json:
        print_json(report)
    else:
        _say_refined(fine.statistics(), ground)
        say_files(files)
    return 0


def export(
    file: Annotated[InFile, Parameter(help="Elevation model.")],
    /,
    *,
    out: Annotated[OutFile, Parameter(help="File to write: .tif, .png or .npy.")],
    layer: LayerName = "elevation",
    rover: LayerRover | None = None,
    window: BoundsOption | None = None,
    factor: Factor = 1,
    cell: Cell | None = None,
    heights: Grey | None = None,
    south_first: SouthFirst = False,
    json: Json = False,
) -> int:
    """Write a part of an elevation model, or a layer computed from it, as .tif, .png or .npy.

    With --rover the layers are those of the ground judged for it, as rovernav inspect --rover lists
    them: slope under its footing, roughness, slip, energy and more.

    Cells are square and in true metres; a GeoTIFF keeps the coordinates of the model. Models larger
    than memory are read in strips.

    Example: rovernav terrain export yard.tif --layer slope --out slope.tif
    """
    from ..core import SettingError, suggest
    from ..terrain import open_raster, read_part

    if rover is None and layer not in LAYERS:
        raise SettingError(f"there is no layer {layer!r}; {suggest(layer, LAYERS)}")
    if out.suffix.lower() not in WRITERS:
        raise SettingError(f"--out must end in .tif, .png or .npy, got {out.name!r}")
    keep_apart({"--out": out}, [file])
    bounds, greys = numbers("--window", window, 4), numbers("--heights", heights, 2)
    raster = open_raster(file, cell=cell, heights=greys, south_first=south_first)
    if bounds is not None:
        raster.window(*bounds)
        raster = raster.within(bounds)
    with progress_bar("reading") as tell:
        ground = read_part(raster, bounds, factor, on_progress=lambda share: tell(share, ""))
        made = _layer(ground, layer, rover)
        WRITERS[out.suffix.lower()](ground, made, out)
    rows, columns = ground.frame.shape
    if json:
        print_json({"file": out, "layer": layer, "unit": made.unit, "source": ground.source,
                    "columns": columns, "rows": rows, "cell_m": ground.frame.cell,
                    "words": made.words, "formula": made.formula})  # fmt: skip
    else:
        unit = "" if made.unit == "1" else f" [{made.unit}]"
        say(f"{layer}{unit} of {columns:,} x {rows:,} cells of {ground.frame.cell:.6g} m")
        say(f"{made.words}\n")
        say_files([out])
    return 0


TERRAIN: dict[str, Callable[..., int]] = {"make": make, "refine": refine, "export": export}


def _layer(ground: Terrain, name: str, rover: str | None) -> Layer:
    """A layer of the ground, or of the ground judged for a rover; angles in degrees."""
    import numpy as np

    from ..core import SettingError, suggest
    from ..rover import Layer, hazards, read_rover
    from ..terrain import hillshade, slope, step_height

    if rover is not None:
        found = hazards(ground, read_rover(rover)).layers
        if name not in found:
            raise SettingError(f"there is no layer {name!r}; {suggest(name, found)}")
        layer = found[name]
    else:
        made = {"slope": slope, "step": step_height, "shade": hillshade}
        values = made[name](ground) if name in made else ground.height
        unit, words, formula, source = LAYERS[name]
        layer = Layer(
            name=name, values=values, unit=unit, words=words, formula=formula, source=source
        )
    if layer.unit != "rad":
        return layer
    return dataclasses.replace(layer, values=np.degrees(layer.values), unit="deg")


def _to_tif(ground: Terrain, layer: Layer, out: Path) -> None:
    from ..terrain import write_geotiff, write_terrain

    if layer.name == "elevation":
        write_terrain(ground, out)
        return
    tags = {"source": ground.source, "formula": layer.formula, "reference": layer.source}
    write_geotiff(
        layer.values, ground.frame, out, unit=layer.unit, description=layer.words, tags=tags
    )


def _to_png(ground: Terrain, layer: Layer, out: Path) -> None:
    from ..show import draw_layer, draw_terrain

    if layer.name == "elevation":
        draw_terrain(ground, out)
    else:
        draw_layer(ground, layer, out)


def _to_npy(ground: Terrain, layer: Layer, out: Path) -> None:
    import numpy as np

    from ..core import write_atomic

    values = layer.values
    if layer.name == "elevation":
        values = values + np.float64(ground.offset)
    rows = np.ascontiguousarray(values[::-1])  # row 0 north, as the reader takes it
    write_atomic(out, lambda file: np.save(file, rows))


WRITERS: dict[str, Callable[[Any, Any, Path], None]] = {
    ".tif": _to_tif, ".tiff": _to_tif, ".png": _to_png, ".npy": _to_npy,
}  # fmt: skip


def _pair(option: str, text: str | None, keys: tuple[str, str]) -> dict[str, float] | None:
    return None if text is None else dict(zip(keys, numbers(option, text, 2), strict=True))


def _group(first: Mapping[str, Any] | None = None, **items: Any) -> dict[str, Any] | None:
    given = {**(first or {}), **{key: item for key, item in items.items() if item is not None}}
    return given or None


def _merged(data: dict[str, Any], given: Mapping[str, Any]) -> dict[str, Any]:
    """A recipe with the options put into it, group by group."""
    out = dict(data)
    for key, item in given.items():
        old = out.get(key)
        out[key] = {**old, **item} if isinstance(old, dict) and isinstance(item, dict) else item
    return out


def _write_json(path: Path, report: dict[str, Any]) -> None:
    import json

    from ..core import plain_data, write_text

    write_text(path, json.dumps(plain_data(report), indent=2, allow_nan=False) + "\n")


def _say_made(report: dict[str, Any]) -> None:
    found = report["measured"]
    say(f"{report['source']}\n")
    pairs = [
        (
            "slope p50 / p95 / p99",
            " / ".join(f"{d:.1f}" for d in found["slope_deg"].values()) + " deg",
        )
    ]
    if "hurst" in found:
        h, s = found["hurst"], found["rms_slope_deg"]
        pairs.append(("Hurst exponent", f"{h['measured']:.3f}, asked {h['asked']:g}"))
        if s["measured"] is not None:
            over = f"over {s['baseline_m']:g} m"
            pairs.append(("rms slope", f"{s['measured']:.2f} deg {over}, asked {s['asked']:g}"))
    for what in ("craters", "pits"):
        if what in found:
            pairs.append(
                (what, f"{found[what]['count']:,}, expected {found[what]['expected']:,.1f}")
            )
    if "rocks" in found:
        r = found["rocks"]
        cover = f"{r['count']:,} cover {r['cover']:.2%}, asked {r['asked_cover']:.2%}"
        pairs.append(("rocks", f"{cover} from {r['smallest_m']:g} to {r['largest_m']:g} m"))
    if "dunes" in found:
        d = found["dunes"]
        asked = f"asked {d['asked_height_m']:g} and {d['asked_wavelength_m']:g}"
        size = f"{d['height_m']:.3g} m high every {d['wavelength_m']:.3g} m"
        pairs.append(("dunes", f"{size}, {asked}"))
    if "cliffs" in found:
        c = found["cliffs"]
        pairs.append(("cliffs", f"{c['height_m']:.3g} m high, {c['steepest_deg']:.0f} deg steep"))
    if found["holes"]["asked"]:
        pairs.append(
            (
                "without data",
                f"{found['holes']['measured']:.2%}, asked {found['holes']['asked']:.2%}",
            )
        )
    print_pairs(pairs)
    say()


def _say_refined(s: dict[str, Any], ground: Terrain) -> None:
    rows, columns = ground.frame.shape
    say(f"{ground.source}\n")
    pairs = [
        (
            "cells",
            f"{columns:,} x {rows:,} of {s['cell_m']:.4g} m, {s['cells_per_post']} to a post",
        ),
        ("Hurst exponent", f"{s['hurst']:.2f}"),
        ("rms slope at posts", f"{s['rms_slope_deg_at_posts']:.2f} deg over {s['post_m']:.4g} m"),
        ("added between cells", f"{s['added_rms_slope_deg_at_cells']:.2f} deg rms"),
    ]
    if s["rock_sizes_m"] is not None:
        small, large = s["rock_sizes_m"]
        pairs.append(("rocks", f"cover {s['rock_cover']:.2%} from {small:.3g} to {large:.3g} m"))
    print_pairs(pairs)
    say()
