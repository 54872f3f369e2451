"""Compile the kernels that many tests call, so that tests on several workers find them.

A route, drives of a point and of a body with sensors that err, and a training: the commands
themselves, on little ground, with their results thrown away.
"""

import contextlib
import io
import os
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from rovernav.cli import main as rovernav

FLAT = "--cell 1 --frame local --from 4,4 --to 20,18"
COMMANDS = (
    f"route GROUND {FLAT} --objective energy --no-picture --why 10,10",
    f"route GROUND {FLAT} --no-picture",
    f"drive --terrain GROUND {FLAT} --controller neural --body --sensing stereo --drift",
    f"drive --terrain GROUND {FLAT} --controller goal-seeker --sensing lidar --route plan",
    "drive bassil-v1",
    "paper",
)


def main() -> None:
    """Exit with 1 if a command fails."""
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        y, x = np.mgrid[0:48, 0:48] / 8.0
        np.save("ground.npy", (0.2 * np.sin(x) * np.cos(y)).astype(np.float32))
        for number, command in enumerate(COMMANDS):
            words = command.replace("GROUND", str(Path("ground.npy"))).split()
            begun, said = time.process_time(), io.StringIO()
            with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
                code = rovernav([*words, "--out", f"out-{number}"])
            print(
                f"{command}: {code} ({time.process_time() - begun:.1f} s of processor time)",
                flush=True,
            )
            if code not in (0, 1):
                sys.exit(said.getvalue())


if __name__ == "__main__":
    main()
