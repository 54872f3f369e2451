"""A studio in a process of its own, and plain HTTP to speak with it."""

from __future__ import annotations

import contextlib
import os
import re
import signal
import socket
import subprocess
import sys
import tempfile
import threading
from collections.abc import Generator
from http.client import HTTPConnection, HTTPResponse
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import urlsplit


class Answer(NamedTuple):
    status: int
    headers: dict[str, str]
    body: str
    cookies: list[str]


class Studio:
    """A running studio."""

    def __init__(self, process: subprocess.Popen[str], address: str, folder: Path) -> None:
        self.process, self.address, self.folder = process, address, folder
        parts = urlsplit(address)
        self.host, self.port = parts.hostname or "", parts.port or 0
        self.token = parts.query.removeprefix("token=")

    def ask(
        self,
        path: str = "/",
        *,
        method: str = "GET",
        body: bytes | None = None,
        host: str | None = None,
        to: str | None = None,
        **headers: Any,
    ) -> Answer:
        """One request; header names are written with _ for -."""
        connection = HTTPConnection(to or self.host, self.port, timeout=20)
        with contextlib.closing(connection):
            connection.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
            connection.putheader("Host", f"{self.host}:{self.port}" if host is None else host)
            for name, item in headers.items():
                connection.putheader(name.replace("_", "-"), item)
            if body is not None and "Content_Length" not in headers:
                connection.putheader("Content-Length", str(len(body)))
            connection.endheaders(body)
            return _answer(connection.getresponse())

    def session(self, **headers: Any) -> str:
        """The path of a fresh session."""
        answer = self.ask("/", **headers)
        assert answer.status == 303, answer
        return answer.headers["location"]

    def knock(self, path: str, *, host: str | None = None, **headers: Any) -> int:
        """The status that a WebSocket handshake gets."""
        answer = self.ask(
            path, host=host, Connection="Upgrade", Upgrade="websocket",
            Sec_WebSocket_Version="13", Sec_WebSocket_Key="dGhlIHNhbXBsZSBub25jZQ==", **headers,
        )  # fmt: skip
        return answer.status

    def raw(self, data: bytes) -> bytes:
        """Whatever comes back for bytes that are perhaps no HTTP at all."""
        with socket.create_connection((self.host, self.port), timeout=10) as connection:
            connection.sendall(data)
            with contextlib.suppress(OSError):
                connection.shutdown(socket.SHUT_WR)
            parts: list[bytes] = []
            with contextlib.suppress(OSError):
                while part := connection.recv(65536):
                    parts.append(part)
            return b"".join(parts)

    def stop(self, how: signal.Signals = signal.SIGINT) -> tuple[int, str]:
        """End it; exit code and error stream."""
        self.process.send_signal(how)
        self.process.wait(30)
        return self.process.returncode, (self.folder / "errors.txt").read_text()


@contextlib.contextmanager
def running(*words: str | Path, port: int = 0, library: Path | None = None) -> Generator[Studio]:
    """A studio on any free port, in an empty working folder."""
    with tempfile.TemporaryDirectory() as parent:
        folder = Path(parent)
        work = folder / "work"
        work.mkdir()
        library = library or folder / "library.sqlite3"
        command = [sys.executable, "-m", "rovernav", "studio", "--no-browser"]
        command += ["--port", str(port), "--library", str(library), *map(str, words)]
        with (folder / "errors.txt").open("w") as errors:
            process = subprocess.Popen(
                command, stdout=subprocess.PIPE, stderr=errors, text=True, cwd=work,
                env=os.environ | {"PYTHONUNBUFFERED": "1"},
            )  # fmt: skip
        watchdog = threading.Timer(900, process.kill)
        watchdog.start()
        try:
            assert process.stdout is not None
            line = process.stdout.readline()
            found = re.search(r"http://\S+", line)
            assert found, line + (folder / "errors.txt").read_text()
            yield Studio(process, found[0], folder)
            assert list(work.iterdir()) == [], "the studio wrote into the working folder"
        finally:
            watchdog.cancel()
            process.kill()
            process.wait()
            if process.stdout:
                process.stdout.close()


def _answer(response: HTTPResponse) -> Answer:
    headers = {name.lower(): item for name, item in response.getheaders()}
    cookies = [item for name, item in response.getheaders() if name.lower() == "set-cookie"]
    if response.status == 101:
        return Answer(101, headers, "", cookies)
    return Answer(response.status, headers, response.read().decode("utf-8", "replace"), cookies)
