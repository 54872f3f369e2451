"""A studio without a server, and one in a process of its own."""

from __future__ import annotations

import asyncio
import os
import tempfile
from collections.abc import Awaitable, Callable, Iterator
from pathlib import Path

import pytest

from tests.studio.server import Studio, running

os.environ["NICEGUI_STORAGE_PATH"] = tempfile.mkdtemp(prefix="rovernav-test-nicegui-")

from nicegui import Client  # the line above must come first
from nicegui.testing import User
from nicegui.testing.user_simulation import user_simulation

from rovernav.studio import Library, Options, Sessions
from rovernav.studio._shell import pages

Scenario = Callable[[User, Sessions], Awaitable[None]]


@pytest.fixture
def studio_user(tmp_path: Path) -> Callable[[Scenario], None]:
    """Runs a scenario with a simulated user of the pages, in this process."""

    def play(scenario: Scenario) -> None:
        library = Library(tmp_path / "runs.sqlite3")
        sessions = Sessions(Options(show=False), library)

        async def whole() -> None:
            async with user_simulation() as user:
                pages(sessions)
                try:
                    await scenario(user, sessions)
                finally:
                    sessions.close()
                    Client.page_routes.clear()  # or NiceGUI would unload our modules

        asyncio.run(whole())

    return play


@pytest.fixture(scope="module")
def studio() -> Iterator[Studio]:
    """A studio for this machine alone."""
    with running() as studio:
        yield studio


@pytest.fixture(scope="module")
def open_studio() -> Iterator[Studio]:
    """A studio that other machines can reach, so that it needs its token."""
    with running("--host", "0.0.0.0") as studio:
        yield studio
