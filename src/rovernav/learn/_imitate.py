"""Imitation: a network learns to choose headings from a planner that knows no more than it does.

In the first round the teacher drives generated worlds, in the later ones the student does, and at
every place the teacher says how likely each heading should be (DAgger: Ross, Gordon and Bagnell
2011, AISTATS). The label is a distribution, because a mean of "left" and "right" is the rock.
"""

from __future__ import annotations

import dataclasses
import io
import itertools
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from ..control import HeadingCodec, NeuralController, SensedPlanner
from ..core import (
    F64,
    Controller,
    Executor,
    FileError,
    Outcome,
    Serial,
    SettingError,
    canonical_json,
    read_bytes,
    sha256_of,
    value,
    write_atomic,
)
from ..nets import Card, Network, load_network, save_network
from ..rover import Rover, read_rover
from ..scenes import Scene, equip, free_pairs, pair_mission, practice_grid
from ..sim import Worlds, begin, tick
from ._batch_settings import BatchSettings
from ._minibatch import train_batches
from ._patterns import Patterns
from ._recipe import Recipe

MAX_BYTES = 4_000_000_000


@value
class Lesson:
    """One progress event of a teaching.

    Attributes:
        round: Which round, from 1.
        rounds: How many.
        doing: ``driving`` or ``learning``.
        share: Share of this round done, 0 to 1.
        patterns: Patterns gathered so far.
        reached: Share of this round's drives that reached their goals; NaN while unknown.
        loss: Mean cross-entropy of the last epoch; NaN while unknown.
    """

    round: int
    rounds: int
    doing: str
    share: float
    patterns: int
    reached: float
    loss: float


Listener = Callable[[Lesson], None]


def teach(
    recipe: Recipe,
    folder: Path,
    *,
    executor: Executor | None = None,
    on_event: Listener | None = None,
) -> Network:
    """Teach a driver, or go on with a teaching that was stopped.

    Every finished round is kept in `folder`, so nothing but the round in work is lost by a crash,
    and the result has the same bits as without it.

    Args:
        recipe: Everything that matters.
        folder: Where rounds are kept; one recipe, one folder.
        executor: Who drives, one world at a time; this thread where not given. The bits are the
            same.
        on_event: Told after every world and epoch.

    Returns:
        The network, its card naming codec and recipe.

    Raises:
        SettingError: The folder holds rounds of another recipe, or the recipe cannot be used.
    """
    rover = read_rover(recipe.rover)
    if rover.drive != "differential":
        raise SettingError(f"rover {rover.name} has no differential drive; teach one that has")
    codec = HeadingCodec(speed=rover.speed, turn_rate=rover.turn_rate)
    _check_folder(recipe, folder)
    network = fresh_network(recipe, codec)
    tables: list[F64] = []
    for number in range(1, recipe.rounds + 1):
        tell = _Teller(recipe, number, on_event)
        table = _read_round(folder / f"round-{number}.npz")
        if table is None:
            driver = SensedPlanner(codec) if number == 1 else NeuralController(network)
            practice = _Practice(recipe=recipe, rover=rover, codec=codec, number=number)
            table = _drive_round(practice, driver, executor or Serial(), tell)
            _write_round(folder / f"round-{number}.npz", table)
        tables.append(table)
        kept = folder / f"network-{number}.safetensors"
        network = load_network(kept) if kept.exists() else _learn(recipe, network, tables, tell)
        if not kept.exists():
            save_network(network, kept)
    return network


def fresh_network(recipe: Recipe, codec: HeadingCodec) -> Network:
    """The untrained student: float32, tanh hidden layers, linear outputs as logits."""
    topology = (codec.rays + 3, *recipe.hidden, codec.headings)
    activations = ("tanh",) * len(recipe.hidden) + ("linear",)
    network = Network.seeded(
        topology, activations, np.random.default_rng([recipe.seed, 0]), dtype=np.float32
    )
    inputs = [f"free_{ray}" for ray in range(codec.rays)]
    card = Card(
        inputs=(*inputs, "heading_cos", "heading_sin", "goal_distance"),
        outputs=tuple(f"heading_{b}" for b in range(codec.headings)),
        input_units=("1",) * topology[0],
        output_units=("logit",) * topology[-1],
        codec=codec.settings(),
        training={"method": "imitation", "recipe": recipe.model_dump(mode="json")},
        seed=recipe.seed,
    )
    return network.with_card(card)


class _Teller:
    """Sends the events of one round."""

    def __init__(self, recipe: Recipe, number: int, on_event: Listener | None) -> None:
        self._recipe, self._number, self._on_event = recipe, number, on_event
        self.patterns, self.reached = 0, float("nan")

    def __call__(self, doing: str, share: float, loss: float = float("nan")) -> None:
        if self._on_event:
            self._on_event(
                Lesson(
                    round=self._number,
                    rounds=self._recipe.rounds,
                    doing=doing,
                    share=share,
                    patterns=self.patterns,
                    reached=self.reached,
                    loss=loss,
                )
            )


@value
class _Practice:
    """What all drives of a round share, besides the driver."""

    recipe: Recipe
    rover: Rover
    codec: HeadingCodec
    number: int


def _drive_round(practice: _Practice, driver: Controller, executor: Executor, tell: _Teller) -> F64:
    """Patterns (m, inputs + headings) of a round, its worlds in order."""
    worlds = practice.recipe.worlds
    done = itertools.count(1)
    tables: list[F64] = []
    ended: list[np.ndarray] = []
    for table, outcome in executor.map(
        _drive_world,
        range(worlds),
        shared=(practice, driver),
        on_done=lambda: tell("driving", next(done) / worlds),
    ):
        tables.append(table)
        ended.append(outcome)
        tell.patterns += len(table)
        tell.reached = float(np.mean(np.concatenate(ended) == Outcome.REACHED))
    tell("driving", 1.0)
    return np.concatenate(tables)


def _drive_world(shared: tuple[_Practice, Controller], world: int) -> tuple[F64, np.ndarray]:
    """Patterns and outcomes of one world: a job for an executor."""
    practice, driver = shared
    recipe, number = practice.recipe, practice.number
    rng = np.random.default_rng([recipe.seed, number, world])
    scene = _practice_scene(recipe, practice.rover, rng)
    every = 1 if number == 1 else recipe.every
    return _gather(scene, practice.codec, driver, recipe.steps, every)


def _practice_scene(recipe: Recipe, rover: Rover, rng: np.random.Generator) -> Scene:
    """A generated world with missions whose straight lines are blocked."""
    for _ in range(100):
        grid = practice_grid(rng, rover, side=recipe.side_m, cell=recipe.cell_m)
        try:
            starts, goals = free_pairs(
                grid, recipe.rovers, rng, nearest=recipe.side_m / 8, farthest=recipe.side_m
            )
        except SettingError:
            continue
        sensors, mapper, motion, pace = equip(rover, recipe.cell_m)
        return Scene(
            name="practice",
            worlds=Worlds.single(grid=grid, rovers=recipe.rovers),
            mission=pair_mission(starts, goals, goal_radius=0.5, pace=pace),
            sensors=sensors,
            motion=motion,
            mapper=mapper,
        )
    raise SettingError("no world of this recipe has missions with a blocked line; make it larger")


def _gather(
    scene: Scene, codec: HeadingCodec, driver: Controller, steps: int, every: int
) -> tuple[F64, np.ndarray]:
    """Drive a scene and label what was met on the way."""
    teacher = SensedPlanner(codec)
    drive = scene.drive(driver)
    state = begin(drive, np.random.default_rng(0))
    rows: list[F64] = []
    for step in range(steps):
        driving = state.rovers.driving
        if not driving.any():
            break
        state = tick(drive, state)
        seen = state.observation
        assert seen is not None
        if step % every == 0:
            labels = teacher.headings(_rows(seen.map, driving))
            rows.append(np.hstack([codec.encode(seen)[driving], labels]))
    return np.concatenate(rows), state.rovers.outcome


def _rows(local: Any, keep: np.ndarray) -> Any:
    """The maps of some rovers."""
    changes = {name: getattr(local, name)[keep] for name in ("cells", "centre", "pose", "goal")}
    return dataclasses.replace(local, **changes)


def _learn(recipe: Recipe, network: Network, tables: list[F64], tell: _Teller) -> Network:
    """Train on all rounds so far, each pattern with its mirror image."""
    card = network.card
    table = np.concatenate(tables)
    table = np.concatenate([table, mirrored(table, network.topology[0] - 3)])
    inputs = network.topology[0]
    patterns = Patterns(
        x=np.ascontiguousarray(table[:, :inputs]),
        y=np.ascontiguousarray(table[:, inputs:]),
        inputs=card.inputs,
        outputs=card.outputs,
        source="imitation",
    )
    last = len(tables) == recipe.rounds
    settings = BatchSettings(
        optimizer="adam", loss="softmax", eta=recipe.eta, batch=min(recipe.batch, len(table)),
        epochs=recipe.epochs * (2 if last else 1), tolerance=0.0, schedule="cosine",
        seed=recipe.seed + len(tables),
    )  # fmt: skip
    tell.patterns = len(table)
    done = train_batches(
        network,
        patterns,
        settings,
        on_event=lambda event: tell("learning", event.epoch / settings.epochs, event.loss),
    )
    return done.network.with_card(card)


def mirrored(table: F64, rays: int) -> F64:
    """The same patterns seen in a mirror: left and right change places."""
    headings = table.shape[1] - rays - 3
    out = table.copy()
    out[:, :rays] = table[:, -np.arange(rays) % rays]
    out[:, rays + 1] = -table[:, rays + 1]
    out[:, rays + 3 :] = table[:, rays + 3 + (-np.arange(headings) % headings)]
    return out


def _check_folder(recipe: Recipe, folder: Path) -> None:
    """Make sure that the folder is this recipe's."""
    from ..core import write_text

    text = canonical_json(recipe.model_dump(mode="json"))
    path = folder / "recipe.json"
    if not path.exists():
        write_text(path, text)
    elif path.read_text(encoding="utf-8") != text:
        raise SettingError(f"{folder} holds rounds of another recipe; name another folder")


def _write_round(path: Path, table: F64) -> None:
    buffer = io.BytesIO()
    digest = sha256_of(table.tobytes())
    np.savez(buffer, allow_pickle=False, table=table, sha256=np.array(digest))
    write_atomic(path, lambda file: file.write(buffer.getvalue()) and None)


def _read_round(path: Path) -> F64 | None:
    """The patterns of a finished round, or None if it is not there."""
    if not path.exists():
        return None
    try:
        data = read_bytes(path, limit=MAX_BYTES, what="round of a teaching")
        with np.load(io.BytesIO(data), allow_pickle=False) as file:
            table, digest = file["table"], str(file["sha256"])
    except (ValueError, KeyError, OSError, EOFError, zipfile.BadZipFile):
        table, digest = np.empty(0), ""
    if sha256_of(table.tobytes()) != digest:
        raise FileError(f"{path} is damaged; delete it, and this round is driven again")
    return table
