"""Make the pictures of the studio anew, in a real browser, into `docs/images/`.

Needs Chromium. Each picture is of a studio of its own, with a library of its own, and is reduced
to 256 colours.
"""

import io
import re
import sys
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))  # the tests know how to start a studio and a browser

from PIL import Image  # noqa: E402
from playwright.sync_api import Page, expect  # noqa: E402

from tests.studio.browser import Visit, browsing  # noqa: E402
from tests.studio.server import running  # noqa: E402

IMAGES = ROOT / "docs" / "images"
LIMIT = 300_000
"""Largest picture [bytes]."""
PATIENCE = 120_000


def main() -> None:
    """One studio, one visit per picture."""
    pictures: dict[str, Callable[[Page], None]] = {
        "studio-train": train,
        "studio-worked": worked,
        "studio-mirrored": mirrored,
        "studio-runs": runs,
        "studio-hills": hills,
        "studio-3d": deep,
    }
    with running() as studio, browsing() as browser:
        for name, play in pictures.items():
            scheme = "dark" if name == "studio-worked" else "light"
            visit = Visit(browser, studio.address, color_scheme=scheme)
            play(visit.page)
            visit.page.mouse.move(2, 400)
            visit.page.wait_for_timeout(1500)
            keep(visit.page.screenshot(), name)
            visit.context.close()


def train(page: Page) -> None:
    """The paper's network, learnt."""
    page.get_by_role("button", name="Start", exact=True).click()
    expect(page.get_by_role("status")).to_contain_text("Learnt", timeout=PATIENCE)


def worked(page: Page) -> None:
    """The worked example at its fifth step."""
    page.get_by_role("tab", name="Worked example").click()
    for _ in range(4):
        page.get_by_role("button", name="Next step").click()
        page.wait_for_timeout(300)
    page.mouse.wheel(0, 1000)


def mirrored(page: Page) -> None:
    """The collision with the mirrored obstacle."""
    page.get_by_role("button", name="Full speed").click()
    train(page)
    page.get_by_role("button", name="Drive it", exact=True).click()
    page.get_by_label("World").click()
    page.get_by_role("option", name=re.compile("mirrored", re.IGNORECASE)).click()
    page.get_by_role("button", name="Drive", exact=True).click()
    expect(page.get_by_text("collided").first).to_be_visible(timeout=PATIENCE)


def hills(page: Page) -> None:
    """Three controllers on generated ground, and why the neural driver turns."""
    page.set_viewport_size({"width": 1600, "height": 1000})
    page.get_by_role("tab", name="Drive").click()
    page.get_by_label("The Train tab's network").click()
    for name in ("neural", "goal-seeker", "planner"):
        page.get_by_label(re.compile(f"^{name}:")).click()
    page.get_by_label("World").click()
    page.get_by_role("option", name="Generated hills").click()
    page.get_by_label("Seed", exact=True).fill("5")
    expect(page.get_by_text("Forbidden to research")).to_be_visible(timeout=PATIENCE)
    page.wait_for_timeout(3000)
    page.get_by_role("button", name="Drive", exact=True).click()
    expect(page.get_by_text("timed out").first).to_be_visible(timeout=PATIENCE)
    page.get_by_role("button", name="Pause or go on").click()
    page.get_by_role("slider", name="Time").press("Home")
    page.locator(".rnd-strip img").first.click(position={"x": 260, "y": 60})
    page.get_by_role("button", name="Ask about this step").click()


def deep(page: Page) -> None:
    """The same ground in three dimensions."""
    hills(page)
    page.get_by_role("button", name="3D", exact=True).click()
    page.wait_for_timeout(20_000)


def runs(page: Page) -> None:
    """Three trainings on top of each other."""
    for momentum in ("0.9", "0.0", "0.5"):
        page.get_by_label("momentum").fill(momentum)
        page.wait_for_timeout(800)
        page.get_by_role("button", name="Back to the initial weights").click()
        page.get_by_role("button", name="Full speed").click()
        page.get_by_role("button", name="Start", exact=True).click()
        page.wait_for_timeout(2500)
    page.get_by_role("tab", name="Runs").click()
    page.get_by_role("button", name="Trainings").click()
    page.wait_for_timeout(1500)
    for box in page.get_by_role("checkbox").all()[:3]:
        box.click()
        page.wait_for_timeout(700)


def keep(data: bytes, name: str) -> None:
    """Write a picture, in 256 colours."""
    path = IMAGES / f"{name}.png"
    with Image.open(io.BytesIO(data)) as image:
        image.convert("RGB").quantize(256).save(path, optimize=True)
    size = path.stat().st_size
    sys.stdout.write(f"{path.relative_to(ROOT)}: {size:,} bytes\n")
    if size > LIMIT:
        sys.exit(f"{path} is larger than {LIMIT:,} bytes")


if __name__ == "__main__":
    main()
