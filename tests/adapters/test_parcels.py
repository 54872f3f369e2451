from __future__ import annotations

import pickle
import threading
from typing import Any

import numpy as np
import pytest

from rovernav.adapters._parcel import Parcel
from tests.adapters import jobs


@pytest.mark.parametrize("protocol", [4, 5])
def test_what_goes_in_comes_out(protocol: int) -> None:
    frozen = np.arange(6.0).reshape(2, 3)
    frozen.flags.writeable = False
    value: Any = {"a": np.arange(5), "b": (frozen, "text", None), "c": np.arange(12)[::3]}
    _, parcel = Parcel.pack(value)
    out = pickle.loads(pickle.dumps(parcel, protocol=protocol)).open()
    assert out["b"][1:] == ("text", None)
    for got, was in ((out["a"], value["a"]), (out["b"][0], frozen), (out["c"], value["c"])):
        assert (got.dtype, got.tobytes()) == (was.dtype, was.tobytes())
        assert got.flags.writeable == was.flags.writeable
        assert got.flags.aligned


def test_memory_that_came_over_a_wire_askew_is_put_right() -> None:
    _, parcel = Parcel.pack(np.arange(4.0))
    (rebuild, (head, buffers, writable)) = parcel.__reduce_ex__(4)
    askew = memoryview(b"x" + buffers[0])[1:]
    out = rebuild(head, [askew], writable).open()
    assert out.flags.aligned
    assert out.tolist() == [0.0, 1.0, 2.0, 3.0]


def test_the_name_is_that_of_the_content() -> None:
    array = np.zeros(100)
    names = {Parcel.pack(array)[0], Parcel.pack(array.copy())[0]}
    assert len(names) == 1
    array[99] = 1e-300
    names.add(Parcel.pack(array)[0])
    array.flags.writeable = False
    names.add(Parcel.pack(array)[0])
    assert len(names) == 3


def test_what_is_packed_is_a_copy() -> None:
    array = np.zeros(3)
    _, parcel = Parcel.pack(array)
    array[0] = 5.0
    assert parcel.open().tolist() == [0.0, 0.0, 0.0]


def test_many_threads_open_it_once() -> None:
    _, parcel = Parcel.pack(jobs.Counted("threads"))
    found: list[Any] = []
    ready = threading.Barrier(8, timeout=30)

    def look() -> None:
        ready.wait()
        found.append(parcel.open())

    threads = [threading.Thread(target=look) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len({id(one) for one in found}) == 1
    assert jobs.OPENED["threads"] == 1
