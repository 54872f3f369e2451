"""Parcels: shared values on their way to workers, packed once and opened once in each process."""

from __future__ import annotations

import hashlib
import pickle
import threading
from collections.abc import Sequence
from typing import Any, final

Bytes = bytes | bytearray | memoryview
_CLOSED = object()


@final
class Parcel:
    """A pickled value, its arrays beside it so that opening them copies nothing.

    It travels unopened, and keeps what it holds once it is open: a process with many threads
    opens it once. Arrays come out read-only or writable as they went in.

    Args:
        head: The pickle, protocol 5.
        buffers: The memory of its arrays.
        writable: Which of them can be written to.
    """

    __slots__ = ("_buffers", "_head", "_lock", "_value", "_writable")

    def __init__(self, head: bytes, buffers: Sequence[Bytes], writable: Sequence[bool]) -> None:
        self._head, self._buffers, self._writable = head, list(buffers), list(writable)
        self._lock = threading.Lock()
        self._value: Any = _CLOSED

    @classmethod
    def pack(cls, value: Any) -> tuple[str, Parcel]:
        """The value's name, made from all its bytes, and the value packed."""
        import cloudpickle  # what was defined in a notebook is found by no import

        views: list[pickle.PickleBuffer] = []
        head = cloudpickle.dumps(value, protocol=5, buffer_callback=views.append)
        raw = [view.raw() for view in views]
        writable = [not view.readonly for view in raw]
        digest = hashlib.blake2b(head, digest_size=16)
        digest.update(bytes(writable))
        for view in raw:
            digest.update(len(view).to_bytes(8, "little"))
            digest.update(view)
        return digest.hexdigest(), cls(head, [bytes(view) for view in raw], writable)

    def open(self) -> Any:
        """What is in it: the same object each time."""
        with self._lock:
            if self._value is _CLOSED:
                # A copy of its own, because what came over the wire need not be aligned.
                self._buffers = [
                    bytearray(buffer) if writable else bytes(buffer)
                    for buffer, writable in zip(self._buffers, self._writable, strict=True)
                ]
                self._value = pickle.loads(self._head, buffers=self._buffers)
            return self._value

    def __reduce_ex__(self, protocol: Any) -> tuple[Any, ...]:
        buffers: list[Any] = list(self._buffers)
        if protocol >= 5:
            buffers = [pickle.PickleBuffer(buffer) for buffer in buffers]
        else:
            buffers = [bytes(buffer) for buffer in buffers]
        return Parcel, (self._head, buffers, self._writable)
