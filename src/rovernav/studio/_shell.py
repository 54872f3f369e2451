"""The frame of the page: its head, its tabs, and which session it shows."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from nicegui import ui
from starlette.requests import Request
from starlette.responses import RedirectResponse, Response

from .._version import __version__
from ._drive_page import drive_tab
from ._gate import OWNER
from ._lessons_page import lessons_tab
from ._runs_page import runs_tab
from ._session import Session, Sessions
from ._theme import LOGO, style
from ._train_page import train_tab


class Tab(NamedTuple):
    """A tab: its name, its icon, and what builds its content for a session."""

    name: str
    icon: str
    build: Callable[[Session], None]


TABS = (
    Tab("Train", "psychology", train_tab),
    Tab("Drive", "explore", drive_tab),
    Tab("Runs", "inventory_2", runs_tab),
    Tab("Lessons", "school", lessons_tab),
)


def pages(sessions: Sessions) -> None:
    """Make the pages of a studio known: ``/`` begins a session, ``/s/KEY`` shows it."""

    @ui.page("/")
    def begin(request: Request) -> Response:
        owner = request.scope.get(OWNER, "")
        lost = "?fresh=1" if "lost" in request.query_params else ""
        return RedirectResponse(f"/s/{sessions.begin(owner).key}{lost}", status_code=303)

    @ui.page("/s/{key}")
    def show(request: Request, key: str, fresh: str = "") -> Response | None:
        session = sessions.find(key)
        if session is None:
            return RedirectResponse("/?lost=1", status_code=303)
        others = [one for one in sessions.of(session.owner) if one is not session]
        _page(session, others)
        if fresh:
            ui.notify(
                "The session of that address is gone, as the studio was started anew; "
                "here is a fresh one. Finished runs are under Runs.",
                type="info", timeout=12000, position="top", close_button="OK",
            )  # fmt: skip
        return None


def _stumble(error: Exception) -> None:
    """A defect of ours: the page lives on, the terminal shows where."""
    ui.notify(f"A defect of rovernav: {type(error).__name__}: {error}", type="negative",
              position="top", timeout=10000, close_button="OK")  # fmt: skip


def _page(session: Session, others: list[Session]) -> None:
    ui.on_exception(_stumble)
    ui.add_css(style())
    ui.colors(primary="#0072B2", secondary="#5b6875", accent="#CC79A7", positive="#009E73",
              negative="#C44E00", info="#0072B2", warning="#E69F00")  # fmt: skip
    dark = ui.dark_mode(session.dark)
    with ui.header(fixed=True, elevated=False).classes("rn-head"):
        ui.html(LOGO.read_text(encoding="utf-8")).classes("w-6 h-6").props("aria-hidden=true")
        ui.label("rovernav studio").classes("rn-brand")
        with ui.tabs().props("dense no-caps inline-label align=left") as tabs:
            for tab in TABS:
                ui.tab(tab.name, icon=tab.icon)
        ui.space()
        _others(session, others)
        _dark_button(session, dark)
    with ui.column().classes("rn-page") as main:
        panels = ui.tab_panels(tabs, value=session.tab, animated=False).classes("w-full")
    ui.skip_link("Skip to the content", target=main)
    tabs.bind_value(session, "tab")
    _build_when_seen(session, tabs, panels)


def _build_when_seen(session: Session, tabs: ui.tabs, panels: ui.tab_panels) -> None:
    """Build a tab's content when it is first turned to."""
    waiting = {tab.name: tab for tab in TABS}

    def build(name: object) -> None:
        if isinstance(name, str) and name in waiting:
            with panels, ui.tab_panel(name):
                waiting.pop(name).build(session)

    build(session.tab)
    tabs.on_value_change(lambda event: build(event.value))


def _others(session: Session, others: list[Session]) -> None:
    """A menu of the sessions that this browser has open or left at work."""
    with ui.button(icon="tab", color=None).props('flat dense round aria-label="Sessions"'):
        ui.tooltip("Sessions")
        with ui.menu().props("auto-close"):
            ui.menu_item("Begin a fresh session in a new tab",
                         lambda: ui.navigate.to("/", new_tab=True))  # fmt: skip
            for number, other in enumerate(others[:8], 1):
                doing = "at work" if other.busy else "idle"
                ui.menu_item(
                    f"Earlier session {number} ({other.tab}, {doing})",
                    lambda key=other.key: ui.navigate.to(f"/s/{key}"),
                )
            ui.separator()
            ui.label(f"rovernav {__version__}").classes("rn-note px-4 py-1")


def _dark_button(session: Session, dark: ui.dark_mode) -> None:
    def turn() -> None:
        session.dark = {None: True, True: False, False: None}[session.dark]
        dark.value = session.dark
        button.props(f"icon={_DARK[session.dark][0]}")
        tip.text = _DARK[session.dark][1]

    icon, words = _DARK[session.dark]
    button = ui.button(icon=icon, on_click=turn, color=None).props(
        'flat dense round aria-label="Light or dark"'
    )
    with button:
        tip = ui.tooltip(words)


_DARK = {
    None: ("brightness_auto", "Light or dark as the system says"),
    True: ("dark_mode", "Dark"),
    False: ("light_mode", "Light"),
}
