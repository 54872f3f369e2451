"""A drive under the hands of a person: a world, who drives in it, and what became of it.

A plain class: tested without a page, it goes on while no page looks at it.
"""

from __future__ import annotations

import dataclasses
import functools
import secrets
import tempfile
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, final

from ..core import FileError, RovernavError, SettingError, suggest
from ..learn import controller_names, find_controller, rover_of, usual_rover
from ..nets import Network, parse_network
from ..rover import presets, read_rover
from ..terrain import open_raster
from ._drive_keep import UPLOADS, kept_drive, world_from
from ._drive_run import DriveRun, Entry, Pick
from ._drive_world import Obstacle, Surfaces, World, checked, flat_worlds
from ._playback import Playback

LIVE = Pick("train", "Train tab")
SLICE = 0.02
"""Work between two looks at whether to go on [s]."""
MOST_PICKS, FIRST = 8, "bassil-v1"
MAX_NETWORK, MAX_TERRAIN = 8_000_000, 48_000_000
"""Bytes of an uploaded network, and of an uploaded elevation model."""
MOST_CELLS = 25_000_000
"""Cells of an uploaded elevation model."""


@final
class DriveModel:
    """World, controllers, drives and playback of one session.

    Args:
        current_network: The Train tab's network now.
        keep: Keeps a finished drive in the library; returns its name there.
    """

    def __init__(self, *, current_network: Callable[[], Network], keep: Callable[..., str]) -> None:
        self._network, self._keep = current_network, keep
        self.surfaces, self.playback = Surfaces(), Playback()
        self.flat = flat_worlds()
        self.world = self.flat[FIRST]
        self.files: dict[str, tuple[Path, float | None]] = {}
        self.uploads: dict[str, Pick] = {}
        self.picked: list[str] = [LIVE.key]
        self.runs: list[DriveRun] = []
        self.refused: list[tuple[Pick, str]] = []
        self.changes = 0
        self._undo, self._redo = list[World](), list[World]()
        self._folder: tempfile.TemporaryDirectory[str] | None = None
        self._go_on = threading.Event()
        self._go_on.set()
        self._job: object = None
        self._thread: threading.Thread | None = None

    # -- the world

    def set_world(self, world: World, *, settle: bool = False) -> None:
        """Take another world, which `undo` takes back.

        Args:
            world: The new one.
            settle: Move start and goal to where all usual rovers can stand.

        Raises:
            RovernavError: It cannot be driven in; the old one stays.
        """
        checked(world)
        if settle:
            world = self.surfaces.settle(world, list({*self.rovers(world), *_usual_rovers()}))
        if world != self.world:
            self._undo = [*self._undo[-99:], self.world]
            self._redo.clear()
            self._show(world)

    def change(self, *, settle: bool = False, **fields: Any) -> None:
        """Change parts of the world; see `set_world`."""
        self.set_world(dataclasses.replace(self.world, **fields), settle=settle)

    def undo(self) -> None:
        """Take back the last change of the world."""
        if self._undo:
            self._redo.append(self.world)
            self._show(self._undo.pop())

    def redo(self) -> None:
        """Make the change again that was taken back last."""
        if self._redo:
            self._undo.append(self.world)
            self._show(self._redo.pop())

    def _show(self, world: World) -> None:
        self.world = world
        self.changes += 1

    def place(self, end: str, x: float, y: float) -> None:
        """Put ``start`` or ``goal`` at a point.

        Raises:
            RovernavError: The rover cannot stand there; the sentence says why.
        """
        world = dataclasses.replace(self.world, **{end: (x, y)})
        for rover in self.rovers(world):
            self.surfaces.check_end(world, end, rover)
        self.set_world(world)

    def draw(self, kind: str, numbers: Sequence[float]) -> None:
        """Draw an obstacle.

        Raises:
            SettingError: It is none.
        """
        obstacle = Obstacle(str(kind), tuple(round(float(n), 3) for n in numbers))
        self.change(obstacles=(*self.world.obstacles, obstacle))

    def delete(self, index: int) -> None:
        """Delete an obstacle."""
        kept = [each for i, each in enumerate(self.world.obstacles) if i != index]
        self.change(obstacles=tuple(kept))

    def obstacle_at(self, x: float, y: float) -> int | None:
        """The obstacle under a point, the last drawn first."""
        for i in reversed(range(len(self.world.obstacles))):
            if self.world.obstacles[i].holds(x, y):
                return i
        return None

    def offer_terrain(self, path: Path, cell: float | None = None) -> str:
        """Offer an elevation model that was named when the studio was started."""
        self.files.setdefault(path.name, (path, cell))
        return path.name

    def upload_terrain(self, name: str, data: bytes, *, cell: float | None = None) -> str:
        """Take in an uploaded elevation model, through a file of ours.

        Args:
            name: What it is called; only shown.
            data: Its bytes.
            cell: Side of a cell, where the file does not say it [m].

        Returns:
            Under which name it is offered.

        Raises:
            FileError: Too large, or no elevation model.
        """
        if len(data) > MAX_TERRAIN:
            raise FileError(f"an uploaded elevation model may have {MAX_TERRAIN:,} bytes")
        if not data.startswith((b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")):
            raise FileError("that is no GeoTIFF; upload an elevation model in that format")
        if self._folder is None:
            self._folder = tempfile.TemporaryDirectory(prefix=UPLOADS)
        path = Path(self._folder.name) / f"{secrets.token_hex(8)}.tif"
        path.write_bytes(data)
        shown = _free_name("".join(c for c in name if c.isprintable())[:60], self.files)
        world = World(ground="file", file=path, cell=cell, title=shown)
        try:
            rows, columns = open_raster(path, cell=cell).frame.shape
            if rows * columns > MOST_CELLS:
                raise FileError(
                    f"{shown} has {columns:,} x {rows:,} cells, more than {MOST_CELLS:,}; crop it "
                    "first (gdal_translate -srcwin XOFF YOFF WIDTH HEIGHT IN OUT.tif)"
                )
            self.surfaces.terrain(world)
        except RovernavError as error:
            path.unlink(missing_ok=True)
            raise FileError(str(error).replace(str(path), shown)) from None
        self.files[shown] = (path, cell)
        return shown

    def file_world(self, shown: str) -> World:
        """A world on an offered elevation model, start and goal across it."""
        if shown not in self.files:
            raise SettingError(f"no elevation model {shown!r}; {suggest(shown, self.files)}")
        path, cell = self.files[shown]
        world = World(ground="file", file=path, cell=cell, title=shown)
        _, _, width, height = self.surfaces.window(world)
        ends = {"start": (0.3 * width, 0.3 * height), "goal": (0.7 * width, 0.7 * height)}
        return dataclasses.replace(world, **ends)

    # -- who drives

    def controllers(self) -> dict[str, str]:
        """Everyone who could drive, by key: words for each."""
        named = {key: f"{key}: {words}" for key, words in controller_names().items()}
        uploads = {key: pick.label for key, pick in self.uploads.items()}
        return {LIVE.key: "The Train tab's network, as it is now", **named, **uploads}

    def choose(self, keys: Sequence[str]) -> None:
        """Let these drive.

        Raises:
            SettingError: Nobody of that name, or too many.
        """
        known = self.controllers()
        for key in keys:
            if key not in known:
                raise SettingError(f"no controller {key!r}; {suggest(key, known)}")
        if len(keys) > MOST_PICKS:
            raise SettingError(f"at most {MOST_PICKS} controllers can be compared at once")
        self.picked = list(dict.fromkeys(keys))

    def upload_network(self, name: str, data: bytes) -> str:
        """Take in a network file; returns its key.

        Raises:
            FileError: No network file.
            SettingError: It is no driver.
        """
        if len(data) > MAX_NETWORK:
            raise FileError(f"an uploaded network may have {MAX_NETWORK:,} bytes")
        shown = "".join(c for c in name if c.isprintable())[:60] or "network"
        network = parse_network(data, shown)
        _driver(network)
        key = f"file:{len(self.uploads) + 1}"
        self.uploads[key] = Pick(key, shown, network)
        return key

    def pick(self, key: str) -> Pick:
        """The controller of a key."""
        if key == LIVE.key:
            return LIVE
        return self.uploads.get(key) or Pick(key, key)

    def rovers(self, world: World) -> list[str]:
        """The rovers that the chosen controllers will drive."""
        found: list[str] = []
        for key in self.picked:
            try:
                found.append(self._seat(self.pick(key), world)[2])
            except RovernavError:  # it cannot drive, and will be told so when it shall
                continue
        return list(dict.fromkeys(found)) or [world.rover or "paper-point"]

    def _seat(self, pick: Pick, world: World) -> tuple[Any, Network | None, str, str]:
        """Controller, its network if it is no registered one, its rover, and a note on that."""
        network = self._network() if pick.key == LIVE.key else pick.network
        controller = find_controller(pick.key) if network is None else _driver(network)
        usual = rover_of(controller)
        if not world.rover or read_rover(world.rover).drive == read_rover(usual).drive:
            return controller, network, world.rover or usual, ""
        return controller, network, usual, f"drives {usual}: {world.rover} has another drive"

    # -- driving

    def drive(self) -> None:
        """Let everyone drive who was chosen, in the background, and play it from the start."""
        if not self.picked:
            raise SettingError("nobody was chosen to drive; choose a controller")
        self.stop()
        job = self._job = object()
        self.runs, self.refused = [], []
        self._go_on.set()
        entries = [self.pick(key) for key in self.picked]
        self.playback.begin()
        self._thread = threading.Thread(
            target=self._work, args=(job, self.world, entries, secrets.token_hex(4)), daemon=True
        )
        self._thread.start()

    def pause(self) -> None:
        """Hold drive and playback."""
        self._go_on.clear()
        self.playback.hold()

    def resume(self) -> None:
        """Go on; from the start if the end was reached."""
        self._go_on.set()
        self.playback.play(self.length)

    def stop(self) -> None:
        """Give up what is still being driven."""
        self._job = None
        self._go_on.set()
        thread, self._thread = self._thread, None
        if thread is not None and thread is not threading.current_thread():
            thread.join(timeout=10.0)

    def close(self) -> None:
        """Stop, and remove the files of uploads."""
        self.stop()
        if self._folder is not None:
            self._folder.cleanup()
            self._folder = None

    @property
    def running(self) -> bool:
        """Whether something is being driven."""
        thread = self._thread
        return thread is not None and thread.is_alive()

    @property
    def paused(self) -> bool:
        """Whether drive and playback are held."""
        return not self.playback.playing

    @property
    def length(self) -> float:
        """How long the longest drive is so far [s]."""
        return max((run.times[-1] for run in self.runs), default=0.0)

    def now(self) -> float:
        """Where the playback is [s]; it waits for drives that are still being driven."""
        return self.playback.now(self.length, more=self.running)

    def _work(self, job: object, world: World, picks: list[Pick], group: str) -> None:
        for pick in picks:
            try:
                run = DriveRun(self._enter(pick, world))
            except RovernavError as error:
                self.refused.append((pick, str(error)))
                continue
            if self._job is not job:
                return
            self.runs.append(run)
        pending = list(self.runs)
        while pending:
            for run in list(pending):
                self._go_on.wait()
                if self._job is not job:
                    return
                run.advance(SLICE)
                if run.ended:
                    pending.remove(run)
                    self._store(run, world, group)
                time.sleep(0.001)  # the page answers in between

    def _enter(self, pick: Pick, world: World) -> Entry:
        controller, network, rover, note = self._seat(pick, world)
        scenario, scene = self.surfaces.scene(world, pick.controller_name, rover)
        return Entry(pick, controller, network, scenario, scene, read_rover(rover), note)

    def _store(self, run: DriveRun, world: World, group: str) -> None:
        if run.trace is None:
            return
        try:
            run.kept = self._keep(**kept_drive(run, world, group))
        except RovernavError as error:
            run.note = f"{run.note} not kept: {error}".strip()

    # -- from the library

    def restore(self, settings: dict[str, Any], files: dict[str, bytes]) -> None:
        """Set up the world and the controller of a kept drive.

        Args:
            settings: What `kept_drive` kept.
            files: Contents by name; an uploaded network or elevation model is among them.

        Raises:
            RovernavError: They do not make a drive.
        """
        world, key = world_from(settings, self.files)
        if "terrain.tif" in files:
            shown = self.upload_terrain(world.title, files["terrain.tif"], cell=world.cell)
            world = dataclasses.replace(world, file=self.files[shown][0], title=shown)
        if "network.safetensors" in files:
            key = self.upload_network(str(settings.get("label", "")), files["network.safetensors"])
        self.choose([key])
        self.set_world(world)


def _driver(network: Network) -> Any:
    from ..control import NeuralController

    return NeuralController(network)


def _free_name(name: str, taken: Any) -> str:
    name = name or "terrain.tif"
    number, free = 1, name
    while free in taken:
        number += 1
        free = f"{name} ({number})"
    return free


@functools.cache
def _usual_rovers() -> frozenset[str]:
    """The rovers that the registered controllers are made for."""
    return frozenset(usual_rover(name) for name in controller_names())


def rover_names() -> dict[str, str]:
    """The rovers that can be chosen, by name: words for each."""
    words = {"": "the controller's usual rover"}
    for name in presets():
        rover = read_rover(name)
        size = "a point" if rover.is_point else f"{rover.length:g} x {rover.width:g} m"
        words[name] = f"{name}: {size}, {rover.drive}"
    return words
