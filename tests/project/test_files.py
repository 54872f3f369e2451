from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

LONGEST = 400
HOSTS = r"\b(?:pypi|pythonhosted|anaconda|conda-forge)\." + r"(?:org|com)\b"
FOLDERS = r"(?:^|[\s\"'`(=:])/(?:root|work|home/\w+|Users/\w+)" + "/"


def tracked(root: Path) -> list[Path]:
    """The files of the project: those in git, and those that would be."""
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "-z"]
    listed = subprocess.run(command, cwd=root, capture_output=True, text=True, check=False)
    if listed.returncode != 0:
        pytest.skip("not a git checkout")
    return [root / name for name in listed.stdout.split("\0") if name and (root / name).is_file()]


def texts(root: Path) -> dict[str, str]:
    found: dict[str, str] = {}
    for path in tracked(root):
        content = path.read_bytes()
        if b"\0" not in content[:8192]:
            found[str(path.relative_to(root))] = content.decode("utf-8", errors="replace")
    return found


def matches(root: Path, pattern: str) -> list[str]:
    return [
        f"{name}:{number}: {line.strip()[:120]}"
        for name, text in texts(root).items()
        for number, line in enumerate(text.splitlines(), 1)
        if re.search(pattern, line)
    ]


def test_source_files_are_short(root: Path) -> None:
    lengths = {
        str(path.relative_to(root)): len(path.read_text(encoding="utf-8").splitlines())
        for path in (root / "src").rglob("*.py")
    }
    assert lengths
    assert {name: n for name, n in lengths.items() if n > LONGEST} == {}


def test_no_folder_of_one_machine(root: Path) -> None:
    assert matches(root, FOLDERS) == []


def test_no_package_registry_is_named(root: Path) -> None:
    assert matches(root, HOSTS) == []


def test_pins_name_no_place(root: Path) -> None:
    pins = (root / "constraints.txt").read_text(encoding="utf-8")
    assert "/" not in pins.replace("`.venv/bin/pip", "")
    assert "@" not in pins


def test_only_small_files(root: Path) -> None:
    limit = 1_000_000
    assert {p.name: p.stat().st_size for p in tracked(root) if p.stat().st_size > limit} == {}
