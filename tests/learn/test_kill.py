"""A training that is killed, again and again, ends with the bits of one that was left alone."""

from __future__ import annotations

import functools
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from rovernav.learn import (
    OnlineSettings,
    StopReason,
    Training,
    checkpointer,
    load_training,
    paper_network,
    shipped_patterns,
    train,
)
from rovernav.learn import _online as engine
from tests.bits import assert_same_bits

TABLE = shipped_patterns("bassil-v1")
SETTINGS = OnlineSettings(
    order="shuffled", seed=11, eta=0.1, momentum=0.5, tolerance=0.0, epochs=400_000
)
CHILD = "import sys; from tests.learn.test_kill import go_on; go_on(sys.argv[1])"


def go_on(name: str) -> None:
    """What the killed process does: go on from the checkpoint and save often."""
    engine.SLICE = 20_000 * 17
    path = Path(name)
    start = load_training(path, SETTINGS, TABLE) if path.exists() else paper_network()
    save = checkpointer(path, SETTINGS, TABLE, every=0.0)

    def save_and_tell(training: Training) -> None:
        save(training)
        sys.stdout.write("saved\n")
        sys.stdout.flush()

    train(start, TABLE, SETTINGS, on_step=save_and_tell)


def run(path: Path, root: Path, saves: int | None = None, delay: float = 0.0) -> int:
    """Run the child to its end, or kill it `delay` [s] after so many saves; its exit status."""
    command = [sys.executable, "-c", CHILD, str(path)]
    with subprocess.Popen(command, cwd=root, stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout is not None
        for number, _ in enumerate(child.stdout, 1):
            if number == saves:
                time.sleep(delay)
                child.kill()
        return child.wait()


@functools.cache
def left_alone() -> Training:
    return train(paper_network(), TABLE, SETTINGS)


@pytest.mark.parametrize("kills", [3, pytest.param(20, marks=pytest.mark.long)])
def test_killed_and_resumed_is_uninterrupted_to_the_bit(
    kills: int, tmp_path: Path, root: Path
) -> None:
    rng = np.random.default_rng(kills)
    path = tmp_path / "c.safetensors"
    epochs = [0]
    for _ in range(kills):
        saves, delay = int(rng.integers(1, 60 // kills + 1)), float(rng.uniform(0.0, 0.02))
        assert run(path, root, saves, delay) == -9
        saved = load_training(path, SETTINGS, TABLE)
        assert saved.stop is None
        epochs.append(saved.epoch)
    assert epochs == sorted(set(epochs))
    assert run(path, root) == 0
    ended = load_training(path, SETTINGS, TABLE)
    assert (ended.epoch, ended.updates, ended.stop) == (400_000, 1_600_000, StopReason.EPOCHS)
    assert_same_bits(ended.network.parameters, left_alone().network.parameters)
    assert_same_bits(ended.deltas, left_alone().deltas)
    left = {p.name for p in tmp_path.iterdir()} - {path.name}
    assert all(name.startswith(".c.safetensors.") and name.endswith(".tmp") for name in left)
