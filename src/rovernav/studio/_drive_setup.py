"""The left column of the Drive tab: the world, the rover, who drives, what was drawn."""

from __future__ import annotations

import dataclasses
import math
import random
from collections.abc import Awaitable, Callable
from functools import partial
from html import escape
from typing import Any, final

from nicegui import run, ui

from ..core import RovernavError
from ..scenes import GENERATORS
from ._drive import MAX_NETWORK, MAX_TERRAIN, MOST_PICKS, DriveModel, rover_names
from ._drive_map import COLOURS, DASHES
from ._drive_world import World
from ._uploads import refuse, upload_button

ROCKS = (0.0, 0.2)
"""Share of the ground that the rocks slider covers."""
_ENDS = ("start x", "start y", "goal x", "goal y")
SOME_ROCKS = 0.02
"""Share of fresh ground that rocks cover."""
NICE = {
    "bassil-v1": "The paper's scene",
    "bassil-mirrored-v1": "The paper's scene, mirrored obstacle",
    "bassil-free-v1": "The paper's scene, no obstacle",
}
"""Kinder names for some worlds; others are shown by their own."""


@final
class SetupPanel:
    """World, rover, controllers, obstacles.

    Args:
        model: What they set up.
        changed: Called when the world is another, to draw it anew.
    """

    def __init__(self, model: DriveModel, changed: Callable[[], Awaitable[None]]) -> None:
        self.model, self._changed = model, changed
        self._filling = False
        self._kind = "flat"
        self._sliders: dict[str, ui.slider] = {}
        self._boxes: dict[str, tuple[ui.checkbox, ui.html]] = {}

    def build(self) -> None:
        """Build the column in the present container."""
        with ui.column().classes("rn-card w-full"):
            ui.label("World").classes("rn-title")
            self.ground = ui.select(self._grounds(), on_change=self._by_hand(self._choose_ground))
            self.ground.props('dense options-dense outlined aria-label="World"')
            self.ground.classes("w-full").mark("world")
            self.made = ui.column().classes("w-full gap-1")
            with ui.row().classes("w-full items-center gap-1 no-wrap"):
                upload_button("GeoTIFF", kinds=(".tif", ".tiff"), limit=MAX_TERRAIN,
                              on_file=self._take_terrain)  # fmt: skip
                self.cell = ui.number("cell [m]", min=0.01, max=1e6, step=0.1).props(
                    "dense clearable").classes("w-24")  # fmt: skip
                self.cell.tooltip("Only for a GeoTIFF that does not say how large its cells are")
        with ui.column().classes("rn-card w-full"):
            ui.label("Who drives").classes("rn-title")
            self.picks = ui.column().classes("w-full gap-0")
            upload_button("Network file", kinds=(".safetensors",), limit=MAX_NETWORK,
                          on_file=self._take_network)  # fmt: skip
            self.rover = ui.select(
                rover_names(), label="Rover", on_change=self._by_hand(self._choose_rover)
            )
            self.rover.props("dense options-dense outlined").classes("w-full").mark("rover")
        with ui.column().classes("rn-card w-full"):
            self._ends_and_obstacles()
        self.fill()

    def _ends_and_obstacles(self) -> None:
        with ui.row().classes("w-full items-center no-wrap"):
            ui.label("Start, goal and obstacles").classes("rn-title")
            ui.space()
            for icon, words, do in (
                ("undo", "Undo", self.model.undo),
                ("redo", "Redo", self.model.redo),
                ("delete_sweep", "Delete all obstacles", self._clear),
            ):
                ui.button(icon=icon, color=None, on_click=self._doing(do)).props(
                    f'flat dense round size=sm aria-label="{words}"'
                ).tooltip(words).mark(words.split()[0].lower())  # fmt: skip
        with ui.row().classes("w-full no-wrap gap-1"):
            self.numbers = {name: self._end(name) for name in _ENDS}
        self.obstacles = ui.column().classes("w-full gap-0 rnd-scroll")
        with ui.expansion("Add by numbers", icon="add").props("dense").classes("w-full rnd-add"):
            self._by_numbers()

    def _end(self, name: str) -> ui.number:
        field = ui.number(name, step=0.1, format="%.2f", on_change=self._by_hand(self._type_ends))
        return field.props("dense debounce=500").classes("col").mark(name.replace(" ", "-"))

    def _by_numbers(self) -> None:
        kinds = {"box": "rectangle: x0, y0, x1, y1", "circle": "circle: x, y, radius",
                 "polygon": "polygon: x, y, x, y, …"}  # fmt: skip
        kind = ui.select(kinds, value="circle").props("dense options-dense").classes("w-full")
        text = ui.input(placeholder="6, 0, 1.5").props("dense").classes("w-full").mark("numbers")

        async def add() -> None:
            try:
                numbers = [float(part) for part in str(text.value or "").split(",")]
            except ValueError:
                refuse("write numbers joined by commas, like 6, 0, 1.5")
                return
            await self._doing(lambda: self.model.draw(kind.value, numbers))()

        kind.mark("kind")
        text.on("keydown.enter", add)
        ui.button("Add", on_click=add).props("dense unelevated").mark("add")

    def fill(self) -> None:
        """Show the world as it is."""
        self._filling = True
        world = self.model.world
        self.ground.set_options(self._grounds(), value=self._ground_key(world))
        self.rover.value = world.rover
        for name, value in zip(self.numbers, (*world.start, *world.goal), strict=True):
            self.numbers[name].value = round(value, 3)
        self._fill_made(world)
        self._fill_obstacles(world)
        self.fill_picks()
        self._filling = False

    def fill_picks(self) -> None:
        """Show who could drive, and in which colour those will who were chosen.

        Boxes that are there already stay: somebody may be about to click the next one.
        """
        before, self._filling = self._filling, True
        known = self.model.controllers()
        if list(known) != list(self._boxes):
            self.picks.clear()
            self._boxes.clear()
            with self.picks:
                for key, words in known.items():
                    self._boxes[key] = self._box(key, words)
        for key, (box, colour) in self._boxes.items():
            box.value = key in self.model.picked
            colour.content = swatch(self.model.picked.index(key)) if box.value else ""
        self._filling = before

    def _box(self, key: str, words: str) -> tuple[ui.checkbox, ui.html]:
        def choose(event: Any) -> Any:
            return None if self._filling else self._choose(key, bool(event.value))

        with ui.row().classes("w-full items-center no-wrap gap-1"):
            box = ui.checkbox(words, on_change=choose)
            box.props("dense size=xs").classes("rnd-pick").mark(f"pick-{key}")
            box.props["aria-label"] = words
            ui.space()
            return box, ui.html()

    def _fill_made(self, world: World) -> None:
        """Show the settings of the ground; its fields stay while it is of the same kind."""
        if self._kind != world.ground:
            self._kind = world.ground
            self.made.clear()
            self._sliders.clear()
            if not world.flat:
                with self.made:
                    self._ground_fields(world)
        if world.flat:
            return
        self.seed.value = world.seed
        values: dict[str, Any] = {"rocks": world.rocks}
        if world.ground in GENERATORS:
            values |= GENERATORS[world.ground](**dict(world.made)).model_dump()
        for key, slider in self._sliders.items():
            slider.value = values[key]

    def _ground_fields(self, world: World) -> None:
        with ui.row().classes("w-full items-center no-wrap gap-1"):
            self.seed = ui.number(
                "Seed", min=0, precision=0, step=1, on_change=self._by_hand(self._type_seed)
            )
            self.seed.props("dense debounce=500").classes("col").mark("ground-seed")
            ui.button(icon="casino", color=None, on_click=self._dice).props(
                'flat dense round aria-label="Another seed"'
            ).tooltip("Another seed").mark("dice")  # fmt: skip
        if world.ground in GENERATORS:
            self._made_sliders(GENERATORS[world.ground]())
        self._sliders["rocks"] = _slider(
            "Rocks: share of the ground", (*ROCKS, 0.01),
            lambda v: self._later(rocks=v if v >= 0.005 else 0.0),
        )  # fmt: skip

    def _made_sliders(self, settings: Any) -> None:
        """A slider for each number of a generator that says its range and title."""
        for key, field in type(settings).model_fields.items():
            low, high = (_bound(field, name) for name in ("ge", "le"))
            if field.title is None or low is None or high is None:
                continue
            whole = isinstance(getattr(settings, key), int)
            bounds = (low, min(high, _NARROW.get(key, high)), 1 if whole else _step(low, high))
            self._sliders[key] = _slider(field.title, bounds, partial(self._make, key, whole))

    async def _make(self, key: str, whole: bool, value: float) -> None:
        made = {**dict(self.model.world.made), key: int(value) if whole else float(value)}
        await self._later(made=tuple(sorted(made.items())))

    async def _later(self, **fields: Any) -> None:
        """Change the ground away from the page's own thread, start and goal moved if need be."""
        await self._away(lambda: self.model.change(settle=True, **fields))

    async def _away(self, do: Callable[[], object]) -> None:
        try:
            await run.io_bound(do)
        except RovernavError as error:
            refuse(str(error))
        self.fill()
        await self._changed()

    def _by_hand(self, act: Callable[[Any], Awaitable[None]]) -> Callable[[Any], Any]:
        """A handler that answers to people alone, not to what `fill` writes into the fields.

        It has to look at once: what it starts runs later, when the filling is long over.
        """
        return lambda event: None if self._filling else act(event)

    def _doing(self, do: Callable[[], object]) -> Callable[[], Awaitable[None]]:
        async def act() -> None:
            try:
                do()
            except RovernavError as error:
                refuse(str(error))
            self.fill()
            await self._changed()

        return act

    def _clear(self) -> None:
        self.model.change(obstacles=())

    def _fill_obstacles(self, world: World) -> None:
        self.obstacles.clear()
        with self.obstacles:
            for i, each in enumerate(world.obstacles):
                with ui.row().classes("w-full items-center no-wrap gap-1"):
                    ui.label(each.words).classes("rn-note ellipsis")
                    ui.space()
                    ui.button(icon="close", color=None,
                              on_click=self._doing(lambda i=i: self.model.delete(i))).props(
                        f'flat dense round size=xs aria-label="Delete {escape(each.words)}"'
                    ).mark(f"delete-{i}")  # fmt: skip

    def _grounds(self) -> dict[str, str]:
        flat = {f"flat:{name}": NICE.get(name, name) for name in self.model.flat}
        made = {f"made:{name}": f"Generated {name}" for name in GENERATORS}
        files = {f"file:{name}": name for name in self.model.files}
        own = {} if self._ground_key(self.model.world) != "own" else {"own": "Flat, your own"}
        return {**own, **flat, **made, **files}

    def _ground_key(self, world: World) -> str:
        if world.ground == "file":
            return f"file:{world.title}"
        if not world.flat:
            return f"made:{world.ground}"
        plain = dataclasses.replace(world, rover="")
        same = (name for name, scene in self.model.flat.items() if scene == plain)
        return next((f"flat:{name}" for name in same), "own")

    async def _choose_ground(self, event: Any) -> None:
        kind, _, name = str(event.value or "").partition(":")
        if name not in {"flat": self.model.flat, "made": GENERATORS}.get(kind, self.model.files):
            return
        model, rover = self.model, self.model.world.rover

        def choose() -> None:
            if kind == "flat":
                world = model.flat[name]
            elif kind == "made":
                world = World(
                    ground=name, seed=model.world.seed, rocks=SOME_ROCKS, **_corners(name)
                )
            else:
                world = model.file_world(name)
            model.set_world(dataclasses.replace(world, rover=rover), settle=kind != "flat")

        await self._away(choose)

    async def _choose_rover(self, event: Any) -> None:
        await self._away(lambda: self.model.change(rover=str(event.value or ""), settle=True))

    async def _type_ends(self, _: object = None) -> None:
        values = [number_in(number.value) for number in self.numbers.values()]
        if math.isnan(sum(values)):
            return
        world = self.model.world
        wanted = {"start": (values[0], values[1]), "goal": (values[2], values[3])}
        for end, point in wanted.items():
            if max(abs(a - b) for a, b in zip(point, getattr(world, end), strict=True)) > 1e-3:
                await self._doing(lambda end=end, p=point: self.model.place(end, *p))()

    async def _type_seed(self, event: Any) -> None:
        seed = number_in(event.value)
        if 0 <= seed < 2**53:
            await self._later(seed=int(seed))

    async def _dice(self) -> None:
        await self._later(seed=random.SystemRandom().randrange(10_000))

    async def _choose(self, key: str, chosen: bool) -> None:
        keys = [k for k in self.model.picked if k != key] + ([key] if chosen else [])
        await self._doing(lambda: self.model.choose(keys[-MOST_PICKS:]))()

    def _take_terrain(self, name: str, data: bytes) -> None:
        async def take() -> None:
            cell = number_in(self.cell.value, 0.0)

            def read() -> None:
                shown = self.model.upload_terrain(name, data, cell=cell if cell > 0 else None)
                self.model.set_world(self.model.file_world(shown), settle=True)

            await self._away(read)

        ui.timer(0.0, take, once=True)

    def _take_network(self, name: str, data: bytes) -> None:
        key = self.model.upload_network(name, data)
        self.model.choose([*self.model.picked, key][-MOST_PICKS:])
        self.fill_picks()


def swatch(number: int) -> str:
    """The colour and dash of a track."""
    return (
        f'<svg width="34" height="10" aria-hidden="true"><line x1="1" y1="5" x2="33" y2="5" '
        f'stroke="var(--rn-{COLOURS[number % 8]})" stroke-width="4" '
        f'stroke-dasharray="{DASHES[number % 8]}"/></svg>'
    )


_NARROW = {"side_m": 200.0, "cell_m": 1.0, "relief_m": 20.0, "craters": 150}
"""Sliders stop here, where ground is quickly made; files and numbers may say more."""


def _corners(name: str) -> dict[str, Any]:
    """Start and goal across a generated ground, a fifth of its side in."""
    side = GENERATORS[name]().side_m
    return {"start": (0.2 * side, 0.2 * side), "goal": (0.8 * side, 0.8 * side)}


def _slider(
    words: str, bounds: tuple[float, float, float], do: Callable[[float], Any]
) -> ui.slider:
    low, high, step = bounds
    with ui.row().classes("w-full items-center no-wrap gap-2"):
        ui.label(words).classes("rn-note rnd-slider-name")
        slider = ui.slider(min=low, max=high, step=step, value=low).props(
            f'label dense aria-label="{escape(words)}"'
        ).classes("col")  # fmt: skip
        slider.on("change", lambda event: do(min(max(number_in(event.args, low), low), high)))
        slider.mark(words.split(":")[0].lower())
        ui.label().bind_text_from(slider, "value", lambda v: f"{v:.3g}").classes("rn-num rn-note")
    return slider


def number_in(item: Any, otherwise: float = math.nan) -> float:
    """A finite number that came from a browser, or what stands for none."""
    good = isinstance(item, (int, float)) and math.isfinite(item)
    return float(item) if good else otherwise


def _bound(field: Any, name: str) -> float | None:
    found = [getattr(each, name) for each in field.metadata if hasattr(each, name)]
    return found[0] if found else None


def _step(low: float, high: float) -> float:
    return 0.05 if high - low <= 2 else 0.5 if high - low <= 100 else 5.0
