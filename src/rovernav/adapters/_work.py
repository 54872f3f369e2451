"""What a worker does: open the parcels, run the job, send back the result or the job's error."""

from __future__ import annotations

import contextlib
import functools
import hashlib
import pickle
import platform
from collections.abc import Generator
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from ._parcel import Parcel

DONE, FAILED, FOREIGN = "done", "failed", "foreign"
PACKAGES = ("rovernav", "numpy", "numba", "llvmlite")
"""What results depend on, besides Python."""


def deliver(parcel: Parcel) -> Parcel:
    """The task whose result is a shared value: the cluster can repeat it when a copy is lost."""
    return parcel


def pack_item(job: Any, item: Any) -> bytes:
    """A job and one item, for `run_item`."""
    import cloudpickle

    return cloudpickle.dumps((job, item), protocol=5)


def run_item(packed: bytes, mark: str, spread: bool, *parcels: Parcel) -> bytes:
    """Run one item on a worker.

    Args:
        packed: Made by `pack_item`.
        mark: The `mark` of the machine that asks; another one's work is not done.
        spread: Whether the parcels are the parts of a tuple, or one parcel is all.
        parcels: What all items share.

    Returns:
        Pickled: `DONE`, `FAILED` or `FOREIGN`, the result, error or `fingerprint`, the `processor`.
    """
    if mark != own_mark():
        return pickle.dumps((FOREIGN, fingerprint(), processor()))
    try:
        job, item, parts = _unpacked(packed, parcels)
        shared = parts if spread else next(iter(parts), None)
        with one_thread():
            answer = pickle.dumps((DONE, job(shared, item), processor()), protocol=5)
    except Exception as error:  # travels in the result, so that no worker prints it
        answer = _failure(error)
    return answer


def _unpacked(packed: bytes, parcels: tuple[Parcel, ...]) -> tuple[Any, Any, tuple[Any, ...]]:
    try:
        job, item = pickle.loads(packed)
        return job, item, tuple(parcel.open() for parcel in parcels)
    except (ImportError, AttributeError) as error:
        from ..core import WorkerError

        raise WorkerError(
            f"a worker cannot open its work: {error}; it needs the same modules as this machine"
        ) from None


def _failure(error: Exception) -> bytes:
    """The error as it was; one that cannot travel, as words."""
    try:
        answer = pickle.dumps((FAILED, error, processor()), protocol=5)
        pickle.loads(answer)
    except Exception:
        words = RuntimeError(f"{type(error).__name__}: {error}")
        answer = pickle.dumps((FAILED, words, processor()), protocol=5)
    return answer


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
