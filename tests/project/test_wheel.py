"""The wheel, alone in an empty environment: does it bring its data, does it declare its needs?"""

from __future__ import annotations

import fcntl
import json
import os
import shutil
import subprocess
import sys
import venv
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.conftest import ROOT
from tests.project.distributions import closure

pytestmark = pytest.mark.xdist_group("wheel")  # built once, in one worker

ENVIRONMENT = ROOT / "build" / "wheel"
"""Always the same folder, as compiled kernels are kept by the path of their source."""
KERNELS = ROOT / "build" / "wheel-kernels"


def run(*command: str | Path, cwd: Path) -> str:
    own = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    environment = {**own, "PIP_DISABLE_PIP_VERSION_CHECK": "1", "ROVERNAV_CACHE_DIR": str(KERNELS)}
    done = subprocess.run(
        [str(part) for part in command],
        cwd=cwd,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, f"{command}\n{done.stdout[-2000:]}\n{done.stderr[-2000:]}"
    return done.stdout


@pytest.fixture(scope="module")
def wheel(root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    options = ("--wheel", "--no-isolation", "--outdir", folder)
    run(sys.executable, "-m", "build", *options, root, cwd=folder)
    (built,) = folder.glob("*.whl")
    return built


@pytest.fixture
def environment() -> Iterator[Path]:
    """An empty environment, for this test alone."""
    ENVIRONMENT.parent.mkdir(exist_ok=True)
    with ENVIRONMENT.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        shutil.rmtree(ENVIRONMENT, ignore_errors=True)
        venv.create(ENVIRONMENT, with_pip=False, symlinks=True)
        yield ENVIRONMENT


def packages(environment: Path) -> Path:
    (folder,) = (environment / "lib").glob("python*/site-packages")
    return folder


def lend_dependencies(environment: Path) -> None:
    """Link what rovernav declares, and nothing else, into the environment."""
    folder = packages(environment)
    for item in closure("rovernav").values():
        for top in {file.parts[0] for file in item.files or [] if file.parts[0] != ".."}:
            if top != "__pycache__" and not (folder / top).exists():
                (folder / top).symlink_to(Path(str(item.locate_file(top))))


def install(environment: Path, *arguments: str | Path, cwd: Path) -> None:
    pip = (sys.executable, "-m", "pip", "--python", environment / "bin" / "python")
    run(*pip, "install", "--quiet", *arguments, cwd=cwd)
    for path in (packages(environment) / "rovernav" / "kernels").glob("*.py"):
        os.utime(path, (0, 0))  # compiled kernels of an earlier run with the same source are found


def reproduces_the_paper(environment: Path, empty: Path) -> None:
    empty.mkdir()
    program = environment / "bin" / "rovernav"
    said = run(program, "paper", "--json", "--out", empty / "paper", cwd=empty)
    assert json.loads(said)["epochs"] == 215
    assert [path.name for path in empty.iterdir()] == ["paper"]


def test_all_files_are_in_the_wheel(wheel: Path, root: Path) -> None:
    listed = set(run(sys.executable, "-m", "zipfile", "-l", wheel, cwd=root).split())
    source = root / "src"
    shipped = {
        path.relative_to(source).as_posix()
        for path in (source / "rovernav").rglob("*")
        if path.is_file() and "__pycache__" not in path.parts and not path.name.startswith(".")
    }
    assert shipped - listed == set()


def test_paper_from_the_wheel(wheel: Path, environment: Path, tmp_path: Path) -> None:
    lend_dependencies(environment)
    install(environment, "--no-deps", "--no-index", wheel, cwd=tmp_path)
    reproduces_the_paper(environment, tmp_path / "empty")


@pytest.mark.long
def test_paper_from_the_wheel_with_downloaded_dependencies(
    wheel: Path, environment: Path, root: Path, tmp_path: Path
) -> None:
    install(environment, "--constraint", "constraints.txt", wheel, cwd=root)
    reproduces_the_paper(environment, tmp_path / "empty")
