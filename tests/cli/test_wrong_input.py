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
from tests.cli.runner import run

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "wrong-input.md"


class Case(NamedTuple):
    kind: str
    wrong: str  # what is wrong, for the page
    words: str  # what is typed after rovernav
    sentence: str  # what it says; … stands for anything
    make: Callable[[], Any] = lambda: None  # makes the files


TABLE, NETWORK, CHECKPOINT, SCENARIO, ROVER, GROUND, TRACE, PLACE, OPTION = (
    "Pattern tables", "Network files", "Checkpoints", "Scenario files", "Rover files",
    "Elevation models", "Traces", "Where things go", "Commands and options",
)  # fmt: skip
TRAIN, DRIVE = "train table.csv", "drive drive.yaml"
GO = "train bassil-v1 --init paper --momentum .5"
ON = "drive --terrain ground.tif --from -5,-8 --to 20,-6.5"
NPY = "drive --terrain ground.npy --from 1,1 --to 9,9"

CASES = [
    Case(TABLE, "missing", TRAIN, ""),
    Case(TABLE, "a folder", "train .", ""),
    Case(TABLE, "empty", TRAIN, "", of(bad.table, "")),
    Case(TABLE, "no pattern", TRAIN, "", of(bad.table, "in:x,in:y,out:u\n")),
    Case(TABLE, "no names", TRAIN, "", of(bad.table, "0,1,2\n0,1,1\n")),
    Case(TABLE, "text in a cell", TRAIN, "", of(bad.table, bad.TABLE + "0,one,1,1\n")),
    Case(TABLE, "an empty cell", TRAIN, "", of(bad.table, bad.TABLE + "0,,1,1\n")),
    Case(TABLE, "a cell too few", TRAIN, "", of(bad.table, bad.TABLE + "0,1,1\n")),
    Case(TABLE, "nan", TRAIN, "", of(bad.table, bad.TABLE + "0,nan,1,1\n")),
    Case(TABLE, "a name twice", TRAIN, "", of(bad.table, "in:x,in:x,out:u\n1,2,3\n")),
    Case(TABLE, "a column without a mark", TRAIN, "", of(bad.table, "in:x,y,out:u\n1,2,3\n")),
    Case(TABLE, "no target", TRAIN, "", of(bad.table, "in:x,in:y\n1,2\n")),
    Case(TABLE, "other inputs than the topology", TRAIN, "", of(bad.table, "in:x,out:u\n1,2\n")),
    Case(TABLE, "other targets than the topology", f"{TRAIN} --topology 2-3-3", "", bad.table),
    Case(TABLE, "not UTF-8", TRAIN, "", of(bad.table, b"in:\xe4,out:u\n1,2\n")),
    Case(TABLE, "a quote that does not end", TRAIN, "", of(bad.table, bad.TABLE + '0,"1,1,1\n')),
    Case(NETWORK, "missing", "train bassil-v1 --init net.safetensors", ""),
    Case(NETWORK, "no controller of that name", "drive bassil-v1 --controller basil", ""),
    Case(NETWORK, "text", "drive bassil-v1 --controller table.csv", "", bad.table),
    Case(NETWORK, "cut off", "inspect net.safetensors", "", lambda: (bad.network(), bad.spoil("net.safetensors", keep=0.8))),
    Case(NETWORK, "a bit turned", "inspect net.safetensors", "", lambda: (bad.network(), bad.spoil("net.safetensors"))),
    Case(NETWORK, "another program's", "inspect net.safetensors", "", bad.foreign_safetensors),
    Case(NETWORK, "a checkpoint", "train bassil-v1 --init run.ckpt", "", bad.checkpoint),
    Case(NETWORK, "not for driving", "drive bassil-v1 --controller net.safetensors", "", bad.network),
    Case(NETWORK, "codec and topology disagree", "drive bassil-v1 --controller net.safetensors", "", of(bad.network, (3, 2), {"name": "bassil", "step": 1.0})),
    Case(NETWORK, "another topology", "train bassil-v1 --init net.safetensors --topology 2-4-2", "", bad.network),
    Case(CHECKPOINT, "there already", f"{GO} --checkpoint run.ckpt", "", bad.checkpoint),
    Case(CHECKPOINT, "of other settings", f"{GO} --eta .3 --checkpoint run.ckpt --resume", "", bad.checkpoint),
    Case(CHECKPOINT, "of another table", "train bassil-replay-v1 --init paper --checkpoint run.ckpt --resume", "", bad.checkpoint),
    Case(CHECKPOINT, "of another network", f"train bassil-v1 --topology 2-4-2 --checkpoint run.ckpt --resume", "", bad.checkpoint),
    Case(CHECKPOINT, "damaged", f"{GO} --checkpoint run.ckpt --resume", "", lambda: (bad.checkpoint(), bad.spoil("run.ckpt"))),
    Case(CHECKPOINT, "not named", f"{GO} --resume", ""),
    Case(CHECKPOINT, "a folder", f"{GO} --checkpoint . --resume", ""),
    Case(SCENARIO, "missing", DRIVE, ""),
    Case(SCENARIO, "no scenario of that name", "drive basil-v1", ""),
    Case(SCENARIO, "an elevation model", "drive ground.tif", "", bad.ground),
    Case(SCENARIO, "not YAML", DRIVE, "", of(bad.scenario, "boxes: [[1, 2\n")),
    Case(SCENARIO, "a list", DRIVE, "", of(bad.scenario, ends="- from\n- to\n")),
    Case(SCENARIO, "an unknown key", DRIVE, "", of(bad.scenario, "terain: yard.tif\n")),
    Case(SCENARIO, "a key twice", DRIVE, "", of(bad.scenario, "seed: 1\nseed: 2\n")),
    Case(SCENARIO, "a key missing", DRIVE, "", of(bad.scenario, ends="from: [0, 0]\n")),
    Case(SCENARIO, "an alias", DRIVE, "", of(bad.scenario, ends="from: &a [0, 0]\nto: *a\n")),
    Case(SCENARIO, "three numbers", DRIVE, "", of(bad.scenario, ends="from: [0, 0, 0]\nto: [1, 0]\n")),
    Case(SCENARIO, "not a number", DRIVE, "", of(bad.scenario, ends="from: [0, .nan]\nto: [1, 0]\n")),
    Case(SCENARIO, "a box inside out", DRIVE, "", of(bad.scenario, "boxes: [[3, -1, 2, 1]]\n")),
    Case(SCENARIO, "terrain and boxes", DRIVE, "", of(bad.scenario, "terrain: a.tif\nboxes: [[2, -1, 3, 1]]\n")),
    Case(SCENARIO, "a cell without a terrain", DRIVE, "", of(bad.scenario, "cell: 0.5\n")),
    Case(SCENARIO, "far away", DRIVE, "", of(bad.scenario, ends="from: [0, 0]\nto: [1.0e+9, 0]\n")),
    Case(SCENARIO, "an unknown frame", DRIVE, "", of(bad.scenario, "frame: map\n")),
    Case(SCENARIO, "a negative seed", DRIVE, "", of(bad.scenario, "seed: -1\n")),
    Case(SCENARIO, "no time", DRIVE, "", of(bad.scenario, "time_limit_s: 0\n")),
    Case(SCENARIO, "a rover for other ground", DRIVE, "", of(bad.scenario, "rover: jackal\n")),
    Case(SCENARIO, "its terrain missing", DRIVE, "", of(bad.scenario, "terrain: yard.tif\n")),
    Case(ROVER, "no preset of that name", f"{ON} --rover sojurner", "", bad.ground),
    Case(ROVER, "missing", f"{ON} --rover rover.yaml", "", bad.ground),
    Case(ROVER, "an unknown key", f"{ON} --rover rover.yaml", "", of(bad.rover, wheels="6")),
    Case(ROVER, "a number out of range", f"{ON} --rover rover.yaml", "", of(bad.rover, max_slope_deg="120.0")),
    Case(ROVER, "text for a number", f"{ON} --rover rover.yaml", "", of(bad.rover, speed_m_s="fast")),
    Case(GROUND, "missing", ON, ""),
    Case(GROUND, "a web address", "inspect https://example.org/yard.tif", ""),
    Case(GROUND, "a picture", "inspect figure.png", "", lambda: Path("figure.png").write_bytes(b"\x89PNG\r\n\x1a\n")),
    Case(GROUND, "text", ON, "", lambda: Path("ground.tif").write_text("heights")),
    Case(GROUND, "a pointer to other files", ON, "", lambda: Path("ground.tif").write_text("<VRTDataset/>")),
    Case(GROUND, "cut off", ON, "", lambda: (bad.ground(), bad.spoil("ground.tif", keep=0.5))),
    Case(GROUND, "an image of three bands", ON, "", of(bad.ground, count=3)),
    Case(GROUND, "in degrees", ON, "", of(bad.ground, crs="EPSG:4326")),
    Case(GROUND, "heights in feet", ON, "", bad.ground_in_feet),
    Case(GROUND, "rotated", ON, "", of(bad.ground, transform=(0.4, 0.3, -7.0, 0.3, -0.4, 9.0))),
    Case(GROUND, "cells that are not square", ON, "", of(bad.ground, transform=(0.5, 0.0, -7.0, 0.0, -0.7, 9.0))),
    Case(GROUND, "no height at all", ON, "", of(bad.ground_of, -9999.0)),
    Case(GROUND, "an infinite height", ON, "", of(bad.ground_of, float("inf"))),
    Case(GROUND, "heights that mark missing data", ON, "", of(bad.ground_of, -3.4e38)),
    Case(GROUND, "a cell that contradicts the file", f"{ON} --cell 2", "", bad.ground),
    Case(GROUND, "an array without its cell", NPY, "", of(bad.array, [[0.0] * 9] * 9)),
    Case(GROUND, "an array of three dimensions", f"{NPY} --cell 1", "", of(bad.array, [[[0.0] * 9] * 9])),
    Case(GROUND, "an array of Python objects", f"{NPY} --cell 1", "", of(bad.array, [[{}]])),
    Case(GROUND, "start off the map", "drive --terrain ground.tif --from 100,0 --to 1,2", "", bad.ground),
    Case(GROUND, "goal where the rover cannot stand", "drive --terrain ground.tif --from -5,-8 --to 8.5,3", "", bad.ground),
    Case(GROUND, "no goal", "drive --terrain ground.tif --from -5,-8", ""),
    Case(TRACE, "missing", "inspect trace.npz", ""),
    Case(TRACE, "cut off", "inspect trace.npz", "", of(bad.trace, 0.7)),
    Case(TRACE, "another program's", "inspect trace.npz", "", lambda: Path("trace.npz").write_bytes(b"PK\x05\x06" + bytes(18))),
    Case(PLACE, "a file where a folder should be", f"{TRAIN} --out table.csv", "", bad.table),
    Case(PLACE, "an empty name", f"{GO} --out ''", ""),
    Case(PLACE, "a result over an input", "train bassil-v1 --init ./network.safetensors --out .", "", lambda: (bad.network(), Path("net.safetensors").rename("network.safetensors"))),
    Case(PLACE, "a trace over its table", f"{TRAIN} --trace table.csv", "", bad.table),
    Case(PLACE, "a trace into a folder", f"{GO} --trace .", ""),
    Case(OPTION, "an unknown command", "drve", ""),
    Case(OPTION, "an unknown option", "train bassil-v1 --epoch 5", ""),
    Case(OPTION, "a shortened option", "train bassil-v1 --tol .1", ""),
    Case(OPTION, "an option without its value", "train bassil-v1 --epochs", ""),
    Case(OPTION, "an option twice", "train bassil-v1 --eta 1 --eta 2", ""),
    Case(OPTION, "nothing to train", "train", ""),
    Case(OPTION, "a word too many", "train bassil-v1 bassil-v1", ""),
    Case(OPTION, "nothing to drive", "drive", ""),
    Case(OPTION, "not a whole number", "train bassil-v1 --epochs 1.5", ""),
    Case(OPTION, "not a number", "train bassil-v1 --eta 0,25", ""),
    Case(OPTION, "epochs below 0", "train bassil-v1 --epochs -1", ""),
    Case(OPTION, "a rate of 0", "train bassil-v1 --eta 0", ""),
    Case(OPTION, "a momentum of 1", "train bassil-v1 --momentum 1", ""),
    Case(OPTION, "a tolerance that is no number", "train bassil-v1 --tolerance nan", ""),
    Case(OPTION, "a negative seed", "drive bassil-v1 --seed -1", ""),
    Case(OPTION, "an unknown rule", "train bassil-v1 --rule papr", ""),
    Case(OPTION, "an unknown order", "train bassil-v1 --order random", ""),
    Case(OPTION, "an unknown activation", "train bassil-v1 --activations sigmoid,liner", ""),
    Case(OPTION, "activations for other layers", "train bassil-v1 --activations tanh", ""),
    Case(OPTION, "a topology that is none", "train bassil-v1 --topology 2--3", ""),
    Case(OPTION, "a layer without units", "train bassil-v1 --topology 0-3", ""),
    Case(OPTION, "a layer too large", "train bassil-v1 --topology 2-3-1000000000", ""),
    Case(OPTION, "a network too large", "train bassil-v1 --topology 2-90000-90000-2", ""),
    Case(OPTION, "one number for a point", "drive --terrain a.tif --from 1 --to 3,4", ""),
    Case(OPTION, "an infinite point", "drive --terrain a.tif --from inf,1 --to 3,4", ""),
    Case(OPTION, "an unknown frame", f"{ON} --frame map", ""),
    Case(OPTION, "an option that the scenario decides", "drive bassil-v1 --from 1,2", ""),
    Case(OPTION, "a cell of no size", "inspect ground.npy --cell 0", ""),
    Case(OPTION, "a cell for a network", "inspect net.safetensors --cell 1", "", bad.network),
    Case(OPTION, "an outcome that is none", "drive bassil-v1 --require reachd", ""),
    Case(OPTION, "a scenario that is not the paper's", "paper --scenario hills-v1", ""),
]  # fmt: skip

if __name__ == "__main__":
    import sys,tempfile
    for c in CASES:
        with tempfile.TemporaryDirectory() as d:
            os.chdir(d)
            c.make()
            r=run(*shlex.split(c.words))
            print(f"{c.kind} / {c.wrong}: [{r.code}]{' OUT!' if r.out else ''} {r.err.strip()}")
