"""Drive and Lessons with a simulated user, in this process."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from typing import Any

import pytest
from nicegui import ui
from nicegui.testing import User

from rovernav.core import Outcome
from rovernav.studio import Sessions
from rovernav.studio._drive_map import HIGH, WIDE, View
from rovernav.studio._drive_tools import Pen

Play = Callable[[Callable[[User, Sessions], Any]], None]


async def until(check: Callable[[], object], seconds: float = 60.0) -> None:
    end = time.monotonic() + seconds
    while not check():
        assert time.monotonic() < end, "nothing happened"
        await asyncio.sleep(0.02)


async def opened(user: User, sessions: Sessions, tab: str) -> Any:
    """The session behind the page that the user opens, its tab chosen."""
    await user.open("/")
    assert user.client is not None
    session = sessions.find(user.client.request.url.path.removeprefix("/s/"))
    assert session is not None
    user.find(kind=ui.tab, content=tab).click()
    session.go(tab)
    await user.should_see("World" if tab == "Drive" else "Three lessons")
    return session


def the(user: User, mark: str) -> Any:
    (element,) = user.find(marker=mark).elements
    return element


def mouse(user: User, kind: str, place: tuple[float, float], view: View) -> None:
    x, y = view.at(*place)
    args = {"mouse_event_type": kind, "image_x": x, "image_y": y, "button": 0, "buttons": 1}
    user.find(marker="map").trigger("mouse", args)


async def stroke(user: User, view: View, *places: tuple[float, float]) -> None:
    """Press at the first place, move, let go at the last."""
    mouse(user, "mousedown", places[0], view)
    for x, y in places[1:]:
        px, py = view.at(x, y)
        user.find(marker="map").trigger("mousemove", {"x": px, "y": py, "buttons": 1})
    mouse(user, "mouseup", places[-1], view)
    await asyncio.sleep(0.3)


async def driven(user: User, session: Any) -> None:
    before = session.drive.runs
    user.find(marker="drive").click()
    await until(lambda: session.drive.runs is not before and not session.drive.running)


def test_draw_drive_and_ask_why(studio_user: Play) -> None:
    async def scenario(user: User, sessions: Sessions) -> None:
        session = await opened(user, sessions, "Drive")
        model = session.drive
        view = View.around(model.surfaces.window(model.world))
        user.find(marker="pick-bassil").click()
        user.find(marker="pick-train").click()
        await until(lambda: model.picked == ["bassil"])
        await driven(user, session)
        assert model.runs[0].outcome is Outcome.REACHED
        await user.should_see(marker="outcome-0", content="reached")
        (detour,) = user.find(kind=ui.label, content="detour").elements
        assert detour.props["title"] == "Driven over straight length"
        inside = list(the(user, "tracks").descendants())
        assert not [each for each in inside if isinstance(each, ui.tooltip)]  # gone too soon

        user.find(marker="tool-circle").click()
        await stroke(user, view, (2.5, 2.5), (2.5, 3.5))
        assert model.world.obstacles[-1].numbers == (2.5, 2.5, 1.0)
        await user.should_see("circle at 2.5, 2.5, radius 1 m")
        assert the(user, "delete-1")
        await driven(user, session)
        assert model.runs[0].outcome is Outcome.COLLIDED
        model.playback.hold()
        model.playback.seek(model.length)
        user.find(marker="why").click()
        await until(lambda: the(user, "why-text").content)
        said = the(user, "why-text").content
        assert "it collided" in said
        assert "motor_x" in said
        assert "No safety check" in said

        user.find(marker="tool-delete").click()
        await stroke(user, view, (2.5, 2.5), (2.5, 2.5))
        assert len(model.world.obstacles) == 1
        user.find(marker="tool-polygon").click()
        for place in ((8.0, -3.0), (9.0, -3.0), (9.0, -2.0)):
            await stroke(user, view, place, place)
        mouse(user, "dblclick", (9.0, -2.0), view)
        await until(lambda: model.world.obstacles[-1].kind == "polygon")
        user.find(marker="undo").click()
        await until(lambda: len(model.world.obstacles) == 1)

    studio_user(scenario)


def test_a_corner_comes_before_the_key_that_closes(
    studio_user: Play, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A slow corner is still a corner of the polygon that a quick hand closes behind it."""
    up = Pen.up

    def slow(pen: Pen, x: float, y: float, *, still: bool) -> bool:
        time.sleep(0.2)
        return up(pen, x, y, still=still)

    monkeypatch.setattr(Pen, "up", slow)

    async def scenario(user: User, sessions: Sessions) -> None:
        model = (await opened(user, sessions, "Drive")).drive
        view = View.around(model.surfaces.window(model.world))
        user.find(marker="tool-polygon").click()
        for place in ((8.0, -3.0), (9.0, -3.0), (9.0, -2.0)):
            mouse(user, "mousedown", place, view)
            mouse(user, "mouseup", place, view)
        mouse(user, "dblclick", (9.0, -2.0), view)
        await until(lambda: model.world.obstacles[-1].kind == "polygon", 5.0)
        assert len(model.world.obstacles[-1].numbers) == 6

    studio_user(scenario)


def test_places_that_cannot_be_are_refused_with_a_sentence(studio_user: Play) -> None:
    async def scenario(user: User, sessions: Sessions) -> None:
        session = await opened(user, sessions, "Drive")
        model = session.drive
        view = View.around(model.surfaces.window(model.world))
        user.find(marker="tool-goal").click()
        await stroke(user, view, (5.0, 1.0), (5.0, 1.0))
        await user.should_see("the goal lies in a rectangle")
        assert model.world.goal == (11.73, 0.0)
        await stroke(user, view, (10.0, 3.0), (10.0, 3.0))
        assert model.world.goal == (10.0, 3.0)
        for args in ({}, None, {"x": "1", "y": []}, {"x": float("nan"), "y": 0}, [1, 2]):
            user.find(marker="map").trigger("mousemove", args)
            user.find(marker="map").trigger("wheel", args)
        bad = {"mouse_event_type": "mousedown", "image_x": float("inf"), "image_y": 0, "button": 0}
        user.find(marker="map").trigger("mouse", bad)
        the(user, "numbers").value = "1, x"
        user.find(marker="add").click()
        await user.should_see("write numbers joined by commas")

    studio_user(scenario)


def test_generated_ground_is_made_and_several_drive_on_it(studio_user: Play) -> None:
    async def scenario(user: User, sessions: Sessions) -> None:
        session = await opened(user, sessions, "Drive")
        model = session.drive
        with user:
            the(user, "world").value = "made:hills"
        await until(lambda: model.world.ground == "hills")
        await until(lambda: user.find(marker="ground-seed").elements)
        start = model.world.start
        with user:
            the(user, "ground-seed").value = 7
        await until(lambda: model.world.seed == 7)
        user.find(marker="craters").trigger("change", 40)
        await until(lambda: ("craters", 40) in model.world.made)
        user.find(marker="rocks").trigger("change", 0.02)
        await until(lambda: model.world.rocks == 0.02)
        assert model.world.start != start or model.world.goal
        for mark in ("pick-planner", "pick-neural"):
            user.find(marker=mark).click()
            await asyncio.sleep(0.1)
        await driven(user, session)
        assert [run.pick.key for run in model.runs] == ["train", "planner", "neural"]
        await user.should_see(marker="outcome-2")
        model.pause()
        user.find(marker="on").click()
        user.find(marker="back").click()
        user.find(marker="time").trigger("update:modelValue", 5.0)
        await until(lambda: abs(model.now() - 5.0) < 1e-9)
        user.find(marker="time").trigger("update:modelValue", "soon")
        assert len(session.library.list(kind="drive")) == 3

    studio_user(scenario)


def test_two_sessions_do_not_see_each_other(studio_user: Play) -> None:
    async def scenario(user: User, sessions: Sessions) -> None:
        first = await opened(user, sessions, "Drive")
        first.drive.draw("circle", (9.0, 2.0, 0.5))
        second = await opened(user, sessions, "Drive")
        assert second is not first
        assert len(second.drive.world.obstacles) == 1
        assert len(first.drive.world.obstacles) == 2
        await user.should_not_see(marker="delete-1")

    studio_user(scenario)


def test_a_lesson_sets_up_the_tabs_and_checks_answers(studio_user: Play) -> None:
    async def scenario(user: User, sessions: Sessions) -> None:
        session = await opened(user, sessions, "Lessons")
        user.find(marker="open-why-two-bits-fail").click()
        await user.should_see("Train the paper's network")
        the(user, "answer-0").value = "7"
        user.find(marker="check-0").click()
        await user.should_see("Let the training end by itself")
        the(user, "answer-0").value = "215"
        user.find(marker="check-0").click()
        await user.should_see("it never says when it stopped")
        assert session.lessons.solved == {("why-two-bits-fail", 0)}
        user.find("Drive it with the mirrored obstacle").click()
        await until(lambda: session.tab == "Drive")
        await until(lambda: session.drive.runs and not session.drive.running)
        assert session.drive.world == session.drive.flat["bassil-mirrored-v1"]
        session.go("Lessons")
        user.find(marker="all-lessons").click()
        await user.should_see("1 of 7")

    studio_user(scenario)


def test_the_map_keeps_its_place_when_it_is_magnified() -> None:
    view = View.around((0.0, 0.0, 20.0, 10.0))
    west, south, east, north = view.window
    assert (west, east) == (0.0, 20.0)
    assert south < 0.0 < 10.0 < north
    closer = view.zoomed(2.0, 250.0, 100.0)
    assert closer.place(250.0, 100.0) == pytest.approx(view.place(250.0, 100.0), abs=1e-12)
    x, y = view.at(3.0, 4.0)
    assert view.place(x, y) == pytest.approx((3.0, 4.0), abs=1e-12)
    moved = view.moved(WIDE / 2, -HIGH / 2)
    assert moved.at(3.0, 4.0) == pytest.approx((x + WIDE / 2, y - HIGH / 2), abs=1e-9)
