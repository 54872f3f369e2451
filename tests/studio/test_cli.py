"""`rovernav studio` from the command line."""

from __future__ import annotations

import importlib.util
import re
import signal
import socket
import sqlite3
import subprocess
import sys
from pathlib import Path

import pytest

from rovernav.core import SettingError
from rovernav.studio import Options
from rovernav.studio._server import listen
from tests.cli.runner import run
from tests.studio.server import running


def test_ctrl_c_and_sigterm_end_it_cleanly() -> None:
    for how in (signal.SIGINT, signal.SIGTERM):
        with running() as studio:
            assert studio.ask("/").status == 303
            code, errors = studio.stop(how)
            assert (code, errors) == (0 if how == signal.SIGINT else -how, "")


def test_a_taken_port_is_named() -> None:
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        said = run("studio", "--port", str(port), "--no-browser")
    assert said.code == 2
    assert f"port {port} is taken, perhaps by another studio; name another" in said.err


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--port", "70000"], "port must be from 0 (any free one) to 65535, got 70000"),
        (["--port", "x"], "--port must be a whole number, got 'x'"),
        (["--host", "not a host"], "host must be an address of this machine"),
        (["--host", "no-such-machine.invalid"], "cannot listen on 'no-such-machine.invalid'"),
        (["--host", "192.0.2.1"], "cannot listen on '192.0.2.1'"),
        (["--host", ""], "host must be an address of this machine"),
        (["--library", "."], "is no file; name a file for the library"),
        (["--library", "text.txt"], "the library text.txt cannot be used"),
        (["--library", "other.sqlite3"], "other.sqlite3 is not a library of runs"),
        (["--terrain", "nowhere.tif"], "nowhere.tif"),
        (["--brwoser"], "there is no option --brwoser; did you mean --browser?"),
    ],
)
def test_bad_input_is_answered_in_words(
    words: list[str], sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("text.txt").write_text("no library " * 500)
    with sqlite3.connect("other.sqlite3") as connection:
        connection.execute("CREATE TABLE t (x)")
    connection.close()
    if "--port" not in words:
        words = [*words, "--port", "0"]
    if "--library" not in words:
        words = [*words, "--library", "fresh.sqlite3"]
    said = run("studio", "--no-browser", *words)
    assert said.code == 2, said
    assert sentence in said.err
    assert "Traceback" not in said.err


def test_without_the_extra_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    real = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name, *a: None if name == "nicegui" else real(name, *a)
    )
    said = run("studio", "--no-browser", "--port", "0")
    assert said.code == 2
    assert "pip install 'rovernav[studio]'" in said.err


def test_help_is_light() -> None:
    command = [sys.executable, "-X", "importtime", "-m", "rovernav", "studio", "--help"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    loaded = set(re.findall(r"\|\s+([\w.]+)$", done.stderr, re.M))
    assert "--no-browser" in done.stdout
    assert {"nicegui", "numba", "fastapi", "matplotlib", "scipy", "numpy"} & loaded == set()


def test_only_this_machine_s_own_addresses_are_local() -> None:
    for host in ("127.0.0.1", "localhost", "::1", "127.8.8.8"):
        assert Options(host=host).local
    for host in ("0.0.0.0", "192.168.0.7", "::", "example.org"):
        assert not Options(host=host).local


def test_listening_on_version_6_addresses() -> None:
    try:
        with listen("::1", 0) as listener:
            assert listener.family == socket.AF_INET6
    except SettingError as error:
        pytest.skip(f"this machine has none: {error}")
