"""Drive and Lessons in a real browser: drawing, asking why, 3D, a GeoTIFF, a lesson."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, expect

from tests.cli.runner import write_ground
from tests.studio.browser import Visit, browsing
from tests.studio.server import Studio

pytestmark = pytest.mark.xdist_group("browser")  # one browser at a time
PATIENCE = 60_000
ACROSS = re.compile(r"^rectangle (8\.9|9)")


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with browsing() as browser:
        yield browser


@pytest.fixture
def page(browser: Browser, studio: Studio) -> Iterator[Page]:
    visit = Visit(browser, studio.address)
    yield visit.page
    visit.context.close()
    assert visit.foreign(studio.host) == []
    assert visit.complaints == []


def button(page: Page, name: str) -> Any:
    return page.get_by_role("button", name=name, exact=True)


class Map:
    """The map of the Drive tab under a mouse; it shows the paper's scene as it is at first."""

    WIDE, HIGH, WEST, EAST, SOUTH, NORTH = 1000, 620, -2.5, 14.5, -7.0, 8.5

    def __init__(self, page: Page) -> None:
        self.page = page
        canvas = page.locator(".rnd-canvas img").first
        canvas.wait_for()
        box = canvas.bounding_box()
        assert box is not None
        self.box = box
        self.scale = min(self.WIDE / (self.EAST - self.WEST), self.HIGH / (self.NORTH - self.SOUTH))

    def at(self, x: float, y: float) -> tuple[float, float]:
        """Where a place of the world is on the screen."""
        middle = (self.WEST + self.EAST) / 2, (self.SOUTH + self.NORTH) / 2
        px = self.WIDE / 2 + (x - middle[0]) * self.scale
        py = self.HIGH / 2 - (y - middle[1]) * self.scale
        return (
            self.box["x"] + px / self.WIDE * self.box["width"],
            self.box["y"] + py / self.HIGH * self.box["height"],
        )

    def drag(self, a: tuple[float, float], b: tuple[float, float]) -> None:
        self.page.mouse.move(*self.at(*a))
        self.page.mouse.down()
        self.page.mouse.move(*self.at(*b), steps=5)
        self.page.mouse.up()

    def click(self, x: float, y: float) -> None:
        self.page.mouse.click(*self.at(x, y))


def drive_tab(page: Page, *who: str) -> Map:
    page.get_by_role("tab", name="Drive").click()
    area = Map(page)
    page.get_by_label("The Train tab's network").click()
    for name in who:
        page.get_by_label(re.compile(f"^{name}:")).click()
    return area


def test_draw_all_three_kinds_drive_and_ask_why(page: Page) -> None:
    area = drive_tab(page, "neural")
    button(page, "Drag a rectangle").click()
    area.drag((9.0, -1.0), (9.6, 1.0))
    expect(page.get_by_text(ACROSS)).to_be_visible()
    button(page, "Drag a circle from its middle").click()
    area.drag((2.0, -4.5), (2.0, -5.3))
    expect(page.get_by_text(re.compile(r"^circle at (1\.9|2)"))).to_be_visible()
    page.get_by_role("button", name=re.compile("^Click the corners")).click()
    for corner in ((8.0, -5.0), (10.0, -5.0), (9.0, -4.0)):
        area.click(*corner)
    page.keyboard.press("Enter")
    expect(page.get_by_text(re.compile("^polygon of 3"))).to_be_visible()
    button(page, "Drive").click()
    expect(page.get_by_text("reached").first).to_be_visible(timeout=PATIENCE)
    button(page, "Pause or go on").click()
    page.get_by_role("button", name="Ask about this step").click()
    why = page.locator(".rnd-why-card")
    expect(why).to_contain_text("What each hidden neuron added")
    expect(why).to_contain_text("No safety check")
    page.get_by_role("button", name=re.compile("^Click a track")).click()
    area.click(0.1, 0.0)  # the first steps of the track
    expect(why).to_contain_text(re.compile(r"neural, step [1-4] of"))

    page.get_by_role("button", name="Click an obstacle to delete it").click()
    area.click(9.3, 0.0)
    expect(page.get_by_text(ACROSS)).to_have_count(0)
    button(page, "Undo").click()
    expect(page.get_by_text(ACROSS)).to_be_visible()


def test_the_place_under_the_pointer_is_told_and_the_wheel_comes_closer(page: Page) -> None:
    area = drive_tab(page, "bassil")
    place = page.get_by_text(re.compile(r"^-?\d+\.\d\d, -?\d+\.\d\d m"))
    page.mouse.move(*area.at(6.0, 5.0))
    expect(place).to_have_text(re.compile(r"^(5\.9|6\.0)\d, (4\.9|5\.0)\d m$"))
    for _ in range(3):
        page.mouse.wheel(0, -240)
        page.wait_for_timeout(200)
    page.mouse.move(*area.at(6.0, 5.1))
    page.mouse.move(*area.at(6.0, 5.0))
    expect(place).to_have_text(re.compile(r"^(5\.9|6\.0)\d, (4\.9|5\.0)\d m$"))


def test_ground_of_ones_own_in_two_and_three_dimensions(page: Page, tmp_path: Path) -> None:
    drive_tab(page, "planner")
    with page.expect_file_chooser() as chooser:
        page.get_by_role("button", name="GeoTIFF").click()
    chooser.value.set_files(write_ground(tmp_path / "own ground.tif"))
    expect(page.get_by_text("Forbidden to research")).to_be_visible(timeout=PATIENCE)
    expect(page.locator(".rnd-canvas image")).to_have_count(1)
    button(page, "Drive").click()
    expect(page.locator(".rnd-tracks")).to_contain_text(
        re.compile("reached|timed out|collided"), timeout=PATIENCE
    )
    button(page, "3D").click()
    scene = page.locator(".rnd-scene canvas")
    expect(scene.or_(page.get_by_text("3D needs WebGL"))).to_be_visible(timeout=PATIENCE)
    button(page, "2D").click()
    expect(page.locator(".rnd-canvas img").first).to_be_visible()


def test_a_lesson_leads_to_the_drive_it_speaks_of(page: Page) -> None:
    page.get_by_role("tab", name="Lessons").click()
    page.get_by_label("Why two bits fail").click()
    answer = page.get_by_label("Your answer").first
    answer.fill("200")
    answer.press("Enter")
    expect(page.get_by_text("Let the training end by itself")).to_be_visible()
    answer.fill("215")
    answer.press("Enter")
    expect(page.get_by_text("it never says when it stopped")).to_be_visible()
    page.get_by_role("button", name="Both in the mirrored scene").click()
    expect(page.get_by_label("Look at neural")).to_be_visible(timeout=PATIENCE)
    expect(page.locator(".rnd-tracks")).to_contain_text("reached", timeout=PATIENCE)
