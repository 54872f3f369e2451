"""The Train tab: the training engine of the paper, live."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from nicegui import events, run, ui

from ..core import RovernavError
from ..learn import patterns_csv
from ..nets import network_bytes
from ._pace import SPEEDS
from ._session import Session
from ._state import State
from ._train_settings import settings_card
from ._train_table import table_card
from ._train_view import TrainView, curve_options, figures, status_words, train_view
from ._train_weights import edit_weights
from ._uploads import refuse
from ._worked_page import worked_pane

EVERY = 0.15
"""How often the page looks whether something changed [s]."""
DRAWN = {"slow": 0.15, "watch": 0.3, "full": 0.6}
"""How long pictures stay while a training runs, by its speed [s]."""
_SPEEDS = {"slow": "Slow", "watch": "Watch", "full": "Full speed"}
_TONES = {"good": "rn-good", "bad": "rn-bad", "warn": "rn-warn", "run": "rn-run", "": ""}


def train_tab(session: Session) -> None:
    """Build the tab in the present container."""
    _TrainTab(session).build()


class _TrainTab:
    """The elements of the tab, and what each of them does; it decides nothing by itself."""

    def __init__(self, session: Session) -> None:
        self.session, self.train = session, session.train
        self.seen: object = None
        self.drawn = 0.0
        self.table = self.train.setup.table
        self.busy = False

    def build(self) -> None:
        with ui.element("div").classes("rn-train"):
            with ui.row().classes("rn-card rn-bar items-center no-wrap"):
                self._buttons()
            with ui.column().classes("rn-side gap-2 no-wrap"):
                self.refresh_table = table_card(self.session, self._look_again)
                self.refresh_settings = settings_card(self.session)
            with ui.column().classes("rn-card rn-middle"):
                self._drawing()
            with ui.column().classes("rn-right gap-2"):
                self._charts()
            with ui.column().classes("rn-card rn-low"):
                self._low()
        ui.timer(EVERY, self._refresh)

    def _buttons(self) -> None:
        train = self.train
        self.start = ui.button(icon="play_arrow", on_click=self._toggle).props(
            'round unelevated aria-label="Start"'
        )
        self.start.mark("start")
        with self.start:
            self.start_tip = ui.tooltip("Start")
        _icon("restart_alt", self._act(train.reset), "Back to the initial weights", "reset")
        ui.separator().props("vertical")
        _words("1 pattern", "skip_next", self._later(train.step_pattern),
               "Present one pattern, change the weights once", "step-pattern")  # fmt: skip
        _words("1 epoch", "fast_forward", self._later(train.step_epoch),
               "Present every pattern once", "step-epoch")  # fmt: skip
        ui.separator().props("vertical")
        ui.toggle({name: _SPEEDS[name] for name in SPEEDS}, value=train.speed,
                  on_change=self._speed).props(
            'dense no-caps unelevated aria-label="Speed"').mark("speed")  # fmt: skip
        ui.space()
        with ui.row().classes("items-baseline gap-5 no-wrap rn-figures"):
            self.status = ui.label().classes("rn-status").props("role=status aria-live=polite")
            self.status.mark("status")
            self.epoch = _figure("epoch")
            self.error = _figure("largest |error|")
            self.rate = ui.label().classes("rn-note rn-num")
        ui.space()
        more = ui.button(icon="more_vert", color=None).props('flat dense round aria-label="More"')
        with more, ui.menu().props("auto-close"):
            ui.menu_item("Keep this run in Runs", self._keep).mark("keep")
            ui.menu_item("Download the network", self._network)
            ui.menu_item("Download the table as CSV", self._csv)
        _words("Drive it", "explore", lambda: self.session.go("Drive"),
               "Drive a rover with this network", "drive-it")  # fmt: skip

    def _drawing(self) -> None:
        with ui.row().classes("w-full items-center no-wrap gap-2"):
            ui.label("Network").classes("rn-title").props("role=heading aria-level=2")
            self.shown = ui.label().classes("rn-note rn-num")
            ui.space()
            ui.html(_LEGEND).classes("rn-note")
        self.drawing = ui.html().classes("w-full rn-draw")

    def _charts(self) -> None:
        with ui.column().classes("rn-card w-full"):
            ui.label("Error").classes("rn-title").props("role=heading aria-level=2")
            options = {"xAxis": {}, "yAxis": {}, "series": []}
            self.chart = ui.echart(options).classes("w-full rn-chart")
        with ui.column().classes("rn-card w-full"):
            with ui.row().classes("w-full items-center no-wrap gap-2"):
                ui.label("Answers over two inputs").classes("rn-title").props(
                    "role=heading aria-level=2"
                )
                ui.space()
                self.axes = ui.row().classes("gap-1 no-wrap")
            self.answers = ui.html().classes("w-full rn-answers")
        self._choose_axes()

    def _choose_axes(self) -> None:
        """Which inputs vary, where there are more than two."""
        self.axes.clear()
        names = self.train.setup.table.inputs
        if len(names) <= 2:
            return
        options = dict(enumerate(name[:14] for name in names))
        with self.axes:
            for axis, label in enumerate(("To the right", "Upwards")):
                ui.select(
                    options,
                    value=self.session.surface_axes[axis],
                    on_change=lambda event, k=axis: self._axis(k, event.value),
                ).props(f'dense borderless options-dense aria-label="{label}"')

    def _low(self) -> None:
        with ui.row().classes("w-full items-center no-wrap"):
            with ui.tabs().props("dense no-caps align=left").classes("rn-small-tabs") as tabs:
                for name in ("Weights", "Trace", "Worked example"):
                    ui.tab(name)
            ui.space()
        with ui.tab_panels(tabs, value="Weights", animated=False).classes("w-full"):
            with ui.tab_panel("Weights"):
                self.weights = ui.html().classes("w-full")
                ui.button("Edit the weights", icon="edit", color=None,
                          on_click=lambda: edit_weights(self.session)).props(
                    "flat dense no-caps size=sm").mark("edit-weights")  # fmt: skip
            with ui.tab_panel("Trace"):
                with ui.row().classes("items-center gap-3"):
                    ui.switch("Write down every weight after every pattern",
                              value=self.train.tracing,
                              on_change=lambda e: self._do(lambda: self.train.trace(bool(e.value)))
                              ).props("dense").mark("trace")  # fmt: skip
                    ui.label("As the paper's listing prints them, the latest first; "
                             "training is slower meanwhile.").classes("rn-note")  # fmt: skip
                self.trace = (
                    ui.label()
                    .classes("rn-trace rn-mono w-full")
                    .props('tabindex=0 role=region aria-label="Trace"')
                )
            with ui.tab_panel("Worked example"):
                worked_pane(self.session)

    async def _refresh(self) -> None:
        """Show the present state, if it is another one than was shown last.

        The figures follow at once; pictures take the browser longer, so that while a training runs
        they are drawn less often and leave room for answers.
        """
        mark = (self.train.version, self.session.shown, tuple(self.session.surface_axes))
        if mark == self.seen or self.busy:
            return
        state = self.train.state()
        self._figures(state)
        if state.running and time.monotonic() - self.drawn < DRAWN[self.train.speed]:
            return
        self.busy = True
        try:
            view = await run.io_bound(train_view, state, self.session.shown, self._axes())
        finally:
            self.busy = False
        if view is None:  # the studio is being stopped
            return
        self.seen, self.drawn = mark, time.monotonic()
        self._draw(state, view)
        if state.setup.table is not self.table:
            self.table = state.setup.table
            if self.table is not self.session.desk.handed_over:
                self.refresh_table()
            self._choose_axes()
        self.refresh_settings()

    def _figures(self, state: State) -> None:
        words, tone = status_words(state)
        self.status.text = words
        self.status.classes(replace=f"rn-status {_TONES[tone]}")
        self.epoch.text, self.error.text, self.rate.text = figures(state)
        label = "Pause" if state.running else "Start"
        self.start.props(f"icon={'pause' if state.running else 'play_arrow'}")
        self.start.props(f'aria-label="{label}"')
        self.start_tip.text = label

    def _draw(self, state: State, view: TrainView) -> None:
        self.drawing.content = view.drawing
        self.answers.content = view.answers
        self.weights.content = view.weights
        self.trace.text = view.trace or "Nothing yet."
        self.shown.text = f"shows pattern {self.session.shown + 1}"
        options = curve_options(state, view)
        self.chart.options.clear()
        self.chart.options.update(options)
        self.chart.update()

    def _axes(self) -> tuple[int, int]:
        inputs = self.train.setup.table.x.shape[1]
        first, second = (min(axis, inputs - 1) for axis in self.session.surface_axes)
        return (first, second) if first != second else (0, min(1, inputs - 1))

    def _axis(self, axis: int, value: object) -> None:
        if isinstance(value, int):
            self.session.surface_axes[axis] = value

    def _look_again(self) -> None:
        self.session.shown = min(self.session.shown, len(self.train.setup.table.x) - 1)

    def _toggle(self) -> None:
        self._do(self.train.pause if self.train.running else self.train.start)

    def _speed(self, event: events.ValueChangeEventArguments[Any]) -> None:
        self._do(lambda: self.train.choose_speed(event.value))

    def _do(self, action: Callable[[], object]) -> None:
        try:
            action()
        except RovernavError as error:
            refuse(str(error))

    def _act(self, action: Callable[[], object]) -> Callable[[], None]:
        return lambda: self._do(action)

    def _later(self, action: Callable[[], object]) -> Callable[[], object]:
        async def perform() -> None:
            await run.io_bound(action)  # off the event loop: an epoch may take a while

        return perform

    async def _keep(self) -> None:
        try:
            await run.io_bound(self.train.keep_now)
            ui.notify("Kept; it stands in Runs.", type="positive", position="top")
        except RovernavError as error:
            refuse(str(error))

    def _network(self) -> None:
        ui.download.content(network_bytes(self.train.driver()), "network.safetensors")

    def _csv(self) -> None:
        ui.download.content(patterns_csv(self.train.setup.table), "patterns.csv")


def _figure(name: str) -> ui.label:
    with ui.column().classes("gap-0"):
        figure = ui.label().classes("rn-figure rn-num").mark(name.split()[0])
        ui.label(name).classes("rn-note")
    return figure


def _icon(icon: str, action: Callable[[], object], label: str, mark: str) -> None:
    with (
        ui.button(icon=icon, on_click=action, color=None)
        .props(f'flat round dense aria-label="{label}"')
        .mark(mark)
    ):
        ui.tooltip(label).props("delay=500")


def _words(words: str, icon: str, action: Callable[[], object], tip: str, mark: str) -> None:
    with (
        ui.button(words, icon=icon, on_click=action, color=None)
        .props("flat dense no-caps")
        .mark(mark)
    ):
        ui.tooltip(tip).props("delay=500")


_LEGEND = (
    '<span class="rn-key rn-key-plus"></span> weight above 0 '
    '<span class="rn-key rn-key-minus"></span> below 0; wider is larger'
)
