"""What only a real process shows: signals, kills, pipes, streams, what is loaded."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rovernav.cli._app import COMMANDS
from rovernav.learn import OnlineSettings, load_training, read_patterns
from rovernav.nets import load_network
from tests.cli.runner import run, tell

COMMAND = (sys.executable, "-m", "rovernav")
NOISE = ("train", "noise.csv", "--topology", "2-3-1", "--tolerance", "0", "--order", "shuffled")


def start(
    *words: str, stdout: Any = subprocess.PIPE, env: dict[str, str] | None = None
) -> subprocess.Popen[str]:
    command = [*COMMAND, *words]
    return subprocess.Popen(command, stdout=stdout, stderr=subprocess.PIPE, text=True, env=env)


@pytest.fixture
def noise(here: Path) -> Path:
    """Patterns that contradict each other: the weights never rest, so a lost epoch shows."""
    path = here / "noise.csv"
    path.write_text("in:x,in:y,out:u\n0,1,0.3\n0,1,-0.4\n1,0,0.9\n1,0,-0.2\n")
    return path


def wait_for_saves(path: Path, process: subprocess.Popen[str], count: int) -> None:
    """Until the process has written the file `count` times, or is done."""
    until, last = time.monotonic() + 120, path.stat().st_mtime_ns if path.exists() else None
    while count and process.poll() != 0:
        assert process.poll() is None, process.communicate()[1]
        assert time.monotonic() < until
        time.sleep(0.005)
        now = path.stat().st_mtime_ns if path.exists() else None
        if now != last:
            last, count = now, count - 1


def test_ctrl_c_keeps_what_was_learnt(noise: Path) -> None:
    words = (*NOISE, "--epochs", "1e12", "--checkpoint", "run.ckpt")
    with start(*words, "--json") as process:
        wait_for_saves(Path("run.ckpt"), process, 2)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
    assert (process.returncode, err) == (130, "")
    report = json.loads(out)
    assert report["stop"] == "interrupted"
    assert report["epochs"] > 0
    network = load_network(Path("rovernav-train/network.safetensors"))
    assert network.parameters.tolist() == report["weights"]
    settings = OnlineSettings(momentum=0.5, tolerance=0.0, order="shuffled")
    saved = load_training(Path("run.ckpt"), settings, read_patterns(noise))
    assert (saved.epoch, saved.updates) == (report["epochs"], report["updates"])


def test_ctrl_c_during_the_start_is_no_traceback(here: Path) -> None:
    command = [sys.executable, "-X", "importtime", "-m", "rovernav", "train", "bassil-v1"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        while "cyclopts" not in process.stderr.readline():
            assert process.poll() is None
        process.send_signal(signal.SIGINT)
        rest = process.stderr.read()
    said = [line for line in rest.splitlines() if not line.startswith("import time:")]
    assert (process.returncode, said) == (130, ["error: interrupted"])


@pytest.mark.parametrize("kills", [2, pytest.param(10, marks=pytest.mark.long)])
def test_killed_and_resumed_has_the_bits_of_one_left_alone(noise: Path, kills: int) -> None:
    rng = np.random.default_rng(kills)
    words = (*NOISE, "--epochs", "6e6" if kills < 5 else "4e7")
    alone = tell(*words)
    settings = OnlineSettings(momentum=0.5, tolerance=0.0, order="shuffled", epochs=alone["epochs"])
    file, epochs = Path("run.ckpt"), [0]
    for _ in range(kills):
        with start(*words, "--checkpoint", file.name, "--resume") as process:
            wait_for_saves(file, process, 2)  # one at the start, one a second later
            time.sleep(rng.uniform(0.0, 1.5))
            process.kill()
        assert process.wait() in (-9, 0)  # 0: a fast machine was ready before
        epochs.append(load_training(file, settings, read_patterns(noise)).epoch)
    assert epochs == sorted(epochs)
    assert epochs[-1] > 0
    resumed = tell(*words, "--checkpoint", file.name, "--resume")
    for key in ("weights_sha256", "epochs", "updates", "max_error"):
        assert resumed[key] == alone[key]


def test_a_pipe_closed_early_is_no_error(here: Path) -> None:
    with start("template") as process:
        assert process.stdout is not None
        process.stdout.close()
        assert process.stderr is not None
        assert process.stderr.read() == ""
    assert process.returncode == 0


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full")
def test_a_full_disk_is_a_failure(here: Path) -> None:
    with Path("/dev/full").open("w") as full, start("template", stdout=full) as process:
        _, err = process.communicate(timeout=60)
    assert (process.returncode, err) == (1, "error: the system refused: No space left on device\n")


def test_closed_streams(here: Path) -> None:
    for closed, code in ((">&-", 0), ("2>&-", 0), (">&- 2>&-", 0)):
        done = subprocess.run(f"{' '.join(COMMAND)} template {closed}", shell=True, check=False,
                              capture_output=True, text=True)  # fmt: skip
        assert done.returncode == code
        assert "Traceback" not in done.stderr


def test_names_that_no_terminal_can_show(here: Path) -> None:
    odd = os.fsdecode(b"\xff.csv")
    table = (Path(__file__).parents[2] / "src/rovernav/learn/tables/bassil-v1.csv").read_bytes()
    Path(odd).write_bytes(table)
    plain = os.environ | {"PYTHONIOENCODING": "ascii", "LC_ALL": "C", "PYTHONUTF8": "0"}
    with start("train", odd, "--epochs", "3", "--out", "ö\n", env=plain) as process:
        out, err = process.communicate(timeout=60)
    assert (process.returncode, err) == (0, "")
    assert "network.safetensors" in out
    with start("train", "a\x1b[31mb", env=plain) as process:
        _, err = process.communicate(timeout=60)
    assert err.isascii()
    assert "\x1b" not in err


def test_help_is_light_and_quick(here: Path) -> None:
    code = (
        "import sys\n"
        "from rovernav.cli import main\n"
        f"for name in [None, *{list(COMMANDS)}]:\n"
        "    assert main([*([name] if name else []), '--help']) == 0\n"
        "heavy = {'numpy', 'numba', 'scipy', 'matplotlib', 'pydantic', 'rasterio', 'safetensors',"
        " 'dask', 'distributed'}\n"
        "print(sorted(heavy & set(sys.modules)), file=sys.stderr)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.stderr == "[]\n"
    assert done.stdout.count("Example: rovernav ") == len(COMMANDS)


def test_python_m_rovernav(here: Path) -> None:
    with start("--version") as process:
        out, err = process.communicate(timeout=60)
    assert (process.returncode, out, err) == (0, run("--version").out, "")
    with start("train", "--epochs") as process:
        out, err = process.communicate(timeout=60)
    assert (process.returncode, out) == (2, "")
    assert err == "error: --epochs needs a value after it\nSee: rovernav train --help\n"
