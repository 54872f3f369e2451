"""The grid maps and scenarios of the MovingAI benchmarks, and all shortest ways that they ask for.

Source: N. R. Sturtevant, Benchmarks for grid-based pathfinding, IEEE Transactions on Computational
Intelligence and AI in Games 4 (2012). A step to one of the eight neighbours costs its length; a
diagonal one needs both cells beside it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from ..core import F64, I64, FileError, Frame, InputError, ShapeError, read_text, value
from ._costs import CostMap
from ._shortest import GridSearch

FREE, BLOCKED = ".GS", "@OTW"
"""Ground and swamp can be entered; out of bounds, trees and water cannot."""
LARGEST_MAP = 64_000_000
"""Bytes that a map or a scenario file may have."""
MOST_CELLS = 8192


@value
class Scenarios:
    """Pairs of cells between which a shortest way is asked for, in the order of the file.

    Attributes:
        start: Row and column (n, 2), row 0 south.
        goal: Row and column (n, 2), row 0 south.
        optimal: Published lengths (n,) [cells].
        tolerance: What a length may differ by (n,): half a unit of the last digit printed, and a
            millionth of the length [cells].
    """

    start: I64
    goal: I64
    optimal: F64
    tolerance: F64

    def _check(self) -> None:
        n = len(self.optimal)
        if {self.start.shape, self.goal.shape} != {(n, 2)} or self.tolerance.shape != (n,):
            raise ShapeError("scenarios need as many starts as goals, lengths and tolerances")

    def __len__(self) -> int:
        return len(self.optimal)


def read_map(path: str | Path) -> CostMap:
    """A MovingAI map: cells of one metre, cost 1 where one may go; row 0 is the last of the file.

    Raises:
        FileError: Missing, damaged or of another kind; the sentence says what to do.
    """
    path = Path(path)
    text = read_text(path, limit=LARGEST_MAP, what="MovingAI map")
    lines = text.splitlines()
    width, height, first = _head(path, lines)
    rows = lines[first : first + height]
    if len(rows) < height:
        raise FileError(f"{path} ends after {len(rows)} of {height} rows; get the file again")
    extra = [line for line in lines[first + height :] if line.strip()]
    if extra:
        raise FileError(f"{path} goes on after its {height} rows: {extra[0][:40]!r}")
    for number, row in enumerate(rows):
        if len(row) != width:
            raise FileError(
                f"{path}, row {number}: {len(row)} cells, but the width is {width}; "
                "all rows must be as long"
            )
    letters = np.frombuffer("".join(rows).encode("utf-32-le"), np.uint32).reshape(height, width)
    known = np.isin(letters, [ord(c) for c in FREE + BLOCKED])
    if not known.all():
        row, column = np.argwhere(~known)[0]
        raise FileError(
            f"{path}, row {row}, column {column}: unknown cell {rows[row][column]!r}; "
            f"free cells are {' '.join(FREE)}, blocked ones {' '.join(BLOCKED)}"
        )
    free = np.isin(letters, [ord(c) for c in FREE])[::-1]
    cost = np.where(free, np.float32(1.0), np.float32(np.inf))
    return CostMap(frame=Frame(cell=1.0, shape=(height, width)), cost=cost, unit="m")


def _head(path: Path, lines: list[str]) -> tuple[int, int, int]:
    """Width, height, and the line on which the rows begin."""
    found: dict[str, str] = {}
    for number, line in enumerate(lines[:8]):
        words = line.split()
        if words == ["map"]:
            return _side(path, found, "width"), _side(path, found, "height"), number + 1
        if len(words) != 2 or words[0] not in ("type", "width", "height"):
            break
        found[words[0]] = words[1]
    raise FileError(
        f"{path} is no MovingAI map: it must begin with the lines type octile, height N, width N "
        "and map"
    )


def _side(path: Path, found: dict[str, str], name: str) -> int:
    text = found.get(name, "")
    if not (text.isascii() and text.isdigit() and 1 <= int(text[:9]) <= MOST_CELLS):
        raise FileError(f"{path}: {name} must be from 1 to {MOST_CELLS:,}, got {text!r}")
    return int(text)


def read_scenarios(path: str | Path, costs: CostMap) -> Scenarios:
    """The scenarios of a MovingAI .scen file for a map.

    Args:
        path: The file.
        costs: The map that they are for, from `read_map`.

    Raises:
        FileError: Missing, damaged, of another kind or for another map; the sentence says what to
            do.
    """
    path = Path(path)
    lines = read_text(path, limit=LARGEST_MAP, what="MovingAI scenario file").splitlines()
    if not lines or lines[0].split()[:1] != ["version"]:
        raise FileError(f"{path} is no MovingAI scenario file: its first line must be: version 1")
    h, _w = costs.frame.shape
    starts: list[tuple[int, int]] = []
    goals: list[tuple[int, int]] = []
    lengths: list[tuple[float, float]] = []
    for where, (x0, y0, x1, y1), length in _entries(path, lines, costs):
        for x, y, what in ((x0, y0, "start"), (x1, y1, "goal")):
            if not np.isfinite(costs.cost[h - 1 - y, x]):
                raise FileError(f"{where}: the {what} ({x}, {y}) is a blocked cell of this map")
        starts.append((h - 1 - y0, x0))
        goals.append((h - 1 - y1, x1))
        lengths.append(length)
    if not starts:
        raise FileError(f"{path} holds no scenario; get the file again")
    optimal, tolerance = np.array(lengths).T
    return Scenarios(
        start=np.array(starts), goal=np.array(goals), optimal=optimal, tolerance=tolerance
    )


def _entries(
    path: Path, lines: list[str], costs: CostMap
) -> Iterator[tuple[str, tuple[int, int, int, int], tuple[float, float]]]:
    """Place in the file, the four coordinates, length and tolerance of each scenario."""
    h, w = costs.frame.shape
    for number, line in enumerate(lines[1:], 2):
        words = line.split()
        if not words:
            continue
        where = f"{path}, line {number}"
        if len(words) != 9:
            raise FileError(
                f"{where}: {len(words)} columns, but a scenario has 9: bucket, map, width, height, "
                "start x y, goal x y, length"
            )
        try:
            sides = int(words[2]), int(words[3])
            x0, y0, x1, y1 = (int(word) for word in words[4:8])
        except ValueError:
            raise FileError(f"{where}: sizes and cells must be whole numbers") from None
        if sides != (w, h):
            raise FileError(
                f"{where}: for a map of {sides[0]} x {sides[1]} cells, but this one has {w} x {h}; "
                "give the map that belongs to it"
            )
        if not (0 <= x0 < w and 0 <= x1 < w and 0 <= y0 < h and 0 <= y1 < h):
            raise FileError(f"{where}: a cell lies beyond the map of {w} x {h} cells")
        yield where, (x0, y0, x1, y1), _length(where, words[8])


def _length(where: str, text: str) -> tuple[float, float]:
    """A published length, and what half a unit of its last digit and a millionth of it make."""
    try:
        length = float(text)
    except ValueError:
        length = math.nan
    if not (math.isfinite(length) and length >= 0.0):
        raise FileError(f"{where}: the length must be a number, 0 or more, got {text!r}")
    mantissa, _, exponent = text.lower().partition("e")
    digits = len(mantissa.partition(".")[2]) - int(exponent or 0)
    return length, 0.5 * 10.0**-digits + 1e-6 * length


def solve_scenarios(
    costs: CostMap,
    scenarios: Scenarios,
    *,
    on_event: Callable[[float, str], None] | None = None,
) -> F64:
    """Lengths (n,) [cells] of the shortest ways, in order; inf where there is none.

    Args:
        costs: The map.
        scenarios: What is asked for.
        on_event: Told now and then the share that is done, and a few words.

    Raises:
        InputError: A start or goal is not a free cell of the map.
    """
    ends = np.concatenate([scenarios.start, scenarios.goal])
    if (ends < 0).any() or (ends >= costs.frame.shape).any():
        raise InputError("a scenario lies beyond the map; read it with the map that it is for")
    if not np.isfinite(costs.cost[tuple(ends.T)]).all():
        raise InputError("a scenario begins or ends in a forbidden cell")
    grid = GridSearch(costs, again=True)
    lengths = np.empty(len(scenarios))
    for n, (start, goal) in enumerate(zip(scenarios.start, scenarios.goal, strict=True)):
        if on_event is not None and n % 64 == 0:
            on_event(n / len(scenarios), f"{n:,} of {len(scenarios):,} scenarios")
        lengths[n] = grid.distance((int(start[0]), int(start[1])), (int(goal[0]), int(goal[1])))
    return lengths
