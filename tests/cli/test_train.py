from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import pytest

from rovernav.learn import shipped_patterns, write_patterns
from rovernav.nets import load_network, weights_sha256
from tests.cli.runner import run, tell

PAPER = ("train", "bassil-v1", "--init", "paper")


def test_the_papers_weights_end_where_rovernav_paper_ends() -> None:
    trained, paper = tell(*PAPER), tell("paper")
    assert trained["weights_sha256"] == paper["weights_sha256"]
    assert (trained["stop"], trained["epochs"]) == ("tolerance", paper["epochs"])
    assert trained["updates"] == 4 * trained["epochs"]
    network = load_network(Path("rovernav-train/network.safetensors"))
    assert weights_sha256(network) == trained["weights_sha256"]
    assert np.array_equal(network.parameters, trained["weights"])


@pytest.mark.parametrize(
    ("rule", "momentum", "epochs"), [("paper", "0.9", 50), ("textbook", ".5", 674)]
)
def test_rules_need_the_epochs_of_the_table(rule: str, momentum: str, epochs: int) -> None:
    report = tell(*PAPER, "--rule", rule, "--momentum", momentum)
    assert report["epochs"] == pytest.approx(epochs, abs=1)


def test_the_written_network_says_how_it_was_trained() -> None:
    tell(*PAPER, "--rule", "textbook", "--order", "shuffled", "--seed", "7", "--eta", ".3")
    training = load_network(Path("rovernav-train/network.safetensors")).card.training
    assert training is not None
    said = {key: training[key] for key in ("rule", "order", "seed", "eta", "momentum", "tolerance")}
    assert said == {"rule": "textbook", "order": "shuffled", "seed": 7, "eta": 0.3,
                    "momentum": 0.5, "tolerance": 0.01}  # fmt: skip


def test_orders_and_seeds_differ_and_repeat() -> None:
    def weights(*words: str) -> str:
        return tell(*PAPER, "--epochs", "20", *words)["weights_sha256"]

    assert weights("--order", "shuffled") == weights("--order", "shuffled")
    assert weights("--order", "shuffled") != weights("--order", "cyclic")
    assert weights("--order", "shuffled") != weights("--order", "shuffled", "--seed", "1")
    drawn = [tell("train", "bassil-v1", "--epochs", "0", "--seed", s)["weights"] for s in "011"]
    assert drawn[1] == drawn[2] != drawn[0]


def test_a_table_of_ones_own_is_the_shipped_one() -> None:
    write_patterns(shipped_patterns("bassil-v1"), Path("my table ü.csv"))
    mine = tell("train", "my table ü.csv", "--init", "paper")
    assert mine["weights_sha256"] == tell(*PAPER)["weights_sha256"]


def test_the_topology_is_that_of_the_given_network() -> None:
    tell("train", "bassil-v1", "--topology", "2-5-2", "--epochs", "3", "--out", "a")
    on = tell(
        "train", "bassil-v1", "--init", "a/network.safetensors", "--epochs", "3", "--out", "b"
    )
    assert on["topology"] == "2-5-2"


def test_other_activations() -> None:
    report = tell("train", "bassil-v1", "--topology", "2-4-3-2", "--activations",
                  "tanh, sigmoid,linear", "--epochs", "2e1")  # fmt: skip
    assert report["updates"] == 80
    network = load_network(Path("rovernav-train/network.safetensors"))
    assert network.activations == ("tanh", "sigmoid", "linear")


@pytest.mark.parametrize("order", ["cyclic", "shuffled"])
def test_the_trace_has_a_line_for_every_update(order: str) -> None:
    report = tell(*PAPER, "--trace", "deep/t.csv", "--order", order)
    header, *lines = Path("deep/t.csv").read_text().splitlines()
    assert header.startswith("epoch,pattern,matrix1[0][0],")
    assert len(lines) == report["updates"]
    assert list(map(float, lines[-1].split(",")[2:])) == report["weights"]
    assert tell(*PAPER, "--order", order)["weights_sha256"] == report["weights_sha256"]


def test_a_dash_prints_the_trace_beside_the_result() -> None:
    said = run(*PAPER, "--epochs", "1", "--trace", "-")
    assert said.out.count("epoch 1, pattern") == 4
    assert "matrix2[0][0] = 0.132230277" in said.out
    said = run(*PAPER, "--epochs", "1", "--trace", "-", "--json")
    assert json.loads(said.out)["updates"] == 4
    assert said.err.count("epoch 1, pattern") == 4


def test_no_epochs_keep_the_first_weights() -> None:
    report = tell(*PAPER, "--epochs", "0")
    assert (report["stop"], report["updates"], report["weights"][0]) == ("epochs", 0, 0.17)


@pytest.mark.parametrize("eta", ["100", "1e9", "1e300"])
def test_a_diverged_training_fails_but_keeps_a_network(eta: str) -> None:
    report = tell(*PAPER, "--eta", eta, code=1)
    assert report["stop"] == "diverged"
    assert np.isfinite(load_network(Path("rovernav-train/network.safetensors")).parameters).all()
    said = run(*PAPER, "--eta", eta)
    assert (said.code, said.err) == (1, "")
    assert "try a smaller --eta or --momentum" in said.out


def test_a_checkpoint_goes_on_to_the_same_bits() -> None:
    whole = tell(*PAPER)
    part = run(*PAPER, "--epochs", "100", "--checkpoint", "c/run.ckpt")
    assert part.code == 0
    resumed = run(*PAPER, "--checkpoint", "c/run.ckpt", "--resume", "--json")
    assert resumed.err == "Resumed from c/run.ckpt at epoch 100.\n"
    report = json.loads(resumed.out)
    for key in ("epochs", "updates", "weights_sha256"):
        assert report[key] == whole[key]


def test_resume_without_a_checkpoint_begins_and_says_so() -> None:
    said = run(*PAPER, "--checkpoint", "run.ckpt", "--resume", "--json")
    assert (said.code, json.loads(said.out)["epochs"]) == (0, tell(*PAPER)["epochs"])
    assert said.err == ("There is no checkpoint at run.ckpt yet: training from the beginning.\n")


def test_a_resumed_trace_goes_on_where_the_checkpoint_is() -> None:
    run(*PAPER, "--epochs", "4", "--trace", "whole.csv")
    run(*PAPER, "--epochs", "2", "--checkpoint", "run.ckpt", "--trace", "t.csv")
    with Path("t.csv").open("a") as file:
        file.write("3,0,0.17,0.3")  # written after the checkpoint, cut off by a crash
    tell(*PAPER, "--epochs", "4", "--checkpoint", "run.ckpt", "--resume", "--trace", "t.csv")
    assert Path("t.csv").read_bytes() == Path("whole.csv").read_bytes()


def test_a_resumed_trace_can_begin_a_file_of_its_own() -> None:
    run(*PAPER, "--epochs", "4", "--trace", "whole.csv")
    run(*PAPER, "--epochs", "2", "--checkpoint", "run.ckpt")
    tell(*PAPER, "--epochs", "4", "--checkpoint", "run.ckpt", "--resume", "--trace", "t.csv")
    header, *lines = Path("whole.csv").read_text().splitlines()
    assert Path("t.csv").read_text().splitlines() == [header, *lines[8:]]


def test_a_device_takes_a_trace() -> None:
    assert run(*PAPER, "--trace", os.devnull).code == 0
    run(*PAPER, "--epochs", "2", "--checkpoint", "run.ckpt")
    assert run(*PAPER, "--checkpoint", "run.ckpt", "--resume", "--trace", os.devnull).code == 0


def test_words() -> None:
    said = run(*PAPER)
    first, second, *files = said.out.splitlines()
    assert first.startswith("Every error is within the tolerance: epoch 215, 860 updates, ")
    assert second.startswith("Largest |error| 0.00993")
    assert files == ["Written:", "  rovernav-train/network.safetensors",
                     "  rovernav-train/training.png"]  # fmt: skip


def write_sines(rows: int = 400) -> Path:
    x = np.random.default_rng(0).uniform(-2, 2, (rows, 3))
    y = np.column_stack([np.sin(x[:, 0]) * np.cos(x[:, 1]), x[:, 2] * x[:, 0]])
    path, names = Path("sines.csv"), "in:a,in:b,in:c,out:s,out:p"
    np.savetxt(path, np.hstack([x, y]), delimiter=",", header=names, comments="", fmt="%.6g")
    return path


BATCH = ("--method", "batch", "--topology", "3-16-2")
SMALL = (*BATCH, "--activations", "tanh,linear", "--batch", "64", "--eta", ".01")


def test_batches_learn_in_float32_and_tell_what_they_held_out() -> None:
    report = tell("train", write_sines(), *SMALL, "--validation", ".2", "--epochs", "60")
    assert (report["stop"], report["epochs"], report["updates"]) == ("epochs", 60, 300)
    assert report["max_error"] is None
    assert report["loss"] < 0.1
    assert report["validation"] < 0.1
    network = load_network(Path("rovernav-train/network.safetensors"))
    assert network.parameters.dtype == np.float32
    assert weights_sha256(network) == report["weights_sha256"]
    training = network.card.training
    assert training is not None
    said = {k: training[k] for k in ("method", "optimizer", "loss", "batch", "shards", "order")}
    assert said == {"method": "mini-batch back-propagation", "optimizer": "adam", "loss": "mse",
                    "batch": 64, "shards": 1, "order": "shuffled"}  # fmt: skip
    assert Path("rovernav-train/training.png").stat().st_size > 10_000


def test_workers_do_not_change_the_weights() -> None:
    path = write_sines()
    words = ("train", path, *SMALL, "--optimizer", "sgd", "--momentum", ".8", "--schedule",
             "cosine", "--epochs", "9")  # fmt: skip

    def weights(*more: str) -> str:
        return tell(*words, *more)["weights_sha256"]

    alone = weights("--shards", "4")
    assert weights("--shards", "4", "--workers", "1") == alone
    assert weights("--shards", "4", "--workers", "3") == alone
    assert weights("--shards", "2") != alone


def test_idle_workers_are_told() -> None:
    said = run("train", write_sines(), *SMALL, "--epochs", "1", "--workers", "3")
    assert said.code == 0
    assert said.err == (
        "note: 1 of 3 workers have something to do; --shards 3 feeds them all, with other last "
        "bits of the weights\n"
    )


def test_a_batch_training_resumes_with_other_workers() -> None:
    words = ("train", write_sines(), *SMALL, "--shards", "2", "--validation", ".1")
    whole = tell(*words, "--epochs", "12")
    run(*words, "--epochs", "5", "--checkpoint", "c.ckpt")
    said = run(*words, "--epochs", "12", "--checkpoint", "c.ckpt", "--resume", "--workers", "2",
               "--json")  # fmt: skip
    assert said.err == "Resumed from c.ckpt at epoch 5.\n"
    report = json.loads(said.out)
    for key in ("epochs", "updates", "loss", "validation", "weights_sha256"):
        assert report[key] == whole[key]


def test_words_of_batches() -> None:
    path = write_sines()
    said = run("train", path, *SMALL, "--epochs", "2", "--validation", ".1").out.splitlines()
    assert said[0].startswith("All epochs are done: epoch 2, 12 updates, ")
    assert said[1].startswith("Mean loss ")
    assert ", of the patterns held out " in said[1]
    said = run("train", path, *SMALL, "--epochs", "500", "--tolerance", ".5").out.splitlines()
    assert said[0].startswith("The mean loss is within the tolerance: epoch ")
    assert said[1].startswith("Mean loss 0.")
    said = run("train", path, *BATCH, "--optimizer", "sgd", "--eta", "1e30")
    assert (said.code, said.err) == (1, "")
    assert "try a smaller --eta or --momentum" in said.out


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("--method", "bach"), "unknown --method 'bach'; did you mean 'batch'?"),
        (("--rule", "paper", *BATCH), "--rule goes with --method online, not with --method batch"),
        (("--trace", "-", *BATCH), "--trace goes with --method online, not with --method batch"),
        (("--shards", "2"), "--shards goes with --method batch, not with --method online"),
        (("--workers", "2"), "--workers goes with --method batch, not with --method online"),
        (("--cluster", "local"), "--cluster goes with --method batch, not with"),
        ((*BATCH, "--optimizer", "adm"), "unknown optimizer 'adm'; did you mean 'adam'?"),
        ((*BATCH, "--shards", "0"), "shards must be from 1 to 1024, got 0"),
        ((*BATCH, "--batch", "1.5"), "--batch must be a whole number, got '1.5'"),
        ((*BATCH, "--loss", "softmax", "--activations", "tanh,tanh"), "takes linear outputs as"),
        ((*BATCH, "--validation", ".001"), "of 40 patterns holds out 0; both parts need"),
        ((*BATCH, "--validation", "1"), "validation must be from 0 to below 1, got 1.0"),
    ],
)
def test_wrong_options_of_batches_are_said(words: tuple[str, ...], sentence: str) -> None:
    said = run("train", write_sines(40), *words)
    assert said.code == 2
    assert sentence in said.err
    assert not Path("rovernav-train").exists()
