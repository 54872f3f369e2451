"""The right column of the Drive tab: tracks beside each other, the moment shown, and why."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from html import escape
from typing import final

from nicegui import run, ui

from ..core import Outcome, RovernavError
from ..show import end_words
from ._drive import DriveModel
from ._drive_run import DriveRun, Moment
from ._drive_setup import swatch
from ._why import result_words, why_html

_HEADS = {
    "length": "Length of the way that was driven",
    "detour": "Driven over straight length",
    "gap": "Clearance: smallest distance of the rover's circle to anything",
}
TONES = {Outcome.REACHED: "rn-good", Outcome.COLLIDED: "rn-bad"}


@final
class SidePanel:
    """Table of tracks, readouts, and the reasons of one step.

    Args:
        model: What is driven.
        focus: Which drive is looked at.
        look: Called with a drive's number to look at another one.
    """

    def __init__(
        self, model: DriveModel, focus: Callable[[], int], look: Callable[[int], None]
    ) -> None:
        self.model, self._focus, self._look = model, focus, look
        self._shown: object = None

    def build(self) -> None:
        """Build the column in the present container."""
        with ui.column().classes("rn-card w-full"):
            ui.label("Tracks").classes("rn-title")
            self.table = ui.column().classes("w-full gap-0 rnd-tracks")
        with ui.column().classes("rn-card w-full"):
            ui.label("Now").classes("rn-title")
            self.now = ui.html().classes("w-full").mark("now")
        with ui.column().classes("rn-card w-full rnd-why-card"):
            with ui.row().classes("w-full items-center no-wrap"):
                ui.label("Why did it do that?").classes("rn-title")
                ui.space()
                ui.button("Ask about this step", icon="help_outline", on_click=self.ask).props(
                    "dense unelevated size=sm").mark("why")  # fmt: skip
            self.head = ui.label("Click a point of a track, or ask about the step shown.")
            self.head.classes("rn-note").mark("why-head")
            self.why = ui.html().classes("w-full").mark("why-text")

    def show_table(self) -> None:
        """Draw the table anew where something in it changed."""
        runs = self.model.runs
        state = (
            tuple((run.pick, run.steps, run.ended, run.note) for run in runs),
            tuple(self.model.refused), self._focus(),
        )  # fmt: skip
        if state == self._shown:
            return
        self._shown = state
        self.table.clear()
        with self.table:
            if not runs and not self.model.refused:
                ui.label("Press Drive: every chosen controller drives this world.").classes(
                    "rn-note")  # fmt: skip
                return
            if runs:
                self._table(runs)
            for pick, words in self.model.refused:
                ui.label(f"{pick.label}: {words}").classes("rn-note rn-bad")

    def _table(self, runs: list[DriveRun]) -> None:
        head = ("", "", "length", "detour", "time", "gap")
        with ui.element("table").classes("rn-table w-full").mark("tracks"):
            with ui.element("tr"):
                for i, words in enumerate(head):
                    with ui.element("th").classes("n" if i > 1 else ""):
                        label = ui.label(words)
                        if words in _HEADS:  # plain, as the table is made anew at every step
                            label.props["title"] = _HEADS[words]
            for i, one in enumerate(runs):
                with ui.element("tr").classes(
                    "rnd-row" + (" rnd-on" if i == self._focus() else "")
                ):
                    self._row(i, one)
        for one in runs:
            for words in (one.error, one.note):
                if words:
                    ui.label(f"{one.pick.label}: {words}").classes("rn-note")

    def _row(self, i: int, one: DriveRun) -> None:
        told = one.summary()
        ended = "stopped" if one.error else one.outcome.label.replace("_", " ")
        with ui.element("td").classes("rnd-who"):
            button = ui.element("button").classes("rnd-plain").on("click", partial(self._choose, i))
            button.props["aria-label"] = f"Look at {one.pick.label}"
        with button:
            ui.html(swatch(i))
            ui.label(one.pick.label)
        with ui.element("td"):
            ui.label(ended).classes(TONES.get(one.outcome, "rn-note")).mark(f"outcome-{i}")
        gap = told["clearance_m"] if one.trace is not None else None
        for words in (
            f"{told['length_m']:.2f} m",
            "" if told["detour"] is None else f"{told['detour']:.2f}×",
            f"{told['time_s']:.0f} s",
            "" if gap is None else f"{gap:.2f} m",
        ):
            with ui.element("td").classes("n"):
                ui.label(words)

    def _choose(self, number: int, _: object = None) -> None:
        self._look(number)

    def show_moment(self, one: DriveRun, step: int) -> None:
        """Tell where a drive is at a step."""
        self.now.content = moment_html(one, one.moment(step))

    async def ask(self) -> None:
        """Tell why the drive in focus did what it did at the step shown."""
        runs, i = self.model.runs, self._focus()
        if not 0 <= i < len(runs) or not runs[i].steps:
            self.head.text = "Nothing has been driven yet: press Drive first."
            return
        one = runs[i]
        step = min(one.step_at(self.model.now()), one.steps - 1)
        try:
            told = await run.io_bound(one.why, step)
        except RovernavError as error:
            self.head.text = str(error)
            return
        if told is None:  # the studio is being stopped
            return
        why, after = told
        self.head.text = f"{one.pick.label}, step {step + 1} of {one.steps}, {one.times[step]:g} s"
        last = one.ended and step == one.steps - 1
        self.why.content = why_html(why, result_words(one.driven[step], after, ended=last))

    def forget(self) -> None:
        """Empty the reasons: another drive has begun."""
        self.head.text = "Click a point of a track, or ask about the step shown."
        self.why.content = ""


def moment_html(one: DriveRun, at: Moment) -> str:
    """What a drive does at a moment, as a small table."""
    x, y, heading = at.pose
    rows = [
        ("time", f"{at.time:.1f} s, step {at.step} of {one.steps}"),
        ("place", f"{x:.2f}, {y:.2f} m"),
        ("heading", f"{math.degrees(heading):.0f}° from east"),
        ("driven", f"{at.driven:.2f} m"),
        ("to the goal", f"{at.to_goal:.2f} m"),
    ]
    if at.command is None:
        rows.append(("motors", end_words(one.outcome)))
    elif one.rover.drive == "two-axis":
        rows.append(("motors", f"{at.command[0]:+.3f} along, {at.command[1]:+.3f} across [m/s]"))
    else:
        turn = round(math.degrees(at.command[2])) + 0  # no negative zero
        rows.append(("motors", f"{at.command[0]:.2f} m/s, turn {turn:+d} °/s"))
    if one.standing is not None:
        limit = math.degrees(one.rover.max_slope)
        rows.append(("tilt", f"{math.degrees(at.tilt):.1f}° of {limit:.0f}° allowed"))
    if "beams" in at.channels:
        rows.append(("nearest beam", f"{at.channels['beams'].min():.2f} m"))
    for name, words in (("clear_sight", "x: goal in sight"), ("off_line", "y: off the line")):
        if name in at.channels:
            rows.append((words, f"{at.channels[name][0]:.0f}"))
    return "<table class='rn-table w-full'>" + "".join(
        f"<tr><td>{escape(name)}</td><td class='n'>{escape(words)}</td></tr>"
        for name, words in rows
    ) + "</table>"  # fmt: skip
