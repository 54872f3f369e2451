"""What the checkers of all roles share: results depend on seed, inputs and memory alone."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from .errors import ContractError
from .values import map_arrays

Start = Callable[[Any], Any]
Step = Callable[[int, Any, Any], tuple[Any, Any]]
Results = list["np.ndarray[Any, Any]"]


def check_steps(start: Start, step: Step, *, rovers: int, steps: int, called: str) -> None:
    """Check a part of a drive that goes from memory to memory.

    Args:
        start: From the numbers of some rovers to their memory at the start.
        step: From a step's number, the same rovers and their memory to their results (n, ...) in
            that step, and the memory after it.
        rovers: Rovers in all.
        steps: Steps of a drive.
        called: What the error message calls the part.

    Raises:
        ContractError: The same memory or seed gives other results, two drives disturb each other,
            or a rover's results depend on the batch it is in.
    """
    wrong = _fault(start, step, np.arange(rovers), steps)
    if wrong:
        raise ContractError(f"{called}: {wrong}")


@contextmanager
def unchanged(given: Any, *, called: str) -> Generator[None]:
    """Whatever happens inside must leave the arrays in `given` as they are.

    Raises:
        ContractError: An array was changed, or somebody tried.
    """
    before = _arrays(given)
    try:
        yield
    except ValueError as error:
        if "read-only" not in str(error):
            raise
        raise ContractError(f"{called}: it tries to change what it is given") from error
    if not _same(before, _arrays(given)):
        raise ContractError(f"{called}: it changes what it is given")


def _fault(start: Start, step: Step, everyone: Any, steps: int) -> str:
    whole = _run(start, step, everyone, steps)
    if not _same(whole, _run(start, step, everyone, steps, twice=True)):
        return "the same memory gives another result the next time"
    if not _same(whole, _run(start, step, everyone, steps)):
        return "the same seed gives another result the next time"
    if not _same(whole, _run(start, step, everyone, steps, beside=True)):
        return "another drive beside it changes the result"
    for k in everyone:
        if not _same([result[k : k + 1] for result in whole], _run(start, step, [k], steps)):
            return f"rover {k} alone gets another result than in a batch"
    if not _same([each[::-1] for each in whole], _run(start, step, everyone[::-1], steps)):
        return "the result depends on the order of the rovers"
    return ""


def _run(
    start: Start, step: Step, part: Any, steps: int, *, twice: bool = False, beside: bool = False
) -> Results:
    """Results of a whole drive; each step done twice, or with another drive beside it."""
    memory, other = start(part), start(part)
    results: Results = []
    for number in range(steps):
        if beside:
            _, other = step(steps - 1 - number, part, other)
        if twice:
            step(number, part, memory)
        result, memory = step(number, part, memory)
        results.append(result)
    return results


def _arrays(item: Any) -> Results:
    found: Results = []

    def keep(array: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
        found.append(array.copy())
        return array

    map_arrays(item, keep)
    return found


def _same(left: Sequence[Any], right: Sequence[Any]) -> bool:
    """Whether all arrays have the same bits."""
    pairs = zip(left, right, strict=True)
    return all(a.shape == b.shape and a.tobytes() == b.tobytes() for a, b in pairs)
