"""The choices of the Train tab: network, weights, rates, order, end."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from nicegui import events, ui

from ..core import InputError, RovernavError
from ..learn import ORDERS, RULES
from ..nets import ACTIVATIONS, parse_network
from ._session import Session
from ._setup import PAPER
from ._table import shortest
from ._uploads import refuse, upload_button

MAX_NETWORK = 4_000_000
"""Bytes of a network file that is sent to the page."""
LARGEST, DEEPEST = 64, 6
"""Units of a layer, and layers, that the buttons make; a file may bring more."""
_NUMBERS = {
    "eta": ("η  learning rate", "Share of the error that each update corrects."),
    "momentum": ("α  momentum", "Share of a weight's last change that is repeated."),
    "tolerance": ("Tolerance", "Training stops once every |error| is below this; 0 never stops."),
    "epochs": ("Epochs at most", "An epoch presents every pattern once."),
    "seed": ("Seed", "Of drawn weights and of a shuffled order."),
}
_RULES = {
    "paper": "Hidden errors go back through the weights just updated, as in the paper's listing.",
    "textbook": "Hidden errors go back through the old weights: the exact gradient.",
}


def settings_card(session: Session) -> Callable[[], None]:
    """The choices; returns what to call when they were changed elsewhere."""
    with ui.column().classes("rn-card w-full"):
        ui.label("Network").classes("rn-title").props("role=heading aria-level=2")
        layers = _layers(session)
        weights = _weights(session)
    with ui.column().classes("rn-card w-full"):
        ui.label("Training").classes("rn-title").props("role=heading aria-level=2")
        with ui.element("div").classes("rn-two w-full"):
            fields = [
                _choice(session, "rule", list(RULES), "Rule", _RULES),
                _choice(session, "order", list(ORDERS), "Order", {}),
                *(_number(session, name, *words) for name, words in _NUMBERS.items()),
            ]

    def refresh() -> None:
        for show in (layers, weights, *fields):
            show()

    return refresh


def _number(session: Session, name: str, label: str, help_text: str) -> Callable[[], None]:
    def text() -> str:
        item = getattr(session.train.setup.settings, name)
        return shortest(item) if isinstance(item, float) else str(item)

    def check(typed: str | None) -> str | None:
        if typed == text():
            return None
        try:
            session.train.change(**{name: typed})
        except InputError as error:
            return _sentence(error)
        return None

    field = ui.input(label, value=text()).mark(name)
    field.props("dense outlined hide-bottom-space debounce=300").classes("w-full")
    field.tooltip(help_text).props("delay=600")
    field.validation = check

    def refresh() -> None:
        if field.error is None and not _same_number(field.value, text()):
            field.value = text()

    return refresh


def _choice(
    session: Session, name: str, options: list[str], label: str, helps: dict[str, str]
) -> Callable[[], None]:
    def choose(event: events.ValueChangeEventArguments[Any]) -> None:
        if event.value != getattr(session.train.setup.settings, name):
            _change(session, **{name: event.value})
        tip.text = helps.get(str(event.value), "")

    now = getattr(session.train.setup.settings, name)
    select = ui.select(options, value=now, label=label, on_change=choose).mark(name)
    select.props("dense outlined options-dense hide-bottom-space").classes("w-full")
    with select:
        tip = ui.tooltip(helps.get(now, "")).props("delay=600")
        tip.visible = bool(helps)

    def refresh() -> None:
        select.value = getattr(session.train.setup.settings, name)

    return refresh


def _layers(session: Session) -> Callable[[], None]:
    """Rows for the hidden layers, and one for the outputs' activation."""
    layers = _Layers(session)
    layers.refresh()
    return layers.refresh


class _Layers:
    """The rows; they are made anew where the network got another shape."""

    def __init__(self, session: Session) -> None:
        self.session = session
        self.box = ui.column().classes("w-full gap-1")
        self.seen: object = None

    def refresh(self) -> None:
        setup = self.session.train.setup
        shape = (setup.topology, setup.activations)
        if self.seen == shape:
            return
        self.seen = shape
        self.box.clear()
        with self.box:
            ui.label(" – ".join(map(str, setup.topology))).classes("rn-num text-base font-medium")
            for layer, units in enumerate(setup.hidden):
                self._row(layer, units, setup.activations[layer])
            with ui.row().classes("w-full items-center gap-1 no-wrap"):
                ui.button("layer", icon="add", on_click=self._add, color=None).props(
                    'flat dense no-caps size=sm aria-label="Add a hidden layer"'
                )
                ui.space()
                ui.label("outputs").classes("rn-note")
                _activation(setup.activations[-1], "Activation of the outputs",
                            lambda name: self._activate(-1, name))  # fmt: skip

    def _row(self, layer: int, units: int, activation: str) -> None:
        number = layer + 1
        with ui.row().classes("w-full items-center gap-1 no-wrap"):
            _tiny("remove", lambda: self._resize(layer, -1), f"Fewer units in layer {number}")
            ui.label(f"{units}").classes("rn-num w-6 text-center")
            _tiny("add", lambda: self._resize(layer, 1), f"More units in layer {number}")
            ui.label("hidden").classes("rn-note")
            ui.space()
            _activation(activation, f"Activation of layer {number}",
                        lambda name: self._activate(layer, name))  # fmt: skip
            _tiny("close", lambda: self._remove(layer), f"Remove layer {number}")

    def _resize(self, layer: int, by: int) -> None:
        hidden = list(self.session.train.setup.hidden)
        if layer < len(hidden) and 1 <= hidden[layer] + by <= LARGEST:
            hidden[layer] += by
            _change(self.session, hidden=tuple(hidden))
        self.refresh()

    def _remove(self, layer: int) -> None:
        setup = self.session.train.setup
        hidden, activations = list(setup.hidden), list(setup.activations)
        if layer < len(hidden):
            del hidden[layer], activations[layer]
            _change(self.session, hidden=tuple(hidden), activations=tuple(activations))
        self.refresh()

    def _add(self) -> None:
        setup = self.session.train.setup
        if len(setup.hidden) < DEEPEST:
            _change(self.session, hidden=(*setup.hidden, 3))
        self.refresh()

    def _activate(self, layer: int, name: Any) -> None:
        activations = list(self.session.train.setup.activations)
        if layer < len(activations) and name != activations[layer]:
            activations[layer] = name
            _change(self.session, activations=tuple(activations))
        self.refresh()


def _activation(now: str, label: str, choose: Callable[[Any], None]) -> None:
    select = ui.select(list(ACTIVATIONS), value=now, on_change=lambda event: choose(event.value))
    select.props(f'dense borderless options-dense aria-label="{label}"').classes("rn-act")


def _weights(session: Session) -> Callable[[], None]:
    """Where the initial weights come from."""

    def options() -> dict[str, str]:
        setup = session.train.setup
        found = {"seeded": "drawn from the seed"}
        if setup.topology == PAPER:
            found = {"paper": "the paper's", **found}
        if setup.given is not None and setup.given.topology == setup.topology:
            found["given"] = "from a file or by hand"
        return found

    def choose(event: events.ValueChangeEventArguments[Any]) -> None:
        if event.value is not None and event.value != session.train.setup.weights:
            _change(session, weights=event.value)

    def load(name: str, data: bytes) -> None:
        network = parse_network(data, name)
        session.train.change(
            hidden=network.topology[1:-1],
            activations=network.activations,
            weights="given",
            given=network,
        )
        refresh()

    with ui.row().classes("w-full items-center gap-1 no-wrap"):
        select = (
            ui.select(options(), value=session.train.setup.weights, label="Initial weights",
                      on_change=choose)
            .props("dense outlined options-dense hide-bottom-space")
            .classes("grow")
            .mark("weights")
        )  # fmt: skip
        upload_button("File", kinds=(".safetensors",), limit=MAX_NETWORK, on_file=load).props(
            'aria-label="Load initial weights from a network file"'
        )

    def refresh() -> None:
        select.set_options(options(), value=session.train.setup.weights)

    return refresh


def _change(session: Session, **changes: Any) -> None:
    try:
        session.train.change(**changes)
    except RovernavError as error:
        refuse(_sentence(error))


def _tiny(icon: str, action: Callable[[], None], label: str) -> None:
    ui.button(icon=icon, on_click=action, color=None).props(
        f'flat dense round size=xs aria-label="{label}"'
    )


def _same_number(typed: Any, text: str) -> bool:
    try:
        return float(typed) == float(text)
    except (TypeError, ValueError):
        return False


def _sentence(error: Exception) -> str:
    text = str(error)
    return f"{text[:1].upper()}{text[1:]}."
