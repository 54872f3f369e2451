"""Who may come in, asked over real HTTP."""

from __future__ import annotations

import re
from typing import Any

import pytest

from rovernav.studio import Options
from rovernav.studio._gate import MAX_BODY, own_names
from tests.studio.server import Answer, Studio

SOCKET = "/_nicegui_ws/socket.io/?EIO=4&transport=websocket"


def page(studio: Studio, **headers: Any) -> Answer:
    return studio.ask(studio.session(**headers), **headers)


def test_a_local_visitor_gets_the_page(studio: Studio) -> None:
    answer = page(studio)
    assert answer.status == 200
    assert "rovernav studio" in answer.body
    assert studio.address == f"http://127.0.0.1:{studio.port}/"
    for host in (f"localhost:{studio.port}", f"127.0.0.1:{studio.port}", f"[::1]:{studio.port}"):
        assert studio.ask("/", host=host).status == 303


FOREIGN_HOSTS = [
    "evil.example", "evil.example:{port}", "127.0.0.1.evil.example:{port}", "127.0.0.1",
    "localhost", "localhost:1", "", "localhost:{port}@evil.example", "192.168.1.7:{port}",
    "0.0.0.0:{port}", "localhost:{port}, evil.example", "127.0.0.1:{port}#",
    "[::ffff:10.0.0.1]:{port}", "127.1:{port}",
]  # fmt: skip


@pytest.mark.parametrize("host", FOREIGN_HOSTS)
def test_a_foreign_host_name_is_not_answered(studio: Studio, host: str) -> None:
    name = host.format(port=studio.port)
    assert studio.ask("/", host=name).status == 421
    assert studio.knock(SOCKET, host=name) == 403


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "null", "https://127.0.0.1", "http://localhost:1", "file://"]
)
def test_another_site_s_page_is_not_answered(studio: Studio, origin: str) -> None:
    assert studio.ask("/", Origin=origin).status == 403
    assert studio.knock(SOCKET, Origin=origin) == 403
    polling = SOCKET.replace("websocket", "polling")
    assert studio.ask(polling, Origin=origin).status == 403
    assert studio.ask(polling, method="POST", body=b"40", Origin=origin).status == 403


def test_the_own_page_is_answered(studio: Studio) -> None:
    own = f"http://{studio.host}:{studio.port}"
    assert studio.knock(SOCKET, Origin=own) == 101
    assert studio.knock(SOCKET) == 101  # no browser
    assert studio.ask("/", Sec_Fetch_Site="same-origin").status == 303
    assert studio.ask("/", Sec_Fetch_Site="none").status == 303
    assert studio.ask("/", Sec_Fetch_Site="cross-site", Sec_Fetch_Mode="navigate").status == 303
    assert studio.ask("/", Sec_Fetch_Site="cross-site", Sec_Fetch_Mode="no-cors").status == 403


def test_answers_carry_the_safe_headers(studio: Studio) -> None:
    answer = page(studio)
    policy = answer.headers["content-security-policy"]
    assert "default-src 'self'" in policy
    assert "frame-ancestors 'none'" in policy
    assert "http:" not in policy.replace("http://", "")
    assert answer.headers["x-content-type-options"] == "nosniff"
    assert answer.headers["referrer-policy"] == "no-referrer"
    assert "server" not in answer.headers
    for cookie in answer.cookies:
        assert "HttpOnly" in cookie
        assert "SameSite=Strict" in cookie


def test_bodies_have_a_length_and_a_limit(studio: Studio) -> None:
    assert studio.ask("/", method="POST", Transfer_Encoding="chunked", body=b"0\r\n\r\n",
                      Content_Length="").status in (400, 411)  # fmt: skip
    too_long = str(MAX_BODY + 1)
    assert studio.ask("/", method="POST", Content_Length=too_long).status == 413
    assert studio.ask("/", method="POST", Content_Length="9" * 30).status in (400, 413)
    assert studio.ask("/", method="POST", Content_Length="-1").status in (400, 411)
    for method in ("PUT", "DELETE", "PATCH", "TRACE", "CONNECT", "EVIL"):
        assert studio.ask("/", method=method).status in (400, 405)


def test_sessions_cannot_be_guessed_and_unknown_ones_begin_afresh(studio: Studio) -> None:
    keys = {studio.session().removeprefix("/s/") for _ in range(5)}
    assert len(keys) == 5
    assert all(len(key) >= 24 for key in keys)
    for path in ("/s/x", "/s/..%2f..%2fetc%2fpasswd", "/s/" + "A" * 5000):
        assert studio.ask(path).status in (303, 404)


def test_a_visitor_needs_the_token(open_studio: Studio) -> None:
    studio = open_studio
    assert len(studio.token) >= 32
    for path in ("/", "/s/x", "/?token=", "/?token=wrong", "/?token=" + "x" * 5000,
                 f"/?token={studio.token[:-1]}", "/_nicegui/x", "/?token=%ff%00"):  # fmt: skip
        answer = ask(studio, path)
        assert answer.status == 401, path
        assert "needs its token" in answer.body
        assert studio.token not in answer.body
    here = f"127.0.0.1:{studio.port}"
    assert studio.ask(SOCKET, to="127.0.0.1", host=here, Connection="Upgrade", Upgrade="websocket",
                      Sec_WebSocket_Version="13",
                      Sec_WebSocket_Key="dGhlIHNhbXBsZSBub25jZQ==").status == 403  # fmt: skip


def ask(studio: Studio, path: str, **headers: Any) -> Answer:
    """A request from this machine, whatever address the studio told."""
    return studio.ask(path, to="127.0.0.1", host=f"127.0.0.1:{studio.port}", **headers)


def test_the_token_buys_a_strict_cookie_for_this_browser(open_studio: Studio) -> None:
    studio = open_studio
    answer = ask(studio, f"/?token={studio.token}")
    assert answer.status == 200
    (cookie,) = answer.cookies
    assert "HttpOnly; SameSite=Strict" in cookie
    assert studio.token not in cookie + answer.body
    name = cookie.split(";")[0]
    assert ask(studio, "/", Cookie=name).status == 303
    assert ask(studio, "/", Cookie=f"odd=[{{}}; {name}; other=1").status == 303
    assert ask(studio, "/", Cookie=name[:-2]).status == 401
    assert ask(studio, "/", Cookie=re.sub("=.*", "=", name)).status == 401
    evil = {"Cookie": name, "Origin": "http://evil.example"}
    assert ask(studio, "/", **evil).status == 403
    assert studio.ask("/", to="127.0.0.1", host=f"evil.example:{studio.port}",
                      Cookie=name).status == 421  # fmt: skip


def test_own_names_are_few() -> None:
    assert own_names(Options()) == {"localhost", "127.0.0.1"}
    assert "localhost" in own_names(Options(host="0.0.0.0"))
