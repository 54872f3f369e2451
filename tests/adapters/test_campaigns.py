"""What a user runs on a cluster: the same numbers as without one."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rovernav.adapters import DaskExecutor
from rovernav.bench import _pairs, draw_pairs, score
from rovernav.learn import Recipe, find_controller, teach
from rovernav.nets import weights_sha256
from rovernav.rover import read_rover
from rovernav.terrain import hills
from tests.adapters.clusters import Cluster, pids
from tests.cli.runner import run, tell

TINY = Recipe(
    seed=3, hidden=(8,), rounds=2, worlds=3, rovers=3, side_m=16.0, steps=12, every=2, epochs=1
)

pytestmark = pytest.mark.xdist_group("cluster")  # one cluster for all


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def ground(here: Path) -> Path:
    heights = hills(np.random.default_rng(4), shape=(120, 120), cell=0.2, relief=4.0, craters=25)
    np.save(here / "ground.npy", heights.height)
    return here / "ground.npy"


def test_scores_have_the_bits_of_a_serial_run(
    executor: DaskExecutor, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_pairs, "TOGETHER", 4)
    ground = hills(np.random.default_rng(4), shape=(120, 120), cell=0.2, relief=4.0, craters=25)
    pairs = draw_pairs(ground, read_rover("research"), 12, seed=2, nearest=5.0)
    events: list[float] = []
    for name in ("neural", "goal-seeker"):
        driver = find_controller(name)
        here = score(pairs, name, driver)
        there = score(pairs, name, driver, executor=executor, on_event=events.append)
        for field in ("time", "pose", "outcome", "steps", "length"):
            a, b = getattr(here.trace, field), getattr(there.trace, field)
            assert (a.dtype, a.shape, a.tobytes()) == (b.dtype, b.shape, b.tobytes())
        assert here.report() | {"seconds": 0} == there.report() | {"seconds": 0}
    assert sorted(events) == sorted([1 / 3, 2 / 3, 1.0] * 2)


@pytest.mark.long
def test_a_driver_taught_on_a_cluster_has_the_same_weights(
    executor: DaskExecutor, here: Path
) -> None:
    alone = teach(TINY, here / "alone")
    shares: list[float] = []
    there = teach(
        TINY, here / "there", executor=executor,
        on_event=lambda lesson: shares.append(lesson.share) if lesson.doing == "driving" else None,
    )  # fmt: skip
    assert weights_sha256(there) == weights_sha256(alone)
    for number in (1, 2):
        kept = [
            np.load(here / name / f"round-{number}.npz")["table"] for name in ("alone", "there")
        ]
        assert kept[0].tobytes() == kept[1].tobytes()
    assert sorted(shares) == sorted([1 / 3, 2 / 3, 1.0, 1.0] * 2)


@pytest.mark.long
def test_commands_take_an_address(cluster: Cluster, client: Any, ground: Path) -> None:
    words = ("compare", ground, "--cell", 0.2, "--pairs", 30, "--nearest", 5)
    alone = tell(*map(str, words))
    there = tell(*map(str, words), "--cluster", cluster.address, "--cluster-timeout", "60")
    for report in (alone, there):
        for one in report["scores"]:
            del one["seconds"]
    assert there == alone


SWEEP = ("sweep", "bassil-v1", "--eta", "0.1,0.25,0.4", "--momentum", "0.5,0.9", "--seeds", "2000")


def test_a_sweep_on_a_cluster_outlives_a_worker_and_writes_the_same_bytes(
    cluster: Cluster, client: Any, here: Path
) -> None:
    alone = tell(*SWEEP, "--out", "alone", "--workers", "1", "--members", "0,11999")
    killed = threading.Timer(1.0, lambda: os.kill(min(pids(client).values()), signal.SIGKILL))
    killed.start()
    words = (*SWEEP, "--out", "there", "--members", "0,11999", "--cluster", cluster.address)
    there = tell(*words, "--cluster-timeout", "60")
    killed.join()
    for name in ("sweep.csv", "settings.csv", "best.safetensors"):
        assert (here / "alone" / name).read_bytes() == (here / "there" / name).read_bytes()
    assert there["weights"] == alone["weights"]
    assert (there["solved"], there["best"]) == (alone["solved"], alone["best"])


def test_shards_computed_on_a_cluster_give_the_same_weights(
    cluster: Cluster, client: Any, here: Path
) -> None:
    rng = np.random.default_rng(5)
    rows = rng.normal(size=(600, 5))
    lines = ["in:a,in:b,in:c,out:u,out:v", *(",".join(map(str, row)) for row in rows)]
    (here / "table.csv").write_text("\n".join(lines) + "\n")
    words = ("train", "table.csv", "--method", "batch", "--topology", "3-16-2", "--batch", "200",
             "--epochs", "8", "--tolerance", "0")  # fmt: skip
    alone = tell(*words, "--out", "alone")
    where = ("--cluster", cluster.address, "--cluster-timeout", "60")
    there = tell(*words, "--out", "there", *where)
    assert (there["updates"], there["weights_sha256"]) == (24, alone["weights_sha256"])


@pytest.mark.long
def test_an_interrupted_sweep_on_a_cluster_is_resumed_on_this_machine(
    cluster: Cluster, client: Any, here: Path
) -> None:
    words = (*SWEEP, "--tolerance", "0", "--epochs", "400", "--out", "kept")
    alone = tell(*words[:-1], "alone")
    command = [sys.executable, "-m", "rovernav", *words, "--cluster", cluster.address,
               "--cluster-timeout", "60"]  # fmt: skip
    kept = here / "kept" / "sweep.members"
    with subprocess.Popen(command, stdout=-1, stderr=-1, text=True) as process:
        wait_for(lambda: kept.exists() and kept.stat().st_size > 3000, process)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
    assert (process.returncode, out) == (130, "")
    assert "members are kept in kept" in err
    assert "Traceback" not in err
    again = tell(*words, "--resume")
    assert again["best"] == alone["best"]
    assert (here / "kept/sweep.csv").read_bytes() == (here / "alone/sweep.csv").read_bytes()


def test_complaints_are_one_line(ground: Path) -> None:
    words = ("compare", str(ground), "--cell", "0.2")
    for more, code, what in [
        (("--cluster", "here"), 2, "a cluster's address is written tcp://HOST:PORT"),
        (("--cluster", "tcp://127.0.0.1:1", "--cluster-timeout", "1"), 1, "no Dask scheduler answ"),
        (("--cluster", "local", "--cluster-timeout", "nan"), 2, "a cluster may take from 0 to"),
        (
            ("--cluster", "tcp://127.0.0.1:1", "--workers", "2"),
            2,
            "--workers goes with --cluster l",
        ),
        (("--workers", "-1"), 2, "--workers must be from 0 to 1024, got -1"),
        (("--workers", "2000"), 2, "--workers must be from 0 to 1024, got 2000"),
    ]:
        said = run(*words, *more)
        assert (said.code, said.out) == (code, ""), said.err
        assert said.err.startswith(f"error: {what}")
        assert said.err.count("\n") == 1


def begun(client: Any) -> bool:
    """Whether parts of a comparison are being worked on."""

    def running(dask_scheduler: Any) -> bool:
        return any("drive_part" in str(key) for key in dask_scheduler.tasks)

    return bool(client.run_on_scheduler(running))


def test_ctrl_c_takes_the_work_back(cluster: Cluster, client: Any, ground: Path) -> None:
    command = [sys.executable, "-m", "rovernav", "compare", str(ground), "--cell", "0.2",
               "--pairs", "4000", "--nearest", "5", "--cluster", cluster.address,
               "--cluster-timeout", "60"]  # fmt: skip
    with subprocess.Popen(command, stdout=-1, stderr=-1, text=True) as process:
        wait_for(lambda: begun(client), process)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
    assert (process.returncode, out, err) == (130, "", "error: interrupted\n")
    wait_for(lambda: not begun(client))
    assert len(pids(client)) == 2


@pytest.mark.long
def test_ctrl_c_at_a_terminal_ends_a_local_cluster(ground: Path) -> None:
    command = [sys.executable, "-m", "rovernav", "compare", str(ground), "--cell", "0.2",
               "--pairs", "4000", "--nearest", "5", "--cluster", "local",
               "--workers", "2"]  # fmt: skip
    with subprocess.Popen(
        command, stdout=-1, stderr=-1, text=True, start_new_session=True
    ) as process:
        wait_for(lambda: len(group(process.pid)) >= 3, process)
        time.sleep(2.0)
        assert {address for pid in group(process.pid) for address in listening(pid)} == {
            "127.0.0.1"
        }
        os.killpg(process.pid, signal.SIGINT)  # as a terminal does it: to all of them
        out, err = process.communicate(timeout=60)
    assert (process.returncode, out, err) == (130, "", "error: interrupted\n")
    wait_for(lambda: not group(process.pid))


@pytest.mark.long
@pytest.mark.parametrize("seed", range(3))
def test_a_comparison_outlives_its_workers(
    cluster: Cluster, client: Any, ground: Path, seed: int
) -> None:
    words = ("compare", str(ground), "--cell", "0.2", "--pairs", "1000", "--nearest", "5",
             "--controllers", "neural")  # fmt: skip
    alone = tell(*words)
    rng = np.random.default_rng(seed)
    over = threading.Event()
    kills: list[int] = []

    def kill() -> None:
        while not over.wait(rng.uniform(0.0, 3.0)) and len(kills) < 6:
            alive = sorted(pids(client).values())
            for pid in alive[: rng.integers(1, 3)]:
                os.kill(pid, signal.SIGKILL)
                kills.append(pid)
            while len(pids(client)) < 2 and not over.wait(0.1):
                pass  # a nanny needs some seconds to start another

    killer = threading.Thread(target=kill)
    killer.start()
    try:
        there = tell(*words, "--cluster", cluster.address, "--cluster-timeout", "60")
    finally:
        over.set()
        killer.join()
    assert kills
    del alone["scores"][0]["seconds"], there["scores"][0]["seconds"]
    assert there == alone


def group(leader: int) -> list[int]:
    """The processes that a process started, and itself."""
    found: list[int] = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            fields = (folder / "stat").read_text().rsplit(")", 1)[1].split()
        except OSError:
            continue
        if int(fields[2]) == leader and fields[0] != "Z":
            found.append(int(folder.name))
    return found


def listening(pid: int) -> set[str]:
    """The addresses at which a process waits for others."""
    import psutil

    with contextlib.suppress(psutil.Error):
        found = psutil.Process(pid).net_connections()
        return {str(one.laddr.ip) for one in found if one.status == psutil.CONN_LISTEN}
    return set()


def wait_for(what: Any, process: subprocess.Popen[str] | None = None) -> None:
    until = time.monotonic() + 120.0
    while not what():
        assert time.monotonic() < until
        assert process is None or process.poll() is None, process.communicate()[1]
        time.sleep(0.05)
