from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rovernav.learn import read_patterns, shipped_patterns
from rovernav.nets import load_network, weights_sha256
from rovernav.sim import load_trace
from tests.cli.runner import run, tell

W2 = [[0.13223028, 0.05338751, 0.54820041, 0.45234506],
      [0.83134754, 0.03621201, 0.66485356, 0.47208309]]  # fmt: skip


def test_json_holds_the_numbers_of_the_worked_example() -> None:
    example = tell("paper", "--out", "o")["worked_example"]
    assert_allclose(example["hidden"], [0.52497919, 0.55230791, 0.66596693], rtol=0, atol=1e-8)
    assert_allclose(example["outputs"], [0.83061975, 1.75166762], rtol=0, atol=1e-8)
    assert_allclose(example["errors"], [0.16938025, -0.75166762], rtol=0, atol=1e-8)
    assert_allclose(example["new_weights"]["w2"], W2, rtol=0, atol=1e-8)
    biases = [row[2] for row in example["new_weights"]["w1"]]
    assert_allclose(biases, [0.06243774, 0.20887640, 0.66737107], rtol=0, atol=1e-8)


def test_json_holds_the_test_case() -> None:
    report = tell("paper", "--out", "o")
    assert report["epochs"] == pytest.approx(215, abs=1)
    assert_allclose(report["first"], (0.8287, 0.8287), rtol=0, atol=0.01)
    assert_allclose(report["apex"], (5.672, 5.898), rtol=0, atol=0.15)
    assert_allclose(report["before_cut"], (11.73, 0.0), rtol=0, atol=0.16)
    assert report["end"] == [11.73, 0.0]
    assert (report["apex_step"], report["steps"], report["outcome"]) == (7, 15, "reached")
    assert report["clearance"] >= 0.30
    assert report["patterns_met"] == {"00": 1, "01": 6, "11": 7, "10": 1}


def test_the_calibrated_scenario_meets_the_papers_points() -> None:
    report = tell("paper", "--scenario", "bassil-replay-v1", "--out", "o")
    assert (report["epochs"], report["steps"]) == (pytest.approx(402, abs=1), 14)
    for name, point in (("first", (0.8287, 0.8287)), ("apex", (5.672, 5.898))):
        assert_allclose(report[name], point, rtol=0, atol=0.002)
    assert_allclose(report["end"], (11.73, 0.0), rtol=0, atol=0.01)


def test_the_files_can_be_read_back() -> None:
    report = tell("paper", "--out", "deep/er")
    files = [Path(name) for name in report["files"]]
    assert [file.name for file in files] == [
        "figure3.png", "training.png", "network.safetensors", "trace.npz", "patterns.csv",
    ]  # fmt: skip
    assert all(file.read_bytes().startswith(b"\x89PNG") for file in files[:2])
    network = load_network(files[2])
    assert weights_sha256(network) == report["weights_sha256"]
    assert network.card.codec is not None
    assert network.card.training is not None
    assert network.card.training["epochs_done"] == report["epochs"]
    assert_allclose(load_trace(files[3]).path()[-1], report["end"], rtol=0, atol=0)
    again = read_patterns(files[4])
    assert np.array_equal(again.y, shipped_patterns("bassil-v1").y)


def test_words_stand_beside_the_papers_and_fit_the_terminal() -> None:
    said = run("paper", "--out", "o")
    assert (said.code, said.err) == (0, "")
    assert "paper                 ours" in said.out
    assert "hidden outputs      0.524, 0.552, 0.665   0.524979, 0.552308, 0.665967" in said.out
    assert "epochs to tolerance        not given             215" in said.out
    assert max(map(len, said.out.splitlines())) < 80
    assert "o/figure3.png" in said.out


def test_a_narrow_terminal_breaks_no_number(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "40")
    said = run("paper", "--out", "o")
    assert "    ours   0.524979, 0.552308, 0.665967" in said.out.splitlines()


def test_the_driven_network_is_the_trained_one() -> None:
    paper = tell("paper", "--out", "p")
    drive = tell("drive", "bassil-v1", "--controller", "p/network.safetensors", "--out", "d")
    assert drive["steps"] == paper["steps"]
    assert drive["length_m"] == paper["length_m"]
    assert np.array_equal(
        load_trace(Path("d/trace.npz")).pose, load_trace(Path("p/trace.npz")).pose
    )
