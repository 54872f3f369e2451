from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from rovernav.core import FileError, PatternError
from rovernav.learn import (
    Patterns,
    read_patterns,
    shipped_patterns,
    shipped_tables,
    write_patterns,
)
from tests.bits import assert_same_bits


def read(folder: Path, text: str | bytes, inputs: int | None = None) -> Patterns:
    path = folder / "t.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_patterns(path, inputs=inputs)


SAME = {"x": [[1, 2], [-3, 0.5]], "y": [[0.001], [40]]}


@pytest.mark.parametrize(
    ("text", "inputs"),
    [
        ("in:a,in:b,out:c\n1,2,1e-3\n-3,.5,4E1\n", None),
        ("in:a,in:b,out:c\n1,2,1e-3\n-3,.5,4E1", 2),
        ("a,b,c\n1,2,1e-3\n-3,.5,4E1\n", 2),
        ("out:c,in:a,in:b\n1e-3,1,2\n4E1,-3,.5\n", None),
        ("in:a,out:c,in:b\n.001,1e-3,2\n", None),
        ("INPUT: a ,target:c,Input:b\n+1,0.001,2.\n-3,40,0.5\n", None),
        ("\ufeffin:a,in:b,out:c\r\n1,2,1e-3\r\n-3,.5,4E1\r\n", None),
        ("in:a,in:b,out:c\r1,2,1e-3\r-3,.5,4E1\r", None),
        ('# a,"comment\n\n"in:a","in:b",out:c\n  # and\n"1",2,1e-3\n , ,\n-3,.5,"4E1"\n#', None),
        (" in:a , in:b , out:c \n 1 , 2 , 1e-3 \n\t-3,.5,4E1\n", None),
    ],
)
def test_tables_that_mean_the_same(tmp_path: Path, text: str, inputs: int | None) -> None:
    table = read(tmp_path, text, inputs)
    assert (table.inputs, table.outputs) == (("a", "b"), ("c",))
    assert table.y[0, 0] == 0.001
    if len(table.x) == 2:
        assert {"x": table.x.tolist(), "y": table.y.tolist()} == SAME
    assert table.source == "t.csv"
    assert table.x.flags.c_contiguous
    assert table.y.flags.c_contiguous


def test_names_may_hold_anything_in_quotes(tmp_path: Path) -> None:
    table = read(tmp_path, '"in:a,\n#""b""",out:in:x\n1,2\n')
    assert (table.inputs, table.outputs) == (('a,\n#"b"',), ("in:x",))


HEAD = "in:a,in:b,out:c\n"
MARK = "mark the columns as in:NAME or out:NAME, or give the topology"


@pytest.mark.parametrize(
    ("text", "inputs", "message"),
    [
        ("", None, " is empty; line 1 must name the columns, like in:x,out:y"),
        ("\n \n,,\n# x\n", None, " is empty; line 1 must name the columns, like in:x,out:y"),
        (HEAD, None, " has a header but no pattern; add at least one line of numbers"),
        (HEAD + "# 1,2,3\n\n", None, " has a header but no pattern; add at least one line of n"),
        ("a,b\n1,2\n", None, f", line 1: {MARK}"),
        ("# x\n\na,b\n1,2\n", None, f", line 3: {MARK}"),
        ("1,2,3\n4,5,6\n", 2, ", line 1: the first line must name the columns, got numbers"),
        ("in:a,b,out:c\n1,2,3\n", None, ", line 1: column 'b' is marked neither in: nor out:"),
        ("in:a,in:b\n1,2\n", None, ", line 1: a table needs inputs and targets, got 2 and 0"),
        ("out:a\n1\n", None, ", line 1: a table needs inputs and targets, got 0 and 1"),
        ("a,b\n1,2\n", 2, ", line 1: a table needs inputs and targets, got 2 and 0"),
        ("a,b\n1,2\n", -1, ", line 1: a table needs inputs and targets, got 0 and 2"),
        ("a,b\n1,2\n", 3, ", line 1: a table needs inputs and targets, got 2 and 0"),
        (HEAD + "1,2,3\n", 3, ", line 1: 2 inputs, but the topology has 3"),
        ("in:a,,out:c\n1,2,3\n", None, ", line 1: column 2 has no name"),
        ("in:a,out:c,\n1,2,3\n", None, ", line 1: column 3 has no name"),
        ("in:a,in: ,out:c\n1,2,3\n", None, ", line 1: column 2 has no name"),
        ("in:a,in:a,out:c\n1,2,3\n", None, ", line 1: column name 'in:a' stands twice"),
        ("in:a,out:c,input: a\n1,2,3\n", None, ", line 1: column name 'in:a' stands twice"),
        ("a,b,a\n1,2,3\n", 2, ", line 1: column name 'a' stands twice"),
        (HEAD + "1,2,3\n1,2\n", None, ", line 3: 3 cells needed, got 2"),
        (HEAD + "1,2,3,4\n", None, ", line 2: 3 cells needed, got 4"),
        (HEAD + "1;2;3\n", None, ", line 2: 3 cells needed, got 1"),
        (HEAD + "1,x,3\n", None, ", line 2, column 'in:b': 'x' is not a number"),
        (HEAD + "1,,3\n", None, ", line 2, column 'in:b': the cell is empty"),
        (HEAD + "1, ,3\n", None, ", line 2, column 'in:b': the cell is empty"),
        (HEAD + "1,1_000,3\n", None, ", line 2, column 'in:b': '1_000' is not a number"),
        (HEAD + "1,0x10,3\n", None, ", line 2, column 'in:b': '0x10' is not a number"),
        (HEAD + "1,1d3,3\n", None, ", line 2, column 'in:b': '1d3' is not a number"),
        (HEAD + "1,true,3\n", None, ", line 2, column 'in:b': 'true' is not a number"),
        (HEAD + "1,-,3\n", None, ", line 2, column 'in:b': '-' is not a number"),
        (HEAD + "1,2 3,3\n", None, ", line 2, column 'in:b': '2 3' is not a number"),
        (HEAD + "1," + "y" * 99 + ",3\n", None, f", line 2, column 'in:b': '{'y' * 40}' is not a"),
        (HEAD + "1,2,nan\n", None, ", line 2, column 'out:c': nan is not finite"),
        (HEAD + "-INF,2,3\n", None, ", line 2, column 'in:a': -INF is not finite"),
        (HEAD + "\n#\n1,2, 1e999\n", None, ", line 4, column 'out:c': 1e999 is not finite"),
        (HEAD + '1,2,"3\n1,2,3\n', None, ", line 2: unexpected end of data"),
        (HEAD + '1,2,"3"x\n', None, ", line 2: ',' expected after '\"'"),
        (HEAD + "1,2,\0\n", None, ", line 2, column 'out:c': '\\x00' is not a number"),
        (HEAD + "1,2," + "3" * 140_000, None, ", line 2: field larger than field limit (131072)"),
    ],
)
def test_tables_that_cannot_be_used(
    tmp_path: Path, text: str, inputs: int | None, message: str
) -> None:
    with pytest.raises(PatternError) as caught:
        read(tmp_path, text, inputs)
    said = str(caught.value).removeprefix(str(tmp_path / "t.csv"))
    assert said.startswith(message)
    assert len(said) < 130
    assert "\n" not in said


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (
            "in:ä,out:b\n1,2\n".encode("latin-1"),
            r"is not UTF-8 text \(byte 3\); save the pattern ta",
        ),
        ("in:a,out:b\n1,2\n".encode("utf-16"), r"is not UTF-8 text \(byte 0\)"),
        (b"PK\x03\x04\xff\xfe", r"is not UTF-8 text \(byte 4\)"),
    ],
)
def test_files_that_are_no_text(tmp_path: Path, content: bytes, message: str) -> None:
    with pytest.raises(FileError, match=message):
        read(tmp_path, content)


def test_a_missing_table(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"there is no pattern table at .*t\.csv; check the path"):
        read_patterns(tmp_path / "t.csv")


number = st.floats(allow_nan=False, allow_infinity=False)
name = st.text(st.characters(codec="utf-8", exclude_categories=["Cc", "Zl", "Zp"]), min_size=1)
names = st.lists(name.map(str.strip).filter(bool), min_size=1, max_size=4, unique=True)


@given(data=st.data())
def test_what_was_written_is_read(data: st.DataObject, tmp_path_factory: Any) -> None:
    inputs, outputs = tuple(data.draw(names)), tuple(data.draw(names))
    rows = data.draw(st.integers(1, 5))
    x = data.draw(arrays(np.float64, (rows, len(inputs)), elements=number))
    y = data.draw(arrays(np.float64, (rows, len(outputs)), elements=number))
    table = Patterns(x=x, y=y, inputs=inputs, outputs=outputs)
    path = tmp_path_factory.mktemp("t") / "t.csv"
    write_patterns(table, path)
    again = read_patterns(path)
    assert (again.inputs, again.outputs) == (inputs, outputs)
    assert_same_bits(again.x, x)
    assert_same_bits(again.y, y)
    assert again.sha256 == table.sha256


def table(**changes: Any) -> Patterns:
    plain: dict[str, Any] = {"x": np.zeros((2, 1)), "y": np.ones((2, 1))}
    plain |= {"inputs": ("a",), "outputs": ("b",)}
    return Patterns(**{**plain, **changes})


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"x": np.zeros((3, 1))}, r"x \(p, 1\) and y \(p, 1\), got \(3, 1\) and \(2, 1\)"),
        ({"x": np.zeros(2)}, r"got \(2,\) and \(2, 1\)"),
        ({"y": np.zeros(2)}, r"got \(2, 1\) and \(2,\)"),
        ({"y": np.zeros(2), "outputs": ("b", "c")}, r"y \(p, 2\), got \(2, 1\) and \(2,\)"),
        ({"inputs": ("a", "b")}, r"x \(p, 2\) and"),
        ({"x": np.zeros((0, 1)), "y": np.zeros((0, 1))}, "needs at least one pattern"),
        ({"x": np.array([[1.0], [np.nan]])}, "patterns must be finite numbers"),
        ({"y": np.array([[1.0], [np.inf]])}, "patterns must be finite numbers"),
    ],
)
def test_patterns_that_cannot_be(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(PatternError, match=message):
        table(**changes)


def test_any_dtype_and_layout_becomes_one() -> None:
    x = np.arange(6).reshape(2, 3)
    plain = table(x=x.astype(np.float64), inputs=("a", "b", "c"))
    for same in (x, x.astype(np.float32), np.asfortranarray(x), np.repeat(x, 2, axis=1)[:, ::2]):
        other = table(x=same, inputs=("a", "b", "c"))
        assert_same_bits(other.x, plain.x)
        assert other.x.flags.c_contiguous
        assert not other.x.flags.writeable
        assert other.sha256 == plain.sha256


def test_the_hash_covers_names_and_numbers() -> None:
    tables = [
        table(),
        table(x=np.full((2, 1), 1e-300)),
        table(y=np.full((2, 1), 1 + 1e-15)),
        table(inputs=("c",)),
        table(outputs=("c",)),
    ]
    assert len({t.sha256 for t in tables}) == 5
    assert table(source="elsewhere").sha256 == table().sha256


def test_shipped_tables_are_the_papers() -> None:
    assert shipped_tables() == ["bassil-replay-v1", "bassil-v1"]
    paper, replay = shipped_patterns("bassil-v1"), shipped_patterns("bassil-replay-v1")
    for each in (paper, replay):
        assert each.inputs == ("clear_sight", "off_line")
        assert each.outputs == ("motor_x", "motor_y")
        assert each.x.tolist() == [[0, 0], [0, 1], [1, 1], [1, 0]]
    assert paper.y.tolist() == [[1, 1], [1, 1], [1, -1], [1, 0]]
    assert replay.y.tolist() == [
        [0.8287, 0.8287], [0.807217, 0.844883], [0.865429, -0.842571], [0.865429, 0],
    ]  # fmt: skip
    with pytest.raises(PatternError, match="there is no pattern table 'bassil'; did you mean 'ba"):
        shipped_patterns("bassil")
