from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numba
import pytest

from rovernav.kernels import _jit

FORWARD = """
from rovernav.kernels import _jit
from rovernav.nets import Network
network = Network.from_matrices([[[0.5, 0.25]]], ["linear"])
print(_jit.cache_folder(), network.forward([[3.0]])[0, 0], flush=True)
"""


def python(code: str, folder: Path, **environment: str) -> list[str]:
    """What a fresh Python in `folder` prints."""
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        cwd=folder,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


def test_kernels_work_where_nothing_can_be_written(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    said = python(FORWARD, tmp_path, ROVERNAV_CACHE_DIR=str(tmp_path / "file" / "below"))
    assert said == ["None", "1.75"]


def test_kernels_are_kept_in_the_named_folder(tmp_path: Path) -> None:
    folder, result = python(FORWARD, tmp_path, ROVERNAV_CACHE_DIR="here")
    assert result == "1.75"
    assert Path(folder).parent == tmp_path / "here"
    compiled = {path.name.split("-")[0]: path for path in Path(folder).rglob("*.nbc")}
    assert "network.forward" in compiled
    assert not list(tmp_path.glob("*.nb*"))


def test_without_a_home_nothing_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("ROVERNAV_CACHE_DIR", "NUMBA_CACHE_DIR", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(os.path, "expanduser", lambda path: path)
    assert _jit._parents() == []


def test_the_own_variable_goes_before_numbas(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ROVERNAV_CACHE_DIR", raising=False)
    monkeypatch.setenv("NUMBA_CACHE_DIR", "/b")
    assert _jit._parents() == [Path("/b")]
    monkeypatch.setenv("ROVERNAV_CACHE_DIR", "/a")
    assert _jit._parents() == [Path("/a")]


def test_the_folder_changes_with_each_source(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sources = shutil.copytree(Path(_jit.__file__).parent, tmp_path / "kernels")
    monkeypatch.setattr(_jit, "__file__", str(sources / "_jit.py"))
    names: set[str] = set()
    for path in sorted(sources.glob("*.py")):
        names.add(_jit._source_hash())
        path.write_bytes(path.read_bytes() + b"#")
    assert len(names) == len(list(sources.glob("*.py")))


def test_numbas_own_setting_is_left_alone() -> None:
    assert str(_jit.config.CACHE_DIR) == os.environ.get("NUMBA_CACHE_DIR", "")


def test_the_folder_names_numba() -> None:
    folder = _jit.cache_folder()
    assert folder is None or folder.name.endswith(f"-numba-{numba.__version__}")


@pytest.mark.long
def test_an_edit_in_another_file_reaches_its_callers(tmp_path: Path, root: Path) -> None:
    package = shutil.copytree(root / "src" / "rovernav", tmp_path / "rovernav")
    code = FORWARD.replace("linear", "relu")
    places = {"PYTHONPATH": str(tmp_path), "ROVERNAV_CACHE_DIR": str(tmp_path / "cache")}
    assert python(code, tmp_path, **places)[1] == "1.75"
    path = package / "kernels" / "arithmetic.py"
    text = path.read_text(encoding="utf-8")
    edited = text.replace("return lambda s: 0.0 if s < 0.0 else s", "return lambda s: 7.0 * s")
    assert edited != text
    path.write_text(edited, encoding="utf-8")
    assert python(code, tmp_path, **places)[1] == "12.25"
