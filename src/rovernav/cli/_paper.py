"""`rovernav paper`: the seed paper's training and test case, beside what the paper printed."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from ._console import Json, Out, print_json, print_table, say, say_files

if TYPE_CHECKING:
    from ..learn import Progress, Training
    from ..scenes import Scene
    from ..sim import Trace


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
    from ..control import NeuralController
    from ..learn import paper_training, train
    from ..scenes import bassil_scene
    from ..sim import Drive, simulate

    scene = bassil_scene(scenario)
    network, patterns, settings = paper_training(scenario)
    curve: list[Progress] = []
    training = train(network, patterns, settings, on_event=curve.append)
    drive = Drive(
        worlds=scene.worlds,
        mission=scene.mission,
        sensors=scene.sensors,
        controller=NeuralController(training.network),
        motion=scene.motion,
    )
    trace = simulate(drive, settings={"scenario": scenario})
    report = _report(training, trace, scene)
    report["files"] = _write(out, training, curve, trace, scene)
    if json:
        print_json(report)
    else:
        _print(report, scene)
    return 0


def _report(training: Training, trace: Trace, scene: Scene) -> dict[str, Any]:
    from ..learn import worked_example
    from ..nets import weights_sha256
    from ..sim import clearance

    path = trace.path()
    apex = int(path[:, 1].argmax())
    example = worked_example()
    return {
        "scenario": scene.name,
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
    out: Path, training: Training, curve: list[Progress], trace: Trace, scene: Scene
) -> list[Path]:
    from ..learn import describe, paper_training, write_patterns
    from ..nets import save_network
    from ..show import draw_paper_figure, draw_training
    from ..sim import save_trace

    _, patterns, settings = paper_training(scene.name)
    files = [
        out / name
        for name in ("figure3.png", "training.png", "network.safetensors", "trace.npz", "patterns.csv")
    ]
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
    return files


def _print(report: dict[str, Any], scene: Scene) -> None:
    example = report["worked_example"]
    w1, w2 = example["new_weights"]["w1"], example["new_weights"]["w2"]
    rows = [
        ("hidden outputs", "0.524, 0.552, 0.665", _numbers(example["hidden"], 6)),
        ("outputs", "0.83, 1.74995", _numbers(example["outputs"], 6)),
        ("errors", '0.17, "0. 74994"', _numbers(example["errors"], 6)),
        ("new output weights W00, W01, W10", "0.13227, 0.05346, 0.83176",
         _numbers((w2[0][0], w2[0][1], w2[1][0]), 6)),
        ("new hidden weight W00", "0.17", _numbers(w1[0][:1], 6)),
    ]  # fmt: skip
    print_table("Worked example: one update by hand", ("", "paper", "ours"), rows)
    rows = [
        ("epochs to tolerance", "not given", str(report["epochs"])),
        ("first point [m]", "0.8287, 0.8287", _numbers(report["first"])),
        ("apex [m]", "5.672, 5.898", _numbers(report["apex"])),
        ("step of the apex", "7 (read off)", str(report["apex_step"])),
        ("before the last step [m]", "not given", _numbers(report["before_cut"])),
        ("end [m]", "11.73, 0", _numbers(report["end"])),
        ("steps", "14 or 15 (read off)", str(report["steps"])),
        ("clearance [m]", "not given", f"{report['clearance']:.3f}"),
        ("readings met (sight, off line)", "not given",
         ", ".join(f"{pair} x{count}" for pair, count in report["patterns_met"].items())),
        ("outcome", "reached", report["outcome"]),
    ]  # fmt: skip
    print_table(f"Test case: {scene.name}", ("", "paper", "ours"), rows)
    say(scene.note)
    say("Three of the four patterns and the obstacle are ours: the paper does not give them.")
    say_files(report["files"])


def _numbers(items: Any, digits: int = 4) -> str:
    return ", ".join(f"{float(item):.{digits}f}".rstrip("0").rstrip(".") or "0" for item in items)
