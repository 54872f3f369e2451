"""The studio in a real browser."""

from __future__ import annotations

import json
import re
import shlex
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, expect

from tests.studio.browser import Visit, browsing
from tests.studio.server import Studio, running

pytestmark = pytest.mark.xdist_group("browser")  # one browser at a time
PATIENCE = 60_000
LEARNT = "Learnt: every error is within the tolerance"


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with browsing() as browser:
        yield browser


@pytest.fixture
def visit(browser: Browser, studio: Studio) -> Iterator[Visit]:
    visit = Visit(browser, studio.address)
    yield visit
    visit.context.close()
    assert visit.foreign(studio.host) == []
    assert visit.complaints == []


def button(page: Page, name: str) -> Any:
    return page.get_by_role("button", name=name, exact=True)


def tab(page: Page, name: str) -> None:
    page.get_by_role("tab", name=name).click()


def status(page: Page) -> Any:
    return page.get_by_role("status")


def train_fully(page: Page) -> None:
    page.get_by_role("button", name="Full speed").click()
    button(page, "Start").click()
    expect(status(page)).to_have_text(
        "Learnt: every error is within the tolerance", timeout=PATIENCE
    )


def again(page: Page, folder: Path) -> dict[str, Any]:
    """Run the printed command of the opened run in a real process, with the run's files."""
    with page.expect_download() as download:
        button(page, "All files (ZIP)").click()
    with zipfile.ZipFile(download.value.path()) as files:
        files.extractall(folder)
    command = page.locator(".rn-command .rn-mono").inner_text()
    program, *words = shlex.split(command)
    assert program == "rovernav"
    done = subprocess.run(
        [sys.executable, "-m", "rovernav", *words, "--json"],
        cwd=folder, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def shown(page: Page, name: str) -> str:
    """A number of the opened run."""
    row = page.locator(".rn-runs-open table.rn-table tr").filter(
        has=page.locator("th", has_text=re.compile(f"^{name}$"))
    )
    return row.locator("td").inner_text()


def test_train_drive_reload_and_do_it_again(visit: Visit, tmp_path: Path) -> None:
    page = visit.page
    error = page.locator(".rn-figure").nth(1)
    expect(error).to_have_text("2.985")
    button(page, "Start").click()
    expect(status(page)).to_have_text(
        "Learnt: every error is within the tolerance", timeout=PATIENCE
    )
    assert float(error.inner_text()) < 0.01
    expect(page.locator(".rn-figure").first).to_have_text("215")

    tab(page, "Drive")
    canvas = page.locator(".rnd-canvas svg").first
    canvas.wait_for()
    button(page, "Drag a circle from its middle").click()
    box = canvas.bounding_box()
    assert box is not None
    x, y = box["x"] + 0.15 * box["width"], box["y"] + 0.2 * box["height"]
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 15, y + 4, steps=4)
    page.mouse.up()
    expect(page.get_by_text(re.compile("^circle "))).to_be_visible()
    button(page, "Drive").click()
    expect(page.get_by_text("reached").first).to_be_visible(timeout=PATIENCE)

    page.reload()
    tab(page, "Runs")
    runs = page.locator(".rn-run")
    expect(runs).to_have_count(2)
    runs.filter(has_text="reached").click()
    expect(page.locator(".rn-runs-open")).to_contain_text("reached")
    drive = again(page, tmp_path / "drive")
    assert drive["outcome"] == "reached"
    assert f"{drive['length_m']:.6g}" == shown(page, "length m")
    runs.filter(has_text="2-3-2 on bassil-v1").click()
    expect(page.locator(".rn-command")).to_contain_text("rovernav train")
    training = again(page, tmp_path / "train")
    assert training["weights_sha256"] == shown(page, "weights sha256")
    assert str(training["epochs"]) == shown(page, "epochs") == "215"


def test_the_mirrored_obstacle_within_a_few_clicks(visit: Visit) -> None:
    page = visit.page
    train_fully(page)
    button(page, "Drive it").click()
    page.locator(".rnd-canvas svg").first.wait_for()
    page.get_by_label("World").click()
    page.get_by_role("option", name=re.compile("mirrored", re.IGNORECASE)).click()
    button(page, "Drive").click()
    expect(page.get_by_text("collided").first).to_be_visible(timeout=PATIENCE)


def test_names_with_script_in_them_are_text(visit: Visit, tmp_path: Path) -> None:
    page = visit.page
    image = "<img src=x onerror=window.pwned=1>"
    table = tmp_path / "x.csv"
    table.write_text(f'"in:{image}",in:b,"out:{image}"\n0,1,1\n1,0,0\n')
    with page.expect_file_chooser() as chooser:
        button(page, "Load a table from a CSV file").click()
    chooser.value.set_files(table)
    expect(page.get_by_label("Name of column 1", exact=True)).to_have_value(image)
    expect(page.locator(".rn-net")).to_contain_text("<img src=x")
    train_fully(page)
    tab(page, "Runs")
    field = page.get_by_label("Name", exact=True)
    field.fill(f"<script>window.pwned=1</script>{image}")
    button(page, "Rename").click()
    expect(page.locator(".rn-run-title").first).to_contain_text("<script>window.pwned=1</script>")
    page.reload()
    tab(page, "Runs")
    expect(page.locator(".rn-run-title").first).to_contain_text(image)
    assert page.evaluate("window.pwned") is None
    assert page.locator("img[src=x]").count() == 0


def test_wrong_numbers_are_refused_beside_the_field(visit: Visit) -> None:
    page = visit.page
    cell = page.get_by_label("Pattern 1, clear_sight", exact=True)
    cell.fill("NaN")
    expect(page.get_by_text("NaN is not finite.", exact=True)).to_be_visible()
    cell.fill("0")
    expect(page.get_by_text("NaN is not finite.")).to_have_count(0)
    eta = page.get_by_label("η  learning rate")
    eta.fill("fast")
    expect(page.get_by_text("Eta must be a number, got fast.")).to_be_visible()
    eta.fill("0.25")
    expect(page.get_by_text("Eta must be a number")).to_have_count(0)


def test_everything_can_be_reached_by_keyboard(visit: Visit) -> None:
    page = visit.page
    seen: list[str] = []
    for _ in range(90):
        page.keyboard.press("Tab")
        seen.append(
            page.evaluate(
                "(e => e.getAttribute('aria-label') || e.innerText || e.id)(document.activeElement)"
            ).strip()
        )
    assert seen[0] == "Skip to the content"
    for wanted in (
        "Start", "Back to the initial weights", "Show pattern 3", "Add an input",
        "Pattern 2, off_line", "More units in layer 1", "Load a table from a CSV file",
    ):  # fmt: skip
        assert wanted in seen
    button(page, "Start").focus()
    page.keyboard.press("Enter")
    expect(status(page)).to_have_text(
        "Learnt: every error is within the tolerance", timeout=PATIENCE
    )
    page.get_by_role("tab", name="Train").focus()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("Enter")
    page.get_by_role("tab", name="Drive", selected=True).wait_for()


@pytest.mark.long
def test_a_closed_tab_and_two_browsers(browser: Browser, studio: Studio, visit: Visit) -> None:
    page = visit.page
    page.get_by_label("Tolerance").fill("0")
    page.get_by_label("Epochs at most").fill("1000000000")
    page.get_by_role("button", name="Full speed").click()
    button(page, "Start").click()
    expect(status(page)).to_have_text("Training")
    address = page.url
    page.close()
    other = Visit(browser, studio.address)
    expect(status(other.page)).to_have_text("Ready")
    assert other.page.url != address
    other.context.close()
    back = visit.open(address)
    expect(status(back)).to_have_text("Training")
    epoch = back.locator(".rn-figure").first
    before = int(epoch.inner_text().replace(",", ""))
    expect(epoch).not_to_have_text(f"{before:,}")
    fresh = visit.open(studio.address)
    button(fresh, "Sessions").click()
    fresh.get_by_text(re.compile("Earlier session 1 .*at work")).click()
    expect(status(fresh)).to_have_text("Training")
    button(fresh, "Pause").click()
    expect(status(back)).to_have_text("Paused")


@pytest.mark.long
def test_light_and_dark(browser: Browser, studio: Studio) -> None:
    grounds: list[str] = []
    for scheme in ("light", "dark"):
        visit = Visit(browser, studio.address, color_scheme=scheme)
        ground = "getComputedStyle(document.body).backgroundColor"
        grounds.append(visit.page.evaluate(ground))
        visit.page.get_by_role("button", name="Light or dark").click()
        visit.page.wait_for_function(f"{ground} == 'rgb(18, 24, 30)'")
        visit.context.close()
        assert visit.complaints == []
    assert grounds == ["rgb(243, 245, 247)", "rgb(18, 24, 30)"]


def test_nothing_hangs_over_the_edge(browser: Browser, studio: Studio) -> None:
    for width, height in ((1280, 800), (1920, 1080), (800, 1000)):
        visit = Visit(browser, studio.address, viewport={"width": width, "height": height})
        for name in ("Train", "Drive", "Runs", "Lessons"):
            tab(visit.page, name)
            visit.page.wait_for_timeout(700)
            assert visit.page.evaluate("document.documentElement.scrollWidth") <= width, name
        visit.context.close()


def test_the_page_says_when_the_server_is_gone_and_comes_back(
    browser: Browser, tmp_path: Path
) -> None:
    library = tmp_path / "runs.sqlite3"
    with running(library=library) as studio:
        visit = Visit(browser, studio.address)
        page = visit.page
        train_fully(page)
        page.wait_for_timeout(500)
        studio.process.kill()
        banner = page.locator("#popup")
        expect(banner).to_be_visible(timeout=PATIENCE)
        expect(banner).to_contain_text("Connection lost")
        box = banner.bounding_box()
        assert box is not None
        assert box["width"] > 1200
        port = studio.port
    with running(port=port, library=library):
        page.get_by_text("here is a fresh one").wait_for(timeout=PATIENCE)
        tab(page, "Runs")
        expect(page.locator(".rn-run")).to_have_count(1)  # the killed server lost nothing
        visit.context.close()


def test_with_a_token(browser: Browser, open_studio: Studio) -> None:
    studio = open_studio
    here = f"http://127.0.0.1:{studio.port}/"
    context = browser.new_context()
    page = context.new_page()
    answer = page.goto(here)
    assert answer is not None
    assert answer.status == 401
    page.goto(f"{here}?token={studio.token}")
    page.get_by_role("button", name="Start", exact=True).wait_for()
    assert "token" not in page.url
    assert page.evaluate("document.cookie") == ""
    page.goto(here)
    button(page, "Start").wait_for()
    context.close()
