"""The tutorial on Jezero is run where its elevation model is at hand."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.docs.pages import fits, run, steps

PAGE = "docs/tutorial/route-on-jezero.md"


@pytest.mark.data
def test_every_command_prints_what_the_page_shows(
    root: Path, data_dir: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("NO_COLOR", "1")
    (tmp_path / "jezero").symlink_to(data_dir / "dem/mars_jezero_hirise")
    page = (root / PAGE).read_text(encoding="utf-8")
    page = re.sub(r"^```sh$", "```bash", page, flags=re.M)
    page = re.sub(r"^```py$", "```python", page, flags=re.M)
    assert len(steps(page)) == 5
    for step, printed in run(page, tmp_path):
        assert step.output is not None, step.text
        assert fits(step.output["text"], printed), printed
