"""Twenty visitors at once, for minutes."""

from __future__ import annotations

import asyncio
import json
import random
import re
import time
from html import unescape
from typing import Any

import httpx
import pytest
import socketio

from tests.studio.server import running

pytestmark = pytest.mark.long
VISITORS, SECONDS = 20, 60.0


class Visitor:
    """A page of one browser without a window: reads, clicks, measures how fast it is answered."""

    def __init__(self, base: str, number: int) -> None:
        self.base, self.rng = base, random.Random(number)
        self.answers: list[float] = []

    async def visit(self) -> None:
        """A page from its opening to its end; may be done again in another event loop."""
        self.news = asyncio.Event()
        async with httpx.AsyncClient(follow_redirects=True, timeout=60) as http:
            body = (await http.get(self.base)).text
        raw, client = (
            re.search(r"String\.raw`(.*?)`", body, re.S),
            re.search(r"'client_id': '([0-9a-f-]+)'", body),
        )
        assert raw
        assert client
        elements: dict[str, Any] = json.loads(unescape(raw[1]))
        buttons = {
            element["props"].get("aria-label") or element["props"].get("label"): (
                int(number), event["listener_id"])
            for number, element in elements.items() if element.get("tag") == "nicegui-button"
            or element.get("tag") == "q-btn"
            for event in element.get("events", []) if event["type"] == "click"
        }  # fmt: skip
        assert {"Start", "1 epoch", "Back to the initial weights"} <= set(buttons)
        sio = socketio.AsyncClient(reconnection=False)
        sio.on("update", lambda _: self.news.set())
        query = f"client_id={client[1]}&tab_id=t{id(self)}&document_id=d{id(self)}"
        await sio.connect(
            f"{self.base}?{query}&implicit_handshake=true&next_message_id=0",
            socketio_path="/_nicegui_ws/socket.io", transports=["websocket"], wait_timeout=30,
        )  # fmt: skip
        try:
            await self._play(sio, client[1], buttons)
        finally:
            await sio.disconnect()

    async def _play(self, sio: Any, client: str, buttons: dict[str, tuple[int, str]]) -> None:
        names = ["Start", "1 epoch", "1 pattern", "Back to the initial weights"]
        end = time.monotonic() + SECONDS
        while time.monotonic() < end:
            element, listener = buttons[self.rng.choice([n for n in names if n in buttons])]
            self.news.clear()
            asked = time.perf_counter()
            await sio.emit("event", {"id": element, "client_id": client, "listener_id": listener,
                                     "args": [json.dumps({})]})  # fmt: skip
            await asyncio.wait_for(self.news.wait(), 30)
            self.answers.append(time.perf_counter() - asked)
            await asyncio.sleep(self.rng.uniform(0.2, 1.0))


def memory(process: int) -> int:
    """Bytes of memory that a process holds."""
    with open(f"/proc/{process}/status") as file:
        return 1024 * int(re.search(r"VmRSS:\s+(\d+)", file.read())[1])  # type: ignore[index]


def test_twenty_visitors() -> None:
    with running() as studio:
        visitors = [Visitor(studio.address, number) for number in range(VISITORS)]

        async def all_of_them() -> None:
            await asyncio.gather(*(visitor.visit() for visitor in visitors))

        asyncio.run(all_of_them())
        first = memory(studio.process.pid)
        assert all(len(visitor.answers) > 10 for visitor in visitors)
        waits = sorted(wait for visitor in visitors for wait in visitor.answers)
        middle, slow = waits[len(waits) // 2], waits[int(0.95 * len(waits))]
        assert middle < 1.0, f"half of the answers within {middle:.2f} s, 95 % within {slow:.2f} s"
        asyncio.run(all_of_them())
        assert memory(studio.process.pid) < first + 300_000_000
        assert studio.ask("/").status == 303
        errors = (studio.folder / "errors.txt").read_text()
        assert "rovernav" not in errors
        code, _ = studio.stop()
        assert code == 0
