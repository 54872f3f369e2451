"""inspect, template, demo and help."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import numpy as np
import pytest

from rovernav.cli import _console
from rovernav.cli._app import COMMANDS
from rovernav.cli._template import TEMPLATE
from rovernav.kernels import news
from rovernav.rover import presets
from rovernav.scenes import Scenario, read_scenario
from tests.cli.runner import run, tell, write_ground


def test_inspect_a_network() -> None:
    paper = tell("paper", "--out", "p")
    report = tell("inspect", "p/network.safetensors")
    assert (report["kind"], report["topology"], report["parameters"]) == ("network", "2-3-2", 17)
    assert report["weights_sha256"] == paper["weights_sha256"]
    assert report["training"]["epochs_done"] == paper["epochs"]
    assert report["codec"]["step"] == 0.8287
    assert [layer["units"] for layer in report["layers"]] == [3, 2]
    lines = run("inspect", "p/network.safetensors").out.splitlines()
    assert lines[0] == "p/network.safetensors: a 2-3-2 network"
    assert "  activations     sigmoid, linear" in lines
    assert f"  weights_sha256  {paper['weights_sha256'][:12]}..." in lines
    assert max(map(len, lines)) < 80


def test_inspect_a_trace() -> None:
    drive = tell("drive", "bassil-v1", "--out", "d")
    report = tell("inspect", "d/trace.npz")
    assert (report["kind"], report["outcomes"]) == ("trace", {"reached": 1})
    assert (report["steps"], report["first_length_m"]) == (drive["steps"], drive["length_m"])
    assert report["settings"] == drive["settings"]
    lines = run("inspect", "d/trace.npz").out.splitlines()
    assert "  end       (11.730, 0.000) m" in lines
    assert "  scenario    bassil-v1" in lines


def test_inspect_a_terrain(here: Path) -> None:
    write_ground(here / "ground.tif")
    report = tell("inspect", "ground.tif")
    assert (report["kind"], report["columns"], report["rows"]) == ("terrain", 60, 40)
    assert report["bounds"] == [-7.0, -11.0, 23.0, 9.0]
    assert (report["cell_m"], report["size_m"]) == (0.5, [30.0, 20.0])
    assert report["highest_m"] == pytest.approx(0.01 * 32 + 0.02 * 21 + 5.0, abs=1e-5)
    assert report["crs"] == "WGS 84 / UTM zone 33N"
    lines = run("inspect", "ground.tif").out.splitlines()
    assert "  cells                  60 x 40 (columns x rows)" in lines
    assert "  y                      -11 to 9" in lines


def test_inspect_judges_a_terrain_for_a_rover(here: Path) -> None:
    write_ground(here / "ground.tif")
    report = tell("inspect", "ground.tif", "--rover", "research", "--heading", "-90")
    assert (report["kind"], report["rover"], report["soil"]) == ("hazards", "research", "compacted")
    assert report["heading_deg"] == pytest.approx(-90.0, abs=1e-9)
    names = [layer["name"] for layer in report["layers"]]
    assert names[:6] == ["slope", "east", "north", "roughness", "step", "distance"]
    assert names[6:] == ["slip", "energy", "pitch", "roll"]
    step = report["layers"][4]
    assert step["unit"] == "m"
    assert step["highest"] == pytest.approx(5.0, abs=0.1)
    assert 0.0 < report["forbidden_share"] < 0.5
    assert report["forbidden_share"] == pytest.approx(1 - report["share_by_reason"]["free"])
    said = run("inspect", "ground.tif", "--rover", "research", "--explain", "--layers", "seen")
    lines = said.out.splitlines()
    assert lines[0] == "ground.tif: judged for research"
    assert "slope [rad]" in lines
    assert "  formula  arctan(sqrt(p^2 + q^2))" in lines
    assert max(map(len, lines)) <= 80
    pictures = sorted(path.name for path in (here / "seen").iterdir())
    assert pictures == sorted(
        ["standing.png", *(f"{name}.png" for name in names if name not in {"pitch", "roll"})]
    )


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--soil", "crust"), "--soil needs a rover to judge the terrain for; add --rover"),
        (("--explain",), "--explain needs a rover"),
        (("--turns", "4"), "--turns needs a rover"),
        (("--layers", "x"), "--layers needs a rover"),
        (("--heading", "4"), "--heading needs a rover"),
        (("--rover", "perseverence"), "'perseverence'; did you mean 'perseverance'"),
        (("--rover", "research", "--soil", "snd"), "there is no soil 'snd'"),
        (("--rover", "research", "--turns", "-1"), "--turns must be at least 0, got -1"),
        (("--rover", "research", "--heading", "nan"), "--heading must be a finite number"),
        (("--rover", "paper-point", "--turns", "2"), "rover paper-point has no wheels"),
        (("--rover", "paper-point", "--soil", "crust"), "says nothing of its mass and motors"),
    ],
)
def test_judging_with_a_mistake(here: Path, words: tuple[str, ...], message: str) -> None:
    write_ground(here / "ground.tif")
    said = run("inspect", "ground.tif", *words)
    assert said.code == 2
    assert message in said.err
    assert said.err.count("\n") == 1


def test_only_a_terrain_is_judged() -> None:
    tell("paper", "--out", "p")
    said = run("inspect", "p/network.safetensors", "--rover", "research")
    assert said.code == 2
    assert "--rover goes only with a terrain; p/network.safetensors is a network" in said.err


def test_inspect_goes_by_content(here: Path) -> None:
    tell("paper", "--out", "p")
    Path("p/network.safetensors").rename("weights.bin")
    Path("p/trace.npz").rename("run")
    np.save("flat.npy", np.zeros((4, 5)))
    Path("flat.npy").rename("flat.dat")
    assert tell("inspect", "weights.bin")["kind"] == "network"
    assert tell("inspect", "run")["kind"] == "trace"
    assert tell("inspect", "flat.dat", "--cell", "2")["size_m"] == [10.0, 8.0]


def test_the_template_is_a_whole_scenario_that_drives() -> None:
    said = run("template")
    assert (said.code, said.out, said.err) == (0, TEMPLATE, "")
    Path("drive.yaml").write_text(said.out)
    driven, named = tell("drive", "drive.yaml"), tell("drive", "bassil-v1")
    assert (driven["outcome"], driven["length_m"]) == ("reached", named["length_m"])


def test_the_template_has_every_key_and_every_preset() -> None:
    keys = {line.removeprefix("# ").split(":")[0] for line in TEMPLATE.splitlines()}
    assert set(Scenario.allowed()) <= keys
    assert ", ".join(presets()) in TEMPLATE
    Path("drive.yaml").write_text(TEMPLATE)
    written = tell("template")
    whole = read_scenario(Path("drive.yaml")).model_dump(mode="json", by_alias=True)
    assert {key: whole[key] for key in written} == written


def test_what_the_template_leaves_out_can_be_put_in(here: Path) -> None:
    write_ground(here / "yard.tif")
    text = TEMPLATE.replace("# terrain: yard.tif ", "terrain: yard.tif ")
    text = text.replace("# time_limit_s:", "time_limit_s:")
    text = text.replace("  - [4.365, -1.0, 7.365, 3.75]\n", "").replace("boxes: ", "boxes: [] ")
    text = text.replace("to: [11.73, 0.0]", "to: [4.0, -8.5]")
    Path("drive.yaml").write_text(text.replace("from: [0.0, 0.0] ", "from: [-4.0, -9.0] "))
    report = tell("drive", "drive.yaml")
    assert report["settings"]["time_limit_s"] == 60.0
    assert report["outcome"] == "reached"


def test_demo_tells_every_part(here: Path) -> None:
    report = tell("demo", "--out", "demo", "--seed", "2")
    assert report["paper"]["outcome"] == "reached"
    assert report["rectangles"]["reached"] == pytest.approx(0.45, abs=0.03)
    assert report["hills"]["settings"]["seed"] == 2
    names = {Path(name).name for name in report["pictures"]}
    assert names == {"drive.png", "figure3.png", "training.png", "rectangles.png"}
    assert all(Path(name).is_file() for name in report["pictures"])


@pytest.mark.data
@pytest.mark.long
def test_demo_drives_on_real_ground(data_dir: Path) -> None:
    said = run("demo", "--out", "demo", "--data", data_dir)
    assert said.code == 0
    assert "Real ground" in said.out
    assert "Skipped" not in said.out
    assert len(list(Path("demo").glob("yard-*/path.geojson"))) >= 2


@pytest.mark.parametrize("command", COMMANDS)
def test_help_shows_an_example(command: str) -> None:
    for words in ((command, "--help"), ("help", command), (command, "-h")):
        said = run(*words)
        assert (said.code, said.err) == (0, "")
        assert f"Example: rovernav {command}" in said.out
    assert max(map(len, said.out.splitlines())) <= 80


def test_help_lists_every_command_and_version_is_a_number() -> None:
    for words in ((), ("--help",), ("help",)):
        said = run(*words)
        assert said.code == 0
        assert all(f"│ {command} " in said.out for command in COMMANDS)
    assert run("--version").out.strip().count(".") == 2


def test_a_folder_that_may_not_be_written_to_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "access", lambda path, mode: False)  # root may write everywhere
    said = run("train", "bassil-v1", "--out", "locked")
    assert (said.code, said.out) == (2, "")
    assert said.err == "error: --out locked may not be written to; name another folder\n"


def test_a_defect_of_ours_is_no_mistake_of_the_user(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object) -> None:
        raise RuntimeError("two\nlines")

    monkeypatch.setattr("rovernav.nets.load_network", broken)
    Path("x.safetensors").write_bytes(b'12345678{"')
    said = run("inspect", "x.safetensors")
    assert (said.code, said.out) == (1, "")
    assert said.err.splitlines() == [
        "error: a defect of rovernav: RuntimeError: two lines", "ROVERNAV_DEBUG=1 shows where",
    ]  # fmt: skip
    monkeypatch.setenv("ROVERNAV_DEBUG", "1")
    with pytest.raises(RuntimeError, match="two"):
        run("inspect", "x.safetensors")


@pytest.mark.parametrize(("refusal", "code"), [(errno.ENOSPC, 1), (errno.EACCES, 2)])
def test_a_full_disk_is_no_mistake_either(
    monkeypatch: pytest.MonkeyPatch, refusal: int, code: int
) -> None:
    def full(*_: object) -> None:
        raise OSError(refusal, os.strerror(refusal))

    monkeypatch.setattr(os, "fsync", full)
    said = run("train", "bassil-v1")
    assert (said.code, said.out) == (code, "")
    assert said.err.startswith("error: cannot write rovernav-train/network.safetensors: ")
    assert list(Path("rovernav-train").iterdir()) == []


@pytest.mark.parametrize("terminal", [True, False])
def test_a_terminal_hears_once_that_kernels_are_compiled(
    terminal: bool, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(_console, "_is_terminal", lambda: terminal)
    _console.announce_compiling()
    _console.announce_compiling()  # a second command in the same process
    news.tell("one")
    news.tell("another")
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.count("compiling kernels for this machine") == terminal
    assert not news.LISTENERS
