from __future__ import annotations

import importlib.metadata
import re
import tomllib
from pathlib import Path

import rovernav


def test_version_is_in_one_place(root: Path) -> None:
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert "version" not in project
    assert "version" in project["dynamic"]
    assert importlib.metadata.version("rovernav") == rovernav.__version__


def test_changelog_tells_of_this_version(root: Path) -> None:
    changelog = (root / "CHANGELOG.md").read_text(encoding="utf-8")
    entries: list[str] = re.findall(r"^## \[(.+?)\]", changelog, flags=re.MULTILINE)
    released = [entry for entry in entries if entry != "Unreleased"]
    assert entries[0] in {"Unreleased", rovernav.__version__}
    assert released[0] == rovernav.__version__


def test_licence_is_apache(root: Path) -> None:
    text = (root / "LICENSE").read_text(encoding="utf-8")
    metadata = importlib.metadata.metadata("rovernav")
    assert "Apache License" in text
    assert "Version 2.0, January 2004" in text
    assert "END OF TERMS AND CONDITIONS" in text
    assert metadata["License-Expression"] == "Apache-2.0"


def test_types_are_shipped(root: Path) -> None:
    assert (root / "src" / "rovernav" / "py.typed").exists()
