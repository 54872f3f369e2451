"""The pattern table in the Train tab."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from nicegui import events, ui

from ..core import RovernavError
from ..learn import shipped_tables
from ._desk import MAX_CSV
from ._session import Session
from ._uploads import refuse, upload_button

PER_PAGE = 10


def table_card(session: Session, on_shown: Callable[[], None]) -> Callable[[], None]:
    """The table with its buttons; returns what to call when the training got another table.

    Args:
        session: Whose table.
        on_shown: Called when another pattern is to be shown in the drawings.
    """
    desk, train = session.desk, session.train

    def act(action: Callable[[], object]) -> Callable[[], None]:
        def perform() -> None:
            try:
                action()
            except RovernavError as error:
                refuse(str(error))
            refresh()

        return perform

    def load(name: str, data: bytes) -> None:
        desk.load_csv(name, data)
        refresh()

    def choose(event: events.ValueChangeEventArguments[Any]) -> None:
        if event.value in shipped_tables() and event.value != train.setup.shipped:
            act(lambda: desk.load_shipped(event.value))()

    with ui.column().classes("rn-card w-full"):
        with ui.row().classes("w-full items-center gap-2 no-wrap"):
            ui.label("Patterns").classes("rn-title").props("role=heading aria-level=2")
            ui.space()
            names = {"": "own table", **{name: name for name in shipped_tables()}}
            pick = (
                ui.select(names, value=train.setup.shipped, on_change=choose)
                .props('dense options-dense borderless aria-label="Shipped tables"')
                .mark("shipped")
            )
            upload_button("CSV", kinds=(".csv", ".txt"), limit=MAX_CSV, on_file=load).props(
                'aria-label="Load a table from a CSV file"'
            )
        grid = ui.column().classes("w-full gap-1")
        problem = ui.label().classes("rn-note rn-bad").props("role=alert")
        with ui.row().classes("gap-1"):
            _small("pattern", act(desk.add_row), "Add a pattern")
            _small("input", act(lambda: desk.add_column(target=False)), "Add an input")
            _small("target", act(lambda: desk.add_column(target=True)), "Add a target")

    def say() -> None:
        problem.text = desk.said
        problem.visible = bool(desk.said)

    def refresh() -> None:
        pick.value = train.setup.shipped
        grid.clear()
        with grid:
            _Grid(session, say, refresh, on_shown, act).build()
        say()
        on_shown()

    refresh()
    return refresh


class _Grid:
    """The rows of one page of the table."""

    def __init__(
        self,
        session: Session,
        say: Callable[[], None],
        refresh: Callable[[], None],
        on_shown: Callable[[], None],
        act: Callable[[Callable[[], object]], Callable[[], None]],
    ) -> None:
        self.session, self.desk, self.draft = session, session.desk, session.desk.draft
        self.say, self.refresh, self.on_shown, self.act = say, refresh, on_shown, act
        self.eyes: dict[int, ui.button] = {}

    def build(self) -> None:
        rows = len(self.draft.cells)
        pages = -(-rows // PER_PAGE)
        self.session.page = max(1, min(self.session.page, pages))
        first = (self.session.page - 1) * PER_PAGE
        columns = "26px " + "minmax(54px, 1fr) " * len(self.draft.names) + "26px"
        with (
            ui.element("div").classes("w-full overflow-x-auto"),
            ui.element("div").classes("rn-grid").style(f"grid-template-columns: {columns}"),
        ):
            self._heads()
            for row in range(first, min(rows, first + PER_PAGE)):
                self._row(row)
        if pages > 1:
            ui.pagination(1, pages, value=self.session.page, on_change=self._turn).props(
                "dense max-pages=6"
            )
            ui.label(f"{rows:,} patterns").classes("rn-note")

    def _turn(self, event: events.ValueChangeEventArguments[Any]) -> None:
        if isinstance(event.value, int):
            self.session.page = event.value
            self.refresh()

    def _heads(self) -> None:
        ui.element("div")
        for column in range(len(self.draft.names)):
            with ui.element("div").classes("rn-kind"):
                ui.label("input" if column < self.draft.inputs else "target").classes("rn-note")
                remove = self.act(lambda c=column: self.desk.remove_column(c))
                _cross(remove, f"Remove column {column + 1}")
        ui.element("div")
        ui.element("div")
        for column, name in enumerate(self.draft.names):
            field = self._field(name, f"Name of column {column + 1}", f"name-{column}")
            field.classes("rn-name-field").tooltip(name)
            field.validation = lambda text, c=column: self._name(c, text)
        ui.element("div")

    def _row(self, row: int) -> None:
        shown = self.session.shown == row
        eye = ui.button(
            icon="visibility" if shown else "radio_button_unchecked",
            on_click=lambda: self._show(row),
            color=None,
        ).props(f'flat dense round size=xs aria-label="Show pattern {row + 1}"')
        eye.classes("rn-eye" + (" rn-on" if shown else ""))
        self.eyes[row] = eye
        for column in range(len(self.draft.names)):
            text = self.draft.cells[row][column]
            label = f"Pattern {row + 1}, {self.draft.names[column]}"
            field = self._field(text, label, f"cell-{row}-{column}")
            field.validation = lambda new, r=row, c=column: self._cell(r, c, new)
        _cross(self.act(lambda: self.desk.remove_row(row)), f"Remove pattern {row + 1}")

    def _field(self, text: str, label: str, mark: str) -> ui.input:
        field = ui.input(value=text).mark(mark)
        field.props["aria-label"] = label
        return field.props("dense outlined hide-bottom-space debounce=250").classes("rn-cell")

    def _show(self, row: int) -> None:
        self.session.shown = row
        for number, eye in self.eyes.items():
            on = number == row
            eye.props(f"icon={'visibility' if on else 'radio_button_unchecked'}")
            eye.classes(add="rn-on" if on else "", remove="" if on else "rn-on")
        self.on_shown()

    def _cell(self, row: int, column: int, text: str | None) -> str | None:
        if text == self.draft.cells[row][column]:
            return self.draft.problem(row, column) or None
        wrong = self.desk.set_cell(row, column, text or "")
        self.say()
        return wrong or None

    def _name(self, column: int, text: str | None) -> str | None:
        if text == self.draft.names[column]:
            return self.draft.name_problem(column) or None
        wrong = self.desk.set_name(column, text or "")
        self.say()
        return wrong or None


def _small(words: str, action: Callable[[], None], label: str) -> None:
    ui.button(words, icon="add", on_click=action, color=None).props(
        f'flat dense no-caps size=sm aria-label="{label}"'
    ).mark(f"add-{words}")


def _cross(action: Callable[[], None], label: str) -> None:
    ui.button(icon="close", on_click=action, color=None).props(
        f'flat dense round size=xs aria-label="{label}"'
    ).classes("rn-cross")
