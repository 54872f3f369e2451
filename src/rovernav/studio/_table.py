"""A pattern table while it is being edited: texts in cells, each with what is wrong with it."""

from __future__ import annotations

from typing import final

import numpy as np

from ..core import PatternError
from ..learn import Patterns, parse_number
from ._setup import MAX_COLUMNS, MAX_ROWS

MAX_NAME = 40


@final
class TableDraft:
    """Names and cells as they stand in the page, inputs before targets.

    Args:
        table: What to begin with.
    """

    def __init__(self, table: Patterns) -> None:
        self.inputs = table.x.shape[1]
        self.names = [*table.inputs, *table.outputs]
        self.cells = [[shortest(n) for n in row] for row in np.hstack([table.x, table.y])]
        self.source = table.source

    @property
    def outputs(self) -> int:
        """Columns that are targets."""
        return len(self.names) - self.inputs

    def problem(self, row: int, column: int) -> str:
        """What is wrong with a cell, as a sentence; nothing where it is a number."""
        try:
            parse_number(self.cells[row][column])
        except PatternError as error:
            return f"{str(error)[:1].upper()}{str(error)[1:]}."
        return ""

    def name_problem(self, column: int) -> str:
        """What is wrong with the name of a column; nothing where it can be used."""
        name = self.names[column].strip()
        kind = range(self.inputs) if column < self.inputs else range(self.inputs, len(self.names))
        if not name:
            return "The column needs a name."
        if len(name) > MAX_NAME or not name.isprintable():
            return f"A name has at most {MAX_NAME} letters that can be shown."
        if any(self.names[other].strip() == name for other in kind if other != column):
            return f"{name!r} stands twice."
        return ""

    def first_problem(self) -> str:
        """The first thing that is wrong anywhere, and where; nothing if all is well."""
        for column in range(len(self.names)):
            if problem := self.name_problem(column):
                return f"Column {column + 1}: {problem}"
        for row in range(len(self.cells)):
            for column, name in enumerate(self.names):
                if problem := self.problem(row, column):
                    return f"Pattern {row + 1}, {name}: {problem}"
        return ""

    def patterns(self) -> Patterns:
        """The table.

        Raises:
            PatternError: Something in it is wrong; the first of it, and where.
        """
        if problem := self.first_problem():
            raise PatternError(problem)
        numbers = np.array([[parse_number(cell) for cell in row] for row in self.cells])
        names = tuple(name.strip() for name in self.names)
        return Patterns(
            x=numbers[:, : self.inputs],
            y=numbers[:, self.inputs :],
            inputs=names[: self.inputs],
            outputs=names[self.inputs :],
            source=self.source,
        )

    def add_row(self) -> None:
        """One more pattern, all zeros.

        Raises:
            PatternError: The table is full.
        """
        if len(self.cells) >= MAX_ROWS:
            raise PatternError(f"the page holds {MAX_ROWS:,} patterns at most")
        self.cells.append(["0"] * len(self.names))

    def remove_row(self, row: int) -> None:
        """One pattern less.

        Raises:
            PatternError: It is the last one, or there is none of that number.
        """
        if len(self.cells) == 1:
            raise PatternError("a pattern table needs at least one pattern")
        if not 0 <= row < len(self.cells):
            raise PatternError(f"there is no pattern {row + 1}")
        del self.cells[row]

    def add_column(self, *, target: bool) -> None:
        """One more input or target, all zeros.

        Raises:
            PatternError: The table is full.
        """
        if len(self.names) >= MAX_COLUMNS:
            raise PatternError(f"the page holds {MAX_COLUMNS} columns at most")
        at = len(self.names) if target else self.inputs
        taken = self.names[self.inputs :] if target else self.names[: self.inputs]
        stem = "out" if target else "in"
        number = next(n for n in range(1, MAX_COLUMNS + 2) if f"{stem}{n}" not in taken)
        self.names.insert(at, f"{stem}{number}")
        for row in self.cells:
            row.insert(at, "0")
        self.inputs += not target

    def remove_column(self, column: int) -> None:
        """One input or target less.

        Raises:
            PatternError: It is the last of its kind, or there is none of that number.
        """
        if not 0 <= column < len(self.names):
            raise PatternError(f"there is no column {column + 1}")
        kind = self.inputs if column < self.inputs else self.outputs
        if kind == 1:
            raise PatternError("a table needs at least one input and one target")
        self.inputs -= column < self.inputs
        del self.names[column]
        for row in self.cells:
            del row[column]


def shortest(number: float) -> str:
    """The shortest text that reads back as the number; whole numbers without a point."""
    text = repr(float(number))
    return text[:-2] if text.endswith(".0") else text
