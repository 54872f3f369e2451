from __future__ import annotations

from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests.project.distributions import closure


def pins(root: Path) -> dict[str, str]:
    lines = (root / "constraints.txt").read_text(encoding="utf-8").splitlines()
    requirements = [Requirement(line) for line in lines if line and not line.startswith("#")]
    return {
        canonicalize_name(pin.name): str(pin.specifier)
        for pin in requirements
        if pin.marker is None or pin.marker.evaluate()
    }


def test_everything_installed_is_pinned(root: Path) -> None:
    installed = closure("rovernav", "cluster", "studio", "test", "dev", "docs")
    pinned = pins(root)
    assert {"pip", "hatchling", "editables"} <= pinned.keys()
    assert {name: f"=={item.version}" for name, item in installed.items()} == {
        name: pinned.get(name, "not pinned") for name in installed
    }
