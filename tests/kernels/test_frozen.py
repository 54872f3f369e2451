from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rovernav.kernels import _jit, backprop, frozen
from rovernav.learn import RULES
from tests.bits import assert_same_bits
from tests.kernels.nets import CASES, random_network, run, scalars

pytestmark = pytest.mark.kernels

SETTINGS = [
    {},
    {"epochs": 0},
    {"epochs": 5, "momentum": 0.5},
    {"epochs": 4, "seed": 3, "epoch": 17},
    {"epochs": 4, "momentum": 0.9, "seed": 2**62, "epoch": 10**9},
    {"epochs": 40, "momentum": 0.5, "seed": 1, "tolerance": 0.6},
    {"epochs": 5, "tolerance": 100.0},
    {"epochs": 3, "eta": 1e200},
]


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("case", CASES)
def test_frozen_kernel_has_the_bits_of_the_generic_one(
    case: Any, rule: str, rng: np.random.Generator
) -> None:
    network = random_network(case, rng)
    x, y = rng.normal(size=(3, case[0][0])), 0.5 * rng.normal(size=(3, case[0][-1]))
    train = frozen.frozen_train(network.layer_rows, RULES[rule])
    for changes in SETTINGS:
        settings = scalars(rule=RULES[rule], **changes)
        generic = run(backprop.train, network, x, y, settings)
        quick = run(train, network, x, y, settings)
        assert_same_bits(quick[0], generic[0])
        assert_same_bits(quick[1], generic[1])
        assert quick[2] == generic[2]


def test_the_settings_above_stop_in_the_middle(rng: np.random.Generator) -> None:
    network = random_network(CASES[2], rng)
    x, y = rng.normal(size=(3, 2)), 0.5 * rng.normal(size=(3, 2))
    done, solved = run(backprop.train, network, x, y, scalars(**SETTINGS[5]))[2]
    assert 0 < done < 40
    assert solved


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A kernel cache of this test's own."""
    for module in (_jit, frozen):
        monkeypatch.setattr(module, "cache_folder", lambda: tmp_path)
    return tmp_path


def train_anew(rng: np.random.Generator) -> Any:
    """Train a 1-1 network by a frozen kernel generated afresh."""
    network = random_network(CASES[1], rng)
    x = np.array([[0.5], [-1.0]])
    settings = scalars(epochs=3, momentum=0.5)
    fresh = frozen.frozen_train.__wrapped__(network.layer_rows, backprop.TEXTBOOK)
    expected = run(backprop.train, network, x, 0.5 * x, settings)
    assert_same_bits(run(fresh, network, x, 0.5 * x, settings)[0], expected[0])


def test_generated_source_is_a_readable_file(folder: Path, rng: np.random.Generator) -> None:
    train_anew(rng)
    source = (folder / "frozen_1_1_1_0.py").read_text(encoding="ascii")
    lines = source.splitlines()
    assert "def train(layers, w, v, x, y, s, record):" in lines
    assert max(map(len, lines)) <= 100
    assert [p.name for p in folder.iterdir() if p.is_file()] == ["frozen_1_1_1_0.py"]


@pytest.mark.parametrize("damage", [b"", b"\xff\xfe\x00", b"def train(*_): return 0, True\n"])
def test_damaged_source_is_written_anew(
    folder: Path, damage: bytes, rng: np.random.Generator
) -> None:
    train_anew(rng)
    path = folder / "frozen_1_1_1_0.py"
    whole = path.read_bytes()
    path.write_bytes(damage)
    train_anew(rng)
    assert path.read_bytes() == whole


def test_without_a_folder(monkeypatch: pytest.MonkeyPatch, rng: np.random.Generator) -> None:
    for module in (_jit, frozen):
        monkeypatch.setattr(module, "cache_folder", lambda: None)
    train_anew(rng)
