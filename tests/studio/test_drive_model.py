"""The Drive tab's model, without a page."""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from numpy.testing import assert_allclose

from rovernav.core import FileError, Outcome, RovernavError, SettingError
from rovernav.learn import trained_paper_network
from rovernav.nets import network_bytes
from rovernav.scenes import bassil_scene
from rovernav.sim import load_trace, simulate
from rovernav.studio._drive import DriveModel
from rovernav.studio._drive_run import Pick
from rovernav.studio._drive_world import Obstacle, World
from tests.cli.runner import run as run_cli
from tests.cli.runner import write_ground

SMALL: dict[str, Any] = {
    "ground": "hills",
    "made": (("side_m", 20.0), ("relief_m", 1.0), ("craters", 0)),
}
ACROSS: dict[str, Any] = {"start": (4.0, 10.0), "goal": (16.0, 10.0)}


class Kept:
    """What a library would get."""

    def __init__(self) -> None:
        self.runs: list[dict[str, Any]] = []

    def __call__(self, **run: Any) -> str:
        self.runs.append(run)
        return str(len(self.runs))


@pytest.fixture
def kept() -> Kept:
    return Kept()


@pytest.fixture
def model(kept: Kept) -> Iterator[DriveModel]:
    made = DriveModel(current_network=trained_paper_network, keep=kept)
    yield made
    made.close()


def driven(model: DriveModel) -> None:
    """Drive to the end."""
    model.drive()
    until = time.monotonic() + 60
    while model.running and time.monotonic() < until:
        time.sleep(0.005)
    assert not model.running


def test_it_begins_with_the_papers_scene_and_the_network_of_the_train_tab(
    model: DriveModel,
) -> None:
    driven(model)
    (run,) = model.runs
    there = simulate(bassil_scene().drive(run.controller))
    assert run.outcome is Outcome.REACHED
    assert run.trace is not None
    assert np.array_equal(run.trace.pose, there.pose)
    assert run.clearance == pytest.approx(0.343, abs=1e-3)


def test_the_mirrored_obstacle_is_run_into(model: DriveModel) -> None:
    model.set_world(model.flat["bassil-mirrored-v1"])
    driven(model)
    assert model.runs[0].outcome is Outcome.COLLIDED


def test_an_obstacle_drawn_across_the_way_is_met_and_undone(model: DriveModel) -> None:
    model.set_world(model.flat["bassil-free-v1"])
    driven(model)
    assert model.runs[0].outcome is Outcome.REACHED
    model.draw("circle", (6.0, -1.0, 1.5))
    driven(model)
    assert model.runs[0].outcome is not Outcome.REACHED
    assert model.obstacle_at(6.2, -0.5) == 0
    assert model.obstacle_at(6.2, 2.5) is None
    model.undo()
    assert model.world.obstacles == ()
    model.redo()
    assert len(model.world.obstacles) == 1
    model.delete(0)
    driven(model)
    assert model.runs[0].outcome is Outcome.REACHED


@pytest.mark.parametrize("kind", ["box", "polygon"])
def test_a_driver_with_beams_goes_round_what_is_drawn(model: DriveModel, kind: str) -> None:
    model.set_world(World(**SMALL, **ACROSS))
    model.choose(["neural"])
    numbers = (9.0, 9.0, 11.0, 12.0) if kind == "box" else (9, 9, 11, 9, 11, 12, 9, 12)
    model.draw(kind, numbers)
    driven(model)
    (run,) = model.runs
    assert run.rover.name == "research"
    assert run.outcome is Outcome.REACHED
    assert 0.0 < run.clearance < 3.0
    assert run.driven[-1] > 12.05
    assert len(run.sensed(run.steps)) > 10
    assert len(run.beams(0)) == 49
    assert any(met for _, _, met in run.beams(10))


def test_several_controllers_drive_the_same_world(model: DriveModel, kept: Kept) -> None:
    model.choose(["train", "neural", "goal-seeker", "planner"])
    driven(model)
    outcomes = {run.pick.key: run.outcome for run in model.runs}
    assert outcomes["train"] is Outcome.REACHED
    assert outcomes["planner"] is Outcome.REACHED
    assert outcomes["goal-seeker"] is not Outcome.REACHED
    assert [run.rover.name for run in model.runs] == ["paper-point"] + ["research"] * 3
    assert len(kept.runs) == 4
    assert len({run["settings"]["group"] for run in kept.runs}) == 1
    for run in model.runs:
        told = run.summary()
        assert told["length_m"] == pytest.approx(run.driven[-1])
        assert told["detour"] == pytest.approx(run.driven[-1] / 11.73)


def test_a_rover_that_does_not_fit_is_exchanged_with_a_word(model: DriveModel) -> None:
    model.change(rover="jackal")
    model.choose(["train", "planner"])
    driven(model)
    assert [run.rover.name for run in model.runs] == ["paper-point", "jackal"]
    assert "jackal has another drive" in model.runs[0].note


def test_pausing_holds_the_drive_and_going_on_ends_it_the_same(model: DriveModel) -> None:
    model.set_world(World(**SMALL, **ACROSS))
    model.choose(["neural"])
    driven(model)
    whole = model.runs[0].trace
    model._go_on.clear()
    start = model.drive

    def paused_start() -> None:
        start()
        model.pause()

    paused_start()
    time.sleep(0.1)
    first = model.runs[0].steps if model.runs else 0
    time.sleep(0.2)
    assert (model.runs[0].steps if model.runs else 0) - first <= 100  # one slice may be under way
    assert model.paused
    model.resume()
    until = time.monotonic() + 60
    while model.running and time.monotonic() < until:
        time.sleep(0.01)
    assert whole is not None
    assert model.runs[0].trace is not None
    assert np.array_equal(model.runs[0].trace.pose, whole.pose)


def test_a_drive_that_is_started_anew_gives_up_the_old_one(model: DriveModel, kept: Kept) -> None:
    model.set_world(World(**SMALL, **ACROSS))
    model.choose(["planner"])
    for _ in range(3):
        model.drive()
    driven(model)
    assert len(model.runs) == 1
    assert kept.runs[-1]["summary"]["outcome"] == "reached"


def test_any_moment_can_be_looked_at(model: DriveModel) -> None:
    rough = (("side_m", 20.0), ("relief_m", 1.5))
    model.set_world(World(ground="hills", made=rough, **ACROSS), settle=True)
    model.choose(["neural"])
    driven(model)
    (run,) = model.runs
    assert run.step_at(0.0) == 0
    assert run.step_at(5.5) == 5
    assert run.step_at(1e9) == run.steps
    last, first = run.moment(10**9), run.moment(-5)
    assert last.command is None
    assert last.to_goal <= 0.5
    assert last.driven == run.driven[-1]
    assert first.pose[:2] == run.poses[0][:2]
    assert first.command == run.commands[0]
    assert run.ground is not None
    for step in range(0, run.steps, 7):
        x, y = run.poses[step][:2]
        cell = run.ground.terrain.frame.cell_of(x, y)
        assert run.moment(step).tilt == pytest.approx(float(run.ground.standing.slope[cell]))


@pytest.mark.parametrize("key", ["train", "neural", "planner", "goal-seeker"])
def test_why_is_told_with_the_numbers_of_the_drive(model: DriveModel, key: str) -> None:
    model.choose([key])
    driven(model)
    (run,) = model.runs
    for step in {0, 3, run.steps // 2, run.steps - 1}:
        why, after = run.why(step)
        assert tuple(why.command) == run.commands[step]
        assert tuple(after.rovers.pose[0]) == run.poses[step + 1]
        if why.network is not None:
            sums = why.network.contributions.sum(axis=1)
            assert_allclose(sums, why.network.sums, rtol=0, atol=1e-9)


def test_why_goes_back_from_the_nearest_kept_state(model: DriveModel) -> None:
    model.set_world(
        World(ground="hills", made=(("relief_m", 0.0), ("craters", 0)), start=(5, 5), goal=(45, 40))
    )
    model.choose(["planner"])
    driven(model)
    (run,) = model.runs
    assert run.steps > 140
    for step in (63, 64, 65, 130):
        why, after = run.why(step)
        assert tuple(why.command) == run.commands[step]
        assert tuple(after.rovers.pose[0]) == run.poses[step + 1]


def files_of(run: dict[str, Any], folder: Path) -> list[str]:
    for name, content in run["files"].items():
        (folder / name).write_bytes(content)
    return run["command"].split()[1:]


@pytest.mark.parametrize("ground", ["flat", "hills", "upload"])
def test_the_command_line_gives_the_same_trace(
    model: DriveModel, kept: Kept, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ground: str
) -> None:
    if ground == "hills":
        world = World(**SMALL, **ACROSS, rocks=0.02, seed=5)
        model.set_world(world, settle=True)
    elif ground == "upload":
        data = write_ground(tmp_path / "g.tif").read_bytes()
        world = model.file_world(model.upload_terrain("g.tif", data))
        model.set_world(dataclasses.replace(world, seed=3), settle=True)
    model.draw("circle", (*np.mean([model.world.start, model.world.goal], axis=0), 0.7))
    model.draw("polygon", (7.0, 2.0, 8.0, 2.0, 7.5, 3.5))
    model.choose(["train", "neural"])
    driven(model)
    assert len(kept.runs) == 2
    for number, (run, there) in enumerate(zip(kept.runs, model.runs, strict=True)):
        folder = tmp_path / str(number)
        folder.mkdir()
        words = files_of(run, folder)
        monkeypatch.chdir(folder)
        assert run_cli(*words, "--out", "out").code == 0
        again, stored = load_trace(folder / "out" / "trace.npz"), load_trace(folder / "trace.npz")
        for trace in (again, stored):
            assert there.trace is not None
            for field in ("pose", "time", "commands", "outcome", "steps", "length"):
                assert np.array_equal(getattr(trace, field), getattr(there.trace, field)), field
        assert (folder / "out" / "path.csv").read_bytes() == (folder / "path.csv").read_bytes()


def test_a_kept_drive_can_be_set_up_again(model: DriveModel, kept: Kept, tmp_path: Path) -> None:
    data = write_ground(tmp_path / "g.tif").read_bytes()
    shown = model.upload_terrain("../<b>g.tif", data)
    model.set_world(model.file_world(shown), settle=True)
    model.choose([model.upload_network("mine.safetensors", network_bytes(trained_paper_network()))])
    model.draw("box", (1.0, 1.0, 2.0, 2.0))
    driven(model)
    (run,) = kept.runs
    other = DriveModel(current_network=trained_paper_network, keep=kept)
    other.restore(run["settings"], run["files"])
    driven(other)
    assert other.runs[0].poses == model.runs[0].poses
    assert other.runs[0].pick.label == "mine.safetensors"
    other.close()


@pytest.mark.parametrize(
    "settings",
    [
        {},
        {"world": 3, "key": "bassil"},
        {"world": {"file": "/etc/passwd", "made": {}}, "key": "bassil"},
        {"world": {"file": None, "made": {}, "start": [0, "x"], "goal": [1, 1], "obstacles": []},
         "key": "bassil"},
        {"world": {"file": None, "made": {}, "start": [0, 0], "goal": [1, 1], "obstacles": [3]},
         "key": "bassil"},
    ],
)  # fmt: skip
def test_settings_that_make_no_drive_are_refused(
    model: DriveModel, settings: dict[str, Any]
) -> None:
    before = model.world
    with pytest.raises(RovernavError):
        model.restore(settings, {})
    assert model.world == before


def test_a_terrain_that_is_not_offered_is_not_opened(model: DriveModel) -> None:
    world = {
        "ground": "file", "file": "offered", "title": "/etc/passwd", "made": {}, "start": [0, 0],
        "goal": [1, 1], "obstacles": [],
    }  # fmt: skip
    with pytest.raises(SettingError, match="not offered by this studio"):
        model.restore({"world": world, "key": "bassil"}, {})


@pytest.mark.parametrize(
    ("kind", "numbers", "message"),
    [
        ("box", (2, 0, 1, 1), "a box needs x0 <= x1"),
        ("box", (0, 0, 1), "give four numbers"),
        ("circle", (0, 0, -1), "a circle needs a radius above 0"),
        ("circle", (0, 0, math.nan), "coordinates must be finite"),
        ("circle", (0, 0, 1e9), "a circle needs a radius"),
        ("polygon", (0, 0, 1, 1), "3 to 500 corners"),
        ("polygon", tuple(range(2000)), "3 to 500 corners"),
        ("box", (1e7, 0, 1e8, 1), "within 100 km"),
        ("polygon", (0, 0, 1, 1, 2), "two numbers each"),
        ("blob", (0, 0, 1), "no obstacle 'blob'"),
    ],
)
def test_what_is_no_obstacle_is_refused(
    model: DriveModel, kind: str, numbers: tuple[float, ...], message: str
) -> None:
    before = model.world
    with pytest.raises(SettingError, match=message):
        model.draw(kind, numbers)
    assert model.world == before


def test_obstacles_are_bounded_in_number(model: DriveModel) -> None:
    many = tuple(Obstacle("circle", (float(i), 50.0, 0.1)) for i in range(201))
    with pytest.raises(SettingError, match="at most 200 obstacles"):
        model.change(obstacles=many)


@pytest.mark.parametrize(
    "fields",
    [{"seed": -1}, {"rocks": 0.9}, {"made": (("side_m", 1e9),)}, {"made": (("x", 1),)},
     {"time_limit": 0.0}, {"start": (math.inf, 0.0)}, {"rover": "/etc/rover.yaml"},
     {"rover": "my.yaml"}, {"ground": "sea"}],
)  # fmt: skip
def test_absurd_numbers_are_refused_with_a_sentence(
    model: DriveModel, fields: dict[str, Any]
) -> None:
    model.set_world(World(**SMALL, **ACROSS))
    before = model.world
    with pytest.raises(RovernavError) as caught:
        model.change(settle=True, **fields)
    assert "\n" not in str(caught.value)
    assert model.world == before


def test_ends_where_the_rover_cannot_stand_are_refused_with_the_reason(model: DriveModel) -> None:
    with pytest.raises(SettingError, match="the goal lies in a rectangle"):
        model.place("goal", 5.0, 0.0)
    model.place("goal", 10.0, 1.0)
    assert model.world.goal == (10.0, 1.0)
    model.set_world(World(**SMALL, **ACROSS))
    model.draw("circle", (10.0, 10.0, 1.0))
    with pytest.raises(SettingError, match="an obstacle is there"):
        model.place("start", 10.2, 10.0)
    with pytest.raises(SettingError, match="lies off the map"):
        model.place("start", -1.0, 10.0)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "that is no GeoTIFF"),
        (b"\x89PNG\r\n", "that is no GeoTIFF"),
        (b"<svg onload=alert(1)>", "that is no GeoTIFF"),
        (b"II*\0" + b"\xff" * 100, "x.tif is a damaged or cut-off GeoTIFF"),
    ],
)
def test_uploads_that_are_no_terrain_are_refused(
    model: DriveModel, data: bytes, message: str
) -> None:
    with pytest.raises(FileError, match=message) as caught:
        model.upload_terrain("x.tif", data)
    assert "rovernav-studio" not in str(caught.value)
    assert model.files == {}


def test_uploads_are_bounded(
    model: DriveModel, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    data = write_ground(tmp_path / "g.tif").read_bytes()
    monkeypatch.setattr("rovernav.studio._drive.MOST_CELLS", 100)
    with pytest.raises(FileError, match="more than 100; crop it first"):
        model.upload_terrain("g.tif", data)
    monkeypatch.setattr("rovernav.studio._drive.MAX_TERRAIN", 10)
    with pytest.raises(FileError, match="may have 10 bytes"):
        model.upload_terrain("g.tif", data)
    with pytest.raises(FileError, match="may have"):
        model.upload_network("n", bytes(9_000_000))
    with pytest.raises(FileError, match="net is not a network file"):
        model.upload_network("net", b"junk")


def test_names_of_controllers_come_from_the_registry(model: DriveModel) -> None:
    assert set(model.controllers()) == {"train", "bassil", "goal-seeker", "neural", "planner"}
    with pytest.raises(SettingError, match="did you mean 'planner'"):
        model.choose(["planer"])
    model.choose(["planner", "planner"])
    assert model.picked == ["planner"]
    model.choose([])
    with pytest.raises(SettingError, match="nobody was chosen"):
        model.drive()


def test_a_controller_that_cannot_drive_is_told_beside_those_that_can(kept: Kept) -> None:
    def no_driver() -> Any:
        raise SettingError("this network drives nothing")

    model = DriveModel(current_network=no_driver, keep=kept)
    model.choose(["train", "bassil"])
    driven(model)
    assert [run.pick.key for run in model.runs] == ["bassil"]
    assert model.refused == [(Pick("train", "Train tab"), "this network drives nothing")]
    assert model.rovers(model.world) == ["paper-point"]
    model.close()


def test_two_models_do_not_disturb_each_other(kept: Kept) -> None:
    one, two = (DriveModel(current_network=trained_paper_network, keep=kept) for _ in range(2))
    two.set_world(two.flat["bassil-mirrored-v1"])
    one.drive()
    two.drive()
    until = time.monotonic() + 60
    while (one.running or two.running) and time.monotonic() < until:
        time.sleep(0.005)
    assert one.runs[0].outcome is Outcome.REACHED
    assert two.runs[0].outcome is Outcome.COLLIDED
    one.close()
    two.close()


def test_the_kept_scenario_is_a_file_that_people_can_read(model: DriveModel, kept: Kept) -> None:
    model.draw("circle", (9.0, 1.5, 0.5))
    driven(model)
    text = kept.runs[0]["files"]["scenario.yaml"].decode()
    data = yaml.safe_load(text)
    assert data["circles"] == [[9.0, 1.5, 0.5]]
    assert data["controller"] == "network.safetensors"
    assert kept.runs[0]["command"] == "rovernav drive scenario.yaml"
