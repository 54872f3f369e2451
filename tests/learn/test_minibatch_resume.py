from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from rovernav.core import FileError, SettingError
from rovernav.learn import (
    BatchSettings,
    BatchTraining,
    OnlineSettings,
    Patterns,
    StopReason,
    Training,
    checkpointer,
    load_training,
    save_training,
    train_batches,
)
from rovernav.nets import Network
from tests.bits import assert_same_bits

SCRIPT = """
import sys
from pathlib import Path
from rovernav.learn import checkpointer, train_batches
from tests.learn.test_minibatch_resume import network, settings_for, table
settings = settings_for(int(sys.argv[2]))
save = checkpointer(Path(sys.argv[1]), settings, table(), every=0.0)
done = train_batches(network(), table(), settings, on_event=lambda event: None, on_step=save)
print(done.network.parameters.tobytes().hex())
"""


def table() -> Patterns:
    x = np.random.default_rng(5).uniform(-2.0, 2.0, (200, 3))
    return Patterns(x=x, y=np.sin(x[:, :2]), inputs=("a", "b", "c"), outputs=("d", "e"))


def settings_for(epochs: int = 20, optimizer: str = "adam") -> BatchSettings:
    return BatchSettings(optimizer=optimizer, batch=32, epochs=epochs, seed=3, validation=0.1)


def network() -> Network:
    rng = np.random.default_rng(1)
    return Network.seeded((3, 20, 9, 2), ("tanh", "relu", "linear"), rng, dtype=np.float32)


def assert_same(actual: BatchTraining, expected: BatchTraining) -> None:
    assert_same_bits(actual.network.parameters, expected.network.parameters)
    assert_same_bits(actual.moments, expected.moments)
    assert_same_bits([actual.loss, actual.validation], [expected.loss, expected.validation])
    for name in ("epoch", "updates", "stop"):
        assert getattr(actual, name) == getattr(expected, name)


@pytest.mark.parametrize("optimizer", ["sgd", "adam"])
def test_resumed_is_uninterrupted_to_the_bit(optimizer: str, tmp_path: Path) -> None:
    settings = settings_for(optimizer=optimizer)
    path = tmp_path / "training.ckpt"
    save = checkpointer(path, settings, table(), every=0.0)
    train_batches(network(), table(), settings, on_event=lambda e: e.epoch < 7, on_step=save)
    half = load_training(path, settings, table())
    assert isinstance(half, BatchTraining)
    assert half.epoch == 7
    assert_same(train_batches(half, table(), settings), train_batches(network(), table(), settings))


@pytest.mark.parametrize("stop", [None, *StopReason])
def test_saved_and_loaded_is_the_same(stop: StopReason | None, tmp_path: Path) -> None:
    path, settings = tmp_path / "deep" / "training.ckpt", BatchSettings()
    fresh = BatchTraining.fresh(network())
    training = BatchTraining(network=fresh.network, moments=fresh.moments + 0.5, stop=stop)
    save_training(training, settings, table(), path)
    assert_same(load_training(path, settings, table()), training)


def test_more_epochs_go_on_and_a_cosine_does_not(tmp_path: Path) -> None:
    path = tmp_path / "training.ckpt"
    short, long = BatchSettings(epochs=3), BatchSettings(epochs=5, tolerance=1e-9)
    save_training(train_batches(network(), table(), short), short, table(), path)
    done = train_batches(load_training(path, long, table()), table(), long)
    assert_same(done, train_batches(network(), table(), long))
    short, long = (BatchSettings(epochs=n, schedule="cosine") for n in (3, 5))
    save_training(train_batches(network(), table(), short), short, table(), path)
    with pytest.raises(SettingError, match=r"made with epochs = 3, not 5; resume with the same"):
        load_training(path, long, table())


def test_what_differs_is_said(tmp_path: Path) -> None:
    path, settings = tmp_path / "training.ckpt", BatchSettings()
    save_training(BatchTraining.fresh(network()), settings, table(), path)
    with pytest.raises(SettingError, match="made with optimizer = 'adam', not 'sgd'"):
        load_training(path, BatchSettings(optimizer="sgd"), table())
    other = Patterns(x=table().x, y=table().y + 1, inputs=table().inputs, outputs=table().outputs)
    with pytest.raises(SettingError, match="made with another pattern table"):
        load_training(path, settings, other)
    data = path.read_bytes()
    path.write_bytes(data[:-1] + bytes([data[-1] ^ 1]))
    with pytest.raises(FileError, match="is damaged: sha256 does not fit"):
        load_training(path, settings, table())


def test_the_two_kinds_are_told_apart(tmp_path: Path) -> None:
    path = tmp_path / "training.ckpt"
    save_training(BatchTraining.fresh(network()), BatchSettings(), table(), path)
    sentence = "is a checkpoint of mini-batch training, not of online back-propagation; resume"
    with pytest.raises(SettingError, match=sentence):
        load_training(path, OnlineSettings(), table())
    double = network().with_parameters(network().parameters.astype(np.float64))
    save_training(Training.fresh(double), OnlineSettings(), table(), path)
    with pytest.raises(SettingError, match="of online back-propagation, not of mini-batch"):
        load_training(path, BatchSettings(), table())
    assert load_training(path, OnlineSettings(), table()).epoch == 0


def command(path: Path, epochs: int) -> list[str]:
    return [sys.executable, "-c", SCRIPT, str(path), str(epochs)]


def surroundings(root: Path, **more: str) -> dict[str, str]:
    places = os.pathsep.join([str(root / "src"), str(root)])
    return {**os.environ, "PYTHONPATH": places, **more}


def test_killed_and_resumed_is_uninterrupted_to_the_bit(
    root: Path, tmp_path: Path, rng: np.random.Generator
) -> None:
    path, epochs = tmp_path / "training.ckpt", 2_000_000
    victim = subprocess.Popen(
        command(path, epochs), cwd=root, env=surroundings(root), stdout=subprocess.DEVNULL
    )
    try:
        until = time.monotonic() + 300
        while not path.exists() and victim.poll() is None and time.monotonic() < until:
            time.sleep(0.02)
        time.sleep(rng.uniform(0.0, 0.3))
    finally:
        victim.kill()
        victim.wait()
    settings = settings_for(epochs)
    left = load_training(path, settings, table())
    assert left.stop is None
    more = settings_for(left.epoch + 5)
    resumed = train_batches(load_training(path, more, table()), table(), more)
    assert_same(resumed, train_batches(network(), table(), more))


def test_bits_do_not_depend_on_threads(root: Path, tmp_path: Path) -> None:
    ends = []
    for threads in ("1", "2"):
        names = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "NUMBA_NUM_THREADS")
        ran = subprocess.run(
            command(tmp_path / threads, 5),
            cwd=root,
            env=surroundings(root, **dict.fromkeys(names, threads)),
            capture_output=True,
            text=True,
            check=False,
        )
        assert ran.returncode == 0, ran.stderr
        ends.append(ran.stdout.strip())
    settings = settings_for(5)
    here = train_batches(network(), table(), settings).network.parameters.tobytes().hex()
    assert ends == [here, here]
