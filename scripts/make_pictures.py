"""Make the pictures of the pages anew, by the program itself, into `docs/images/`.

Those of real ground need the development data, whose folder ROVERNAV_DATA names; without them
they stay as they are. Pictures are reduced to 256 colours.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
IMAGES = ROOT / "docs" / "images"
PROGRAM = Path(sys.executable).with_name("rovernav")
YARD = "dem/earth_marsyard2021_9cm/marsyard_terrain_hm.tif"
YARD_DRIVES = {
    "drive": "--from 10,25 --to 35,15 --rover research --controller neural",
    "yard-reached": "--from 12,20 --to 35,20",
    "yard-collided": "--from 12,20 --to 35,15",
}
WAVES = (
    "--method batch --topology 3-64-64-2 --activations tanh,tanh,linear --epochs 20 "
    "--validation 0.1 --schedule cosine --eta 0.01 --shards 8"
)
MADE = "--seed 3 --size 120,90 --slope 4 --craters mars --rocks 0.06"
LIMIT = 300_000
"""Largest picture [bytes]."""


def main() -> None:
    """Run the commands and keep their pictures."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder)
        rovernav("paper", "--out", out / "paper")
        keep(out / "paper/figure3.png", "figure3.png")
        keep(out / "paper/training.png", "training.png")
        rovernav("paper", "--scenario", "bassil-replay-v1", "--out", out / "replay")
        keep(out / "replay/figure3.png", "replay.png")
        write_waves(out / "waves.csv")
        rovernav("train", out / "waves.csv", *WAVES.split(), "--out", out / "waves")
        keep(out / "waves/training.png", "batches.png")
        rovernav("terrain", "make", *MADE.split(), "--out", out / "made")
        keep(out / "made/terrain.png", "made-ground.png")
        data = Path(os.environ.get("ROVERNAV_DATA", "."))
        if not (data / YARD).exists():
            sys.exit(f"no {YARD} in ROVERNAV_DATA: pictures of real ground stay as they are")
        for name, words in YARD_DRIVES.items():
            ground = ("--terrain", data / YARD, "--frame", "local")
            rovernav("drive", *ground, *words.split(), "--out", out / name)
            keep(out / name / "drive.png", f"{name}.png")


def write_waves(path: Path) -> None:
    """The table of the page on larger networks."""
    x = np.random.default_rng(0).uniform(-2, 2, (20_000, 3))
    y = np.column_stack([np.sin(x[:, 0]) * np.cos(x[:, 1]), x[:, 0] * x[:, 2]])
    header = "in:a,in:b,in:c,out:wave,out:product"
    np.savetxt(path, np.hstack([x, y]), delimiter=",", header=header, comments="", fmt="%.6g")


def rovernav(*words: object) -> None:
    """Run a command of the program."""
    subprocess.run([PROGRAM, *map(str, words)], check=True, stdout=subprocess.DEVNULL)


def keep(picture: Path, name: str) -> None:
    """Keep a picture under this name, in 256 colours."""
    IMAGES.mkdir(exist_ok=True)
    with Image.open(picture) as full:  # this method keeps rare colours, such as those of marks
        few = full.convert("RGB").quantize(
            256, method=Image.Quantize.MAXCOVERAGE, kmeans=2, dither=Image.Dither.NONE
        )
    few.save(IMAGES / name, optimize=True)
    size = (IMAGES / name).stat().st_size
    print(f"{IMAGES / name}: {size:,} bytes")
    if size > LIMIT:
        sys.exit(f"{name} is larger than {LIMIT:,} bytes")


if __name__ == "__main__":
    main()
