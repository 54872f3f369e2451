"""`rovernav paper`: the seed paper's training and test case, beside what the paper printed."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from ._console import print_json, print_table, progress_bar, say, say_files
from ._files import claim_folder
from ._options import Json, Out

if TYPE_CHECKING:
    from ..learn import Progress, Training
    from ..scenes import Scene
    from ..sim import Trace

FILES = ("figure3.png", "training.png", "network.safetensors", "trace.npz", "patterns.csv")


def paper(
    *,
    scenario: Annotated[str, Parameter(help="bassil-v1 or bassil-replay-v1.")] = "bassil-v1",
    out: Out = Path("rovernav-paper"),
    json: Json = False,
) -> int:
    """Train the paper's network, drive its test case, and compare with what the paper printed.

    Writes figure3.png, training.png, network.safetensors, trace.npz and patterns.csv.

    Example: rovernav paper --out bassil
    """
    report = run_paper(scenario, out)
    if json:
        print_json(report)
    else:
        print_paper(report)
    return 0


def run_paper(scenario: str, out: Path) -> dict[str, Any]:
    """Train, drive and write the files; returns what there is to tell."""
    from ..control import NeuralController
    from ..learn import paper_training, train
    from ..scenes import bassil_scene
    from ..sim import simulate

    with progress_bar("training and driving"):
        scene = bassil_scene(scenario)
        network, patterns, settings = paper_training(scenario)
        claim_folder(out)
        curve: list[Progress] = []
        training = train(network, patterns, settings, on_event=curve.append)
        trace = simulate(
            scene.drive(NeuralController(training.network)), settings={"scenario": scenario}
        )
        files = [out / name for name in FILES]
        _write(files, training, curve, trace, scene)
        report = _report(training, trace, scene)
    report["files"] = files
    return report


def _report(training: Training, trace: Trace, scene: Scene) -> dict[str, Any]:
    from ..learn import worked_example
    from ..nets import weights_sha256
    from ..sim import clearance

    path = trace.path()
    apex = int(path[:, 1].argmax())
    example = worked_example()
    return {
        "scenario": scene.name,
        "note": scene.note,
        "epochs": training.epoch,
        "updates": training.updates,
        "worked_example": {
            "hidden": example.hidden,
            "outputs": example.outputs,
            "errors": example.errors,
            "new_weights": {"w1": example.w1, "w2": example.w2},
            "outputs_after": example.outputs_after,
        },
        "first": path[1],
        "apex": path[apex],
        "apex_step": apex,
        "before_cut": path[-2],
        "end": path[-1],
        "steps": int(trace.steps[0]),
        "length_m": float(trace.length[0]),
        "clearance": clearance(path, scene.worlds),
        "outcome": trace.ended().label,
        "patterns_met": _patterns_met(trace),
        "weights_sha256": weights_sha256(training.network),
    }


def _patterns_met(trace: Trace) -> dict[str, int]:
    """How often each pair of sensor readings was met: 00, 01, 11, 10."""
    x, y = (trace.channels[name][:, 0, 0] for name in ("clear_sight", "off_line"))
    pairs = [f"{int(a)}{int(b)}" for a, b in zip(x, y, strict=True)]
    return {pair: pairs.count(pair) for pair in ("00", "01", "11", "10")}


def _write(
    files: list[Path], training: Training, curve: list[Progress], trace: Trace, scene: Scene
) -> None:
    from ..learn import describe, paper_training, write_patterns
    from ..nets import save_network
    from ..show import draw_paper_figure, draw_training
    from ..sim import save_trace

    _, patterns, settings = paper_training(scene.name)
    draw_paper_figure(trace, scene, files[0])
    draw_training(
        curve,
        files[1],
        tolerance=settings.tolerance,
        title=f"Training the paper's 2-3-2 network ({scene.name})",
    )
    save_network(describe(training, patterns, settings), files[2])
    save_trace(trace, files[3])
    write_patterns(patterns, files[4])


def print_paper(report: dict[str, Any]) -> None:
    """What the paper printed beside what came out."""
    from ..learn import PRINTED

    def said(*names: str) -> str:
        return ", ".join(PRINTED[name] for name in names)

    example = report["worked_example"]
    w1, w2 = example["new_weights"]["w1"], example["new_weights"]["w2"]
    rows = [
        ("hidden outputs", said("h0", "h1", "h2"), _numbers(example["hidden"], 6)),
        ("outputs", said("O0", "O1"), _numbers(example["outputs"], 6)),
        ("errors", said("error of O0", "error of O1"), _numbers(example["errors"], 6)),
        ("output weight W00", said("new W00 of the outputs"), _numbers(w2[0][:1], 6)),
        ("output weight W01", said("new W01 of the outputs"), _numbers(w2[0][1:2], 6)),
        ("output weight W10", said("new W10 of the outputs"), _numbers(w2[1][:1], 6)),
        ("hidden weight W00", said("new W00 of the hidden layer"), _numbers(w1[0][:1], 6)),
    ]
    print_table("Worked example: one update by hand", ("", "paper", "ours"), rows)
    met = report["patterns_met"]
    rows = [
        ("epochs to tolerance", "not given", str(report["epochs"])),
        ("first point [m]", "0.8287, 0.8287", _numbers(report["first"])),
        ("apex [m]", "5.672, 5.898", _numbers(report["apex"])),
        ("step of the apex", "7 (read off)", str(report["apex_step"])),
        ("before the last step [m]", "not given", _numbers(report["before_cut"])),
        ("end [m]", "11.73, 0", _numbers(report["end"])),
        ("steps", "14 or 15 (read off)", str(report["steps"])),
        ("clearance [m]", "not given", f"{report['clearance']:.3f}"),
        ("readings 00, 01, 11, 10", "not given", ", ".join(map(str, met.values()))),
        ("outcome", "reached", report["outcome"]),
    ]
    print_table(f"Test case: {report['scenario']}", ("", "paper", "ours"), rows)
    say("Readings: how often each pair was sensed; bits: sight clear, off the line.")
    say(report["note"])
    say("Three of the four patterns and the obstacle are ours; the paper gives none.")
    say_files(report["files"])


def _numbers(items: Any, digits: int = 4) -> str:
    return ", ".join(f"{float(item):.{digits}f}".rstrip("0").rstrip(".") or "0" for item in items)
