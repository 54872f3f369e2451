"""The paper's worked example, one step at a time, each number beside the printed one."""

from __future__ import annotations

from nicegui import ui

from ..learn import RULES, worked_steps
from ._session import Session


def worked_pane(session: Session) -> None:
    """Build the pane in the present container."""
    with ui.row().classes("w-full items-center gap-2"):
        back = ui.button(icon="chevron_left", color=None).props(
            'flat dense round aria-label="Step before"'
        )
        title = ui.label().classes("rn-title rn-step").mark("worked-title")
        on = ui.button("Next step", icon="chevron_right").props("unelevated dense no-caps size=sm")
        on.mark("worked-next")
        ui.space()
        rule = ui.toggle(list(RULES), value=session.worked_rule).props(
            'dense no-caps unelevated size=sm aria-label="Rule"'
        )
        ui.button("Set the training up like this", icon="tune", color=None,
                  on_click=lambda: _set_up(session)).props(
            "flat dense no-caps size=sm").mark("worked-set-up")  # fmt: skip
    body = ui.column().classes("w-full gap-1")

    def show() -> None:
        steps = worked_steps(session.worked_rule)
        at = session.worked = max(0, min(session.worked, len(steps) - 1))
        step = steps[at]
        title.text = f"{at + 1} of {len(steps)}: {step.title}"
        back.enabled, on.enabled = at > 0, at < len(steps) - 1
        body.clear()
        with body, ui.element("div").classes("rn-worked"):
            for heading in ("", "how", "paper printed", "full precision"):
                ui.label(heading).classes("rn-note")
            for row in step.rows:
                ui.label(row.name).classes("font-medium")
                ui.label(f"= {row.formula}").classes("rn-mono rn-dim")
                ui.label(row.printed or "not printed").classes(
                    "rn-num" + ("" if row.printed else " rn-note")
                )
                ui.label(f"{row.number:.8f}").classes("rn-num font-medium")
            ui.label(step.note).classes("rn-note").style("grid-column: 1 / -1")

    def turn(by: int) -> None:
        session.worked += by
        show()

    def choose(name: object) -> None:
        if name in RULES:
            session.worked_rule = str(name)
            show()

    back.on_click(lambda: turn(-1))
    on.on_click(lambda: turn(1))
    rule.on_value_change(lambda event: choose(event.value))
    show()


def _set_up(session: Session) -> None:
    """The network, pattern and rates of the example, to be stepped in the real engine."""
    session.train.preset(
        {
            "table": "bassil-v1",
            "hidden": "3",
            "activations": ("sigmoid", "linear"),
            "weights": "paper",
            "rule": session.worked_rule,
            "eta": 0.25,
            "momentum": 0.0,
            "order": "cyclic",
        }
    )
    session.shown = 0
    ui.notify("Press 1 pattern: the weights become those of the example.", position="top")
