"""Who may come in: every request and every WebSocket passes here before anything else sees it.

The studio runs code for whoever reaches it, so it answers only those who asked for it by an
address of its own (a foreign name may be rebound to this machine), whose page is its own (another
site's page may call it from a visitor's browser) and, where other machines can reach it, who know
its token.
"""

from __future__ import annotations

import hmac
import ipaddress
import secrets
import socket
from collections.abc import Awaitable, Callable, MutableMapping
from http.cookies import CookieError, SimpleCookie
from typing import Any, final
from urllib.parse import parse_qs, urlsplit

from ._options import Options

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

MAX_BODY = 64_000_000
"""Bytes of a request at most: the largest elevation model that may be sent."""
OWNER = "rovernav.owner"
"""Where in a request's scope the name of the browser stands."""
_METHODS = ("GET", "HEAD", "POST", "OPTIONS")
_NO_TOKEN = (
    "This studio needs its token. Open the address that the terminal printed when it started; "
    "it ends with ?token=... and is needed once per browser."
)
_POLICY = (
    "default-src 'self'; script-src 'self' 'unsafe-inline' 'unsafe-eval'; "
    "style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; font-src 'self' data:; "
    "connect-src 'self' blob: data: {socket}; worker-src 'self' blob:; object-src 'none'; "
    "base-uri 'none'; form-action 'self'; frame-ancestors 'none'"
)
_ENTER = """<!doctype html><meta charset="utf-8"><title>rovernav studio</title>
<p>One moment …</p><script>location.replace("/")</script>
<noscript><a href="/">On to the studio</a></noscript>"""
"""A page that goes on by itself: after a redirect the strict cookie would not be sent at once."""


@final
class Gate:
    """Middleware that lets in what belongs to this studio.

    Args:
        app: What answers those who came in.
        options: Where the studio listens.
        port: The port that it got.
        token: What visitors must know; None where only this machine can reach it.
    """

    def __init__(self, app: App, options: Options, port: int, token: str | None) -> None:
        self.app = app
        self._local = options.local
        self._names = own_names(options)
        self._port = port
        self._token = token
        self._secret = secrets.token_urlsafe(32)
        self._key, self._who = f"rovernav_key_{port}", f"rovernav_who_{port}"

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Refuse, or pass on with the safe headers added to the answer."""
        if scope["type"] == "lifespan":
            await self.app(scope, receive, send)
            return
        headers = _headers(scope)
        cookies = _cookies(headers.get("cookie", ""))
        status, reason = self._check(scope, headers)
        if status:
            await _refuse(scope, send, status, reason)
        elif not self._known(cookies):
            await self._ask(scope, send)
        else:
            await self._pass(scope, receive, send, cookies.get(self._who, ""), headers)

    def _check(self, scope: Scope, headers: dict[str, str]) -> tuple[int, str]:
        """Why a request is refused, whoever sends it; (0, '') where it is not."""
        host = headers.get("host", "")
        if not self._is_own(host):
            return 421, "This studio does not answer to that host name."
        origin = headers.get("origin")
        if origin is not None and not _same_place(origin, host):
            return 403, "Another site's page may not use this studio."
        foreign = headers.get("sec-fetch-site", "none") not in ("none", "same-origin")
        if foreign and (scope["type"] != "http" or headers.get("sec-fetch-mode") != "navigate"):
            return 403, "Another site's page may not use this studio."
        if scope["type"] == "http":
            return _check_body(scope["method"], headers)
        return 0, ""

    def _is_own(self, host: str) -> bool:
        """Whether the Host header names this studio by one of its own names, and by its port."""
        name, port = _split(host)
        if port != self._port:
            return False
        if name in self._names:
            return True
        try:
            address = ipaddress.ip_address(name)
        except ValueError:
            return False
        return address.is_loopback if self._local else True  # no name, so nothing to rebind

    def _known(self, cookies: dict[str, str]) -> bool:
        if self._token is None:
            return True
        return hmac.compare_digest(cookies.get(self._key, "").encode(), self._secret.encode())

    async def _ask(self, scope: Scope, send: Send) -> None:
        """The token in the address buys the cookie; everyone else stays outside."""
        query = parse_qs(scope.get("query_string", b"").decode("latin-1"))
        given = query.get("token", [""])[0]
        if scope["type"] != "http" or not hmac.compare_digest(
            given.encode(), (self._token or "").encode()
        ):
            await _refuse(scope, send, 401, _NO_TOKEN)
            return
        cookie = f"{self._key}={self._secret}; Path=/; HttpOnly; SameSite=Strict"
        extra = [(b"set-cookie", cookie.encode()), *_safe_headers("'self'")]
        await _answer(send, 200, _ENTER, "text/html", extra)

    async def _pass(
        self, scope: Scope, receive: Receive, send: Send, owner: str, headers: dict[str, str]
    ) -> None:
        """Pass on; name the browser, so that it finds its other sessions again."""
        extra: list[tuple[bytes, bytes]] = []
        if scope["type"] == "http":
            extra += _safe_headers(f"ws://{headers['host']} wss://{headers['host']}")
        if not (16 <= len(owner) <= 64 and owner.isascii() and owner.isprintable()):
            owner = secrets.token_urlsafe(24)
            cookie = f"{self._who}={owner}; Path=/; HttpOnly; SameSite=Strict; Max-Age=31536000"
            extra.append((b"set-cookie", cookie.encode()))
        scope[OWNER] = owner
        scope["headers"] = [
            (name, item) for name, item in scope["headers"] if not name.startswith(b"x-forwarded")
        ]

        async def send_safely(message: MutableMapping[str, Any]) -> None:
            if message["type"] in ("http.response.start", "websocket.accept"):
                message["headers"] = [*message.get("headers", ()), *extra]
            await send(message)

        await self.app(scope, receive, send_safely)


def own_names(options: Options) -> frozenset[str]:
    """Names, besides addresses in numbers, under which a studio may be called."""
    names = {"localhost", options.host.lower()}
    if not options.local:
        machine = socket.gethostname().lower()
        names |= {machine, f"{machine}.local", socket.getfqdn().lower()}
    return frozenset(names)


def _check_body(method: str, headers: dict[str, str]) -> tuple[int, str]:
    if method not in _METHODS:
        return 405, "The studio knows no such method."
    if method != "POST":
        return 0, ""
    length = headers.get("content-length", "")
    if not (length.isascii() and length.isdigit()):
        return 411, "Say how long the content is."
    if len(length) > 15 or int(length) > MAX_BODY:
        return 413, f"At most {MAX_BODY:,} bytes may be sent."
    return 0, ""


def _same_place(origin: str, host: str) -> bool:
    """Whether an Origin header names the page of the host that was called."""
    try:
        parts = urlsplit(origin)
        return parts.scheme in ("http", "https") and parts.netloc.lower() == host.lower()
    except ValueError:
        return False


def _split(host: str) -> tuple[str, int]:
    """Name and port of a Host header; port -1 where it is no such header."""
    try:
        parts = urlsplit(f"//{host}")
        if parts.netloc != host or "@" in host or parts.hostname is None:
            return "", -1
        return parts.hostname.rstrip("."), 80 if parts.port is None else parts.port
    except ValueError:
        return "", -1


def _headers(scope: Scope) -> dict[str, str]:
    """Headers by name in small letters; a name that stands twice joins to what matches nothing."""
    found: dict[str, str] = {}
    for name, item in scope["headers"]:
        key, text = name.decode("latin-1").lower(), item.decode("latin-1")
        glue = "; " if key == "cookie" else ", "
        found[key] = f"{found[key]}{glue}{text}" if key in found else text
    return found


def _cookies(text: str) -> dict[str, str]:
    jar: SimpleCookie = SimpleCookie()
    for part in text.split(";"):
        try:
            jar.load(part.strip())
        except CookieError:  # a foreign cookie with an odd name takes no other with it
            continue
    return {name: item.value for name, item in jar.items()}


def _safe_headers(socket_source: str) -> list[tuple[bytes, bytes]]:
    return [
        (b"content-security-policy", _POLICY.format(socket=socket_source).encode()),
        (b"x-content-type-options", b"nosniff"),
        (b"referrer-policy", b"no-referrer"),
        (b"cross-origin-opener-policy", b"same-origin"),
        (b"cross-origin-resource-policy", b"same-origin"),
    ]


async def _refuse(scope: Scope, send: Send, status: int, reason: str) -> None:
    if scope["type"] == "websocket":
        await send({"type": "websocket.close", "code": 1008})
        return
    await _answer(send, status, reason + "\n", "text/plain", _safe_headers(""))


async def _answer(
    send: Send, status: int, text: str, kind: str, extra: list[tuple[bytes, bytes]]
) -> None:
    body = text.encode()
    headers = [
        (b"content-type", f"{kind}; charset=utf-8".encode()),
        (b"content-length", str(len(body)).encode()),
        (b"cache-control", b"no-store"),
        *extra,
    ]
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": body})
