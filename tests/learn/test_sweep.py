"""A sweep gives every member what its training alone gives it, whoever works on it."""

from __future__ import annotations

import csv
import dataclasses
import io
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rovernav.core import Executor, Processes, Serial, SettingError, ShapeError, Threads, wilson
from rovernav.learn import (
    OnlineSettings,
    Patterns,
    StopReason,
    SweepProgress,
    SweepSettings,
    SweepStore,
    shipped_patterns,
    sweep,
    train,
    train_members,
    write_members_csv,
    write_settings_csv,
)
from rovernav.nets import Network
from tests.bits import assert_same_bits

TABLE = shipped_patterns("bassil-v1")
SMALL = SweepSettings(etas=(0.1, 0.45, 3.0), momenta=(0.0, 0.9), seeds=40, epochs=400)


def table_of(settings: SweepSettings, folder: Path, executor: Executor | None = None) -> bytes:
    store = SweepStore.in_memory(settings, TABLE)
    sweep(TABLE, settings, executor=executor, store=store)
    return write_members_csv(store, settings, len(TABLE.x), folder / "sweep.csv").read_bytes()


def alone(settings: SweepSettings, number: int, patterns: Patterns = TABLE) -> Any:
    """What `rovernav train` makes of a member: its network drawn, then trained by itself."""
    rng = np.random.default_rng(settings.seed(number))
    network = Network.seeded(settings.topology, settings.activations, rng)
    eta, momentum = settings.rate(number)
    return train(network, patterns, OnlineSettings(
        eta=eta, momentum=momentum, rule=settings.rule, tolerance=settings.tolerance,
        epochs=settings.epochs, order=settings.order, seed=settings.seed(number),
    ))  # fmt: skip


@pytest.mark.parametrize(
    "settings",
    [
        SMALL,
        dataclasses.replace(SMALL, order="shuffled", first_seed=2**62, epochs=150),
        dataclasses.replace(SMALL, tolerance=0.0, epochs=30, rule="textbook"),
    ],
)
def test_members_are_their_trainings_alone(settings: SweepSettings, tmp_path: Path) -> None:
    lines = list(csv.DictReader(io.StringIO(table_of(settings, tmp_path).decode())))
    assert len(lines) == settings.members == 240
    numbers = [0, 1, 39, 40, 77, 119, 130, 200, 239]
    for number, again in zip(numbers, train_members(TABLE, settings, numbers), strict=True):
        one, line = alone(settings, number), lines[number]
        assert_same_bits(again.network.parameters, one.network.parameters)
        assert (again.stop, again.epoch, again.updates) == (one.stop, one.epoch, one.updates)
        eta, momentum = settings.rate(number)
        worst = float(np.abs(TABLE.y - one.network.forward(TABLE.x)).max())
        assert line == {
            "member": str(number), "eta": repr(eta), "momentum": repr(momentum),
            "seed": str(settings.first_seed + number % 40), "epochs": str(one.epoch),
            "updates": str(one.updates), "stop": str(one.stop), "max_error": repr(worst),
        }  # fmt: skip


def test_a_large_network_is_trained_one_by_one(rng: np.random.Generator) -> None:
    patterns = Patterns(x=rng.normal(size=(3, 6)), y=rng.normal(size=(3, 2)),
                        inputs=tuple("abcdef"), outputs=("u", "v"))  # fmt: skip
    settings = SweepSettings(topology=(6, 12, 2), etas=(0.05, 1e200), seeds=3, epochs=60,
                             tolerance=0.2)  # fmt: skip
    result = sweep(patterns, settings)
    for number, ended in enumerate(train_members(patterns, settings, range(6))):
        one = alone(settings, number, patterns)
        assert_same_bits(ended.network.parameters, one.network.parameters)
        assert (ended.stop, ended.epoch) == (one.stop, one.epoch)
    assert (result.members, result.diverged) == (6, 3)


@pytest.mark.parametrize("executor", [Serial(), Threads(1), Threads(2), Threads(4), Threads(8)])
def test_the_workers_change_nothing(executor: Executor, tmp_path: Path) -> None:
    settings = dataclasses.replace(SMALL, tolerance=0.0, epochs=9, seeds=1500)
    assert table_of(settings, tmp_path, executor) == table_of(settings, tmp_path, Serial())


def test_processes_change_nothing(tmp_path: Path) -> None:
    assert table_of(SMALL, tmp_path, Processes(2)) == table_of(SMALL, tmp_path, Serial())


def test_scores_are_those_of_the_table(tmp_path: Path) -> None:
    store = SweepStore.in_memory(SMALL, TABLE)
    result = sweep(TABLE, SMALL, store=store)
    path = write_members_csv(store, SMALL, len(TABLE.x), tmp_path / "sweep.csv")
    lines = list(csv.DictReader(path.read_text().splitlines()))
    met = [line for line in lines if line["stop"] == "tolerance"]
    assert result.solved == len(met)
    assert result.updates == result.updates_now == sum(int(line["updates"]) for line in lines)
    assert result.diverged == sum(line["stop"] == "diverged" for line in lines)
    for number, score in enumerate(result.settings):
        mine = lines[40 * number : 40 * number + 40]
        epochs = [int(line["epochs"]) for line in mine if line["stop"] == "tolerance"]
        assert (score.eta, score.momentum) == SMALL.rates[number]
        assert (score.members, score.solved) == (40, len(epochs))
        assert (score.low, score.high) == wilson(len(epochs), 40)
        wanted = np.quantile(epochs, [0.25, 0.5, 0.75]) if epochs else [np.nan] * 3
        assert_allclose(score.epochs, wanted, rtol=1e-12)
        assert_allclose(score.updates, np.multiply(wanted, 4), rtol=1e-12)
        assert score.least_error == min(float(line["max_error"]) for line in mine)
    best = result.best
    assert best is not None
    quickest = min(met, key=lambda line: (int(line["epochs"]), float(line["max_error"])))
    assert (best.member, best.stop) == (int(quickest["member"]), StopReason.TOLERANCE)
    written = write_settings_csv(result, tmp_path / "s.csv").read_text()
    rows = list(csv.DictReader(written.splitlines()))
    assert [row["solved"] for row in rows] == [str(s.solved) for s in result.settings]
    assert rows[-1]["epochs_median"] == ""
    assert rows[1]["updates_median"] == repr(result.settings[1].updates[1])


def test_some_learn_some_do_not_and_some_diverge() -> None:
    result = sweep(TABLE, SMALL)
    assert 0 < result.solved < 240 - result.diverged < 240
    assert result.ns_per_update > 0.0


def test_without_a_tolerance_the_best_has_the_least_error() -> None:
    settings = dataclasses.replace(SMALL, tolerance=0.0, epochs=30)
    result = sweep(TABLE, settings)
    assert result.solved == 0
    assert result.best is not None
    assert result.best.max_error == min(score.least_error for score in result.settings)


def test_a_listener_ends_it_and_it_goes_on() -> None:
    settings = SweepSettings(seeds=30_000, tolerance=0.0, epochs=50)
    store = SweepStore.in_memory(settings, TABLE)
    events: list[SweepProgress] = []

    def stop_early(event: SweepProgress) -> bool:
        events.append(event)
        return event.members <= 2 * store.block

    part = sweep(TABLE, settings, store=store, on_event=stop_early)
    assert not part.finished
    assert part.members == events[-1].members == 3 * store.block == store.members
    rest = sweep(TABLE, settings, store=store)
    whole = sweep(TABLE, settings)
    assert rest.finished
    assert rest.best is not None
    assert whole.best is not None
    assert (rest.best.member, rest.updates) == (whole.best.member, whole.updates)
    assert rest.updates_now == whole.updates - part.updates
    again = sweep(TABLE, settings, store=store)
    assert (again.updates_now, again.seconds, again.members) == (0, 0.0, 30_000)
    assert np.isnan(again.ns_per_update)


def test_the_brake_ends_jobs_of_this_process() -> None:
    """A listener that gives up need not wait for blocks that would take hours."""
    settings = SweepSettings(seeds=64, tolerance=0.0, epochs=10**9)
    table = SweepStore.in_memory(settings, TABLE)
    began = time.monotonic()

    class Impatient:
        """Runs one block on a thread and is interrupted at once."""

        workers = 1

        def map(self, job: Any, items: Any, *, shared: Any = None, on_done: Any = None) -> Any:
            from concurrent.futures import ThreadPoolExecutor

            with ThreadPoolExecutor(1) as pool:
                future = pool.submit(job, shared, next(iter(items)))
                time.sleep(0.2)
                shared.brake.pull()
                yield future.result()

    result = sweep(TABLE, settings, executor=Impatient(), store=table)
    assert (result.finished, result.members, result.best) == (False, 0, None)
    assert time.monotonic() - began < 30


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"etas": ()}, "a sweep needs at least one eta"),
        ({"etas": (0.1, 0.1)}, "eta 0.1 stands twice"),
        ({"etas": (0.1, -1.0)}, "eta must be a number above 0, got -1.0"),
        ({"momenta": (0.0, 1.0)}, "momentum must be from 0 to below 1, got 1.0"),
        ({"seeds": 0}, "seeds must be from 1 to 10^9, got 0"),
        ({"seeds": 10**9, "momenta": (0.0, 0.5)}, "2,000,000,000 members; at most 10^9"),
        ({"etas": tuple(np.arange(1, 102) / 100), "momenta": tuple(np.arange(100) / 100)},
         "101 etas with 100 momenta are 10,100 settings; at most 10,000"),
        ({"first_seed": 2**63 - 999}, "seeds must lie from 0 to 2^63 - 1"),
        ({"first_seed": -1}, "seeds must lie from 0 to 2^63 - 1"),
        ({"rule": "delta"}, "unknown rule 'delta'"),
        ({"topology": (2,)}, "at least inputs and outputs"),
        ({"activations": ("sigmoid",)}, "needs 2 activations"),
        ({"tolerance": -1.0}, "tolerance must be 0 or above"),
    ],
)  # fmt: skip
def test_settings_that_cannot_be(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(SettingError) as caught:
        SweepSettings(**changes)
    assert words in str(caught.value)


def test_patterns_must_fit() -> None:
    with pytest.raises(ShapeError, match="a 3-2 network has 3 inputs"):
        sweep(TABLE, SweepSettings(topology=(3, 2)))


@pytest.mark.long
def test_a_million_members_take_little_memory(tmp_path: Path) -> None:
    import subprocess
    import sys

    code = (
        "import resource, sys; from pathlib import Path; from rovernav.learn import *\n"
        "s = SweepSettings(etas=tuple(k / 100 for k in range(1, 11)), seeds=100_000, epochs=20)\n"
        "t, out = shipped_patterns('bassil-v1'), Path(sys.argv[1])\n"
        "with SweepStore.open(out / 'm', s, t) as store:\n"
        "    r = sweep(t, s, store=store)\n"
        "    write_members_csv(store, s, 4, out / 'sweep.csv')\n"
        "print(r.members, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)\n"
    )
    done = subprocess.run([sys.executable, "-c", code, str(tmp_path)], capture_output=True,
                          text=True, check=True)  # fmt: skip
    members, peak = map(int, done.stdout.split())
    assert members == 1_000_000
    assert peak < 500_000 * (1024 if sys.platform == "darwin" else 1)
    with (tmp_path / "sweep.csv").open() as file:
        assert sum(1 for _ in file) == 1_000_001
