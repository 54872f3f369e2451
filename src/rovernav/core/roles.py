"""The roles that parts of a drive play: small Protocols. A class plays a role or is final."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any, Protocol, TypeVar, runtime_checkable

import numpy as np

from .drive import Command, Mission, Observation, RoverState

Memory = Any
"""What a sensor or controller carries from step to step; passed in and out, never kept."""
Item = TypeVar("Item")
Result = TypeVar("Result")


@runtime_checkable
class Sensor(Protocol):
    """Reads one channel. It is given the world and the mission, so it may look at the truth."""

    name: str

    def start(self, mission: Mission, rng: np.random.Generator) -> Memory:
        """What the sensor remembers at the start of a drive."""
        ...

    def read(self, world: Any, state: RoverState, memory: Memory) -> tuple[Any, Memory]:
        """Readings (n, b) and the memory for the next step."""
        ...


@runtime_checkable
class Controller(Protocol):
    """Decides from what was sensed alone; it never sees the world."""

    def start(self, mission: Mission, rng: np.random.Generator) -> Memory:
        """What the controller remembers at the start of a drive."""
        ...

    def act(self, observation: Observation, memory: Memory) -> tuple[Command, Memory]:
        """The command for every row, and the memory for the next step."""
        ...


@runtime_checkable
class Metric(Protocol):
    """Says what a drive was worth; it sees the trace and the true worlds."""

    name: str
    unit: str

    def compute(self, trace: Any, worlds: Any) -> tuple[Any, Any]:
        """Values (n,), and which of them mean something (n,)."""
        ...


@runtime_checkable
class Mapper(Protocol):
    """Keeps what was sensed, and adds channels made from it to what a controller sees."""

    def start(self, mission: Mission) -> Memory:
        """An empty map for each rover."""
        ...

    def update(self, memory: Memory, pose: Any, goal: Any, channels: Any) -> tuple[Any, Memory]:
        """Further channels by name, (n, b) each, and the map with these readings in it."""
        ...


@runtime_checkable
class Motion(Protocol):
    """Moves the rovers: the only part that may change a pose."""

    period: float

    def step(self, state: RoverState, command: Command) -> RoverState:
        """The state one period [s] later, obstacles not yet considered."""
        ...


@runtime_checkable
class Codec(Protocol):
    """Turns observations into network inputs and network outputs into commands.

    Its name and parameters are stored in the network file, so driving and training cannot disagree.
    """

    @property
    def sizes(self) -> tuple[int, int]:
        """Inputs and outputs of the networks that it fits."""
        ...

    def encode(self, observation: Observation) -> Any:
        """Network inputs (n, i)."""
        ...

    def decode(self, outputs: Any, observation: Observation) -> Command:
        """The command that the network's outputs (n, o) mean."""
        ...

    def settings(self) -> dict[str, Any]:
        """Name and parameters, JSON-able; enough to build this codec again."""
        ...


@runtime_checkable
class Executor(Protocol):
    """Runs a job over items: the same items give the same results in order, whoever runs it."""

    workers: int

    def map(
        self,
        job: Callable[[Any, Item], Result],
        items: Iterable[Item],
        *,
        shared: Any = None,
        on_done: Callable[[], object] | None = None,
    ) -> Iterator[Result]:
        """The results of ``job(shared, item)``, in the order of the items.

        Args:
            job: A function that other processes can import by its name.
            items: What to do; drawn as they are needed, a few per worker ahead.
            shared: What every item needs; sent once to each worker, and not again for the next map
                if that shares the same frozen value.
            on_done: Called, in any thread, each time an item is done: for progress.
        """
        ...
