"""Wrong input: exit code 2, nothing on standard output, one sentence that says what to do.

`CASES` is also the page docs/how-to/wrong-input.md; ROVERNAV_WRITE_DOCS=1 writes it anew.
"""

from __future__ import annotations

import os
import re
import shlex
from collections.abc import Callable
from functools import partial as of
from itertools import groupby
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from tests.cli import bad_files as bad
from tests.cli.ground_cases import MADE_WRONG, PARTS, ROUTES
from tests.cli.runner import run

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "wrong-input.md"


class Case(NamedTuple):
    kind: str
    wrong: str  # what is wrong, for the page
    words: str  # what is typed after rovernav
    sentence: str  # what it says; … stands for anything
    make: Callable[[], Any] = lambda: None  # makes the files


TABLE, NETWORK, CHECKPOINT, SCENARIO, ROVER, GROUND, MADE, WAYS, TRACE, PLACE, OPTION = (
    "Pattern tables", "Network files", "Checkpoints", "Scenario files", "Rover files",
    "Elevation models", "Made ground", "Routes and zones", "Traces", "Where things go",
    "Commands and options",
)  # fmt: skip
TRAIN, DRIVE = "train table.csv", "drive drive.yaml"
GO = "train bassil-v1 --init paper --momentum .5"
ON = "drive --terrain ground.tif --from -5,-8 --to 20,-6.5"
NPY = "drive --terrain ground.npy --from 1,1 --to 9,9"

CASES = [
    Case(TABLE, "missing", TRAIN,
         "there is no pattern file 'table.csv' and no shipped table of that name; Allowed: "
         "bassil-replay-v1, bassil-v1."),
    Case(TABLE, "a folder", "train .", ". is a folder; give the pattern table itself"),
    Case(TABLE, "empty", TRAIN,
         "table.csv is empty; line 1 must name the columns, like in:x,out:y", of(bad.table, "")),
    Case(TABLE, "no pattern", TRAIN,
         "table.csv has a header but no pattern; add at least one line of numbers",
         of(bad.table, "in:x,in:y,out:u\n")),
    Case(TABLE, "no names", TRAIN,
         "table.csv, line 1: the first line must name the columns, got numbers",
         of(bad.table, "0,1,2\n0,1,1\n")),
    Case(TABLE, "text in a cell", TRAIN,
         "table.csv, line 4, column 'in:y': 'one' is not a number",
         of(bad.table, bad.TABLE + "0,one,1,1\n")),
    Case(TABLE, "an empty cell", TRAIN,
         "table.csv, line 4, column 'in:y': the cell is empty",
         of(bad.table, bad.TABLE + "0,,1,1\n")),
    Case(TABLE, "a cell too few", TRAIN,
         "table.csv, line 4: 4 cells needed, got 3", of(bad.table, bad.TABLE + "0,1,1\n")),
    Case(TABLE, "nan", TRAIN,
         "table.csv, line 4, column 'in:y': nan is not finite",
         of(bad.table, bad.TABLE + "0,nan,1,1\n")),
    Case(TABLE, "a name twice", TRAIN,
         "table.csv, line 1: column name 'in:x' stands twice",
         of(bad.table, "in:x,in:x,out:u\n1,2,3\n")),
    Case(TABLE, "a column without a mark", TRAIN,
         "table.csv, line 1: column 'y' is marked neither in: nor out:",
         of(bad.table, "in:x,y,out:u\n1,2,3\n")),
    Case(TABLE, "no target", TRAIN,
         "table.csv, line 1: a table needs inputs and targets, got 2 and 0",
         of(bad.table, "in:x,in:y\n1,2\n")),
    Case(TABLE, "other inputs than the topology", TRAIN,
         "table.csv, line 1: 1 inputs, but the topology has 2", of(bad.table, "in:x,out:u\n1,2\n")),
    Case(TABLE, "other targets than the topology", f"{TRAIN} --topology 2-3-3",
         "the network has 2 inputs and 3 outputs, the patterns have 2 inputs and 2 targets",
         bad.table),
    Case(TABLE, "not UTF-8", TRAIN,
         "table.csv is not UTF-8 text (byte 3); save the pattern table as UTF-8",
         of(bad.table, b"in:\xe4,out:u\n1,2\n")),
    Case(TABLE, "a quote that does not end", TRAIN,
         "table.csv, line 4: …", of(bad.table, bad.TABLE + '0,"1,1,1\n')),
    Case(NETWORK, "missing", "train bassil-v1 --init net.safetensors",
         "--init 'net.safetensors' is neither a known name nor a file; Allowed: paper, seed."),
    Case(NETWORK, "no controller of that name", "drive bassil-v1 --controller basil",
         "there is no controller 'basil' and no such network file; did you mean 'bassil'? "
         "Allowed: …"),
    Case(NETWORK, "text", "drive bassil-v1 --controller table.csv",
         "table.csv is not a network file, or is cut off: it has 39 bytes and should begin with "
         "a safetensors header", bad.table),
    Case(NETWORK, "cut off", "inspect net.safetensors",
         "net.safetensors is not a whole safetensors file: …", of(bad.network, keep=0.8)),
    Case(NETWORK, "a bit turned", "inspect net.safetensors",
         "net.safetensors is damaged: sha256 does not fit its header and weights",
         of(bad.network, keep=1.0)),
    Case(NETWORK, "another program's", "inspect net.safetensors",
         "net.safetensors is a safetensors file, but not one that rovernav wrote",
         bad.foreign_safetensors),
    Case(NETWORK, "a checkpoint", "train bassil-v1 --init run.ckpt",
         "run.ckpt: format must be 'rovernav-network', got 'rovernav-training'", bad.checkpoint),
    Case(NETWORK, "not for driving", "drive bassil-v1 --controller net.safetensors",
         "net.safetensors: this network names no codec, so nothing says what its outputs mean to"
         " motors; drive with a network trained for driving", bad.network),
    Case(NETWORK, "codec and topology disagree", "drive bassil-v1 --controller net.safetensors",
         "net.safetensors: codec bassil needs a network with 2 inputs and 2 outputs, got 3-2",
         of(bad.network, topology=(3, 2), codec={"name": "bassil", "step": 1.0})),
    Case(NETWORK, "another topology", "train bassil-v1 --init net.safetensors --topology 2-4-2",
         "--init net.safetensors holds a 2-3-2 network, not the 2-4-2 one asked for; give the "
         "same --topology", bad.network),
    Case(CHECKPOINT, "there already", f"{GO} --checkpoint run.ckpt",
         "run.ckpt exists; go on from it with --resume, or name another file", bad.checkpoint),
    Case(CHECKPOINT, "of other settings", f"{GO} --eta .3 --checkpoint run.ckpt --resume",
         "run.ckpt was made with eta = 0.25, not 0.3; resume with the same", bad.checkpoint),
    Case(CHECKPOINT, "of another table",
         "train bassil-replay-v1 --init paper --checkpoint run.ckpt --resume",
         "run.ckpt was made with another pattern table; resume with the same", bad.checkpoint),
    Case(CHECKPOINT, "of another network",
         "train bassil-v1 --topology 2-4-2 --checkpoint run.ckpt --resume",
         "run.ckpt holds a 2-3-2 network, not the 2-4-2 one asked for; give the same --topology",
         bad.checkpoint),
    Case(CHECKPOINT, "damaged", f"{GO} --checkpoint run.ckpt --resume",
         "run.ckpt is damaged: sha256 does not fit its contents", of(bad.checkpoint, keep=1.0)),
    Case(CHECKPOINT, "not named", f"{GO} --resume",
         "--resume needs --checkpoint FILE: where the training was saved"),
    Case(CHECKPOINT, "a folder", f"{GO} --checkpoint . --resume",
         "--checkpoint . is a folder; name a file"),
    Case(SCENARIO, "missing", DRIVE, "there is no scenario at drive.yaml; check the path"),
    Case(SCENARIO, "no scenario of that name", "drive basil-v1",
         "there is no scenario 'basil-v1' and no such file; did you mean 'bassil-v1'? "
         "Allowed: …"),
    Case(SCENARIO, "an elevation model", "drive ground.tif",
         "ground.tif is no scenario: its name does not end in .yaml; an elevation model is given"
         " as --terrain FILE --from X,Y --to X,Y", bad.ground),
    Case(SCENARIO, "not YAML", DRIVE,
         "drive.yaml, line 4: expected ',' or ']', but got '<stream end>'",
         of(bad.scenario, "boxes: [[1, 2\n")),
    Case(SCENARIO, "a list", DRIVE,
         "drive.yaml must hold 'key: value' lines, got a list",
         of(bad.scenario, ends="- from\n- to\n")),
    Case(SCENARIO, "an unknown key", DRIVE,
         "drive.yaml: unknown key 'terran'; did you mean 'terrain'? Allowed: …",
         of(bad.scenario, "terran: yard.tif\n")),
    Case(SCENARIO, "a key twice", DRIVE,
         "drive.yaml, line 4: the key 'seed' stands here twice",
         of(bad.scenario, "seed: 1\nseed: 2\n")),
    Case(SCENARIO, "a key missing", DRIVE,
         "drive.yaml: the key 'to' is missing; add it", of(bad.scenario, ends="from: [0, 0]\n")),
    Case(SCENARIO, "an alias", DRIVE,
         "drive.yaml, line 2: aliases are not allowed",
         of(bad.scenario, ends="from: &a [0, 0]\nto: *a\n")),
    Case(SCENARIO, "three numbers", DRIVE,
         "drive.yaml: from = [0, 0, 0]: give two numbers, like [-3.5, 1.2]",
         of(bad.scenario, ends="from: [0, 0, 0]\nto: [1, 0]\n")),
    Case(SCENARIO, "not a number", DRIVE,
         "drive.yaml: from = [0, nan]: coordinates must be finite numbers",
         of(bad.scenario, ends="from: [0, .nan]\nto: [1, 0]\n")),
    Case(SCENARIO, "a box inside out", DRIVE,
         "drive.yaml: boxes.0 = [3, -1, 2, 1]: a box needs x0 <= x1 and y0 <= y1",
         of(bad.scenario, "boxes: [[3, -1, 2, 1]]\n")),
    Case(SCENARIO, "a circle without a size", DRIVE,
         "drive.yaml: circles.0 = [3, -1, 0]: a circle needs a radius above 0",
         of(bad.scenario, "circles: [[3, -1, 0]]\n")),
    Case(SCENARIO, "a polygon with two corners", DRIVE,
         "drive.yaml: polygons.0 = [[3, -1], [2, 1]]: a polygon needs 3 to 500 corners, like "
         "[[0, 0], [2, 0], [1, 3]]",
         of(bad.scenario, "polygons: [[[3, -1], [2, 1]]]\n")),
    Case(SCENARIO, "two grounds", DRIVE,
         "drive.yaml: generate = {'name': 'hills'}: give a terrain or generate one, not both",
         of(bad.scenario, "terrain: a.tif\ngenerate: {name: hills}\n")),
    Case(SCENARIO, "a misspelt key of generated ground", DRIVE,
         "drive.yaml: unknown key 'generate.relief'; did you mean 'relief_m'? Allowed: …",
         of(bad.scenario, "generate: {relief: 3.0}\n")),
    Case(SCENARIO, "an obstacle at the start", DRIVE,
         "rover paper-point cannot stand at the start: an obstacle is there; choose another point",
         of(bad.scenario, "generate: {relief_m: 1.0}\ncircles: [[5, 5, 2]]\n",
            ends="from: [5, 5]\nto: [30, 30]\n")),
    Case(SCENARIO, "a cell without a terrain", DRIVE,
         "drive.yaml: cell = 0.5: that goes with a terrain, and there is none",
         of(bad.scenario, "cell: 0.5\n")),
    Case(SCENARIO, "far away", DRIVE,
         "drive.yaml: to = [1000000000.0, 0]: without a terrain, coordinates lie within 100 km "
         "of (0, 0)", of(bad.scenario, ends="from: [0, 0]\nto: [1.0e+9, 0]\n")),
    Case(SCENARIO, "an unknown frame", DRIVE,
         "drive.yaml: frame = 'map': input should be 'crs', 'local' or 'pixel'",
         of(bad.scenario, "frame: map\n")),
    Case(SCENARIO, "a negative seed", DRIVE,
         "drive.yaml: seed = -1: input should be greater than or equal to 0",
         of(bad.scenario, "seed: -1\n")),
    Case(SCENARIO, "no time", DRIVE,
         "drive.yaml: time_limit_s = 0: input should be greater than 0",
         of(bad.scenario, "time_limit_s: 0\n")),
    Case(SCENARIO, "its terrain missing", DRIVE,
         "there is no elevation file at yard.tif; check the path",
         of(bad.scenario, "terrain: yard.tif\n")),
    Case(ROVER, "no preset of that name", f"{ON} --rover sojurner",
         "there is no rover preset 'sojurner'; did you mean 'sojourner'? Allowed: …. A path that"
         " ends in .yaml reads your own rover.", bad.ground),
    Case(ROVER, "missing", f"{ON} --rover rover.yaml",
         "there is no rover file at rover.yaml; check the path", bad.ground),
    Case(ROVER, "an unknown key", f"{ON} --rover rover.yaml",
         "rover.yaml: unknown key 'wheels'; did you mean 'wheel_radius_m'? Allowed: …",
         of(bad.rover, wheels="6")),
    Case(ROVER, "a number out of range", f"{ON} --rover rover.yaml",
         "rover.yaml: rover mine: max_slope must lie in 0 to 89 deg, got 120",
         of(bad.rover, max_slope_deg="120.0")),
    Case(ROVER, "text for a number", f"{ON} --rover rover.yaml",
         "rover.yaml: speed_m_s = 'fast': input should be a valid number",
         of(bad.rover, speed_m_s="fast")),
    *[Case(GROUND, *one) for one in PARTS],
    *[Case(MADE, *one) for one in MADE_WRONG],
    *[Case(WAYS, *one) for one in ROUTES],
    Case(TRACE, "missing", "inspect trace.npz", "there is no file at trace.npz; check the path"),
    Case(TRACE, "cut off", "inspect trace.npz",
         "trace.npz is not a trace, or is damaged", of(bad.trace, 0.7)),
    Case(TRACE, "another program's", "inspect trace.npz",
         "trace.npz is not a trace, or is damaged",
         of(bad.raw, "trace.npz", b"PK\5\6" + bytes(18))),
    Case(PLACE, "a file where a folder should be", f"{TRAIN} --out table.csv",
         "--out table.csv is a file or lies below one; name a folder", bad.table),
    Case(PLACE, "an empty name", f"{GO} --out ''",
         "--out must not be empty; the present folder is written as ."),
    Case(PLACE, "a result over an input", "train bassil-v1 --init ./network.safetensors --out .",
         "network.safetensors is read by this command and would be written over; change --out "
         "(network.safetensors)", of(bad.network, name="network.safetensors")),
    Case(PLACE, "a trace over its table", f"{TRAIN} --trace table.csv",
         "table.csv is read by this command and would be written over; change --trace", bad.table),
    Case(PLACE, "a trace that is none",
         f"{GO} --epochs 4 --checkpoint run.ckpt --resume --trace table.csv",
         "table.csv is no trace of this network; name another file", bad.half_a_training),
    Case(PLACE, "a trace into a folder", f"{GO} --trace .",
         "cannot write the trace .: Is a directory"),
    Case(OPTION, "an unknown command", "drve",
         "there is no command 'drve'; did you mean 'drive'? Allowed: …"),
    Case(OPTION, "an option before the command", "--json drive bassil-v1",
         "there is no option --json before a command; options follow it, as in rovernav drive "
         "bassil-v1 --json, and alone stand --help and --version"),
    Case(OPTION, "an option without its dashes", "version",
         "there is no command 'version'; did you mean --version?"),
    Case(OPTION, "an unknown option", "train bassil-v1 --epoch 5",
         "there is no option --epoch; did you mean --epochs?"),
    Case(OPTION, "a shortened option", "train bassil-v1 --tol .1",
         "there is no option --tol; did you mean --tolerance?"),
    Case(OPTION, "an option without its value", "train bassil-v1 --epochs",
         "--epochs needs a value after it"),
    Case(OPTION, "an option twice", "train bassil-v1 --eta 1 --eta 2",
         "--eta is given twice; give it once"),
    Case(OPTION, "nothing to train", "train", "PATTERNS is missing; name it after the command"),
    Case(OPTION, "a word too many", "train bassil-v1 bassil-v1",
         "unexpected argument 'bassil-v1'; an option's value follows its name, as in --out X"),
    Case(OPTION, "nothing to drive", "drive",
         "nothing to drive: name a scenario (…), a SCENARIO.yaml, or --terrain FILE --from X,Y "
         "--to X,Y"),
    Case(OPTION, "not a whole number", "train bassil-v1 --epochs 1.5",
         "--epochs must be a whole number, got '1.5'"),
    Case(OPTION, "not a number", "train bassil-v1 --eta 0,25",
         "--eta must be a number, got '0,25'"),
    Case(OPTION, "epochs below 0", "train bassil-v1 --epochs -1",
         "epochs must be from 0 to 10^12, got -1"),
    Case(OPTION, "a rate of 0", "train bassil-v1 --eta 0", "eta must be a number above 0, got 0.0"),
    Case(OPTION, "a momentum of 1", "train bassil-v1 --momentum 1",
         "momentum must be from 0 to below 1, got 1.0"),
    Case(OPTION, "a tolerance that is no number", "train bassil-v1 --tolerance nan",
         "tolerance must be 0 or above, got nan"),
    Case(OPTION, "a negative seed", "drive bassil-v1 --seed -1",
         "--seed must be from 0 to 2^63 - 1, got -1"),
    Case(OPTION, "an unknown rule", "train bassil-v1 --rule papr",
         "unknown rule 'papr'; did you mean 'paper'? Allowed: paper, textbook."),
    Case(OPTION, "an unknown order", "train bassil-v1 --order random",
         "unknown order 'random'; Allowed: cyclic, shuffled."),
    Case(OPTION, "an unknown activation", "train bassil-v1 --activations sigmoid,liner",
         "unknown activation 'liner'; did you mean 'linear'? Allowed: linear, relu, sigmoid, "
         "tanh."),
    Case(OPTION, "activations for other layers", "train bassil-v1 --activations tanh",
         "a 2-3-2 network needs 2 activations, one per layer after the inputs, got 1"),
    Case(OPTION, "a topology that is none", "train bassil-v1 --topology 2--3",
         "a topology is written like 2-3-2 (inputs, hidden layers, outputs), got '2--3'"),
    Case(OPTION, "a layer without units", "train bassil-v1 --topology 0-3",
         "each layer needs 1 to 100,000 units, got '0-3'"),
    Case(OPTION, "a layer too large", "train bassil-v1 --topology 2-3-1000000000",
         "each layer needs 1 to 100,000 units, got '2-3-1000000000'"),
    Case(OPTION, "a network too large", "train bassil-v1 --topology 2-90000-90000-2",
         "a 2-90000-90000-2 network has 8,100,540,002 parameters; at most 50,000,000 are allowed"),
    Case(OPTION, "one number for a point", "drive --terrain a.tif --from 1 --to 3,4",
         "--from must be two numbers X,Y like -3.5,1.2, got '1'"),
    Case(OPTION, "an infinite point", "drive --terrain a.tif --from inf,1 --to 3,4",
         "--from must be two numbers X,Y like -3.5,1.2, got 'inf,1'"),
    Case(OPTION, "an unknown frame", f"{ON} --frame map",
         "--frame has no 'map'; Allowed: crs, local, pixel."),
    Case(OPTION, "an option that the scenario decides", "drive bassil-v1 --from 1,2",
         "--from does not go with the named scenario bassil-v1"),
    Case(OPTION, "a cell of no size", "inspect ground.npy --cell 0",
         "--cell must be a positive number of metres, got '0'"),
    Case(OPTION, "a cell for a network", "inspect net.safetensors --cell 1",
         "--cell goes only with a terrain that does not say it; net.safetensors is a network",
         bad.network),
    Case(OPTION, "an outcome that is none", "drive bassil-v1 --require reachd",
         "--require 'reachd' is no outcome; did you mean 'reached'? Allowed: astray, collided, "
         "high_centred, left_map, reached, stuck, timed_out, tipped."),
    Case(OPTION, "a scenario that is not the paper's", "paper --scenario hills-v1",
         "unknown scenario 'hills-v1'; Allowed: bassil-replay-v1, bassil-v1."),
]  # fmt: skip


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case.kind}-{case.wrong}")
def test_one_sentence_says_what_is_wrong(case: Case) -> None:
    case.make()
    said = run(*shlex.split(case.words))
    assert (said.code, said.out) == (2, "")
    first, *hint = said.err.splitlines()
    pattern = re.escape(f"error: {case.sentence}").replace("…", ".+")
    assert re.fullmatch(pattern, first), first
    assert len(hint) <= 1
    assert all(line.startswith("See: rovernav") for line in hint)
    assert "Traceback" not in said.err


@pytest.mark.parametrize(
    "words",
    [
        ("drive", "x" * 5000),
        ("drive", "bassil-v1", "--controller", "x" * 5000),
        ("train", "x" * 5000),
    ],
    ids=["scenario", "controller", "table"],
)
def test_names_that_no_file_can_have_are_wrong_input(words: tuple[str, ...]) -> None:
    said = run(*words)
    assert (said.code, said.out) == (2, "")
    assert re.search("error: .*File name too long", said.err)
    assert "Traceback" not in said.err


def test_json_does_not_change_that() -> None:
    said = run("train", "table.csv", "--json")
    assert (said.code, said.out) == (2, "")


def test_there_are_many_and_none_twice() -> None:
    assert len({(case.kind, case.wrong) for case in CASES}) == len(CASES) > 30


def test_the_page_lists_them_all() -> None:
    page = PAGE.read_text() if PAGE.exists() else ""
    if os.environ.get("ROVERNAV_WRITE_DOCS"):
        PAGE.write_text(_page())
    elif PAGE.parent.is_dir():
        assert page == _page(), "run this test with ROVERNAV_WRITE_DOCS=1 to write the page anew"


def _page() -> str:
    """The page, from `CASES`."""
    lines = [
        "# When the input is wrong",
        "",
        "Every mistake gets one sentence on the error stream: what is wrong and what to do.",
        "Nothing is printed on standard output, and the exit code is 2.",
        "Exit code 1 means that the work failed: a diverged training, a required outcome missed.",
        "Ctrl-C ends with exit code 130.",
        "",
        f"These {len(CASES)} cases are tested; … stands for words that vary.",
    ]
    for kind, cases in groupby(CASES, key=lambda case: case.kind):
        lines += ["", f"## {kind}", "", "| What is wrong | What rovernav says |", "|---|---|"]
        lines += [f"| {case.wrong} | `{case.sentence}` |" for case in cases]
    return "\n".join(lines) + "\n"
