"""Distributions that are there for one test: files on the path, with what an installer writes."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from rovernav.core.plugins import GROUPS, USED

Install = Callable[..., Path]


def page_file(page: str, name: str) -> str:
    """A file that a page shows under its name."""
    found = re.search(rf'^```\w+ title="my-rover/{name}"\n(.*?)^```$', page, re.M | re.S)
    assert found is not None, name
    return found[1]


def installer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Install:
    """Makes distributions that last as long as the test."""
    USED.clear()
    before = set(sys.modules)

    def install(
        name: str, files: Mapping[str, str], *, version: str = "1.0", **offers: Mapping[str, str]
    ) -> Path:
        """A distribution with these files; `offers` by kind: names and targets."""
        site = tmp_path / f"site-{name}"
        info = site / f"{name.replace('-', '_')}-{version}.dist-info"
        info.mkdir(parents=True)
        head = f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n"
        (info / "METADATA").write_text(head)
        points = [
            line
            for kind, parts in offers.items()
            for line in (f"[{GROUPS[kind]}]", *(f"{key} = {at}" for key, at in parts.items()), "")
        ]
        (info / "entry_points.txt").write_text("\n".join(points))
        for file, text in files.items():
            (site / file).write_text(text)
        monkeypatch.syspath_prepend(str(site))
        monkeypatch.setattr(sys, "dont_write_bytecode", True)
        for module in [*sys.modules]:
            if module not in before and f"{module}.py" in files:
                monkeypatch.delitem(sys.modules, module)
        return site

    return install


def forget(files: Mapping[str, str]) -> None:
    """Modules of files that are gone must not stay."""
    for file in files:
        sys.modules.pop(file.removesuffix(".py"), None)
