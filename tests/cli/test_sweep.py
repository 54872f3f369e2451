from __future__ import annotations

import csv
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

from rovernav.cli._numbers import numbers, whole_numbers
from rovernav.core import SettingError
from rovernav.nets import load_network, weights_sha256
from tests.cli.runner import run, tell

SWEEP = ("sweep", "bassil-v1", "--eta", "0.1..0.5/3", "--momentum", "0,0.9", "--seeds", "30")


def test_members_have_the_weights_that_train_gives_them() -> None:
    report = tell(*SWEEP, "--epochs", "500", "--members", "0,29,47,179", "--seed", "5")
    assert [one["member"] for one in report["weights"]] == [0, 29, 47, 179]
    for one in report["weights"]:
        alone = tell(
            "train", "bassil-v1", "--eta", str(one["eta"]), "--momentum", str(one["momentum"]),
            "--seed", str(one["seed"]), "--epochs", "500",
        )  # fmt: skip
        for key in ("weights_sha256", "weights", "epochs", "updates", "stop"):
            assert one[key] == alone[key]
    assert report["weights"][-1]["seed"] == 34


def test_all_that_train_can_do_the_members_do() -> None:
    words = ("--topology", "2-4-3-2", "--activations", "tanh,relu,linear", "--rule", "textbook",
             "--order", "shuffled", "--tolerance", "0", "--epochs", "40")  # fmt: skip
    report = tell("sweep", "bassil-v1", *words, "--seeds", "3", "--members", "2")
    alone = tell("train", "bassil-v1", *words, "--seed", "2", "--eta", ".25", "--momentum", ".5")
    assert report["weights"][0]["weights_sha256"] == alone["weights_sha256"]
    assert (report["solved"], report["updates"]) == (0, 3 * 40 * 4)


def test_the_report_and_the_files_agree() -> None:
    report = tell(*SWEEP)
    assert report["members"] == report["of"] == 180
    assert report["seconds"] > 0.0
    assert report["ns_per_update"] == pytest.approx(1e9 * report["seconds"] / report["updates"])
    lines = list(csv.DictReader(Path("rovernav-sweep/sweep.csv").read_text().splitlines()))
    assert len(lines) == 180
    assert sum(int(line["updates"]) for line in lines) == report["updates"]
    assert sum(line["stop"] == "tolerance" for line in lines) == report["solved"]
    rows = list(csv.DictReader(Path("rovernav-sweep/settings.csv").read_text().splitlines()))
    assert [(float(r["eta"]), float(r["momentum"])) for r in rows] == [
        (eta, momentum) for eta in (0.1, 0.3, 0.5) for momentum in (0.0, 0.9)
    ]
    best = load_network(Path("rovernav-sweep/best.safetensors"))
    assert best.card.training is not None
    assert best.card.training["epochs_done"] == report["best"]["epochs"]
    assert best.card.seed == best.card.training["seed"] == report["best"]["seed"]
    assert Path("rovernav-sweep/sweep.png").read_bytes().startswith(b"\x89PNG")
    rates = {f"--{key}": str(report["best"][key]) for key in ("eta", "momentum", "seed")}
    alone = tell("train", "bassil-v1", *(word for pair in rates.items() for word in pair))
    assert alone["weights_sha256"] == weights_sha256(best)


@pytest.mark.parametrize("workers", ["1", "2", "4", "8"])
def test_workers_change_no_file(workers: str) -> None:
    names = ("sweep.csv", "settings.csv", "sweep.members", "best.safetensors", "sweep.png")
    words = ("--tolerance", "0", "--epochs", "20", "--seeds", "2000")
    tell(*SWEEP[:-2], *words, "--workers", workers, "--out", "some")
    tell(*SWEEP[:-2], *words, "--workers", "3", "--out", "three")
    for name in names:
        assert (Path("some") / name).read_bytes() == (Path("three") / name).read_bytes()


def test_words_for_people() -> None:
    said = run(*SWEEP, "--members", "3")
    assert said.code == 0
    lines = said.out.splitlines()
    assert lines[0].startswith("180 networks trained: ")
    assert "eta   momentum   solved" in said.out
    assert "Member 3: eta 0.1, momentum 0.0, seed 3, " in said.out
    assert lines[-1] == "  rovernav-sweep/best.safetensors"
    assert max(map(len, lines)) <= 100


def test_many_settings_show_the_best() -> None:
    said = run("sweep", "bassil-v1", "--eta", "0.01..0.5/20", "--momentum", "0..0.9", "--seeds",
               "2", "--epochs", "30", "--tolerance", "0.5")  # fmt: skip
    assert "The best 30 of 200 settings (all are in settings.csv):" in said.out


def test_without_a_tolerance() -> None:
    said = run(*SWEEP, "--tolerance", "0", "--epochs", "5")
    assert "All epochs were done, without a tolerance; 0 diverged." in said.out
    assert "least error" in said.out


def test_resume_repeats_nothing_and_another_sweep_is_refused() -> None:
    first = tell(*SWEEP)
    said = run(*SWEEP)
    assert said.code == 2
    assert "go on with it by --resume" in said.err
    again = run(*SWEEP, "--resume", "--json")
    assert again.err == "Resumed: 180 of 180 members were kept.\n"
    report = json.loads(again.out)
    assert report["settings"] == first["settings"]
    assert (report["updates"], report["seconds"]) == (first["updates"], 0.0)
    assert report["ns_per_update"] is None
    said = run(*SWEEP, "--resume", "--epochs", "7")
    assert said.code == 2
    assert "was made with epochs = 5000, not 7" in said.err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--seeds", "0"), "seeds must be from 1 to 10^9, got 0"),
        (("--seeds", "1e10"), "seeds must be from 1 to 10^9, got 10,000,000,000"),
        (("--eta", "0.5..0.05"), "a range goes from the smaller to the larger"),
        (("--eta", "0.1..0.1"), "a range goes from the smaller to the larger"),
        (("--eta", "0.1..0.5/1"), "from 2 to 10,000, like 0.05..0.5/20; got '1'"),
        (("--eta", "0.1..0.5/x"), "got 'x'"),
        (("--eta", "0.1,,2"), "--eta takes a list like 0,0.5,0.9"),
        (("--eta", "fast"), "got 'fast'"),
        (("--eta", "nan"), "got 'nan'"),
        (("--eta", "0.1..inf"), "got 'inf'"),
        (("--eta", "0"), "eta must be a number above 0, got 0.0"),
        (("--momentum", "0,1"), "momentum must be from 0 to below 1, got 1.0"),
        (("--momentum", "0.5,0.5"), "momentum 0.5 stands twice"),
        (("--eta", "0.001..1/5000", "--momentum", "0..0.9"), "50,000 settings; at most 10,000"),
        (("--eta", "0.001..1/1000", "--seeds", "1e7"), "members; at most 10^9 are allowed"),
        (("--workers", "1025"), "--workers must be from 0 to 1024, got 1025"),
        (("--members", "1000"), "there is no member 1000; this sweep has members 0 to 999"),
        (("--members", "one"), "--members takes whole numbers"),
        (("--topology", "3-3-2"), "a 3-3-2 network has 3 inputs and 2 outputs"),
        (("--topology", "2-3-1"), "1 outputs, the patterns have 2 inputs and 2 targets"),
        (("--rule", "papr"), "did you mean"),
        (("--order", "random"), "unknown order 'random'"),
        (("--seed", "-1"), "--seed must be from 0 to 2^63 - 1"),
        (("--out", "file"), "--out file is a file"),
    ],
)
def test_bad_options_are_one_sentence(words: tuple[str, ...], message: str) -> None:
    Path("file").write_text("x")
    said = run("sweep", "bassil-v1", *words)
    assert (said.code, said.out) == (2, "")
    assert message in said.err
    assert said.err.startswith("error: ")
    assert not Path("rovernav-sweep/sweep.csv").exists()


def test_number_lists() -> None:
    assert numbers("--eta", "0,0.5,0.9") == (0.0, 0.5, 0.9)
    assert numbers("--eta", "0.05..0.5") == tuple(k / 100 for k in range(5, 51, 5))
    assert numbers("--eta", "1e-3..1e-1/3, 2") == (0.001, 0.0505, 0.1, 2.0)
    assert whole_numbers("--members", "3, 1") == [3, 1]
    with pytest.raises(SettingError, match="may list 10,000 numbers"):
        numbers("--eta", "0..1/10000,2..3/10")


LONG: tuple[str, ...] = (
    "sweep", "bassil-v1", "--eta", "0.05..0.5", "--momentum", "0,0.5,0.9",
    "--tolerance", "0", "--epochs", "2000", "--seeds", "600",
)  # fmt: skip


def begin(*words: str) -> subprocess.Popen[str]:
    return subprocess.Popen([sys.executable, "-m", "rovernav", *words], stdout=subprocess.PIPE,
                            stderr=subprocess.PIPE, text=True)  # fmt: skip


def wait_for(path: Path, size: int, process: subprocess.Popen[str]) -> None:
    until = time.monotonic() + 300
    while not (path.exists() and path.stat().st_size > size):
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < until
        time.sleep(0.005)


def test_ctrl_c_keeps_finished_blocks_and_says_how_to_go_on() -> None:
    kept = Path("rovernav-sweep/sweep.members")
    with begin(*LONG, "--json") as process:
        wait_for(kept, 20_000, process)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=120)
    assert process.returncode == 130
    report: dict[str, Any] = json.loads(out)
    assert report["stop"] == "interrupted"
    assert 0 < report["members"] < report["of"] == 18_000
    assert "Go on with the same command and --resume." in err
    assert os.listdir("rovernav-sweep") == ["sweep.members"]
    quick = (*LONG, "--resume", "--json")
    with begin(*quick) as process:
        out, err = process.communicate(timeout=300)
    assert process.returncode == 0
    assert int(err.split()[1].replace(",", "")) >= report["members"]
    tell(*LONG, "--out", "alone")
    for name in ("sweep.csv", "settings.csv", "sweep.members", "best.safetensors"):
        assert (Path("rovernav-sweep") / name).read_bytes() == (Path("alone") / name).read_bytes()


def test_killed_at_a_random_moment_it_goes_on() -> None:
    kept, rng = Path("rovernav-sweep/sweep.members"), np.random.default_rng(2)
    for size in (20_000, 60_000):
        with begin(*LONG, "--resume") as process:
            wait_for(kept, size, process)
            time.sleep(rng.uniform(0.0, 0.1))
            process.kill()
            process.communicate()
    report = tell(*LONG, "--resume")
    alone = tell(*LONG, "--out", "alone")
    assert report["settings"] == alone["settings"]
    for name in ("sweep.csv", "sweep.members", "best.safetensors"):
        assert (Path("rovernav-sweep") / name).read_bytes() == (Path("alone") / name).read_bytes()
