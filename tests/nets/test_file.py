from __future__ import annotations

import json
import pickle
import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from safetensors.numpy import load, save

from rovernav.core import FileError, SettingError, canonical_json, sha256_of
from rovernav.nets import (
    ACTIVATIONS,
    Card,
    Network,
    load_network,
    parameter_count,
    save_network,
    weights_sha256,
)
from tests.bits import assert_same_bits

NAMES = st.text(max_size=5)
PLAIN = st.dictionaries(
    NAMES, st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False,
    allow_infinity=False) | NAMES | st.lists(st.integers())
)  # fmt: skip
SMALL = Network(
    topology=(1, 1),
    activations=("tanh",),
    parameters=np.array([0.5, -0.25]),
    card=Card(inputs=("x",), codec={"name": "c"}, seed=4),
)


@st.composite
def networks(draw: st.DrawFn) -> Network:
    topology = tuple(draw(st.lists(st.integers(1, 4), min_size=2, max_size=4)))

    def tuple_of(strategy: st.SearchStrategy[str], count: int) -> tuple[str, ...]:
        return tuple(draw(st.lists(strategy, min_size=count, max_size=count)))

    width: Any = draw(st.sampled_from([32, 64]))
    numbers = st.floats(width=width)
    ends = {name: draw(st.booleans()) for name in ("inputs", "outputs")}
    return Network(
        topology=topology,
        activations=tuple_of(st.sampled_from(sorted(ACTIVATIONS)), len(topology) - 1),
        parameters=draw(arrays(f"f{width // 8}", parameter_count(topology), elements=numbers)),
        card=Card(
            inputs=tuple_of(NAMES, topology[0]) if ends["inputs"] else (),
            outputs=tuple_of(NAMES, topology[-1]) if ends["outputs"] else (),
            input_units=tuple_of(NAMES, topology[0]) if ends["outputs"] else (),
            output_units=tuple_of(NAMES, topology[-1]) if ends["inputs"] else (),
            codec=draw(st.none() | PLAIN),
            training=draw(st.none() | PLAIN),
            seed=draw(st.none() | st.integers(0, 2**70)),
        ),
    )


def same(a: Network, b: Network) -> bool:
    """Whether two networks agree in every field and every bit."""
    fields = ("inputs", "outputs", "input_units", "output_units", "codec", "training", "seed")
    return (
        (a.topology, a.activations) == (b.topology, b.activations)
        and a.parameters.dtype == b.parameters.dtype
        and a.parameters.tobytes() == b.parameters.tobytes()
        and all(getattr(a.card, field) == getattr(b.card, field) for field in fields)
    )


@settings(max_examples=60)
@given(network=networks())
def test_what_was_saved_is_loaded(network: Network, tmp_path_factory: Any) -> None:
    path = tmp_path_factory.mktemp("n") / "n.safetensors"
    save_network(network, path)
    assert same(load_network(path), network)


def test_the_same_network_gives_the_same_file(tmp_path: Path) -> None:
    digests = [save_network(SMALL, tmp_path / name) for name in ("a", "b")]
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()
    assert digests[0] == digests[1] == header_of(tmp_path / "a")["sha256"]
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a", "b"]


def test_the_file_is_plain_safetensors(tmp_path: Path) -> None:
    path = tmp_path / "n"
    save_network(SMALL, path)
    assert_same_bits(load(path.read_bytes())["parameters"], SMALL.parameters)
    header = header_of(path)
    assert header.pop("sha256") == sha256_of(
        canonical_json(header).encode(), np.array([0.5, -0.25], "<f8").tobytes()
    )
    assert header == {
        "format": "rovernav-network", "version": 1, "topology": [1, 1], "activations": ["tanh"],
        "dtype": "float64", "inputs": ["x"], "outputs": [], "input_units": [], "output_units": [],
        "codec": {"name": "c"}, "training": None, "seed": 4,
    }  # fmt: skip


def test_the_hash_of_the_weights_is_theirs_alone() -> None:
    expected = sha256_of(np.array([0.5, -0.25], "<f8").tobytes())
    assert weights_sha256(SMALL) == weights_sha256(SMALL.with_card(Card())) == expected


def header_of(path: Path) -> dict[str, Any]:
    data = path.read_bytes()
    outer = json.loads(data[8 : 8 + int.from_bytes(data[:8], "little")])
    return json.loads(outer["__metadata__"]["rovernav"])


def forge(
    path: Path,
    changes: dict[str, Any],
    parameters: Any = SMALL.parameters,
    tensors: dict[str, Any] | None = None,
) -> Path:
    """A file as `save_network` writes it, its hash too, but with `changes`; None drops a field."""
    save_network(SMALL, path)
    header = {**header_of(path), **changes}
    del header["sha256"]
    for field, item in changes.items():
        if item is None:
            del header[field]
    digest = sha256_of(canonical_json(header).encode(), np.asarray(parameters).tobytes())
    metadata = {"rovernav": canonical_json({**header, "sha256": digest})}
    path.write_bytes(save(tensors or {"parameters": np.asarray(parameters)}, metadata))
    return path


def refusal(path: Path) -> str:
    """The sentence with which a file is refused, without the path it begins with."""
    with pytest.raises(FileError) as caught:
        load_network(path)
    text = str(caught.value)
    assert text.startswith(str(path))
    assert "\n" not in text
    assert len(text) - len(str(path)) < 300
    return text.removeprefix(str(path))


def test_a_forged_file_without_changes_is_read(tmp_path: Path) -> None:
    assert same(load_network(forge(tmp_path / "n", {})), SMALL)


def test_cut_off_at_every_length(tmp_path: Path) -> None:
    path = tmp_path / "n"
    save_network(SMALL, path)
    whole = path.read_bytes()
    for length in range(len(whole)):
        path.write_bytes(whole[:length])
        assert "not a network file, or is cut off" in refusal(path) or length > 8
        refusal(path)
    path.write_bytes(whole + b"\0")
    assert "is not a whole safetensors file" in refusal(path)


@pytest.mark.parametrize("mask", [0x01, 0x20, 0xFF])
def test_each_byte_changed(tmp_path: Path, mask: int) -> None:
    path = tmp_path / "n"
    save_network(SMALL, path)
    whole = path.read_bytes()
    harmless = 0
    for at in range(len(whole)):
        damaged = bytearray(whole)
        damaged[at] ^= mask
        path.write_bytes(damaged)
        try:
            loaded = load_network(path)
        except FileError:
            refusal(path)
        else:
            assert same(loaded, SMALL)
            harmless += 1
    assert harmless < 0.05 * len(whole)  # spaces after the header


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"format": "other"}, ": format must be 'rovernav-network', got 'other'"),
        ({"format": ["x"] * 999}, ": format must be 'rovernav-network', got ['x', 'x', 'x',"),
        ({"version": 2}, ": version must be 1, got 2; read it with the rovernav that wrote it"),
        ({"version": "1"}, ": version must be 1, got '1'; read it with the rovernav that wrote it"),
        ({"topology": [1, 2]}, ": a 1-2 network has 4 parameters, the file holds shape (2,)"),
        ({"topology": [1]}, ": topology: a network needs at least inputs and outputs"),
        ({"topology": []}, ": topology: a network needs at least inputs and outputs"),
        ({"topology": [-1, -1]}, ": topology: each layer needs 1 to 100,000 units, got '-1--1'"),
        ({"topology": [1, 0, 1]}, ": topology: each layer needs 1 to 100,000 units, got '1-0-1'"),
        ({"topology": [10**9, 10**9]}, ": topology: each layer needs 1 to 100,000 units, got '1"),
        ({"topology": [10**4000] * 2}, ": topology: each layer needs 1 to 100,000 units, got '1"),
        ({"topology": [10**5, 10**5]}, ": topology: a 100000-100000 network has 10,000,100,000 "),
        ({"topology": [1] * 10**6}, ": topology: a network may have 100 layers, got 999999"),
        ({"topology": "1-1"}, ": topology must be a list of whole numbers, got '1-1'"),
        ({"topology": [1.0, 1]}, ": topology must be a list of whole numbers, got [1.0, 1]"),
        ({"topology": [True, 1]}, ": topology must be a list of whole numbers, got [True, 1]"),
        ({"activations": "tanh"}, ": activations must be a list of names, got 'tanh'"),
        ({"activations": [1]}, ": activations must be a list of names, got [1]"),
        ({"activations": ["tanh"] * 2}, " is damaged: a 1-1 network needs 1 activations, one per"),
        ({"activations": ["x"]}, " is damaged: unknown activation 'x'; Allowed: linear, relu, "),
        ({"dtype": "float32"}, ": dtype must be 'float32', got float64"),
        ({"dtype": 3}, ": dtype must be 3, got float64"),
        ({"inputs": ["a", "b"]}, " is damaged: 2 input names do not fit a network with 1"),
        ({"inputs": {}}, ": inputs must be a list of names, got {}"),
        ({"output_units": [None]}, ": output_units must be a list of names, got [None]"),
        ({"codec": "bassil"}, ": codec must be a mapping, got 'bassil'"),
        ({"training": [1]}, ": training must be a mapping, got [1]"),
        ({"seed": "4"}, ": seed must be a whole number, got '4'"),
        ({"seed": 1.5}, ": seed must be a whole number, got 1.5"),
    ],
)
def test_the_first_field_that_differs_is_named(
    tmp_path: Path, changes: dict[str, Any], message: str
) -> None:
    assert refusal(forge(tmp_path / "n", changes)).startswith(message)


@pytest.mark.parametrize(
    "field", ["activations", "codec", "dtype", "inputs", "input_units", "outputs", "output_units",
              "seed", "topology", "training"],
)  # fmt: skip
def test_a_missing_field_is_named(tmp_path: Path, field: str) -> None:
    expected = f" is damaged: its header has no field {field!r}"
    assert refusal(forge(tmp_path / "n", {field: None})) == expected


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        (np.zeros(2, np.float16), ": dtype must be 'float64', got float16"),
        (np.zeros(2, np.int64), ": dtype must be 'float64', got int64"),
        (np.zeros(3), ": a 1-1 network has 2 parameters, the file holds shape (3,)"),
        (np.zeros((2, 1)), ": a 1-1 network has 2 parameters, the file holds shape (2, 1)"),
        (np.array(0.5), ": a 1-1 network has 2 parameters, the file holds shape ()"),
    ],
)
def test_weights_must_fit(tmp_path: Path, parameters: Any, message: str) -> None:
    assert refusal(forge(tmp_path / "n", {}, parameters)) == message


def test_no_other_precision(tmp_path: Path) -> None:
    path = forge(tmp_path / "n", {"dtype": "int64"}, np.zeros(2, np.int64))
    assert refusal(path) == " is damaged: parameters must be float64 or float32, got int64"


def test_other_tensors(tmp_path: Path) -> None:
    for names in (["other"], ["a", "parameters"]):
        path = forge(tmp_path / "n", {}, tensors={name: np.zeros(2) for name in names})
        assert refusal(path) == f": tensors must be ['parameters'], got {names}"


def test_a_changed_weight_with_the_old_hash(tmp_path: Path) -> None:
    path = forge(tmp_path / "n", {}, tensors={"parameters": np.array([0.5, -0.26])})
    assert refusal(path) == " is damaged: sha256 does not fit its header and weights"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (save({"w": np.zeros(3)}), " is a safetensors file, but not one that rovernav wrote"),
        (save({}, {"rovernav": "["}), " is damaged: its header cannot be read"),
        (save({}, {"rovernav": "[1]"}), " is damaged: its header cannot be read"),
        (save({}, {"rovernav": '"text"'}), " is damaged: its header cannot be read"),
        (save({}, {"rovernav": "null"}), " is damaged: its header cannot be read"),
        (save({}, {"rovernav": "{}"}), " is damaged: its header cannot be read"),
        (save({}, {"rovernav": '{"sha256": "", "seed": NaN}'}), " is damaged: its header cannot"),
        (save({}, {"rovernav": "[" * 100_000}), " is damaged: its header cannot be read"),
        (pickle.dumps({"parameters": [0.5]}), " is not a network file, or is cut off"),
        (b"", " is not a network file, or is cut off: it has 0 bytes"),
        (b"\xff" * 100, " is not a network file, or is cut off: it has 100 bytes"),
        ((2**62).to_bytes(8, "little") + b"{}", " is not a network file, or is cut off"),
        ((2).to_bytes(8, "little") + b"{}", " is a safetensors file, but not one that rovernav"),
        ((2).to_bytes(8, "little") + b"[]", " is not a whole safetensors file: "),
        ((2).to_bytes(8, "little") + b"{]", " is not a whole safetensors file: "),
        ((1).to_bytes(8, "little") + b"\xff", " is not a whole safetensors file: "),
        ((99_999).to_bytes(8, "little") + b"[" * 99_999, " is not a whole safetensors file: "),
    ],
)
def test_foreign_files(tmp_path: Path, content: bytes, message: str) -> None:
    path = tmp_path / "n"
    path.write_bytes(content)
    assert refusal(path).startswith(message)


def test_a_pickle_is_never_run(tmp_path: Path) -> None:
    class Trap:
        def __reduce__(self) -> tuple[Any, ...]:
            return Path.touch, (tmp_path / "ran",)

    path = tmp_path / "n"
    path.write_bytes(pickle.dumps(Trap()))
    refusal(path)
    assert not (tmp_path / "ran").exists()


def test_a_missing_file_and_a_folder(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"^there is no network file at .*none; check the path$"):
        load_network(tmp_path / "none")
    with pytest.raises(FileError, match=r"is a folder; give the network file itself$"):
        load_network(tmp_path)


@pytest.mark.parametrize("topology", [[10**5, 400], [2, 10**5, 400, 2]])
def test_a_large_claim_allocates_nothing(tmp_path: Path, topology: list[int]) -> None:
    path = forge(tmp_path / "n", {"topology": topology})
    load_network(forge(tmp_path / "warm", {}))
    tracemalloc.start()
    try:
        refusal(path)
        assert tracemalloc.get_traced_memory()[1] < 1_000_000
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("item", [float("nan"), {1, 2}, np.int64(3)])
def test_a_card_that_json_cannot_hold_is_refused(tmp_path: Path, item: Any) -> None:
    (tmp_path / "n").write_text("old")
    with pytest.raises(SettingError, match="a network's card must hold plain JSON values: "):
        save_network(SMALL.with_card(Card(training={"error": item})), tmp_path / "n")
    assert (tmp_path / "n").read_text() == "old"
