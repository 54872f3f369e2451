"""The Drive tab: a world to draw in, who drives, the way they went, and why."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable
from functools import partial
from typing import Any, final

import numpy as np
from nicegui import events, run, ui

from ..core import RovernavError
from ..rover import Rover, read_rover
from . import _drive_map as draw
from ._drive_3d import Scene3D
from ._drive_map import HIGH, WIDE, View
from ._drive_setup import SetupPanel, number_in
from ._drive_side import SidePanel
from ._drive_strip import HIGH as STRIP
from ._drive_strip import cursor, seconds_at, strip
from ._drive_tools import TOOLS, Pen
from ._ground_picture import GroundPictures, Picture
from ._playback import SPEEDS
from ._session import Session
from ._uploads import refuse

EVERY = 0.1
"""How often the page looks whether something changed [s]."""
NEAR = 14.0
"""A click this near to a track means the track [drawing units]."""


def drive_tab(session: Session) -> None:
    """Build the tab in the present container."""
    _DriveTab(session).build()


@final
class _DriveTab:
    """The elements of the tab; the session's `DriveModel` decides everything."""

    def __init__(self, session: Session) -> None:
        self.session, self.model = session, session.drive
        for path in session.options.terrain:
            self.model.offer_terrain(path, session.options.cell)
        self.view = View.around((0.0, 0.0, 10.0, 7.0))
        self.focus = 0
        self.pen, self.turn = Pen(self.model), asyncio.Lock()
        self.pictures = GroundPictures(self.model.surfaces)
        self.picture: Picture | None = None
        self.seen: dict[str, object] = {}
        self.drag: tuple[float, float] | None = None
        self.setup = SetupPanel(self.model, self._world_changed)
        self.side = SidePanel(self.model, lambda: self.focus, self._look)

    def build(self) -> None:
        with ui.element("div").classes("rn-drive"):
            with ui.column().classes("rnd-left gap-2 no-wrap"):
                self.setup.build()
            with ui.column().classes("rn-card rnd-mid no-wrap"):
                self._toolbar()
                self._map()
                self._transport()
                self._timeline()
            with ui.column().classes("rnd-right gap-2 no-wrap"):
                self.side.build()
        self._fit()
        ui.timer(0.0, self._world_changed, once=True)
        ui.timer(EVERY, self._refresh)
        ui.keyboard(on_key=self._key)

    def _toolbar(self) -> None:
        with ui.row().classes("w-full items-center no-wrap gap-1"):
            with ui.row().classes("rnd-tools no-wrap").props('role=toolbar aria-label="Tools"'):
                self.tools = {name: self._tool_button(name) for name in TOOLS}
            ui.space()
            self.place = ui.label().classes("rn-note rn-num").mark("place")
            for icon, words, do in (
                ("add", "Closer", lambda: self._zoom(1.5)),
                ("remove", "Farther", lambda: self._zoom(1 / 1.5)),
                ("fit_screen", "All of it", self._all),
            ):
                ui.button(icon=icon, color=None, on_click=do).props(
                    f'flat dense round size=sm aria-label="{words}"').tooltip(words)  # fmt: skip
            self.flat = ui.toggle({"2D": "2D", "3D": "3D"}, value="2D", on_change=self._dimension)
            self.flat.props("dense unelevated no-caps size=sm").mark("dimension")

        self.hint = ui.label(TOOLS[self.pen.tool][1]).classes("rn-note rnd-hint")

    def _map(self) -> None:
        self.area = ui.element("div").classes("rnd-map")
        with self.area:
            self.image = ui.interactive_image(
                size=(WIDE, HIGH), on_mouse=self._mouse, sanitize=False,
                events=["mousedown", "mouseup", "dblclick"],
            ).classes("rnd-canvas").mark("map")  # fmt: skip
            names = ("ground", "world", "tracks", "ends", "moment", "frame", "draft")
            self.layers = {name: self.image.add_layer() for name in names}
            share = f"x: e.offsetX / e.target.clientWidth * {WIDE}, " \
                    f"y: e.offsetY / e.target.clientHeight * {HIGH}"  # fmt: skip
            self.image.on(
                "mousemove", self._move, throttle=0.05,
                js_handler=f"(e) => emit({{{share}, buttons: e.buttons}})",
            )  # fmt: skip
            self.image.on(
                "wheel", self._wheel, throttle=0.05,
                js_handler=f"(e) => {{ e.preventDefault(); emit({{{share}, d: e.deltaY}}) }}",
            )  # fmt: skip
        self.legend = ui.html(sanitize=False).classes("rnd-legend")
        self.space = Scene3D(self.model)
        self.space.build()

    def _transport(self) -> None:
        with ui.row().classes("w-full items-center no-wrap gap-2"):
            ui.button("Drive", icon="play_arrow", on_click=self._drive).props(
                "unelevated").mark("drive")  # fmt: skip
            self.pause = ui.button(icon="pause", color=None, on_click=self._pause).props(
                'flat dense round aria-label="Pause or go on"').mark("pause")  # fmt: skip
            for icon, words, by in (("chevron_left", "One step back", -1),
                                    ("chevron_right", "One step on", 1)):  # fmt: skip
                ui.button(icon=icon, color=None, on_click=partial(self._by, by)).props(
                    f'flat dense round aria-label="{words}"').mark(words.split()[-1])  # fmt: skip
            self.slider = ui.slider(min=0, max=1, step=0.01, value=0).props(
                'dense aria-label="Time"').classes("col").mark("time")  # fmt: skip
            self.slider.on("update:modelValue", self._scrub, throttle=0.05)
            self.clock = ui.label("0 s").classes("rn-num rnd-clock").mark("clock")
            speeds = {speed: f"{speed:g}×" for speed in SPEEDS}
            ui.select(speeds, value=self.model.playback.speed,
                      on_change=self._speed).props(
                'dense options-dense borderless aria-label="Speed"').mark("play-speed")  # fmt: skip

    def _timeline(self) -> None:
        self.strip = ui.interactive_image(
            size=(WIDE, STRIP), events=["mousedown"], sanitize=False, on_mouse=self._on_strip
        ).classes("w-full rnd-strip")  # fmt: skip
        self.strip_lines, self.strip_now = self.strip.add_layer(), self.strip.add_layer()

    # -- what the person does

    async def _drive(self) -> None:
        try:
            self.model.drive()
        except RovernavError as error:
            refuse(str(error))
            return
        self.focus = 0
        self.side.forget()

    def _speed(self, event: events.ValueChangeEventArguments[Any]) -> None:
        try:
            self.model.playback.set_speed(number_in(event.value))
        except RovernavError as error:
            refuse(str(error))

    def _pause(self) -> None:
        if self.model.paused:
            self.model.resume()
        else:
            self.model.pause()

    def _by(self, steps: int, _: object = None) -> None:
        one = self._one()
        if one is not None:
            self.model.playback.hold()
            step = max(0, min(one.step_at(self.model.now()) + steps, one.steps))
            self.model.playback.seek(one.times[step])

    def _scrub(self, event: events.GenericEventArguments) -> None:
        seconds = number_in(event.args)
        if not math.isnan(seconds):
            self.model.playback.hold()
            self.model.playback.seek(seconds)

    def _on_strip(self, event: events.MouseEventArguments) -> None:
        self.model.playback.hold()
        self.model.playback.seek(seconds_at(number_in(event.image_x, 0.0), self.model.length))

    def _tool_button(self, name: str) -> ui.button:
        icon, words = TOOLS[name]
        button = ui.button(icon=icon, color=None, on_click=lambda: self._tool(name))
        button.props(f'flat dense aria-label="{words}"').mark(f"tool-{name}")
        button.classes("rnd-tool" + (" rnd-held" if name == self.pen.tool else ""))
        return button.tooltip(words)

    async def _tool(self, name: str) -> None:
        async with self.turn:
            self.tools[self.pen.tool].classes(remove="rnd-held")
            self.pen.choose(name)
        self.tools[self.pen.tool].classes(add="rnd-held")
        self.hint.text = TOOLS[self.pen.tool][1]
        self.layers["draft"].content = ""

    async def _key(self, event: events.KeyEventArguments) -> None:
        if not event.action.keydown or self.session.tab != "Drive":
            return
        if event.key == "Escape":
            async with self.turn:
                self.pen.cancel()
            self.layers["draft"].content = ""
        elif event.key == "Enter":
            await self._draw(self.pen.close)

    def _look(self, number: int) -> None:
        self.focus = number

    async def _mouse(self, event: events.MouseEventArguments) -> None:
        x, y = number_in(event.image_x), number_in(event.image_y)
        if math.isnan(x + y):
            return
        if event.type == "mousedown" and event.button == 0:
            self.drag = (x, y)
            async with self.turn:
                self.pen.down(*self.view.place(x, y))
        elif event.type == "dblclick":
            await self._draw(self.pen.close)
        elif event.type == "mouseup" and self.drag is not None:
            await self._up(x, y)

    async def _up(self, x: float, y: float) -> None:
        assert self.drag is not None
        (x0, y0), self.drag = self.drag, None
        still = math.hypot(x - x0, y - y0) < 4.0
        if self.pen.tool == "look":
            if still:
                await self._ask_near(x, y)
            else:
                await self._set_view(self.view.moved(x - x0, y - y0))
            return
        await self._draw(lambda: self.pen.up(*self.view.place(x, y), still=still))

    async def _draw(self, do: Callable[[], bool]) -> None:
        """What the pen does takes a thread, and its turn: a corner comes before its Enter."""
        try:
            async with self.turn:
                changed = await run.io_bound(do)
        except RovernavError as error:
            self.pen.cancel()
            refuse(str(error))
            changed = False
        self.layers["draft"].content = self.pen.draft(self.view)
        if changed:
            self.setup.fill()
            await self._world_changed()

    def _move(self, event: events.GenericEventArguments) -> None:
        x, y = _numbers(event.args, "x", "y")
        if math.isnan(x + y):
            return
        px, py = self.view.place(x, y)
        self.place.text = (
            f"{px:.2f}, {py:.2f} m{self.pictures.height_words(self.model.world, px, py)}"
        )
        if self.pen.begun:
            self.pen.move(px, py)
            self.layers["draft"].content = self.pen.draft(self.view)

    async def _wheel(self, event: events.GenericEventArguments) -> None:
        x, y, d = _numbers(event.args, "x", "y", "d")
        if not math.isnan(x + y + d):
            await self._set_view(self.view.zoomed(1.25 if d < 0 else 0.8, x, y))

    async def _ask_near(self, x: float, y: float) -> None:
        """Look at the step of a track that was clicked, and tell why."""
        best: tuple[float, int, int] = (NEAR, -1, 0)
        for i, one in enumerate(self.model.runs):
            places = np.array(one.poses[: one.steps + 1])[:, :2]
            px, py = self.view.at(places[:, 0], places[:, 1])
            gaps = np.hypot(px - x, py - y)
            best = min(best, (float(gaps.min()), i, int(gaps.argmin())))
        if best[1] < 0:
            return
        _, self.focus, step = best
        one = self.model.runs[self.focus]
        self.model.playback.hold()
        self.model.playback.seek(one.times[min(step, max(one.steps - 1, 0))])
        await self.side.ask()

    # -- what is shown

    def _one(self) -> Any:
        runs = self.model.runs
        return runs[self.focus] if 0 <= self.focus < len(runs) else None

    def _fit(self) -> None:
        margin = 0.0 if self.model.world.flat else 0.03
        self.view = View.around(self.model.surfaces.window(self.model.world), margin=margin)
        self.seen.clear()

    async def _zoom(self, factor: float) -> None:
        await self._set_view(self.view.zoomed(factor))

    async def _all(self) -> None:
        self._fit()
        await self._world_changed(fit=False)

    async def _set_view(self, view: View) -> None:
        self.view = view
        self.seen.clear()
        await self._world_changed(fit=False)

    async def _world_changed(self, *, fit: bool = True) -> None:
        """Draw ground and obstacles anew, the ground's picture away from the page's own thread."""
        world = self.model.world
        if fit and self.seen.get("surface") != (world.surface, world.flat):
            self._fit()
            self.seen["surface"] = (world.surface, world.flat)
        rover = read_rover(self.model.rovers(world)[0])
        self._show_world(rover)
        self.picture = await run.io_bound(self.pictures.of, world, rover, self.view)
        if world is self.model.world:
            self._show_world(rover)
        if self.flat.value == "3D":
            await self.space.show()

    def _show_world(self, rover: Rover) -> None:
        picture = None if self.model.world.flat else self.picture
        address, window = (picture.address, picture.window) if picture else ("", None)
        self.layers["ground"].content = draw.ground_layer(self.view, address, window)
        self.layers["world"].content = draw.world_layer(
            self.view, self.model.world, grown=rover.radius
        )
        self.legend.content = "" if picture is None else self.pictures.legend(rover)
        self.layers["ends"].content = draw.ends_layer(self.view, self.model.world)
        self.layers["frame"].content = draw.frame_layer(self.view)

    async def _dimension(self, event: events.ValueChangeEventArguments[Any]) -> None:
        deep = event.value == "3D"
        self.area.set_visibility(not deep)
        await self.space.turn(deep)

    def _refresh(self) -> None:
        if self.session.tab != "Drive":
            return
        model = self.model
        if self.seen.get("changes") != model.changes:
            self.seen["changes"] = model.changes
            self.setup.fill()
            ui.timer(0.0, self._world_changed, once=True)
        now, length = model.now(), model.length
        drawn = (tuple((id(r), r.steps, r.ended) for r in model.runs), self.focus, self.view)
        if self.seen.get("tracks") != drawn:
            self.seen["tracks"] = drawn
            self.layers["tracks"].content = draw.tracks_layer(self.view, model.runs, self.focus)
            self.strip_lines.content = strip(model.runs, self.focus, length)
            self.slider.props(f"max={max(length, 0.01)}")
        self.side.show_table()
        moment = (drawn, now)
        if self.seen.get("moment") != moment:
            self.seen["moment"] = moment
            self._show_moment(now, length)
        icon = "play_arrow" if model.paused else "pause"
        if self.pause.props.get("icon") != icon:
            self.pause.props(f"icon={icon}")

    def _show_moment(self, now: float, length: float) -> None:
        self.layers["moment"].content = draw.moment_layer(
            self.view, self.model.runs, now, self.focus
        )
        self.strip_now.content = cursor(now, length) if self.model.runs else ""
        self.slider.set_value(now)
        self.clock.text = f"{now:.1f} of {length:.0f} s"
        one = self._one()
        if one is not None:
            self.side.show_moment(one, one.step_at(now))
            self.space.moment(now, self.focus)


def _numbers(args: Any, *keys: str) -> list[float]:
    """Numbers out of what a browser sent; NaN for what is none."""
    found = args if isinstance(args, dict) else {}
    return [number_in(found.get(key)) for key in keys]
