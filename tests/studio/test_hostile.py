"""What a hostile visitor may send: tables, networks, names, requests, events."""

from __future__ import annotations

import asyncio
import html
import json
import pickle
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import socketio

from rovernav.core import FileError, InputError, SettingError
from rovernav.learn import shipped_patterns
from rovernav.nets import Network, network_bytes, parse_network
from rovernav.studio import Library, TrainModel
from rovernav.studio._desk import TableDesk
from rovernav.studio._train_view import train_view
from rovernav.studio._uploads import check_file, display_name
from tests.studio.server import Studio

SCRIPT = "<script>window.pwned=1</script>"
IMAGE = "<img src=x onerror=window.pwned=1>"


class Bomb:
    """Runs a command where it is unpickled."""

    def __reduce__(self) -> tuple[Any, ...]:
        return (exec, ("raise SystemExit('unpickled')",))


TABLES: dict[str, tuple[bytes, str]] = {
    "nothing": (b"", "is empty"),
    "zero bytes": (b"in:x,out:y\n0\x00,1\n", "zero byte"),
    "no text": (b"\xff\xfe\x00\x01" * 50, "is not UTF-8 text"),
    "NaN": (b"in:x,out:y\nnan,1\n", "nan is not finite"),
    "infinity": (b"in:x,out:y\n1,-inf\n", "-inf is not finite"),
    "text": (b"in:x,out:y\nabc,1\n", "'abc' is not a number"),
    "script": (f"in:x,out:y\n{SCRIPT},1\n".encode(), "is not a number"),
    "a formula": (b"in:x,out:y\n=cmd|'/c calc'!A1,1\n", "is not a number"),
    "overflowing number": (b"in:x,out:y\n1e999,1\n", "is not finite"),
    "missing cell": (b"in:x,out:y\n1\n", "2 cells needed, got 1"),
    "no targets": (b"in:x,in:y\n1,2\n", "needs inputs and targets"),
    "twice the same name": (b"in:x,in:x,out:y\n1,2,3\n", "stands twice"),
    "no header": (b"1,2,3\n4,5,6\n", "must name the columns"),
    "open quote": (b'in:x,out:y\n"1,2\n', "line"),
    "a cell without end": (b"in:x,out:y\n" + b"9" * 200_000 + b",1\n", "line 2"),
    "too many rows": (b"in:x,out:y\n" + b"0,1\n" * 5_001, "5,000 patterns"),
    "too many columns": (
        ",".join([*(f"in:{i}" for i in range(65)), "out:y"]).encode() + b"\n" + b"0," * 65 + b"1\n",
        "64 columns",
    ),
    "too many bytes": (b"in:x,out:y\n" + b"0,1\n" * 600_000, "at most 2,000,000"),
    "invisible letters": ("in:x\u202e\u200b,out:y\n0,1\n".encode(), "cannot be shown"),
    "pickle": (pickle.dumps(Bomb()), "not"),
}


@pytest.fixture
def model(tmp_path: Path) -> Iterator[TrainModel]:
    model = TrainModel(keep=Library(tmp_path / "runs.sqlite3").add)
    yield model
    model.close()


@pytest.mark.parametrize("kind", TABLES)
def test_hostile_tables_are_refused_in_words(kind: str, model: TrainModel) -> None:
    data, said = TABLES[kind]
    desk, before = TableDesk(model), model.setup
    with pytest.raises(InputError, match=re.escape(said)) as error:
        desk.load_csv("table.csv", data)
    assert len(str(error.value)) < 400
    assert model.setup is before
    assert desk.draft.patterns().sha256 == shipped_patterns("bassil-v1").sha256


def test_script_in_names_is_text(model: TrainModel) -> None:
    desk = TableDesk(model)
    desk.load_csv(SCRIPT, f'"in:{SCRIPT}","in:{IMAGE}","out:\'"" onload=x"\n0,1,1\n'.encode())
    assert model.setup.table.inputs == (SCRIPT, IMAGE)
    model.step_epoch()
    view = train_view(model.state(), 0)
    for picture in (view.drawing, view.answers, view.weights):
        assert "<script" not in picture
        assert "<img" not in picture
    assert html.escape(IMAGE[:12]) in view.drawing


def networks() -> dict[str, tuple[bytes, str]]:
    whole = network_bytes(Network.from_matrices([[[1.0, 2.0, 3.0]]], ["linear"]))
    size = int.from_bytes(whole[:8], "little")
    liar = (10**15).to_bytes(8, "little") + whole[8:]
    deep = b"[" * 100_000
    return {
        "pickle": (pickle.dumps(Bomb()), "is not a network file"),
        "nothing": (b"", "is not a network file"),
        "cut off": (whole[:-3], "is not a whole safetensors file"),
        "a header longer than the file": (liar, "is cut off"),
        "a flipped bit": (whole[:-1] + bytes([whole[-1] ^ 1]), "sha256"),
        "nested without end": (
            len(deep).to_bytes(8, "little") + deep, "is not a whole safetensors file"),
        "another topology": (
            whole[:8] + whole[8 : 8 + size].replace(b"[2,1]", b"[9,1]") + whole[8 + size :],
            "damaged|parameters"),
    }  # fmt: skip


@pytest.mark.parametrize("kind", networks())
def test_hostile_networks_are_refused_in_words(kind: str) -> None:
    data, said = networks()[kind]
    with pytest.raises(FileError, match=said):
        parse_network(data, "mine.safetensors")


def test_weights_that_are_no_numbers_are_refused(model: TrainModel) -> None:
    nan = Network.from_matrices([np.full((3, 3), np.nan), np.ones((2, 4))], ["sigmoid", "linear"])
    with pytest.raises(SettingError, match="finite"):
        model.change(weights="given", given=nan)
    single = Network(topology=(2, 3, 2), activations=("sigmoid", "linear"),
                     parameters=np.ones(17, np.float32))  # fmt: skip
    with pytest.raises(InputError, match="float64"):
        model.change(weights="given", given=single)
    assert model.setup.weights == "paper"


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        ("../../etc/passwd", "passwd"), ("C:\\Windows\\x.csv", "x.csv"), ("", "a file without"),
        ("a\0b\n.csv", "ab.csv"), ("\u202egpj.csv", "gpj.csv"),
        ("x" * 500 + ".csv", "x" * 30 + "…"),
        (SCRIPT, "script>"), ("/vsicurl/http://evil.example/x.tif", "x.tif"),
    ],
)  # fmt: skip
def test_file_names_are_for_show_only(name: str, shown: str) -> None:
    assert display_name(name).startswith(shown)
    assert len(display_name(name)) <= 60


def test_files_have_a_kind_and_a_size() -> None:
    check_file("a.CSV", 10, (".csv",), 100)
    for name, size in (("a.exe", 10), ("a.csv.exe", 10), ("csv", 10), ("a.csv", 101), ("a.csv", 0)):
        with pytest.raises(FileError, match=r"give a file that ends in .csv"):
            check_file(name, size, (".csv",), 100)


def test_titles_are_kept_as_text(tmp_path: Path) -> None:
    library = Library(tmp_path / "runs.sqlite3")
    name = library.add(kind="training", title=SCRIPT, command="x'; DROP TABLE run; --",
                       settings={}, summary={}, files={})  # fmt: skip
    assert library.get(name).title == SCRIPT
    assert library.get(name).command == "x'; DROP TABLE run; --"
    for key in ("' OR 1=1 --", "", "\0", "a" * 10_000):
        with pytest.raises(SettingError, match="no longer in the library"):
            library.get(key)
        library.delete(key)
    assert len(library.list()) == 1


# ---- over the network --------------------------------------------------------------------------

REQUESTS = [
    b"\0" * 100,
    b"GET / HTTP/1.1\r\n\r\n",
    b"GET / HTTP/9.9\r\nHost: x\r\n\r\n",
    b"GET " + b"/" * 70_000 + b" HTTP/1.1\r\nHost: localhost\r\n\r\n",
    b"GET / HTTP/1.1\r\nHost: localhost\r\n" + b"X: y\r\n" * 20_000 + b"\r\n",
    b"GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n",
    b"GET http://evil.example/ HTTP/1.1\r\nHost: localhost\r\n\r\n",
    b"POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5\r\nContent-Length: 9\r\n\r\nhello",
    b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03",
]


@pytest.mark.parametrize("data", REQUESTS, ids=range(len(REQUESTS)))
def test_what_is_no_proper_request_gets_no_page(studio: Studio, data: bytes) -> None:
    answer = studio.raw(data)
    assert not answer or re.match(rb"HTTP/1.1 4\d\d ", answer), answer[:200]
    assert studio.ask("/").status == 303


PATHS = [
    "/../../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "/s/%00", "/_nicegui/../../x",
    "/_nicegui/3.18.0/resources/x/../../../../etc/passwd", "/static/..%2f..%2fpyproject.toml",
    "/_nicegui/client/x/upload/1", "/docs", "/openapi.json", "/redoc", "/.env",
]  # fmt: skip


@pytest.mark.parametrize("path", PATHS)
def test_no_path_leads_to_a_file(studio: Studio, path: str) -> None:
    answer = studio.ask(path)
    assert answer.status in (303, 400, 404, 405)
    assert "root:" not in answer.body
    assert "[project]" not in answer.body


class Page:
    """A page of a fresh session as its bare parts: client, elements, uploads."""

    def __init__(self, studio: Studio) -> None:
        self.studio, self.path = studio, studio.session()
        body = studio.ask(self.path).body
        raw = re.search(r"String\.raw`(.*?)`", body, re.DOTALL)
        client = re.search(r"'client_id': '([0-9a-f-]+)'", body)
        assert raw
        assert client
        self.client = client[1]
        text = html.unescape(raw[1])
        self.elements: dict[str, dict[str, Any]] = json.loads(text)

    def uploads(self) -> list[str]:
        found = [e.get("props", {}).get("url", "") for e in self.elements.values()]
        return [url for url in found if url]

    def listeners(self) -> list[tuple[int, str, str]]:
        return [
            (int(number), event["listener_id"], event["type"])
            for number, element in self.elements.items()
            for event in element.get("events", [])
        ]


def form(name: str, data: bytes, kind: str = "text/csv") -> tuple[bytes, str]:
    head = f'--b\r\nContent-Disposition: form-data; name="f"; filename="{name}"\r\n'
    body = head.encode() + f"Content-Type: {kind}\r\n\r\n".encode() + data + b"\r\n--b--\r\n"
    return body, "multipart/form-data; boundary=b"


def test_hostile_uploads_leave_everything_as_it_was(studio: Studio) -> None:
    page = Page(studio)
    urls = page.uploads()
    assert len(urls) >= 2
    sent = [("../../../tmp/pwned.csv", TABLES["text"][0]), (SCRIPT + ".csv", TABLES["NaN"][0]),
            ("x.exe", b"MZ"), ("x.csv", pickle.dumps(Bomb())), ("x.safetensors", b"\0" * 100),
            ("x.csv", b"in:x,out:y\n" + b"0,1\n" * 600_000), ("", b""),
            ("x.csv" + "A" * 20_000, b"in:x,out:y\n0,1\n")]  # fmt: skip
    for url in urls:
        for name, data in sent:
            body, kind = form(name, data)
            answer = studio.ask(url, method="POST", body=body, Content_Type=kind)
            assert answer.status in (200, 400, 403, 413, 422, 500), answer
        for body, kind in ((b"", "multipart/form-data"), (b"x" * 1000, "multipart/form-data; b"),
                           (b"f=1", "application/x-www-form-urlencoded")):  # fmt: skip
            assert studio.ask(url, method="POST", body=body, Content_Type=kind).status >= 200
    again = studio.ask(page.path)
    assert again.status == 200
    assert "motor_x" in again.body
    assert SCRIPT not in again.body
    assert not Path("/tmp/pwned.csv").exists()


ARGUMENTS: list[Any] = [
    None, True, -1, 1e308, "NaN", "", "x" * 10_000, SCRIPT, [], {}, [[[]]], {"value": 99},
    {"value": -1}, {"value": {"a": 1}}, {"value": None, "label": IMAGE}, {"__proto__": {"x": 1}},
    ["../../etc/passwd"], {"mouse_event_type": "click", "image_x": "NaN"}, {"args": 10**400},
    {"value": "0x7fffffffffffffff"}, "\u0000", {"key": {"value": 1}},
]  # fmt: skip


def test_hostile_events_to_every_listener_of_the_page_do_no_harm(studio: Studio) -> None:
    page = Page(studio)
    listeners = page.listeners()
    assert len(listeners) > 40

    async def attack() -> None:
        client = socketio.AsyncClient(reconnection=False)
        query = f"client_id={page.client}&tab_id=t&document_id=d&implicit_handshake=true"
        await client.connect(
            f"http://{studio.host}:{studio.port}/?{query}&next_message_id=0",
            socketio_path="/_nicegui_ws/socket.io", transports=["websocket"],
        )  # fmt: skip
        for nonsense in ({}, {"client_id": page.client}, {"client_id": "x", "id": 1, "args": []}):
            for event in ("event", "javascript_response", "ack", "log", "handshake", "evil"):
                await client.emit(event, nonsense)
        for number, listener, _kind in listeners:
            for argument in ARGUMENTS:
                message = {
                    "id": number, "client_id": page.client, "listener_id": listener,
                    "args": [json.dumps(argument)],
                }  # fmt: skip
                await client.emit("event", message)
        for args in (["{"], "no list", [None] * 1000, [json.dumps({"value": "a"})] * 3):
            message = {"id": listeners[0][0], "client_id": page.client,
                       "listener_id": listeners[0][1], "args": args}  # fmt: skip
            await client.emit("event", message)
        await asyncio.sleep(1.0)
        await client.disconnect()

    asyncio.run(attack())
    assert studio.process.poll() is None
    assert studio.ask(page.path).status == 200
    assert Page(studio).elements
    errors = (studio.folder / "errors.txt").read_text()
    ours = re.findall(r'File ".*?(rovernav/(?:studio|learn|nets)/\w+\.py", line \d+)', errors)
    ours = [place for place in ours if "_gate.py" not in place]  # all requests pass through it
    assert sorted(set(ours)) == []  # NiceGUI writes down what it cannot read; we must not stumble


def test_a_message_that_is_too_long_ends_its_connection_alone(studio: Studio) -> None:
    async def send() -> bool:
        client = socketio.AsyncClient(reconnection=False)
        await client.connect(
            f"http://{studio.host}:{studio.port}", socketio_path="/_nicegui_ws/socket.io",
            transports=["websocket"],
        )  # fmt: skip
        await client.emit("event", {"client_id": "x" * 3_000_000})
        for _ in range(100):
            if not client.connected:
                return True
            await asyncio.sleep(0.1)
        await client.disconnect()
        return False

    assert asyncio.run(send())
    assert studio.ask("/").status == 303


def test_another_s_client_cannot_be_taken_over(studio: Studio) -> None:
    """A page's events need its id, which is as hard to guess as a password."""
    keys = {Page(studio).client for _ in range(3)}
    assert len(keys) == 3
    assert all(len(key) == 36 for key in keys)
