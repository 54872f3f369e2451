"""The wheel, alone in an empty environment: does it bring its data, does it declare its needs?"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import venv
from pathlib import Path

import pytest

from tests.project.distributions import closure

pytestmark = pytest.mark.xdist_group("wheel")  # built once, in one worker


def run(*command: str | Path, cwd: Path) -> str:
    own = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    environment = {**own, "PIP_DISABLE_PIP_VERSION_CHECK": "1"}
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


def empty_environment(folder: Path) -> Path:
    venv.create(folder, with_pip=False, symlinks=True)
    return folder / "bin"


def lend_dependencies(folder: Path) -> None:
    """Link what rovernav declares, and nothing else, into the environment."""
    (packages,) = (folder / "lib").glob("python*/site-packages")
    for item in closure("rovernav").values():
        for top in {file.parts[0] for file in item.files or [] if file.parts[0] != ".."}:
            if top != "__pycache__" and not (packages / top).exists():
                (packages / top).symlink_to(Path(str(item.locate_file(top))))


def reproduces_the_paper(bin_folder: Path, empty: Path) -> None:
    said = run(bin_folder / "rovernav", "paper", "--json", "--out", empty / "paper", cwd=empty)
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


def test_paper_from_the_wheel(wheel: Path, tmp_path: Path) -> None:
    bin_folder = empty_environment(tmp_path / "environment")
    lend_dependencies(tmp_path / "environment")
    installer = (sys.executable, "-m", "pip", "--python", bin_folder / "python", "install")
    run(*installer, "--quiet", "--no-deps", "--no-index", wheel, cwd=tmp_path)
    (tmp_path / "empty").mkdir()
    reproduces_the_paper(bin_folder, tmp_path / "empty")


@pytest.mark.long
def test_paper_from_the_wheel_with_downloaded_dependencies(
    wheel: Path, root: Path, tmp_path: Path
) -> None:
    bin_folder = empty_environment(tmp_path / "environment")
    installer = (sys.executable, "-m", "pip", "--python", bin_folder / "python", "install")
    run(*installer, "--quiet", "--constraint", "constraints.txt", wheel, cwd=root)
    (tmp_path / "empty").mkdir()
    reproduces_the_paper(bin_folder, tmp_path / "empty")
