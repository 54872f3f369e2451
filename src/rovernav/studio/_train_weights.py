"""Every weight under a person's hands."""

from __future__ import annotations

import numpy as np
from nicegui import ui

from ..core import PatternError, RovernavError
from ..learn import parse_number, weight_names
from ._session import Session
from ._table import shortest
from ._uploads import refuse

MOST = 200


def edit_weights(session: Session) -> None:
    """A dialog with one field per weight; a mistake in one of them changes none."""
    train = session.train
    train.pause()
    network = train.network
    if len(network.parameters) > MOST:
        refuse(f"at most {MOST} weights can be edited here; send a network file instead")
        return
    fields: list[ui.input] = []

    def apply() -> None:
        try:
            weights = np.array([parse_number(str(field.value or "")) for field in fields])
            train.set_weights(weights)
        except RovernavError as error:
            refuse(str(error))
            return
        dialog.close()

    def check(text: str | None) -> str | None:
        try:
            parse_number(text or "")
        except PatternError as error:
            return f"{str(error)[:1].upper()}{str(error)[1:]}."
        return None

    with ui.dialog() as dialog, ui.card().classes("rn-card max-w-none"):
        ui.label("Weights").classes("rn-title").props("role=heading aria-level=2")
        ui.label(
            "Training goes on from these as a run of its own. Named as in the paper's listing; "
            "the last of a row is the bias."
        ).classes("rn-note")
        names = iter(weight_names(network))
        for matrix in network.matrices:
            with (
                ui.element("div")
                .classes("rn-grid")
                .style(f"grid-template-columns: repeat({matrix.shape[1]}, 150px)")
            ):
                for weight in matrix.ravel():
                    field = ui.input(next(names), value=shortest(float(weight)), validation=check)
                    field.props("dense outlined hide-bottom-space debounce=250")
                    fields.append(field)
        with ui.row().classes("w-full justify-end"):
            ui.button("Cancel", on_click=dialog.close, color=None).props("flat no-caps")
            ui.button("Use these weights", on_click=apply).props("unelevated no-caps").mark("apply")
    dialog.on("hide", dialog.delete)
    dialog.open()
