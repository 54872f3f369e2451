"""Traces: saved without loss, and damaged or foreign files refused with a sentence."""

from __future__ import annotations

import io
import json
import os
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from rovernav import __version__
from rovernav.control import NeuralController
from rovernav.core import FileError, Mission, Outcome, SettingError
from rovernav.learn import trained_paper_network
from rovernav.scenes import random_rectangles
from rovernav.sim import Trace, load_trace, save_trace, simulate
from tests.bits import assert_same_bits

ARRAYS = ("time", "pose", "commands", "outcome", "steps", "length")


def assert_same(a: Trace, b: Trace) -> None:
    for name in ARRAYS:
        assert_same_bits(getattr(a, name), getattr(b, name))
    assert sorted(a.channels) == sorted(b.channels)
    for name, reading in a.channels.items():
        assert_same_bits(reading, b.channels[name])
    assert_same_bits(a.mission.start, b.mission.start)
    assert_same_bits(a.mission.goal, b.mission.goal)
    assert (a.mission.goal_radius, a.mission.time_limit) == (
        b.mission.goal_radius, b.mission.time_limit,
    )  # fmt: skip
    assert (a.seed, a.settings, a.version) == (b.seed, b.settings, b.version)


@pytest.fixture(scope="module")
def trace() -> Trace:
    scene = random_rectangles(3, np.random.default_rng(0))
    driver = NeuralController(trained_paper_network())
    return simulate(scene.drive(driver), seed=7, settings={"suite": "random-rectangles-v1"})


@pytest.fixture(scope="module")
def good(trace: Trace, tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("trace") / "new folder" / "good.npz"
    save_trace(trace, path)
    return path.read_bytes()


def load(data: bytes, folder: Path) -> Trace:
    path = folder / "trace.npz"
    path.write_bytes(data)
    return load_trace(path)


def refusal(data: bytes, folder: Path) -> str:
    with pytest.raises(FileError) as refused:
        load(data, folder)
    text = str(refused.value)
    assert "\n" not in text
    return text.replace(str(folder / "trace.npz"), "FILE")


@pytest.mark.parametrize("record", ["all", "path", "none"])
def test_a_saved_drive_is_the_same_drive(record: str, tmp_path: Path) -> None:
    scene = random_rectangles(5, np.random.default_rng(1))
    driver = NeuralController(trained_paper_network())
    before = simulate(scene.drive(driver), settings={"a": [1, None, "ü"]}, record=record)
    save_trace(before, tmp_path / "t.npz")
    after = load_trace(tmp_path / "t.npz")
    assert_same(after, before)
    assert after.version == __version__
    assert not after.pose.flags.writeable
    assert [after.ended(k) for k in range(5)] == [before.ended(k) for k in range(5)]


numbers = hnp.from_dtype(np.dtype(np.float64))
finite = st.floats(allow_nan=False, allow_infinity=False)

positive = st.floats(0.0, allow_infinity=False)


@st.composite
def traces(draw: st.DrawFn) -> Trace:
    t, n = draw(st.integers(0, 3)), draw(st.integers(0, 3))

    def array(*shape: int, of: Any = numbers) -> np.ndarray:
        return draw(hnp.arrays(np.float64, shape, elements=of))

    names = draw(st.lists(st.text("abc _/é", min_size=1), max_size=2, unique=True))
    outcome = draw(hnp.arrays(np.int8, n, elements=st.sampled_from([int(o) for o in Outcome])))
    return Trace(
        time=array(t + 1, n),
        pose=array(t + 1, n, 3),
        commands=array(t, n, 3),
        channels={name: array(t, n, draw(st.integers(0, 2))) for name in names},
        mission=Mission(
            start=array(n, 3, of=finite),
            goal=array(n, 2, of=finite),
            goal_radius=draw(positive),
            time_limit=draw(positive),
        ),
        outcome=outcome,
        steps=draw(hnp.arrays(np.int64, n, elements=st.integers(0, 2**62))),
        length=array(n),
        seed=draw(st.integers(0, 2**63)),
        settings=draw(st.dictionaries(st.text(), st.none() | st.text() | finite | st.booleans())),
        version=draw(st.text()),
    )


@settings(max_examples=40)
@given(before=traces())
def test_saving_and_loading_is_identity(
    before: Trace, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.getbasetemp() / "identity.npz"
    save_trace(before, path)
    assert_same(load_trace(path), before)


def test_the_same_trace_gives_the_same_file(trace: Trace, good: bytes, tmp_path: Path) -> None:
    save_trace(trace, tmp_path / "again.npz")
    assert (tmp_path / "again.npz").read_bytes() == good
    assert [path.name for path in tmp_path.iterdir()] == ["again.npz"]


def test_a_cut_file_is_refused(good: bytes, tmp_path: Path) -> None:
    for length in (*range(0, len(good), 97), len(good) - 1):
        assert refusal(good[:length], tmp_path) == "FILE is not a trace, or is damaged"


def survives(data: bytearray, trace: Trace, folder: Path) -> bool:
    """Whether the file still loads; if it does it must be the same trace."""
    try:
        after = load(bytes(data), folder)
    except FileError:
        return False
    assert_same(after, trace)
    return True


def test_a_changed_byte_is_refused_or_harmless(good: bytes, trace: Trace, tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    harmless = 0
    for at in rng.choice(len(good), 400, replace=False).tolist():
        data = bytearray(good)
        data[at] ^= int(rng.integers(1, 256))
        harmless += survives(data, trace, tmp_path)
    assert harmless < 110  # dates and rights, which zip keeps for each of its members


@pytest.mark.long
def test_any_changed_byte_is_refused_or_harmless(good: bytes, trace: Trace, tmp_path: Path) -> None:
    for at in range(len(good)):
        for flip in (1, 0x80, 0xFF):
            data = bytearray(good)
            data[at] ^= flip
            survives(data, trace, tmp_path)


def npz(**arrays: Any) -> bytes:
    file = io.BytesIO()
    np.savez(file, **arrays)
    return file.getvalue()


def test_foreign_files_are_refused(tmp_path: Path) -> None:
    npy = io.BytesIO()
    np.save(npy, np.arange(4))
    foreign = [
        b"", b"PK", b"not a trace", b"\x00" * 100, pickle.dumps({"a": 1}), npy.getvalue(),
        npz(a=np.arange(3)), npz(header=np.arange(3)), npz(header=np.zeros(2, np.uint8)),
        npz(header=np.frombuffer(b"[1, 2]", np.uint8)),
    ]  # fmt: skip
    for data in foreign:
        assert refusal(data, tmp_path) == "FILE is not a trace, or is damaged"
    with pytest.raises(FileError, match=r"there is no trace at .*nothing\.npz; check the path"):
        load_trace(tmp_path / "nothing.npz")
    with pytest.raises(FileError, match="is a folder"):
        load_trace(tmp_path)


class Bomb:
    """Makes a folder when it is unpickled."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def __reduce__(self) -> Any:
        return (os.mkdir, (str(self.folder),))


def test_nothing_is_unpickled(good: bytes, tmp_path: Path) -> None:
    bomb = Bomb(tmp_path / "sprung")
    for data in (
        changed(good, {"pose": np.array([bomb])}),
        npz(header=np.array(bomb)),
        pickle.dumps(bomb),
    ):
        assert refusal(data, tmp_path) == "FILE is not a trace, or is damaged"
    assert not bomb.folder.exists()


def changed(good: bytes, arrays: Any = (), *, without: str = "", header: Any = None) -> bytes:
    """The file with other arrays, header fields, or without one of its arrays."""
    with np.load(io.BytesIO(good)) as file:
        members: dict[str, Any] = {name: file[name] for name in file.files}
    fields = {**json.loads(members["header"].tobytes()), **(header or {})}
    members["header"] = np.frombuffer(json.dumps(fields).encode(), np.uint8)
    members.update(arrays)
    members.pop(without, None)
    return npz(**members)


def test_another_format_or_version_is_named(good: bytes, tmp_path: Path) -> None:
    text = refusal(changed(good, header={"version": 3}), tmp_path)
    assert text == (
        "FILE: format must be 'rovernav-trace' version 2 or older, got 'rovernav-trace' version 3"
    )
    assert "got 'x' version 2" in refusal(changed(good, header={"format": "x"}), tmp_path)


def test_a_file_of_version_1_still_loads(good: bytes, trace: Trace, tmp_path: Path) -> None:
    after = load(changed(good, header={"version": 1}, without="number"), tmp_path)
    assert_same(after, trace)
    assert after.mission.number.tolist() == [0, 1, 2]
    assert after.attitude is None


@pytest.mark.parametrize("name", [*ARRAYS, "start", "goal", "number", "channel:off_line"])
def test_the_first_wrong_array_is_named(name: str, good: bytes, tmp_path: Path) -> None:
    assert refusal(changed(good, without=name), tmp_path) == f"FILE is damaged: it has no {name!r}"
    with np.load(io.BytesIO(good)) as file:
        array = file[name]
    for wrong in (array.astype(np.float32), array[None], np.float64(0.0)):
        text = refusal(changed(good, {name: wrong}), tmp_path)
        assert text.startswith("FILE is damaged: ")
        assert " must be " in text


def test_a_wrong_shape_is_told(good: bytes, tmp_path: Path) -> None:
    text = refusal(changed(good, {"goal": np.zeros((2, 2))}), tmp_path)
    assert text == "FILE is damaged: goal must be float64 (3, 2), got float64 (2, 2)"


@pytest.mark.parametrize(
    ("field", "item"),
    [
        ("seed", "1"), ("settings", []), ("channels", None), ("goal_radius", "1"),
        ("time_limit", None), ("rovernav", 1),
    ],
)  # fmt: skip
def test_a_wrong_header_field_is_named(field: str, item: Any, good: bytes, tmp_path: Path) -> None:
    text = refusal(changed(good, header={field: item}), tmp_path)
    assert text == f"FILE is damaged: its header has no usable {field!r}"


def test_impossible_values_are_refused(good: bytes, tmp_path: Path) -> None:
    sentence = "FILE is damaged: an outcome or a number of steps is impossible"
    assert refusal(changed(good, {"outcome": np.full(3, 99, np.int8)}), tmp_path) == sentence
    assert refusal(changed(good, {"steps": np.full(3, -1)}), tmp_path) == sentence
    text = refusal(changed(good, {"goal": np.full((3, 2), np.nan)}), tmp_path)
    assert text == "FILE is damaged: mission goal has a coordinate that is not a finite number"


def test_settings_must_be_plain_data(trace: Trace, tmp_path: Path) -> None:
    scene = random_rectangles(1, np.random.default_rng(0))
    driver = NeuralController(trained_paper_network())
    for odd in (object(), float("nan"), np.float64):
        odd_trace = simulate(scene.drive(driver), settings={"odd": odd})
        with pytest.raises(SettingError, match="the settings of a trace must be plain data: "):
            save_trace(odd_trace, tmp_path / "odd.npz")
    assert list(tmp_path.iterdir()) == []


def test_a_trace_that_cannot_be_written_is_told(trace: Trace, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(FileError, match="cannot write"):
        save_trace(trace, tmp_path / "file" / "trace.npz")
