"""Settings of mini-batch training."""

from __future__ import annotations

import math

from ..core import SettingError, suggest, value
from ..kernels import descent
from ..nets import LOSSES

OPTIMIZERS = {"adam": descent.ADAM, "sgd": descent.SGD}
SCHEDULES = ("constant", "cosine")
_WHOLE = (
    ("batch", 1, 10**6, "10^6"),
    ("shards", 1, 1024, "1024"),
    ("epochs", 0, 10**12, "10^12"),
    ("seed", 0, 2**63 - 1, "2^63 - 1"),
)
"""Whole numbers: name, least, most, and most as it is written."""
_ORDERS = ("cyclic", "shuffled")


@value
class BatchSettings:
    """Settings of mini-batch back-propagation.

    Attributes:
        optimizer: ``sgd`` (with momentum) or ``adam`` (Kingma and Ba 2015; beta1 0.9,
            beta2 0.999, epsilon 1e-8).
        eta: Learning rate.
        momentum: Share of a weight's last change that is repeated; only for ``sgd``.
        loss: ``mse``, ``softmax`` or ``binary``: see `nets.LOSSES`.
        batch: Patterns per update; the last batch of an epoch has the rest.
        epochs: Epochs at most.
        tolerance: Stop after an epoch whose mean loss is below this; 0 does all epochs.
        order: ``shuffled`` (anew each epoch, from `seed` and the epoch's number alone) or
            ``cyclic`` (the table's order).
        seed: Seed of the shuffled order.
        schedule: ``constant``, or ``cosine``: the rate falls from `eta` to 0 along half a cosine
            over `epochs`, one value per epoch (Loshchilov and Hutter 2017, equation 5).
        validation: Share of the table, its last rows, that is not learnt but only measured.
        shards: Parts of a batch whose gradients are summed by themselves and then added in their
            order. The last bits of the weights depend on it, never on how many workers share the
            shards out: 1 has no use for a second worker, 8 feeds up to eight.
    """

    optimizer: str = "adam"
    eta: float = 0.001
    momentum: float = 0.9
    loss: str = "mse"
    batch: int = 256
    epochs: int = 100
    tolerance: float = 0.0
    order: str = "shuffled"
    seed: int = 0
    schedule: str = "constant"
    validation: float = 0.0
    shards: int = 1

    def _check(self) -> None:
        for what, name, allowed in (
            ("optimizer", self.optimizer, OPTIMIZERS),
            ("loss", self.loss, LOSSES),
            ("order", self.order, _ORDERS),
            ("schedule", self.schedule, SCHEDULES),
        ):
            if name not in allowed:
                raise SettingError(f"unknown {what} {name!r}; {suggest(name, allowed)}")
        if not (math.isfinite(self.eta) and self.eta > 0):
            raise SettingError(f"eta must be a number above 0, got {self.eta!r}")
        if not 0 <= self.momentum < 1:
            raise SettingError(f"momentum must be from 0 to below 1, got {self.momentum!r}")
        if not (math.isfinite(self.tolerance) and self.tolerance >= 0):
            raise SettingError(f"tolerance must be 0 or above, got {self.tolerance!r}")
        if not 0 <= self.validation < 1:
            raise SettingError(f"validation must be from 0 to below 1, got {self.validation!r}")
        for name, low, high, text in _WHOLE:
            if not low <= getattr(self, name) <= high:
                raise SettingError(
                    f"{name} must be from {low} to {text}, got {getattr(self, name)!r}"
                )

    def eta_at(self, epoch: int) -> float:
        """The learning rate of epoch number `epoch`; the first is 0."""
        if self.schedule == "constant":
            return float(self.eta)
        return 0.5 * self.eta * (1.0 + math.cos(math.pi * epoch / self.epochs))

    def learnt(self, rows: int) -> int:
        """How many of a table's rows are learnt; the others are held out.

        Raises:
            SettingError: A validation share is asked for, but one of the two parts is empty.
        """
        held = round(self.validation * rows)
        if self.validation and not 0 < held < rows:
            raise SettingError(
                f"validation = {self.validation!r} of {rows} patterns holds out {held}; "
                "both parts need at least one"
            )
        return rows - held
