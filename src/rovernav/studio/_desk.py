"""The pattern table on the desk: each edit that makes sense goes to the training at once."""

from __future__ import annotations

from typing import final

from ..core import FileError, PatternError
from ..learn import Patterns, parse_patterns, shipped_patterns, shipped_tables
from ._table import TableDraft
from ._training import TrainModel

MAX_CSV = 2_000_000
"""Bytes of a table that is sent to the page."""


@final
class TableDesk:
    """Holds the draft of a table, and what is wrong with it, beside the training that learns it.

    Args:
        model: Receives each table without mistakes.
    """

    def __init__(self, model: TrainModel) -> None:
        self._model = model
        self._seen = model.setup.table
        self._draft = TableDraft(self._seen)
        self.said = ""

    @property
    def draft(self) -> TableDraft:
        """The table as it stands; made anew where the training got another one elsewhere."""
        if self._model.setup.table is not self._seen:
            self._seen = self._model.setup.table
            self._draft = TableDraft(self._seen)
            self.said = ""
        return self._draft

    @property
    def handed_over(self) -> Patterns:
        """The table that the draft was last given to the training as, or made from."""
        return self._seen

    def set_cell(self, row: int, column: int, text: str) -> str:
        """Write into a cell; returns what is wrong with it, or nothing."""
        draft = self.draft
        if not (0 <= row < len(draft.cells) and 0 <= column < len(draft.names)):
            return ""
        draft.cells[row][column] = str(text)[:60]
        self._hand_over()
        return draft.problem(row, column)

    def set_name(self, column: int, text: str) -> str:
        """Name a column; returns what is wrong with the name, or nothing."""
        draft = self.draft
        if not 0 <= column < len(draft.names):
            return ""
        draft.names[column] = str(text)[:200]
        self._hand_over()
        return draft.name_problem(column)

    def add_row(self) -> None:
        """One more pattern."""
        self.draft.add_row()
        self._hand_over()

    def remove_row(self, row: int) -> None:
        """One pattern less."""
        self.draft.remove_row(row)
        self._hand_over()

    def add_column(self, *, target: bool) -> None:
        """One more input or target; the network grows with it."""
        self.draft.add_column(target=target)
        self._hand_over()

    def remove_column(self, column: int) -> None:
        """One input or target less."""
        self.draft.remove_column(column)
        self._hand_over()

    def load_shipped(self, name: str) -> None:
        """A table that comes with the package."""
        self._take(shipped_patterns(name))

    def load_csv(self, name: str, data: bytes) -> None:
        """A table that somebody sent.

        Raises:
            PatternError: It cannot be used; the line and what is wrong with it.
            FileError: It is no text.
        """
        if len(data) > MAX_CSV:
            raise FileError(f"{name} has {len(data):,} bytes, at most {MAX_CSV:,} are taken")
        try:
            text = data.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            raise FileError(f"{name} is not UTF-8 text (byte {error.start})") from None
        if "\0" in text:
            raise FileError(f"{name} is not text: it holds a zero byte")
        table = parse_patterns(text, name, inputs=None if _marked(text) else 2)
        for column in TableDraft(table).names:
            if not column.isprintable():
                raise PatternError(f"{name}: a column's name holds what cannot be shown")
        self._take(table)

    def _take(self, table: Patterns) -> None:
        self._model.change(table=table, shipped=shipped_name(table))
        self.said = ""

    def _hand_over(self) -> None:
        """Give the table to the training if nothing in it is wrong."""
        try:
            table = self._draft.patterns()
            shipped = shipped_name(table)
            if not shipped and not table.source.endswith("(edited)"):
                self._draft.source = f"{table.source} (edited)"
                table = self._draft.patterns()
            self._model.change(table=table, shipped=shipped)
        except PatternError as error:
            self.said = f"The training keeps the table without this: {error}"
            return
        self._seen = table
        self.said = ""


def shipped_name(table: Patterns) -> str:
    """The shipped table that has the same names and numbers; nothing if none has."""
    for name in shipped_tables():
        if shipped_patterns(name).sha256 == table.sha256:
            return name
    return ""


def _marked(text: str) -> bool:
    """Whether the first line that counts marks its columns with in: and out:."""
    lines = (line.strip() for line in text.splitlines())
    first = next((line for line in lines if line and not line.startswith("#")), "")
    return ":" in first
