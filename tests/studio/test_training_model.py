"""The Train tab's model, without a page."""

from __future__ import annotations

import io
import shlex
import threading
import time
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rovernav.core import FileError, InputError, PatternError, SettingError
from rovernav.learn import (
    Patterns,
    StopReason,
    Training,
    paper_network,
    paper_training,
    shipped_patterns,
    shipped_tables,
    trace_csv,
    train,
    worked_example,
)
from rovernav.nets import weights_sha256
from rovernav.studio import Library, TrainModel
from rovernav.studio._kept import read_curve
from rovernav.studio._kept_files import (
    archive,
    archive_name,
    initial_and_table,
    settings_of,
    training_png,
    training_trace,
)
from tests.bits import assert_same_bits
from tests.cli.runner import tell

PATIENCE = 60.0


@pytest.fixture
def library(tmp_path: Path) -> Library:
    return Library(tmp_path / "runs.sqlite3")


@pytest.fixture
def model(library: Library) -> Iterator[TrainModel]:
    model = TrainModel(keep=library.add)
    model.choose_speed("full")
    yield model
    model.close()


def wait(until: Callable[[], object]) -> None:
    end = time.monotonic() + PATIENCE
    while not until():
        assert time.monotonic() < end, "nothing happened"
        time.sleep(0.005)


def run(model: TrainModel) -> None:
    """Train to the end, and until the run is kept, or could not be."""
    model.start()
    wait(lambda: model.state().kept or model.state().said.startswith("Not kept"))


def test_a_training_gives_the_library_s_bits_and_is_kept(
    model: TrainModel, library: Library
) -> None:
    run(model)
    right = train(*paper_training())
    state = model.state()
    assert_same_bits(state.training.network.parameters, right.network.parameters)
    assert (state.training.epoch, state.training.stop) == (215, StopReason.TOLERANCE)
    (kept,) = library.list()
    assert state.kept == kept.id
    assert kept.summary["weights_sha256"] == weights_sha256(right.network)
    assert (kept.summary["epochs"], kept.summary["stop"]) == (215, "tolerance")
    curve = read_curve(library.file(kept.id, "curve.csv"))
    assert curve[0].epoch == 0
    assert curve[-1].epoch == 215
    assert curve[-1].worst < 0.01 <= curve[-2].worst
    assert model.driver().card.training is not None
    assert model.driver().card.codec is not None


def test_pauses_and_steps_leave_the_bits_alone(model: TrainModel, library: Library) -> None:
    model.change(order="shuffled", seed=3, weights="seeded")
    model.step_pattern()
    assert model.state().training.pattern == 1
    model.step_epoch()
    assert (model.state().training.epoch, model.state().training.pattern) == (1, 0)
    model.choose_speed("slow")
    model.start()
    wait(lambda: model.state().training.epoch > 1)
    model.pause()
    model.step_pattern()
    model.choose_speed("full")
    run(model)
    again = train(model.setup.initial(), model.setup.table, model.setup.settings)
    assert_same_bits(model.network.parameters, again.network.parameters)
    assert len(library.list()) == 1


def test_stepping_shows_the_worked_example(model: TrainModel) -> None:
    model.preset({"table": "bassil-v1", "weights": "paper", "momentum": 0.0, "rule": "textbook"})
    model.step_pattern()
    assert_same_bits(model.network.matrices[1], worked_example("textbook").w2)
    model.reset()
    assert_same_bits(model.network.parameters, paper_network().parameters)


def test_other_rates_go_on_from_the_present_weights_as_a_run_of_its_own(
    model: TrainModel, library: Library
) -> None:
    for _ in range(5):
        model.step_epoch()
    here = model.network.parameters
    model.change(eta=0.125, rule="textbook")
    state = model.state()
    assert_same_bits(model.network.parameters, here)
    assert (state.training.epoch, state.training.updates) == (0, 0)
    assert not state.training.deltas.any()
    assert len(state.before) == 6
    run(model)
    (kept,) = library.list()
    initial, _ = initial_and_table(library, kept)
    assert_same_bits(initial.parameters, here)
    assert "--init initial.safetensors" in kept.command
    model.reset()
    assert_same_bits(model.network.parameters, paper_network().parameters)


def test_changes_reach_a_running_training(model: TrainModel) -> None:
    model.change(tolerance=0, epochs=10**9)
    model.start()
    wait(lambda: model.state().training.epoch > 1000)
    model.change(eta=0.2)
    assert model.running
    wait(lambda: model.state().training.epoch > 100)
    assert model.setup.settings.eta == 0.2
    model.change(tolerance=0.01)
    wait(lambda: not model.running)
    assert model.state().training.stop is StopReason.TOLERANCE
    model.change(hidden=(4,))
    assert not model.running
    assert model.network.topology == (2, 4, 2)
    assert model.state().training.updates == 0


def test_the_table_says_how_many_inputs_and_outputs_there_are(model: TrainModel) -> None:
    table = Patterns(
        x=np.array([[0.0, 1.0, 2.0]]), y=np.array([[1.0]]), inputs=("a", "b", "c"), outputs=("y",)
    )
    model.change(table=table)
    assert model.setup.topology == (3, 3, 1)
    assert model.setup.weights == "seeded"
    model.change(hidden=())
    assert (model.setup.topology, model.setup.activations) == ((3, 1), ("linear",))
    model.change(hidden=(2, 5))
    assert model.setup.activations == ("sigmoid", "sigmoid", "linear")
    with pytest.raises(SettingError, match="the paper's weights are for a 2-3-2 network"):
        model.change(weights="paper")


BAD: list[tuple[dict[str, Any], str]] = [
    ({"eta": "NaN"}, "eta must be a number, got NaN"),
    ({"eta": "abc"}, "eta must be a number, got abc"),
    ({"eta": ""}, "eta must be a number, got nothing"),
    ({"eta": None}, "eta must be a number, got nothing"),
    ({"eta": "-1"}, "eta must be a number above 0"),
    ({"eta": "inf"}, "eta must be a number, got inf"),
    ({"eta": "1_0"}, "eta must be a number, got 1_0"),
    ({"eta": {"x": 1}}, "eta must be a number"),
    ({"eta": True}, "eta must be a number"),
    ({"momentum": "1"}, "momentum must be from 0 to below 1"),
    ({"tolerance": "-0.1"}, "tolerance must be 0 or above"),
    ({"epochs": "1.5"}, "epochs must be a whole number"),
    ({"epochs": "1e15"}, "epochs must be from 0 to 10"),
    ({"seed": "-1"}, "seed must be from 0"),
    ({"rule": "papr"}, "unknown rule 'papr'; did you mean 'paper'"),
    ({"order": ["cyclic"]}, "unknown order"),
    ({"activations": ("sigmoid", "lineal")}, "unknown activation 'lineal'"),
    ({"activations": ("sigmoid",)}, "needs 2 activations"),
    ({"hidden": (100_001,)}, "each layer needs 1 to"),
    ({"hidden": (200, 200)}, "the page trains networks of 20,000 weights at most"),
    ({"weights": "mine"}, "unknown weights"),
    ({"etta": 1}, "there is no setting 'etta'; did you mean 'eta'"),
]


@pytest.mark.parametrize(("changes", "said"), BAD)
def test_what_is_not_allowed_changes_nothing(
    model: TrainModel, changes: dict[str, Any], said: str
) -> None:
    model.step_epoch()
    before, weights = model.setup, model.network.parameters
    with pytest.raises(InputError) as error:
        model.change(**changes)
    assert said in str(error.value)
    assert model.setup is before
    assert_same_bits(model.network.parameters, weights)
    with pytest.raises(InputError):
        model.preset({"table": "bassil-replay-v1", **changes})
    assert model.setup is before


def test_a_preset_with_an_unknown_speed_or_table_changes_nothing(model: TrainModel) -> None:
    before = model.setup
    with pytest.raises(SettingError, match="unknown speed 'ful'; did you mean 'full'"):
        model.preset({"eta": 0.1, "speed": "ful"})
    with pytest.raises(PatternError, match="there is no pattern table 'xor'"):
        model.preset({"eta": 0.1, "table": "xor"})
    with pytest.raises(SettingError, match="hidden layers are written like 3 or 8-4"):
        model.preset({"eta": 0.1, "hidden": "3-x"})
    assert model.setup is before


def test_too_large_a_table_is_for_the_command_line(model: TrainModel) -> None:
    big = Patterns(x=np.zeros((5001, 2)), y=np.zeros((5001, 2)), inputs=("a", "b"),
                   outputs=("c", "d"))  # fmt: skip
    with pytest.raises(PatternError, match="5,000 patterns and 64 columns at most"):
        model.change(table=big)
    wide = Patterns(x=np.zeros((5000, 2)), y=np.zeros((5000, 2)), inputs=("a", "b"),
                    outputs=("c", "d"))  # fmt: skip
    with pytest.raises(SettingError, match="too many for the page"):
        model.change(table=wide, hidden=(2000,))


def test_a_weight_must_be_finite(model: TrainModel) -> None:
    for number in (np.nan, np.inf):
        with pytest.raises(SettingError, match="every weight must be a finite number"):
            model.set_weights(np.full(17, number))
    with pytest.raises(InputError, match="17 parameters"):
        model.set_weights(np.zeros(16))
    model.set_weights(np.arange(17.0))
    assert model.setup.weights == "given"
    assert_same_bits(model.network.parameters, np.arange(17.0))


@pytest.mark.parametrize("stepped", [False, True])
def test_divergence_keeps_the_last_good_network(
    model: TrainModel, library: Library, stepped: bool
) -> None:
    model.change(eta=40.0)
    if stepped:
        while model.state().training.stop is None:
            model.step_pattern()
    else:
        run(model)
    state = model.state()
    assert state.training.stop is StopReason.DIVERGED
    assert state.training.pattern == 0
    assert np.isfinite(model.network.parameters).all()
    assert "diverged" in state.said.lower()
    whole = train(paper_network(), model.setup.table, model.setup.settings)
    assert_same_bits(model.network.parameters, whole.network.parameters)
    model.start()
    assert not model.running
    assert "reset" in model.state().said
    model.step_epoch()
    assert model.state().training.stop is StopReason.DIVERGED


def test_a_finished_training_is_not_kept_twice(model: TrainModel, library: Library) -> None:
    run(model)
    model.start()
    wait(lambda: not model.running)
    assert len(library.list()) == 1
    model.change(tolerance=0.001)
    run(model)
    wait(lambda: len(library.list()) == 2)
    assert [run.summary["epochs"] for run in library.list()] == [319, 215]


def test_a_full_disk_loses_the_record_and_not_the_training() -> None:
    def keep(**run: Any) -> str:
        raise FileError("the disk is full")

    model = TrainModel(keep=keep)
    model.choose_speed("full")
    run(model)
    assert model.state().said == "Not kept: the disk is full"
    assert model.state().training.epoch == 215


def test_keeping_by_hand(model: TrainModel, library: Library) -> None:
    with pytest.raises(SettingError, match="nothing to keep before the first epoch"):
        model.keep_now()
    model.step_pattern()
    with pytest.raises(SettingError, match="finish the epoch first"):
        model.keep_now()
    model.step_epoch()
    model.step_epoch()
    kept = library.get(model.keep_now())
    assert (kept.summary["epochs"], kept.summary["stop"]) == (2, None)


def test_the_trace_is_the_library_s(model: TrainModel, library: Library) -> None:
    model.change(order="shuffled", seed=2, epochs=30, tolerance=0)
    model.trace(True)
    model.step_pattern()
    run(model)
    lines = model.state().trace
    (kept,) = library.list()
    rows = training_trace(library, kept).decode().splitlines()[1:]
    assert len(rows) == len(lines) == 120
    for line, row in zip(lines, rows, strict=True):
        epoch, pattern, *weights = row.split(",")
        assert (line.epoch, line.pattern) == (int(epoch), int(pattern) + 1)
        assert_same_bits(line.weights, np.array(list(map(float, weights))))
    out = io.StringIO()
    train(paper_network(), model.setup.table, model.setup.settings,
          recorder=trace_csv(out, paper_network()))  # fmt: skip
    assert out.getvalue().splitlines()[1:] == rows
    model.trace(False)
    assert model.state().trace == ()


def test_the_trace_can_be_switched_while_it_runs(model: TrainModel) -> None:
    model.change(tolerance=0, epochs=10**9)
    model.start()
    wait(lambda: model.state().training.epoch > 10)
    model.trace(True)
    wait(lambda: len(model.state().trace) == 2000)
    model.pause()
    last = model.state().trace[-1]
    assert_same_bits(last.weights, model.network.parameters)
    assert last.epoch == model.state().training.epoch


def test_a_long_curve_stays_short(model: TrainModel) -> None:
    model.change(tolerance=0, epochs=4000)
    for _ in range(3300):
        model.step_epoch()
    points = model.state().curve
    assert len(points) <= 3000
    assert (points[0].epoch, points[-1].epoch) == (0, 3300)


def branched(model: TrainModel) -> None:
    for _ in range(3):
        model.step_epoch()
    model.change(eta=0.125, momentum=0.75)
    run(model)


def softened(model: TrainModel) -> None:
    model.change(tolerance=0.001)
    for _ in range(250):
        model.step_epoch()
    model.change(tolerance=0.01)  # from the beginning, this would have ended at 215
    run(model)


def own_table(model: TrainModel) -> None:
    table = Patterns(
        x=np.array([[0.1, 1 / 3], [1.0, -2.5], [0.25, 4.0]]), y=np.array([[0.5], [0.0], [1e-3]]),
        inputs=("a", "b, c"), outputs=('"q"',), source="<b>mine</b>.csv",
    )  # fmt: skip
    model.change(table=table, hidden=(4, 3), order="shuffled", seed=9, epochs=150, tolerance=0)
    run(model)


def by_hand(model: TrainModel) -> None:
    model.set_weights(np.linspace(-1, 1, 17))
    model.change(epochs=40)
    run(model)


def other_activation(model: TrainModel) -> None:
    model.change(activations=("tanh", "linear"), epochs=60)
    run(model)


def diverged(model: TrainModel) -> None:
    model.change(eta=40.0)
    run(model)


def stopped(model: TrainModel) -> None:
    for _ in range(7):
        model.step_epoch()
    model.keep_now()


STORIES = [run, branched, softened, own_table, by_hand, other_activation, diverged, stopped]


@pytest.mark.parametrize("story", STORIES, ids=lambda story: story.__name__)
def test_the_command_of_a_run_does_it_again(
    story: Callable[[TrainModel], None], model: TrainModel, library: Library, tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    story(model)
    kept = library.list()[0]
    folder = tmp_path / "files"
    zipfile.ZipFile(io.BytesIO(archive(library, kept))).extractall(folder)
    assert kept.command in (folder / "README.txt").read_text(encoding="utf-8")
    monkeypatch.chdir(folder)
    program, *words = shlex.split(kept.command)
    assert program == "rovernav"
    said = tell(*words, code=1 if kept.summary["stop"] == "diverged" else 0)
    for key in ("weights_sha256", "epochs", "updates", "topology", "patterns"):
        assert said[key] == kept.summary[key], key
    assert said["max_error"] == pytest.approx(kept.summary["max_error"], abs=0, rel=0)


moves = st.lists(
    st.sampled_from(
        ["pattern", "epoch", "epoch", "start", "pause", "eta", "tolerance", "order", "trace"]
    ),
    max_size=25,
)


@settings(max_examples=15)
@given(moves=moves)
def test_whatever_a_person_does_the_run_can_be_done_again(
    moves: list[str], tmp_path_factory: pytest.TempPathFactory
) -> None:
    library = Library(tmp_path_factory.mktemp("l") / "runs.sqlite3")
    model = TrainModel(keep=library.add)
    model.choose_speed("full")
    actions: dict[str, Callable[[], object]] = {
        "pattern": model.step_pattern,
        "epoch": model.step_epoch,
        "start": model.start,
        "pause": model.pause,
        "eta": lambda: model.change(eta=model.setup.settings.eta * 0.75),
        "tolerance": lambda: model.change(tolerance=model.setup.settings.tolerance * 0.5),
        "order": lambda: model.change(order="shuffled", seed=len(moves)),
        "trace": lambda: model.trace(not model.tracing),
    }
    for move in moves:
        actions[move]()
    model.pause()
    model.step_epoch()
    if model.state().training.updates:
        kept = library.get(model.keep_now())
        initial, table = initial_and_table(library, kept)
        epochs = kept.summary["epochs"]
        plain = settings_of(kept)
        again = train(initial, table, type(plain)(
            eta=plain.eta, momentum=plain.momentum, rule=plain.rule, order=plain.order,
            seed=plain.seed, tolerance=0.0, epochs=epochs))  # fmt: skip
        assert weights_sha256(again.network) == kept.summary["weights_sha256"]


def test_many_hands_at_once_do_no_harm(model: TrainModel) -> None:
    model.change(tolerance=0, epochs=10**9)
    failed: list[BaseException] = []

    def look() -> None:
        state = model.state()
        done = state.training.epoch * len(state.setup.table.x) + state.training.pattern
        assert state.training.updates == done

    def press(seed: int) -> None:
        rng = np.random.default_rng(seed)
        actions: list[Callable[[], object]] = [
            look, look, model.start, model.pause, model.step_pattern, model.reset,
            lambda: model.change(eta=float(rng.uniform(0.01, 0.3))),
        ]  # fmt: skip
        try:
            for _ in range(60):
                actions[rng.integers(len(actions))]()
        except BaseException as error:
            failed.append(error)

    threads = [threading.Thread(target=press, args=(seed,)) for seed in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(PATIENCE)
    model.pause()
    assert failed == []
    still = model.state().version
    time.sleep(0.2)
    assert model.state().version == still


def test_the_picture_of_a_run(model: TrainModel, library: Library) -> None:
    run(model)
    (kept,) = library.list()
    assert training_png(library, kept).startswith(b"\x89PNG")


def test_too_long_a_trace_is_for_the_command_line(model: TrainModel, library: Library) -> None:
    model.change(tolerance=0, epochs=50_000)
    run(model)
    (kept,) = library.list()
    with pytest.raises(SettingError, match=r"write it with: rovernav train .* --trace trace.csv"):
        training_trace(library, kept)


def test_archives_have_plain_names(model: TrainModel, library: Library) -> None:
    own_table(model)
    (kept,) = library.list()
    name = archive_name(kept)
    assert name.isascii()
    assert name.replace("-", "").isalnum()


def test_every_shipped_table_can_be_trained(model: TrainModel) -> None:
    for name in shipped_tables():
        model.preset({"table": name, "weights": "seeded", "epochs": 3, "tolerance": 0})
        model.step_epoch()
        assert model.setup.table.sha256 == shipped_patterns(name).sha256
        assert model.setup.shipped == name
        assert isinstance(model.state().training, Training)
