"""Start the studio: a port, the gate before it, the pages behind."""

from __future__ import annotations

import contextlib
import errno
import importlib.util
import os
import secrets
import socket
import tempfile
import threading
import webbrowser
from typing import Any

from ..core import FileError, MissingExtraError, SettingError
from ._library import Library, usual_library
from ._options import Options
from ._session import Sessions

MAX_MESSAGE = 1_000_000
"""Bytes of one WebSocket message at most."""
GRACE = 2
"""How long pages may still be served after Ctrl-C [s]."""


def serve(options: Options) -> None:
    """Run the studio until Ctrl-C.

    Args:
        options: Where to listen, where runs are kept.

    Raises:
        MissingExtraError: The extra ``studio`` is not installed.
        SettingError: The address cannot be listened on.
        FileError: The library cannot be used, or a terrain is missing.
    """
    check_extra()
    for path in options.terrain:
        if not path.is_file():
            raise FileError(f"there is no elevation model at {path}; check --terrain")
    with contextlib.ExitStack() as stack:
        listener = stack.enter_context(listen(options.host, options.port))
        library = Library(options.library or usual_library())
        sessions = Sessions(options, library)
        stack.callback(sessions.close)
        scratch = stack.enter_context(tempfile.TemporaryDirectory(prefix="rovernav-studio-"))
        os.environ["NICEGUI_STORAGE_PATH"] = scratch  # read when nicegui is first imported
        port = listener.getsockname()[1]
        token = None if options.local else secrets.token_urlsafe(24)
        server = _server(sessions, options, port, token)
        address = _address(options.host, port, token)
        options.say(f"Studio: {address}")
        if token is not None:
            options.say("Whoever has this address can use it; nothing is encrypted.")
        options.say(f"Runs are kept in {library.path}. Ctrl-C stops the studio.")
        if options.show:
            threading.Timer(1.0, webbrowser.open, (address,)).start()
        _warm_up()
        with contextlib.suppress(KeyboardInterrupt):
            server.run(sockets=[listener])


def check_extra() -> None:
    """Raise `MissingExtraError` where the studio's packages are not installed."""
    if importlib.util.find_spec("nicegui") is None:
        raise MissingExtraError(
            "the studio needs the extra 'studio', which is not installed: "
            "pip install 'rovernav[studio]'"
        )


def listen(host: str, port: int) -> socket.socket:
    """A socket that listens.

    Raises:
        SettingError: The port is taken, or the host is no address of this machine.
    """
    try:
        found = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
        return socket.create_server(found[0][4][:2], family=found[0][0], backlog=128)
    except OSError as error:
        if error.errno == errno.EADDRINUSE:
            raise SettingError(
                f"port {port} is taken, perhaps by another studio; "
                "name another with --port, or --port 0 for any free one"
            ) from None
        if error.errno in (errno.EACCES, errno.EPERM):
            raise SettingError(f"port {port} may not be used; name one above 1023") from None
        raise SettingError(
            f"cannot listen on {host!r}: {error.strerror or error}; name an address of this machine"
        ) from None
    except (UnicodeError, OverflowError) as error:
        raise SettingError(f"cannot listen on {host!r}: {error}") from None


def _server(sessions: Sessions, options: Options, port: int, token: str | None) -> Any:
    import uvicorn
    from fastapi import FastAPI
    from nicegui import ui

    from ._gate import Gate
    from ._shell import pages
    from ._theme import LOGO

    app = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)
    pages(sessions)
    ui.run_with(
        app,
        title="rovernav studio",
        favicon=LOGO,
        dark=None,
        language="en-US",
        reconnect_timeout=10.0,
        show_welcome_message=False,
    )
    config = uvicorn.Config(
        Gate(app, options, port, token),
        log_level="error",
        access_log=False,
        server_header=False,
        proxy_headers=False,
        ws="wsproto",
        ws_max_size=MAX_MESSAGE,
        timeout_graceful_shutdown=GRACE,
        h11_max_incomplete_event_size=64 * 1024,
    )
    return uvicorn.Server(config)


def _address(host: str, port: int, token: str | None) -> str:
    if host in ("0.0.0.0", "::"):  # every address of this machine: name the one that others know
        host = _outward()
    name = f"[{host}]" if ":" in host else host
    return f"http://{name}:{port}/" + (f"?token={token}" if token else "")


def _outward() -> str:
    """The address by which other machines know this one; asking the routing table sends nothing."""
    try:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.connect(("192.0.2.1", 9))  # RFC 5737: nobody's
            return probe.getsockname()[0]
    except OSError:
        return socket.gethostname()


def _warm_up() -> None:
    """Compile or load the kernels of the first click while the page is being opened."""
    from ._training import warm_up

    threading.Thread(target=warm_up, daemon=True, name="warm-up").start()
