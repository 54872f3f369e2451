from __future__ import annotations

import difflib
from pathlib import Path

import pytest

from tests.docs.pages import fits, plain, run, steps

ROOT = Path(__file__).resolve().parents[2]
PAGES = sorted(
    str(path.relative_to(ROOT))
    for path in (ROOT / "README.md", *(ROOT / "docs").rglob("*.md"))
    if steps(path.read_text(encoding="utf-8"))
)


@pytest.mark.parametrize("name", PAGES)
def test_every_block_of_a_page_runs_and_prints_what_the_page_shows(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("NO_COLOR", "1")
    for step, printed in run((ROOT / name).read_text(encoding="utf-8"), tmp_path):
        if step.output is not None and not fits(step.output["text"], printed):
            shown = plain(step.output["text"])
            changes = difflib.unified_diff(shown, plain(printed), "page", "program", lineterm="")
            refresh = "python scripts/refresh_docs.py writes the real output into the pages"
            pytest.fail(f"after {step.text!r}:\n" + "\n".join(changes) + f"\n\n{refresh}")


def test_the_tutorial_and_how_to_pages_are_run() -> None:
    assert "docs/tutorial/first-drive.md" in PAGES
    assert sum(name.startswith("docs/how-to/") for name in PAGES) >= 5


def test_dots_stand_for_what_differs_from_run_to_run() -> None:
    assert fits("epoch 215, … s.\n", "epoch 215, 0.03 s.\n")
    assert fits("first\n…\nlast\n", "first\nsecond\nthird\nlast\n")
    assert not fits("epoch 215, … s.\n", "epoch 216, 0.03 s.\n")
    assert not fits("first\n", "first\nsecond\n")
