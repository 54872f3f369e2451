"""The Runs tab: what was kept, to be found, compared, taken along and done again."""

from __future__ import annotations

import html
import time
from collections.abc import Callable, Sequence
from typing import Any

from nicegui import events, run, ui

from ..core import RovernavError
from ._kept_files import archive, archive_name
from ._kinds import KINDS
from ._library import Run
from ._runs_desk import COMPARED
from ._session import Session
from ._uploads import refuse


def runs_tab(session: Session) -> None:
    """Build the tab in the present container."""
    _RunsTab(session).build()


class _RunsTab:
    """The elements of the tab; what is listed and marked stands in the session's desk."""

    def __init__(self, session: Session) -> None:
        self.session, self.desk, self.library = session, session.runs, session.library
        self.seen: object = None

    def build(self) -> None:
        with ui.element("div").classes("rn-runs") as self.grid:
            with ui.column().classes("rn-card rn-runs-list"):
                with ui.row().classes("w-full items-center no-wrap"):
                    ui.label("Kept runs").classes("rn-title").props("role=heading aria-level=2")
                    ui.space()
                    kinds = {"": "All", **{name: kind.label for name, kind in KINDS.items()}}
                    ui.toggle(kinds, value=self.desk.kind or "", on_change=self._filter).props(
                        'dense no-caps unelevated size=sm aria-label="Kinds"'
                    )
                self.list = ui.column().classes("w-full gap-0")
            self.details = ui.column().classes("rn-card rn-runs-open")
            self.compared = ui.column().classes("rn-card rn-runs-compared")
        ui.timer(1.0, self._refresh)

    def _refresh(self) -> None:
        """Show what the library holds, if it or the choice has changed."""
        try:
            runs = self.desk.listed()
        except RovernavError as error:
            refuse(str(error))
            return
        desk = self.desk
        mark = ([(r.id, r.title) for r in runs], desk.page, desk.opened, list(desk.marked))
        if mark == self.seen:
            return
        self.seen = mark
        self._list(runs)
        self._open()
        self._compare()

    def _now(self) -> None:
        self.seen = None
        self._refresh()

    def _filter(self, event: events.ValueChangeEventArguments[Any]) -> None:
        self.desk.kind = event.value if event.value in KINDS else None
        self.desk.page = 1
        self._now()

    def _list(self, runs: list[Run]) -> None:
        self.list.clear()
        with self.list:
            if not runs:
                ui.label(
                    "Nothing is kept yet. A training or a drive that ends is kept by itself."
                ).classes("rn-note")
            for one in self.desk.on_page(runs):
                self._row(one)
            if self.desk.pages(runs) > 1:
                ui.pagination(1, self.desk.pages(runs), value=self.desk.page,
                              on_change=self._turn).props("dense max-pages=7")  # fmt: skip

    def _row(self, one: Run) -> None:
        kind = KINDS.get(one.kind)
        opened = " rn-opened" if one.id == self.desk.opened else ""
        with ui.row().classes(f"rn-run-row w-full items-center no-wrap gap-2{opened}"):
            box = ui.checkbox(
                value=one.id in self.desk.marked, on_change=lambda e: self._mark(one.id, e.value)
            ).props("dense size=sm")
            box.props["aria-label"] = f"Compare {one.title}"
            ui.icon(kind.icon if kind else "help").classes("rn-note text-base")
            with (
                ui.button(on_click=lambda: self._show(one.id), color=None)
                .props("flat no-caps dense align=left")
                .classes("grow rn-run")
                .mark("run"),
                ui.column().classes("gap-0 items-start"),
            ):
                ui.label(one.title).classes("rn-run-title")
                ui.label(f"{_when(one.created)}, {kind.result(one) if kind else ''}").classes(
                    "rn-note"
                )

    def _turn(self, event: events.ValueChangeEventArguments[Any]) -> None:
        if isinstance(event.value, int):
            self.desk.page = event.value
            self._now()

    def _mark(self, which: str, on: Any) -> None:
        self.desk.mark(which, bool(on))
        self._now()

    def _show(self, which: str) -> None:
        self.desk.opened = which
        self._now()

    def _open(self) -> None:
        one = self.desk.open_run()
        self.details.clear()
        self.details.visible = one is not None
        if one is None:
            return
        kind = KINDS.get(one.kind)
        with self.details:
            with ui.row().classes("w-full items-center no-wrap gap-2"):
                name = ui.input("Name", value=one.title).props("dense outlined maxlength=120")
                name.classes("grow").mark("run-name")
                rename = lambda: self._rename(one.id, name)  # noqa: E731
                name.on("keydown.enter", rename)
                ui.button("Rename", on_click=rename, color=None).props("flat dense no-caps").mark(
                    "rename"
                )
            ui.html(_pairs(one.summary)).classes("w-full")
            ui.label("The same again, from the command line, in a folder with the files:").classes(
                "rn-note"
            )
            with ui.row().classes("w-full items-start no-wrap gap-1 rn-command"):
                ui.label(one.command).classes("rn-mono grow").mark("command")
                ui.button(icon="content_copy", color=None,
                          on_click=lambda: self._copy(one.command)).props(
                    'flat dense round size=sm aria-label="Copy the command"')  # fmt: skip
            with ui.row().classes("items-center gap-1"):
                if kind is not None:
                    ui.button(f"Open in {kind.tab}", icon="open_in_new",
                              on_click=lambda: self._reopen(one)).props(
                        "unelevated dense no-caps").mark("reopen")  # fmt: skip
                _file("All files (ZIP)", "folder_zip", lambda: self._archive(one))
                for file in one.files:
                    _file(file, "download", lambda f=file: self._send(one, f))
                for file in kind.made if kind else ():
                    _file(file, "download", lambda f=file: self._make(one, f))
            ui.button("Delete", icon="delete", color=None,
                      on_click=lambda: self._ask_to_delete(one)).props(
                "flat dense no-caps").classes("rn-bad").mark("delete")  # fmt: skip

    def _compare(self) -> None:
        runs = self.desk.compared()
        many = len(runs) > 1
        self.grid.classes(add="rn-comparing" if many else "", remove="" if many else "rn-comparing")
        self.compared.clear()
        with self.compared:
            ui.label("Compare").classes("rn-title").props("role=heading aria-level=2")
            if not many:
                ui.label(
                    f"Tick two to {COMPARED} runs of one kind to see them on top of each other."
                ).classes("rn-note")
                return
            kind = KINDS[runs[0].kind]
            if kind.chart is not None:
                ui.echart(kind.chart(self.library, runs)).classes("w-full rn-compare-chart")
            if kind.compare is not None:
                kind.compare(self.library, runs)
            ui.html(_table(runs, kind.columns)).classes("w-full overflow-auto")

    def _rename(self, which: str, field: ui.input) -> None:
        self._do(lambda: self.library.rename(which, str(field.value or "")))
        self._now()

    def _reopen(self, one: Run) -> None:
        def reopen() -> None:
            KINDS[one.kind].reopen(self.session, one)
            self.session.go(KINDS[one.kind].tab)

        self._do(reopen)

    def _ask_to_delete(self, one: Run) -> None:
        def delete() -> None:
            self._do(lambda: self.desk.forget(one.id))
            dialog.close()
            self._now()

        with ui.dialog() as dialog, ui.card().classes("rn-card"):
            ui.label("Delete this run and its files for good?").classes("rn-title")
            ui.label(one.title)
            with ui.row().classes("w-full justify-end"):
                ui.button("Cancel", on_click=dialog.close, color=None).props("flat no-caps")
                ui.button("Delete", on_click=delete, color="negative").props(
                    "unelevated no-caps"
                ).mark("delete-it")
        dialog.on("hide", dialog.delete)
        dialog.open()

    def _copy(self, text: str) -> None:
        ui.clipboard.write(text)
        ui.notify("Copied.", position="top", timeout=1500)

    async def _archive(self, one: Run) -> None:
        await self._fetch(lambda: archive(self.library, one), f"{archive_name(one)}.zip")

    async def _send(self, one: Run, name: str) -> None:
        await self._fetch(lambda: self.library.file(one.id, name), name)

    async def _make(self, one: Run, name: str) -> None:
        await self._fetch(lambda: KINDS[one.kind].made[name](self.library, one), name)

    async def _fetch(self, make: Callable[[], bytes], name: str) -> None:
        try:
            data = await run.io_bound(make)
            if data is not None:  # None: the studio is being stopped
                ui.download.content(data, name)
        except RovernavError as error:
            refuse(str(error))

    def _do(self, action: Callable[[], object]) -> None:
        try:
            action()
        except RovernavError as error:
            refuse(str(error))


def _file(words: str, icon: str, action: Callable[[], Any]) -> None:
    ui.button(words, icon=icon, on_click=action, color=None).props("flat dense no-caps size=sm")


def _when(created: float) -> str:
    return time.strftime("%Y-%m-%d %H:%M", time.localtime(created))


def _pairs(summary: Any) -> str:
    rows = "".join(
        f"<tr><th>{html.escape(str(name).replace('_', ' '))}</th>"
        f"<td>{html.escape(_cell(item))}</td></tr>"
        for name, item in summary.items()
        if not isinstance(item, dict | list)
    )
    return f'<table class="rn-table">{rows}</table>'


def _table(runs: Sequence[Run], columns: Any) -> str:
    head = "".join(f"<th>{html.escape(label)}</th>" for label in columns.values())
    rows = "".join(
        f"<tr><td>{html.escape(run.title)}</td>"
        + "".join(f"<td>{html.escape(_cell(run.summary.get(key), 12))}</td>" for key in columns)
        + "</tr>"
        for run in runs
    )
    return f'<table class="rn-table"><thead><tr><th></th>{head}</tr></thead>{rows}</table>'


def _cell(item: Any, longest: int = 80) -> str:
    if isinstance(item, float):
        return f"{item:.6g}"
    if isinstance(item, int) and not isinstance(item, bool):
        return f"{item:,}"
    text = "–" if item is None else str(item).replace("_", " ")
    return text if len(text) <= longest else text[:longest] + "…"
