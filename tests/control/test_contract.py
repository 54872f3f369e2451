"""Our controllers keep their contract, and the checker notices those that do not."""

from __future__ import annotations

import dataclasses
import itertools
import math
import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from rovernav.control import (
    GoalSeeker,
    HeadingCodec,
    NeuralController,
    SensedPlanner,
    check_controller,
)
from rovernav.core import Command, ContractError, Mission, Observation
from rovernav.learn import paper_network, trained_paper_network
from rovernav.nets import Card, Network
from tests.control.observations import bassil, scanned
from tests.sim.drives import Always, Mirrored


@pytest.mark.parametrize(
    "controller",
    [
        NeuralController(trained_paper_network()),
        NeuralController(trained_paper_network("bassil-replay-v1")),
        NeuralController(paper_network()),
        Mirrored(NeuralController(paper_network())),
        Always(1.0, 2.0, 3.0),
    ],
)
def test_controllers_keep_their_contract(controller: Any) -> None:
    check_controller(controller, bassil)
    check_controller(controller, bassil, rovers=1, steps=1, seed=4)


def heading_network() -> Network:
    codec = HeadingCodec()
    network = Network.seeded((67, 16, 32), ("tanh", "linear"), np.random.default_rng(0))
    return network.with_card(Card(codec=codec.settings()))


@pytest.mark.parametrize(
    "controller", [GoalSeeker(), SensedPlanner(), NeuralController(heading_network())]
)
def test_drivers_by_map_keep_their_contract(controller: Any) -> None:
    check_controller(controller, scanned)


@dataclasses.dataclass
class Broken:
    """A controller with one fault: `fault` gives its twists."""

    fault: Callable[[Broken, Observation, Any], Any]
    count: Any = dataclasses.field(default_factory=itertools.count)
    seen: float = 0.0

    def start(self, mission: Mission, rng: np.random.Generator) -> Any:
        self.seen = 0.0
        return {"rng": rng, "steps": [0]}

    def act(self, observation: Observation, memory: Any) -> tuple[Command, Any]:
        return Command(twist=self.fault(self, observation, memory)), memory


def forward(seen: Observation, speed: Any) -> np.ndarray:
    return np.broadcast_to(np.asarray(speed)[..., None], (len(seen.goal), 3)).copy()


def keeps(driver: Broken, seen: Observation, memory: Any) -> np.ndarray:
    driver.seen = max(driver.seen, float(seen.goal.max()))
    return forward(seen, driver.seen)


def counts(_: Broken, seen: Observation, memory: Any) -> np.ndarray:
    memory["steps"][0] += 1
    return forward(seen, float(memory["steps"][0]))


def writes(_: Broken, seen: Observation, memory: Any) -> np.ndarray:
    seen.goal[:, 1] = 0.0
    return forward(seen, 1.0)


def writes_by_force(_: Broken, seen: Observation, memory: Any) -> np.ndarray:
    goal = seen.goal if seen.goal.base is None else seen.goal.base
    goal.flags.writeable = True
    goal *= 2.0
    return forward(seen, 1.0)


MEMORY = "the same memory gives another result the next time"
FAULTS = [
    (lambda s, o, m: forward(o, 1.0)[:1], "a command's twist must be float64 (5, 3), got"),
    (lambda s, o, m: forward(o, 1.0)[:, :2], "a command's twist must be float64 (5, 3), got"),
    (lambda s, o, m: forward(o, 1.0).astype(np.float32), "must be float64 (5, 3), got float32"),
    (lambda s, o, m: [[0.0] * 3] * len(o.goal), "must be float64 (5, 3), got list (5, 3)"),
    (lambda s, o, m: forward(o, math.nan), "a command is not finite"),
    (lambda s, o, m: forward(o, math.inf), "a command is not finite"),
    (lambda s, o, m: forward(o, float(next(s.count))), MEMORY),
    (lambda s, o, m: m["rng"].normal(size=(len(o.goal), 3)), MEMORY),
    (counts, MEMORY),
    (keeps, "another drive beside it changes the result"),
    (lambda s, o, m: forward(o, o.goal[:, 0] / np.abs(o.goal).max()), "alone gets another result"),
    (lambda s, o, m: forward(o, np.cumsum(o.goal[:, 0])), "rover 1 alone gets another result"),
    (lambda s, o, m: forward(o, np.arange(len(o.goal)) / 7), "rover 1 alone gets another result"),
    (writes, "it tries to change what it is given"),
    (writes_by_force, "it changes what it is given"),
]


@pytest.mark.parametrize(("fault", "sentence"), FAULTS)
def test_broken_controllers_are_noticed(fault: Any, sentence: str) -> None:
    with pytest.raises(ContractError, match=f"^controller Broken: .*{re.escape(sentence)}"):
        check_controller(Broken(fault), bassil)


def test_a_result_that_only_the_order_changes_is_noticed() -> None:
    def first_is_special(_: Broken, seen: Observation, memory: Any) -> np.ndarray:
        alone = len(seen.goal) == 1
        return forward(seen, seen.goal[:, 0] + (0.0 if alone else 1e-9 * (seen.goal[0, 0] > 9)))

    check_controller(Broken(first_is_special), bassil)

    def far_first(n: int, rng: np.random.Generator) -> Observation:
        seen = bassil(n, rng)
        goal = seen.goal.copy()
        goal[-1, 0] = 10.0
        return dataclasses.replace(seen, goal=goal)

    with pytest.raises(ContractError, match="the result depends on the order of the rovers"):
        check_controller(Broken(first_is_special), far_first)


def test_errors_of_the_controller_itself_pass_through() -> None:
    def fails(_: Broken, seen: Observation, memory: Any) -> np.ndarray:
        raise ValueError("out of coffee")

    with pytest.raises(ValueError, match="out of coffee"):
        check_controller(Broken(fails), bassil)


def test_what_is_no_controller_is_told_so() -> None:
    with pytest.raises(ContractError, match="controller int is no controller: it needs start and"):
        check_controller(42, bassil)
