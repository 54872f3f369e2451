"""Settings of a sweep: every rate with every momentum, each from many seeds."""

from __future__ import annotations

import dataclasses
import json
from typing import Any

from ..core import SettingError, ShapeError, canonical_json, value
from ..nets import Card, Network, default_activations, seeded_parameters, topology_text
from ._online import OnlineSettings
from ._patterns import Patterns

MOST_MEMBERS = 10**9
MOST_SETTINGS = 10_000


@value
class SweepSettings:
    """What a sweep trains: a member for each eta, momentum and seed.

    Members are numbered from 0: all seeds of the first eta and momentum, all seeds of the first eta
    and the second momentum, and so on. A member is the training that `train` makes of
    ``Network.seeded(topology, activations, default_rng(seed))`` with its rates and its seed.

    Attributes:
        topology: Units per layer, inputs first.
        activations: One name per layer after the inputs; empty means sigmoid, the outputs linear.
        etas: Learning rates.
        momenta: Shares of the last change that are repeated.
        seeds: Networks per eta and momentum.
        first_seed: Seed of the first of them; the others follow.
        rule: ``paper`` or ``textbook``.
        tolerance: A member ends once every |error| is below this; 0 does all epochs.
        epochs: Epochs of a member at most.
        order: ``cyclic`` or ``shuffled`` by the member's seed.
    """

    topology: tuple[int, ...] = (2, 3, 2)
    activations: tuple[str, ...] = ()
    etas: tuple[float, ...] = (0.25,)
    momenta: tuple[float, ...] = (0.5,)
    seeds: int = 1000
    first_seed: int = 0
    rule: str = "paper"
    tolerance: float = 0.01
    epochs: int = 5000
    order: str = "cyclic"

    def _check(self) -> None:
        for name, kind in (("etas", "eta"), ("momenta", "momentum")):
            numbers = tuple(float(number) for number in getattr(self, name))
            _check_list(kind, numbers)
            object.__setattr__(self, name, numbers)
        if not 1 <= self.seeds <= MOST_MEMBERS:
            raise SettingError(f"seeds must be from 1 to 10^9, got {self.seeds:,}")
        if not 0 <= self.first_seed <= 2**63 - self.seeds:
            raise SettingError(
                f"seeds must lie from 0 to 2^63 - 1, got {self.seeds:,} from {self.first_seed:,} on"
            )
        count = len(self.etas) * len(self.momenta)
        if count > MOST_SETTINGS:
            raise SettingError(
                f"{len(self.etas):,} etas with {len(self.momenta):,} momenta are {count:,} "
                f"settings; at most {MOST_SETTINGS:,} are allowed"
            )
        if count * self.seeds > MOST_MEMBERS:
            raise SettingError(
                f"{count:,} settings with {self.seeds:,} seeds are {count * self.seeds:,} members; "
                "at most 10^9 are allowed"
            )
        if not self.activations:
            object.__setattr__(self, "activations", default_activations(self.topology))
        self.network(0)
        step = self.seeds * len(self.momenta)
        for number in (*range(0, self.members, step), *range(0, step, self.seeds)):
            self.online(number)  # every eta and every momentum

    @property
    def members(self) -> int:
        """Networks in all."""
        return len(self.etas) * len(self.momenta) * self.seeds

    @property
    def rates(self) -> tuple[tuple[float, float], ...]:
        """Eta and momentum of each setting."""
        return tuple((eta, momentum) for eta in self.etas for momentum in self.momenta)

    def rate(self, member: int) -> tuple[float, float]:
        """Eta and momentum of a member."""
        setting = member // self.seeds
        return self.etas[setting // len(self.momenta)], self.momenta[setting % len(self.momenta)]

    def seed(self, member: int) -> int:
        """The seed of a member."""
        return self.first_seed + member % self.seeds

    def online(self, member: int) -> OnlineSettings:
        """The settings with which `train` trains this member alone."""
        eta, momentum = self.rate(member)
        return OnlineSettings(
            eta=eta,
            momentum=momentum,
            rule=self.rule,
            tolerance=self.tolerance,
            epochs=self.epochs,
            order=self.order,
            seed=self.seed(member),
        )

    def network(self, member: int) -> Network:
        """The network with which this member begins."""
        seed = self.seed(member)
        return Network(
            topology=self.topology,
            activations=self.activations,
            parameters=seeded_parameters(self.topology, [seed])[0],
            card=Card(seed=seed),
        )

    def check_fit(self, patterns: Patterns) -> None:
        """Raise `ShapeError` unless the patterns have the topology's inputs and outputs."""
        got = (patterns.x.shape[1], patterns.y.shape[1])
        if got != (self.topology[0], self.topology[-1]):
            raise ShapeError(
                f"a {topology_text(self.topology)} network has {self.topology[0]} inputs and "
                f"{self.topology[-1]} outputs, the patterns have {got[0]} inputs and "
                f"{got[1]} targets"
            )

    def plain(self) -> dict[str, Any]:
        """The settings as JSON has them."""
        return json.loads(canonical_json(dataclasses.asdict(self)))


def _check_list(name: str, numbers: tuple[float, ...]) -> None:
    if not numbers:
        raise SettingError(f"a sweep needs at least one {name}")
    seen: set[float] = set()
    for number in numbers:
        if number in seen:
            raise SettingError(f"{name} {number!r} stands twice in the list")
        seen.add(number)
