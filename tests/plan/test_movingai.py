from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rovernav.core import FileError, InputError
from rovernav.plan import Scenarios, read_map, read_scenarios, shortest, solve_scenarios

MAP = """type octile
height 3
width 4
map
.@..
.@G.
...T
"""
SCEN = """version 1
0\tm.map\t4\t3\t0\t0\t2\t1\t4.00000000
1 m.map 4 3 0 2 2 2 2
1\tm.map\t4\t3\t2\t1\t3\t0\t1.41421
"""
FAST = ("dao/arena", "dao/lak303d", "cities/Berlin_0_256")


@pytest.fixture
def files(tmp_path: Path) -> tuple[Path, Path]:
    grid, scen = tmp_path / "m.map", tmp_path / "m.map.scen"
    grid.write_text(MAP)
    scen.write_text(SCEN)
    return grid, scen


def test_rows_go_from_north_to_south(files: tuple[Path, Path]) -> None:
    costs = read_map(files[0])
    blocked = [
        [False, False, False, True],
        [False, True, False, False],
        [False, True] + [False] * 2,
    ]
    np.testing.assert_array_equal(costs.forbidden, blocked)
    assert (costs.unit, costs.frame.cell, costs.least, costs.most) == ("m", 1.0, 1.0, 1.0)


def test_scenarios_in_order_of_the_file(files: tuple[Path, Path]) -> None:
    costs = read_map(files[0])
    scenarios = read_scenarios(files[1], costs)
    assert len(scenarios) == 3
    np.testing.assert_array_equal(scenarios.start, [[2, 0], [0, 0], [1, 2]])
    np.testing.assert_array_equal(scenarios.goal, [[1, 2], [0, 2], [2, 3]])
    assert_allclose(scenarios.tolerance, [0.5e-8 + 4e-6, 0.5 + 2e-6, 0.5e-5 + 1.41421e-6])
    lengths = solve_scenarios(costs, scenarios)
    assert_allclose(lengths, [5.0, 2.0, np.sqrt(2)], atol=1e-12)  # no corner is cut


def test_no_way_is_infinitely_long(files: tuple[Path, Path]) -> None:
    files[0].write_text(MAP.replace("...T", ".@.T"))
    costs = read_map(files[0])
    lengths = solve_scenarios(costs, read_scenarios(files[1], costs))
    np.testing.assert_array_equal(np.isfinite(lengths), [False, False, True])


def test_it_tells_how_far_it_is(files: tuple[Path, Path]) -> None:
    told: list[tuple[float, str]] = []
    costs = read_map(files[0])
    solve_scenarios(
        costs,
        read_scenarios(files[1], costs),
        on_event=lambda share, words: told.append((share, words)),
    )
    assert told == [(0.0, "0 of 3 scenarios")]


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("type octile", "no such", "is no MovingAI map: it must begin with"),
        ("height 3", "height 0", "height must be from 1 to 8,192, got '0'"),
        ("height 3", "height 99999999999", "height must be from 1 to 8,192"),
        ("width 4", "width four", "width must be from 1 to 8,192, got 'four'"),
        ("width 4\n", "", "width must be from 1 to 8,192, got ''"),
        ("height 3", "height 4", "ends after 3 of 4 rows"),
        ("height 3", "height 2", "goes on after its 2 rows: '...T'"),
        (".@G.", ".@G", "row 1: 3 cells, but the width is 4"),
        (".@G.", ".@x.", "row 1, column 2: unknown cell 'x'"),
        (".@G.", ".@é.", "row 1, column 2: unknown cell 'é'"),
    ],
)
def test_a_bad_map(files: tuple[Path, Path], old: str, new: str, words: str) -> None:
    files[0].write_text(MAP.replace(old, new), encoding="utf-8")
    with pytest.raises(FileError) as told:
        read_map(files[0])
    assert words in str(told.value)
    assert str(told.value).startswith(str(files[0]))


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("version 1", "# 1", "is no MovingAI scenario file"),
        (
            "\t4\t3\t0\t0",
            "\t9\t3\t0\t0",
            "line 2: for a map of 9 x 3 cells, but this one has 4 x 3",
        ),
        ("\t2\t1\t3\t0", "\t2\t1\t4\t0", "line 4: a cell lies beyond the map of 4 x 3 cells"),
        ("\t2\t1\t3\t0", "\t2\t1\t-1\t0", "line 4: a cell lies beyond the map"),
        ("\t2\t1\t3\t0", "\t1\t1\t3\t0", "line 4: the start (1, 1) is a blocked cell of this map"),
        ("\t2\t1\t3\t0", "\t2\t1\t3\t2", "line 4: the goal (3, 2) is a blocked cell of this map"),
        ("\t1.41421", "", "line 4: 8 columns, but a scenario has 9"),
        ("1.41421", "nan", "line 4: the length must be a number, 0 or more, got 'nan'"),
        ("1.41421", "-1", "line 4: the length must be a number, 0 or more, got '-1'"),
        ("\t2\t1\t3\t0", "\t2.5\t1\t3\t0", "line 4: sizes and cells must be whole numbers"),
        (SCEN.partition("\n")[2], "", "holds no scenario"),
        (SCEN, "", "is no MovingAI scenario file"),
    ],
)
def test_a_bad_scenario_file(files: tuple[Path, Path], old: str, new: str, words: str) -> None:
    assert old in SCEN
    files[1].write_text(SCEN.replace(old, new))
    with pytest.raises(FileError) as told:
        read_scenarios(files[1], read_map(files[0]))
    assert words in str(told.value)


def test_scenarios_of_another_map(files: tuple[Path, Path]) -> None:
    costs = read_map(files[0])
    far = Scenarios(
        start=np.array([[0, 0]]), goal=np.array([[5, 5]]), optimal=np.ones(1), tolerance=np.ones(1)
    )
    with pytest.raises(InputError, match="lies beyond the map"):
        solve_scenarios(costs, far)
    blocked = Scenarios(
        start=np.array([[0, 0]]), goal=np.array([[0, 3]]), optimal=np.ones(1), tolerance=np.ones(1)
    )
    with pytest.raises(InputError, match="begins or ends in a forbidden cell"):
        solve_scenarios(costs, blocked)


def published(data_dir: Path, name: str) -> None:
    """Every scenario of a map has its published length, to the digits printed."""
    grid = data_dir / "movingai" / f"{name}.map"
    costs = read_map(grid)
    scenarios = read_scenarios(grid.with_name(f"{grid.name}.scen"), costs)
    lengths = solve_scenarios(costs, scenarios)
    off = np.abs(lengths - scenarios.optimal)
    assert (off <= scenarios.tolerance).all(), (int(off.argmax()), off.max())
    middles = [
        costs.frame.centre_of(*map(int, ends[-1])) for ends in (scenarios.start, scenarios.goal)
    ]
    assert_allclose(shortest(costs, *middles).length, lengths[-1], rtol=1e-12)


@pytest.mark.data
@pytest.mark.parametrize("name", FAST)
def test_published_lengths(data_dir: Path, name: str) -> None:
    published(data_dir, name)


@pytest.mark.data
@pytest.mark.long
def test_every_published_length(data_dir: Path) -> None:
    names = sorted((data_dir / "movingai").glob("*/*.map"))
    assert len(names) == 14
    for path in names:
        published(data_dir, f"{path.parent.name}/{path.stem}")
