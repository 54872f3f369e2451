"""What a worker does: open the parcels, run the job, send back the result or the job's error."""

from __future__ import annotations

import contextlib
import functools
import hashlib
import pickle
import platform
import time
from collections.abc import Generator, Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, NamedTuple

from ._parcel import Parcel

DONE, FAILED, FOREIGN = "done", "failed", "foreign"
PACKAGES = ("rovernav", "numpy", "numba", "llvmlite")
"""What results depend on, besides Python."""


class Answer(NamedTuple):
    """What a worker says about some items.

    Attributes:
        found: For each item up to the first that failed: how it went, and the result or error,
            pickled; or that the worker does not fit, and its `fingerprint`.
        seconds: Time that the items took [s].
        processor: The worker's.
    """

    found: list[tuple[str, Any]]
    seconds: float
    processor: str


def deliver(parcel: Parcel) -> Parcel:
    """The task whose result is a shared value: the cluster can repeat it when a copy is lost."""
    return parcel


def pack_items(job: Any, items: Sequence[Any]) -> bytes:
    """A job and some items, for `run_items`."""
    import cloudpickle

    return cloudpickle.dumps((job, items), protocol=5)


def run_items(packed: bytes, mark: str, spread: bool, *parcels: Parcel) -> bytes:
    """Run some items on a worker, up to the first that fails.

    Args:
        packed: Made by `pack_items`.
        mark: The `own_mark` of the machine that asks; another one's work is not done.
        spread: Whether the parcels are the parts of a tuple, or one parcel is all.
        parcels: What all items share.

    Returns:
        A pickled `Answer`.
    """
    if mark != own_mark():
        return pickle.dumps(Answer([(FOREIGN, fingerprint())], 0.0, processor()))
    found: list[tuple[str, Any]] = []
    began = time.perf_counter()
    try:
        job, items, parts = _unpacked(packed, parcels)
        shared = parts if spread else next(iter(parts), None)
        began = time.perf_counter()
        with one_thread():
            for item in items:
                found.append((DONE, pickle.dumps(job(shared, item), protocol=5)))
    except Exception as error:  # travels in the answer, so that no worker prints it
        found.append((FAILED, _portable(error)))
    return pickle.dumps(Answer(found, time.perf_counter() - began, processor()), protocol=5)


def _portable(error: Exception) -> bytes:
    """The error as it was; one that cannot travel, as words."""
    try:
        packed = pickle.dumps(error, protocol=5)
        pickle.loads(packed)
    except Exception:
        packed = pickle.dumps(RuntimeError(f"{type(error).__name__}: {error}"))
    return packed


def _unpacked(packed: bytes, parcels: tuple[Parcel, ...]) -> tuple[Any, Any, tuple[Any, ...]]:
    try:
        job, item = pickle.loads(packed)
        return job, item, tuple(parcel.open() for parcel in parcels)
    except (ImportError, AttributeError) as error:
        from ..core import WorkerError

        raise WorkerError(
            f"a worker cannot open its work: {error}; it needs the same modules as this machine"
        ) from None


@contextlib.contextmanager
def one_thread() -> Generator[None]:
    """Kernels started by this thread use no further threads: a worker has a slot per thread."""
    import numba

    before = numba.get_num_threads()
    numba.set_num_threads(1)
    try:
        yield
    finally:
        numba.set_num_threads(before)


@functools.cache
def fingerprint() -> dict[str, str]:
    """What must be equal for equal results: the Python, packages and sources of this process."""
    found = {"Python": ".".join(platform.python_version_tuple()[:2])}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "missing"
    found["rovernav's sources"] = _sources()
    return found


@functools.cache
def own_mark() -> str:
    """The fingerprint in a few letters."""
    return hashlib.sha256(repr(sorted(fingerprint().items())).encode()).hexdigest()[:16]


@functools.cache
def processor() -> str:
    """What the last bits of results may depend on: processor and C library."""
    from llvmlite import binding

    features = ",".join(sorted(k for k, on in binding.get_host_cpu_features().items() if on))
    digest = hashlib.sha256(features.encode()).hexdigest()[:8]
    library = " ".join(platform.libc_ver()).strip() or platform.system()
    return f"{platform.machine()} {binding.get_host_cpu_name()} {digest}, {library}"


def _sources() -> str:
    root = Path(__file__).parents[1]
    digest = hashlib.sha256()
    for path in sorted(root.rglob("*.py")):
        digest.update(path.relative_to(root).as_posix().encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()[:12]
