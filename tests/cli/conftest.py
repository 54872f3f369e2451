"""Commands run in an empty folder, so that messages name short paths and nothing is left over."""

from __future__ import annotations

from pathlib import Path

import pytest


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.delenv("ROVERNAV_DATA", raising=False)
    monkeypatch.delenv("ROVERNAV_DEBUG", raising=False)
    return tmp_path
