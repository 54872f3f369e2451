"""`rovernav inspect`: what is in a file, in words."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from ._bodies import body_report
from ._console import print_json, print_pairs, print_table, progress_bar, say
from ._ground import print_ground, print_map, read_ground, read_map
from ._judge import Judging, judge
from ._options import Cell, Grey, InFile, Json, SouthFirst, Whole, numbers

if TYPE_CHECKING:
    from ..nets import Network
    from ..sim import Trace


def inspect(
    file: Annotated[InFile, Parameter(help="A network, trace, terrain or map file.")],
    /,
    *,
    cell: Cell | None = None,
    heights: Grey | None = None,
    south_first: SouthFirst = False,
    world: Annotated[Whole | None, Parameter(help="Which world of an archive of maps.")] = None,
    rover: Annotated[
        str | None,
        Parameter(help="Judge a terrain for this rover: a preset, or a .yaml file of your own."),
    ] = None,
    soil: Annotated[
        str | None, Parameter(help="Soil for slip and energy; the rover's own if not given.")
    ] = None,
    heading: Annotated[
        float | None,
        Parameter(
            allow_leading_hyphen=True,
            help="Direction of travel, from east towards north [deg]; uphill if not given.",
        ),
    ] = None,
    turns: Annotated[
        int, Parameter(help="Headings at which to bound tilt and clearance of every cell; slow.")
    ] = 0,
    explain: Annotated[
        bool, Parameter(negative="", help="Say of each layer how it comes about, and whence.")
    ] = False,
    layers: Annotated[
        Path | None, Parameter(help="Folder for a picture of each layer; made if needed.")
    ] = None,
    json: Json = False,
) -> int:
    """Say what a network, trace, terrain or map file holds, and what to beware of.

    Of an elevation model it tells where it lies, how steep it is, and how far its heights can be
    trusted: holes, steps of rounding, noise between posts.

    With --rover a terrain is judged for that rover: where it can stand, slope, roughness, steps,
    slip, energy.

    Example: rovernav inspect rovernav-paper/network.safetensors
    """
    from ..core import SettingError

    kind = _kind(file)
    given = {"cell": cell, "heights": numbers("--heights", heights, 2)}
    given |= {"south-first": south_first or None, "world": world}
    for option, item in given.items():
        if item is not None and kind != ("map" if option == "world" else "terrain"):
            goes = "an archive of maps" if option == "world" else "a terrain"
            also = " that does not say it" if option == "cell" else ""
            raise SettingError(f"--{option} goes only with {goes}{also}; {file} is a {kind}")
    asked = Judging(rover=rover, soil=soil, heading=heading, turns=turns, pictures=layers)
    if rover is not None:
        if kind != "terrain" and (kind != "map" or world is not None):
            raise SettingError(f"--rover goes only with a terrain; {file} is a {kind}")
        return judge(file, given, asked, explain=explain, json=json)
    asked.needs_a_rover(explain=explain)
    with progress_bar("reading"):
        report = _READERS[kind](file, given)
    if json:
        print_json({"kind": kind, "file": file, **report})
    else:
        _WRITERS[kind](file, report)
    return 0


def _kind(file: Path) -> str:
    """Told by the first bytes, not by the name."""
    from ..core import FileError

    if file.is_dir():
        return "terrain"
    try:
        with file.open("rb") as stream:
            head = stream.read(16)
    except FileNotFoundError:
        raise FileError(f"there is no file at {file}; check the path") from None
    except OSError as error:
        raise FileError(f"cannot read {file}: {error.strerror}") from error
    if head.startswith(b"PK") or file.suffix.lower() == ".npz":
        return _archive(file)
    if head.startswith(b"\x1f\x8b") or head.lstrip().startswith((b"<sdf", b"<?xml version=")):
        return _world_or_label(file)
    if head[8:10] == b'{"' or file.suffix.lower() == ".safetensors":
        return "network"
    if file.suffix.lower() in (".yaml", ".yml"):
        return "map"
    if not head.startswith((b"II", b"MM", b"\x93NUMPY")) and file.suffix.lower() in _TEXTS:
        raise FileError(f"{file} is {_TEXTS[file.suffix.lower()]}; {_KNOWN}")
    return "terrain"


def _archive(file: Path) -> str:
    """What a zip archive of arrays holds, by their names."""
    import zipfile

    try:
        with zipfile.ZipFile(file) as archive:
            names = {name.removesuffix(".npy") for name in archive.namelist()}
    except (OSError, zipfile.BadZipFile):
        return "trace"
    if "world_ids" in names:
        return "map"
    return "terrain" if names & {"elevation", "heights", "height", "dem", "z"} else "trace"


def _world_or_label(file: Path) -> str:
    with file.open("rb") as stream:
        return "terrain" if b"<Product_Observational" in stream.read(4096) else "map"


_KNOWN = "inspect reads networks (.safetensors), traces (.npz), elevation models and maps"
_TEXTS = {".geojson": "a path, which any map program shows"}


def _read_network(file: Path, given: Mapping[str, Any]) -> dict[str, Any]:
    from ..nets import load_network, topology_text, weights_sha256

    network = load_network(file)
    card = network.card
    return {
        "topology": topology_text(network.topology),
        "activations": network.activations,
        "parameters": len(network.parameters),
        "precision": str(network.parameters.dtype),
        "inputs": card.inputs,
        "input_units": card.input_units,
        "outputs": card.outputs,
        "output_units": card.output_units,
        "seed": card.seed,
        "weights_sha256": weights_sha256(network),
        "codec": None if card.codec is None else dict(card.codec),
        "training": None if card.training is None else dict(card.training),
        "layers": _layers(network),
    }


def _layers(network: Network) -> list[dict[str, Any]]:
    return [
        {
            "layer": number,
            "units": matrix.shape[0],
            "inputs": matrix.shape[1] - 1,
            "smallest": float(matrix.min()),
            "largest": float(matrix.max()),
            "rms": float((matrix.astype(float) ** 2).mean() ** 0.5),
        }
        for number, matrix in enumerate(network.matrices, 1)
    ]


def _read_trace(file: Path, given: Mapping[str, Any]) -> dict[str, Any]:
    import numpy as np

    from ..core import Outcome
    from ..sim import load_trace

    trace: Trace = load_trace(file)
    counts = np.bincount(trace.outcome, minlength=len(Outcome))
    return {
        "rovers": len(trace.outcome),
        "steps": int(trace.steps.max()),
        "time_s": float(trace.time[-1].max()),
        "outcomes": {o.label: int(counts[o]) for o in Outcome if counts[o]},
        "first_start": trace.mission.start[0, :2],
        "first_end": trace.pose[-1, 0, :2],
        "first_length_m": float(trace.length[0]),
        "body_of_first": body_report(trace),
        "sensors": sorted(trace.channels),
        "seed": trace.seed,
        "settings": dict(trace.settings),
        "rovernav": trace.version,
    }


def _print_network(file: Path, report: dict[str, Any]) -> None:
    say(f"{file}: a {report['topology']} network\n")
    named = {
        key: ", ".join(_with_units(report[f"{key}s"], report[f"{key}_units"])) or "unnamed"
        for key in ("input", "output")
    }
    print_pairs(
        [
            ("activations", ", ".join(report["activations"])),
            ("parameters", f"{report['parameters']:,}, {report['precision']}"),
            ("inputs", named["input"]),
            ("outputs", named["output"]),
            ("seed", "none" if report["seed"] is None else str(report["seed"])),
            ("weights_sha256", short(report["weights_sha256"])),
        ]
    )
    for title, empty in (("codec", "none: not for driving"), ("training", "not stated")):
        say(f"\n{title}")
        print_pairs(_pairs(report[title]) if report[title] else [("", empty)])
    say()
    columns = list(report["layers"][0])
    print_table("layers", columns, [[_shown(row[c]) for c in columns] for row in report["layers"]])


def _print_trace(file: Path, report: dict[str, Any]) -> None:
    drives = report["rovers"]
    say(f"{file}: a trace of {drives:,} drive{'s' if drives != 1 else ''}\n")
    of = "" if drives == 1 else " of the first"
    ends = ", ".join(f"{label.replace('_', ' ')} {n:,}" for label, n in report["outcomes"].items())
    print_pairs(
        [
            ("outcome", ends if drives > 1 else next(iter(report["outcomes"]))),
            ("steps", f"{report['steps']:,}"),
            ("time", f"{report['time_s']:.1f} s"),
            (f"start{of}", _point(report["first_start"])),
            (f"end{of}", _point(report["first_end"])),
            (f"length{of}", f"{report['first_length_m']:.3f} m"),
            *_body_pairs(report["body_of_first"], of),
            ("sensors", ", ".join(report["sensors"]) or "none recorded"),
            ("seed", str(report["seed"])),
            ("rovernav", report["rovernav"]),
        ]
    )
    if report["settings"]:
        say("\nsettings")
        print_pairs(_pairs(report["settings"]))


def _body_pairs(body: Mapping[str, float], of: str) -> list[tuple[str, str]]:
    """Energy, tilt and slip of a rover with a body; nothing for a point."""
    if not body:
        return []
    return [
        (f"energy{of}", f"{body['energy_kj']:.3f} kJ"),
        (f"worst tilt{of}", f"{body['worst_tilt_deg']:.1f} deg"),
        (f"slip{of}", f"{body['mean_slip']:.1%} on average, {body['worst_slip']:.1%} at most"),
    ]


_READERS = {
    "network": _read_network, "trace": _read_trace, "terrain": read_ground, "map": read_map,
}  # fmt: skip
_WRITERS = {
    "network": _print_network, "trace": _print_trace, "terrain": print_ground, "map": print_map,
}  # fmt: skip


def short(digest: str) -> str:
    """A hash short enough for a line; --json has the whole."""
    return f"{digest[:12]}..."


def _with_units(names: tuple[str, ...], units: tuple[str, ...]) -> list[str]:
    return [f"{n} [{u}]" for n, u in zip(names, units, strict=True)] if units else list(names)


def _pairs(mapping: Mapping[str, Any]) -> list[tuple[str, str]]:
    return [
        (key, short(item) if "sha256" in key and isinstance(item, str) else _shown(item))
        for key, item in mapping.items()
    ]


def _point(point: Any) -> str:
    return f"({float(point[0]):.3f}, {float(point[1]):.3f}) m"


def _shown(item: Any) -> str:
    if isinstance(item, bool):
        return "yes" if item else "no"
    if isinstance(item, (list, tuple)):
        return ", ".join(map(_shown, item)) or "none"
    return f"{item:.6g}" if isinstance(item, float) else str(item)
