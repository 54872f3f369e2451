"""A real browser, driven without a window; what it asks for and complains about is written down."""

from __future__ import annotations

import contextlib
import os
import shutil
from collections.abc import Generator
from typing import Any
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import Browser, Page, expect, sync_playwright

from tests.conftest import UNDER_CI

expect.set_options(timeout=60_000)  # [ms]; a busy machine draws late

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
)  # fmt: skip


def find_browser() -> str:
    """The browser's program; where there is none, the test is skipped, but not under CI."""
    for name in (os.environ.get("ROVERNAV_BROWSER", ""), *NAMES):
        if name and (found := shutil.which(name)):
            return found
    if UNDER_CI:
        pytest.fail("no Chromium; .ci/run installs it")
    pytest.skip("no Chromium; install it, or name its program in ROVERNAV_BROWSER")


@contextlib.contextmanager
def browsing() -> Generator[Browser]:
    """A browser with a profile of its own, which is thrown away."""
    program = find_browser()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=FLAGS)
        try:
            yield browser
        finally:
            browser.close()


class Visit:
    """A page in the browser, and what happened in it behind the scenes."""

    def __init__(self, browser: Browser, address: str, **options: Any) -> None:
        options = {"viewport": {"width": 1280, "height": 800}, **options}
        self.context = browser.new_context(**options)
        self.asked: list[str] = []
        self.complaints: list[str] = []
        self.page = self.open(address)

    def open(self, address: str) -> Page:
        """One more tab of this visitor."""
        page = self.context.new_page()
        page.on("request", lambda request: self.asked.append(request.url))
        page.on("websocket", lambda socket: self.asked.append(socket.url))
        page.on("pageerror", lambda error: self.complaints.append(str(error)))
        page.on(
            "console",
            lambda message: (
                self.complaints.append(message.text) if message.type == "error" else None
            ),
        )
        page.set_default_timeout(60_000)
        page.goto(address)
        page.get_by_role("button", name="Start", exact=True).wait_for()
        return page

    def foreign(self, host: str) -> list[str]:
        """What was asked of any other place than the studio."""
        local = ("data", "blob", "about")
        places = [(url, urlsplit(url)) for url in self.asked]
        return [url for url, at in places if at.scheme not in local and at.hostname != host]
