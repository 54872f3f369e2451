"""The network file: safetensors with a JSON header, and a reader that trusts nothing.

The header's ``__metadata__`` has one entry ``rovernav`` with canonical JSON: format, version,
topology, activations, dtype, names and units, codec, training, seed, and the SHA-256 of that JSON
without the hash, followed by the weights' bytes. Never pickle.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from reprlib import repr as short
from typing import Any

import numpy as np

from ..core import (
    FileError,
    Float,
    RovernavError,
    SettingError,
    canonical_json,
    read_bytes,
    sha256_of,
    write_atomic,
)
from ._card import Card
from ._network import Network, check_topology, parameter_count, topology_text

FORMAT = "rovernav-network"
VERSION = 1
MAX_BYTES = 500_000_000
_FIELDS = ("activations", "codec", "dtype", "format", "inputs", "input_units", "outputs",
           "output_units", "seed", "topology", "training", "version")  # fmt: skip


def save_network(network: Network, path: Path) -> str:
    """Write a network file atomically.

    Args:
        network: What to write.
        path: Where; the folder is made if needed.

    Returns:
        Its hash, as it stands in the file: SHA-256 over header and weights.

    Raises:
        FileError: The file cannot be written there.
        SettingError: The card holds what JSON cannot, like NaN.
    """
    data, digest = _pack(network)
    write_atomic(path, lambda file: file.write(data))
    return digest


def network_bytes(network: Network) -> bytes:
    """What `save_network` writes.

    Raises:
        SettingError: The card holds what JSON cannot, like NaN.
    """
    return _pack(network)[0]


def load_network(path: Path) -> Network:
    """Read a network file.

    Raises:
        FileError: Missing, truncated, foreign, damaged, of another version or wrong shape; the
            sentence names the first field that differs.
    """
    return parse_network(read_bytes(path, limit=MAX_BYTES, what="network file"), path)


def parse_network(data: bytes, source: Path | str) -> Network:
    """The network in the bytes of a network file.

    Args:
        data: The whole file.
        source: What error messages call it.

    Raises:
        FileError: As `load_network`.
    """
    header, parameters = _open(source, data)
    try:
        network = Network(
            topology=tuple(header["topology"]),
            activations=tuple(header["activations"]),
            parameters=parameters,
            card=Card(
                inputs=tuple(header["inputs"]),
                outputs=tuple(header["outputs"]),
                input_units=tuple(header["input_units"]),
                output_units=tuple(header["output_units"]),
                codec=header["codec"],
                training=header["training"],
                seed=header["seed"],
            ),
        )
    except RovernavError as error:
        raise FileError(f"{source} is damaged: {error}") from None
    return network


def weights_sha256(network: Network) -> str:
    """SHA-256 of the weights' bytes alone (little-endian)."""
    return sha256_of(_little(network.parameters))


def _pack(network: Network) -> tuple[bytes, str]:
    """The bytes of a network file, and the hash that stands in it."""
    from safetensors.numpy import save

    header = _header(network)
    try:
        digest = _hash(header, network.parameters)
    except (TypeError, ValueError) as error:
        raise SettingError(f"a network's card must hold plain JSON values: {error}") from None
    metadata = {"rovernav": canonical_json({**header, "sha256": digest})}
    return save({"parameters": np.ascontiguousarray(network.parameters)}, metadata), digest


def _header(network: Network) -> dict[str, Any]:
    card = network.card
    return {
        "format": FORMAT,
        "version": VERSION,
        "topology": list(network.topology),
        "activations": list(network.activations),
        "dtype": str(network.parameters.dtype),
        "inputs": list(card.inputs),
        "outputs": list(card.outputs),
        "input_units": list(card.input_units),
        "output_units": list(card.output_units),
        "codec": None if card.codec is None else dict(card.codec),
        "training": None if card.training is None else dict(card.training),
        "seed": card.seed,
    }


def _hash(header: Mapping[str, Any], parameters: Float) -> str:
    return sha256_of(canonical_json(header).encode(), _little(parameters))


def _little(parameters: Float) -> bytes:
    return parameters.astype(parameters.dtype.newbyteorder("<")).tobytes()


def _open(path: Path | str, data: bytes) -> tuple[dict[str, Any], Float]:
    metadata, tensors = _safetensors(path, data)
    text = metadata.get("rovernav")
    if text is None:
        raise FileError(f"{path} is a safetensors file, but not one that rovernav wrote")
    try:
        header = json.loads(text)
        digest = header.pop("sha256")
        canonical_json(header)  # refuses NaN, which JSON has not
    except (ValueError, KeyError, AttributeError, TypeError, RecursionError):
        raise FileError(f"{path} is damaged: its header cannot be read") from None
    _check_header(path, header)
    if list(tensors) != ["parameters"]:
        raise FileError(f"{path}: tensors must be ['parameters'], got {short(sorted(tensors))}")
    parameters = tensors["parameters"]
    _check_parameters(path, header, parameters)
    if _hash(header, parameters) != digest:
        raise FileError(f"{path} is damaged: sha256 does not fit its header and weights")
    return header, parameters


def _safetensors(path: Path | str, data: bytes) -> tuple[dict[str, str], dict[str, Float]]:
    """Metadata and tensors, or one sentence about why this is no whole safetensors file."""
    from safetensors import SafetensorError
    from safetensors.numpy import load

    try:
        size = int.from_bytes(data[:8], "little")
        if len(data) < 8 or size > len(data) - 8:
            raise FileError(
                f"{path} is not a network file, or is cut off: it has {len(data)} bytes and "
                f"should begin with a safetensors header"
            )
        header = json.loads(data[8 : 8 + size])
        return dict(header.get("__metadata__", {})), load(data)
    except (
        SafetensorError, ValueError, AttributeError, TypeError, KeyError, RecursionError
    ) as error:  # fmt: skip
        if isinstance(error, FileError):
            raise
        reason = str(error).splitlines()[0][:120] if str(error) else type(error).__name__
        raise FileError(f"{path} is not a whole safetensors file: {reason}") from None


def _check_header(path: Path | str, header: Any) -> None:
    if header.get("format") != FORMAT:
        raise FileError(f"{path}: format must be {FORMAT!r}, got {short(header.get('format'))}")
    if header.get("version") != VERSION:
        raise FileError(
            f"{path}: version must be {VERSION}, got {short(header.get('version'))}; "
            f"read it with the rovernav that wrote it"
        )
    for field in _FIELDS:
        if field not in header:
            raise FileError(f"{path} is damaged: its header has no field {field!r}")
    _check_kinds(path, header)


def _check_kinds(path: Path | str, header: dict[str, Any]) -> None:
    topology = header["topology"]
    if not isinstance(topology, list) or not all(type(n) is int for n in topology):
        raise FileError(f"{path}: topology must be a list of whole numbers, got {short(topology)}")
    for field in ("activations", "inputs", "outputs", "input_units", "output_units"):
        item = header[field]
        if not isinstance(item, list) or not all(isinstance(name, str) for name in item):
            raise FileError(f"{path}: {field} must be a list of names, got {short(item)}")
    for field in ("codec", "training"):
        if not isinstance(header[field], dict | None):
            raise FileError(f"{path}: {field} must be a mapping, got {short(header[field])}")
    if header["seed"] is not None and type(header["seed"]) is not int:
        raise FileError(f"{path}: seed must be a whole number, got {short(header['seed'])}")


def _check_parameters(path: Path | str, header: dict[str, Any], parameters: Float) -> None:
    if str(parameters.dtype) != header["dtype"]:
        raise FileError(f"{path}: dtype must be {short(header['dtype'])}, got {parameters.dtype}")
    topology = tuple(header["topology"])
    try:
        check_topology(topology)
    except SettingError as error:
        raise FileError(f"{path}: topology: {error}") from None
    count = parameter_count(topology)
    if parameters.shape != (count,):
        raise FileError(
            f"{path}: a {topology_text(topology)} network has {count} parameters, "
            f"the file holds shape {parameters.shape}"
        )
