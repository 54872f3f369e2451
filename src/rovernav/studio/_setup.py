"""What a training is set up with: the choices of the Train tab, checked as the command's are."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..core import PatternError, SettingError, ShapeError, suggest, value
from ..learn import (
    OnlineSettings,
    Patterns,
    Training,
    check_fit,
    paper_network,
    seeded_network,
)
from ..nets import (
    Network,
    default_activations,
    parameter_count,
    parse_topology,
    topology_text,
)

MAX_ROWS, MAX_COLUMNS = 5_000, 64
"""Size of a table that a page may hold; larger ones are for the command line."""
MAX_WEIGHTS = 20_000
MAX_WORK = 40_000_000
"""Patterns times weights at most: an epoch then takes about as long as a slice."""
WEIGHTS = ("paper", "seeded", "given")
"""Where initial weights come from: the paper, a seed, or a file or the hands of a person."""
PAPER = (2, 3, 2)
SETTINGS = tuple(field.name for field in dataclasses.fields(OnlineSettings))


@value
class Setup:
    """A training as it will begin.

    Attributes:
        table: What to learn.
        shipped: Name of the shipped table that it is, unchanged; empty for any other.
        hidden: Units of each hidden layer.
        activations: One per layer after the inputs.
        settings: Rates, rule, order and when to stop.
        weights: ``paper``, ``seeded`` or ``given``.
        given: The initial network where `weights` is ``given``.
    """

    table: Patterns
    shipped: str
    hidden: tuple[int, ...]
    activations: tuple[str, ...]
    settings: OnlineSettings
    weights: str
    given: Network | None = None

    def _check(self) -> None:
        check_size(self.table, self.topology)
        if self.weights not in WEIGHTS:
            raise SettingError(
                f"unknown weights {self.weights!r}; {suggest(self.weights, WEIGHTS)}"
            )
        if self.weights == "paper" and self.topology != PAPER:
            raise SettingError(
                f"the paper's weights are for a {topology_text(PAPER)} network, this one is "
                f"{topology_text(self.topology)}; choose seeded ones"
            )
        initial = self.initial()
        check_fit(initial, self.table)
        Training.fresh(initial)  # raises where it cannot be trained here
        if not np.isfinite(initial.parameters).all():
            raise SettingError("a network to train needs finite weights; this one has others")

    @property
    def topology(self) -> tuple[int, ...]:
        """Units per layer; the table says how many inputs and outputs there are."""
        return (self.table.x.shape[1], *self.hidden, self.table.y.shape[1])

    def initial(self) -> Network:
        """The network that the training begins with."""
        if self.weights == "paper":
            paper = paper_network()
            return Network(
                topology=PAPER,
                activations=self.activations,
                parameters=paper.parameters,
                card=paper.card,
            )
        if self.weights == "seeded" or self.given is None:
            return seeded_network(self.topology, self.activations, self.settings.seed)
        if self.given.topology != self.topology:
            raise ShapeError(
                f"the given weights are of a {topology_text(self.given.topology)} network, the "
                f"table and the hidden layers make a {topology_text(self.topology)} one"
            )
        return Network(
            topology=self.topology,
            activations=self.activations,
            parameters=self.given.parameters,
            card=self.given.card,
        )


def check_size(table: Patterns, topology: tuple[int, ...]) -> None:
    """Raise where a table or a network is more than a page can hold and train at once."""
    rows, columns = len(table.x), table.x.shape[1] + table.y.shape[1]
    if rows > MAX_ROWS or columns > MAX_COLUMNS:
        raise PatternError(
            f"the page holds tables of {MAX_ROWS:,} patterns and {MAX_COLUMNS} columns at most, "
            f"this one has {rows:,} and {columns}; use rovernav train"
        )
    parse_topology(topology_text(topology))
    weights = parameter_count(topology)
    if weights > MAX_WEIGHTS:
        raise SettingError(
            f"the page trains networks of {MAX_WEIGHTS:,} weights at most, a "
            f"{topology_text(topology)} one has {weights:,}; use rovernav train"
        )
    if weights * rows > MAX_WORK:
        raise SettingError(
            f"{rows:,} patterns for {weights:,} weights are too many for the page; "
            "use rovernav train"
        )


def changed(setup: Setup, changes: Mapping[str, Any]) -> Setup:
    """The setup with other choices, by the names of `Setup` and of the settings.

    What must change with them changes too: a table with other columns makes another network, and
    then the weights are drawn anew.

    Raises:
        InputError: A name there is not, or a value that is not allowed.
    """
    allowed = (*SETTINGS, "table", "shipped", "hidden", "activations", "weights", "given")
    for name in changes:
        if name not in allowed:
            raise SettingError(f"there is no setting {name!r}; {suggest(name, allowed)}")
    own = {name: _number(name, changes[name]) for name in SETTINGS if name in changes}
    parts = {name: item for name, item in changes.items() if name not in SETTINGS}
    if own:
        parts["settings"] = dataclasses.replace(setup.settings, **own)
    if "table" in parts:
        parts.setdefault("shipped", "")
    table, hidden = parts.get("table", setup.table), parts.get("hidden", setup.hidden)
    topology = (table.x.shape[1], *hidden, table.y.shape[1])
    if "activations" not in parts and len(topology) != len(setup.topology):
        parts["activations"] = refit_activations(setup.activations, len(topology) - 1, topology)
    if "weights" not in parts and topology != setup.topology:
        parts["weights"] = "seeded"
    return dataclasses.replace(setup, **parts)


def starts_elsewhere(old: Setup, new: Setup) -> bool:
    """Whether the training begins with another network."""
    drawn = new.weights == "seeded" and new.settings.seed != old.settings.seed
    return (
        drawn
        or new.topology != old.topology
        or new.activations != old.activations
        or new.weights != old.weights
        or new.given is not old.given
    )


def learns_differently(old: Setup, new: Setup) -> bool:
    """Whether the next update would be another one."""
    same = ("eta", "momentum", "rule", "order")
    shuffled = new.settings.order == "shuffled" and new.settings.seed != old.settings.seed
    return (
        shuffled
        or new.table.sha256 != old.table.sha256
        or any(getattr(new.settings, name) != getattr(old.settings, name) for name in same)
    )


def parse_hidden(text: Any) -> tuple[int, ...]:
    """``4-4`` as (4, 4); nothing as no hidden layer.

    Raises:
        SettingError: Not whole numbers above 0 joined by hyphens.
    """
    if isinstance(text, str) and not text.strip():
        return ()
    try:
        hidden = tuple(int(part) for part in str(text).strip().split("-"))
    except ValueError:
        hidden = (0,)
    if min(hidden) < 1 or max(hidden) > 1000 or len(hidden) > 8:
        raise SettingError(
            "hidden layers are written like 3 or 8-4: one to eight layers of 1 to 1000 units, "
            f"got {str(text)[:40]!r}"
        )
    return hidden


def refit_activations(
    activations: Sequence[str], layers: int, topology: tuple[int, ...]
) -> tuple[str, ...]:
    """Activations for another number of layers: the output keeps its own, hidden ones the first."""
    hidden = activations[0] if len(activations) > 1 else default_activations(topology)[0]
    kept = list(activations[:-1])[: layers - 1]
    kept += [hidden] * (layers - 1 - len(kept))
    return (*kept, activations[-1])


_WHOLE = ("epochs", "seed")


def _number(name: str, item: Any) -> Any:
    """A setting's value from what a field holds; text and NaN become one clear sentence."""
    if name in ("rule", "order"):
        return item if isinstance(item, str) else repr(item)
    text = str(item).strip()
    try:
        number = float(text.replace(",", "")) if not isinstance(item, bool) else math.nan
    except ValueError:
        number = math.nan
    if item is None or "_" in text or not math.isfinite(number):
        shown = text[:40] if item is not None and text else "nothing"
        raise SettingError(f"{name} must be a number, got {shown}")
    if name not in _WHOLE:
        return number
    if number != np.floor(number):
        raise SettingError(f"{name} must be a whole number, got {text[:40]}")
    return int(text) if text.lstrip("+-").isdigit() else int(number)
