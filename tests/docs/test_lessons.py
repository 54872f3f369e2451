"""The lessons' notebooks run, and print what they show."""

from __future__ import annotations

import importlib.util
import re
import warnings
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]
NOTEBOOKS = sorted((ROOT / "docs" / "lessons").glob("*.ipynb"))
LARGEST = 100_000
PATHS = re.compile(r"(?<![\w.])/(?:home|root|tmp|usr|work|opt|Users)/|[A-Z]:\\")


def refresh() -> Any:
    spec = importlib.util.spec_from_file_location("lessons", ROOT / "scripts/refresh_lessons.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def printed(notebook: Any) -> list[str]:
    """What each code cell prints, and the kinds of its other outputs."""
    return [
        " ".join(
            output.text if output.output_type == "stream" else "+".join(sorted(output.data))
            for output in cell.outputs
        )
        for cell in notebook.cells
        if cell.cell_type == "code"
    ]


@pytest.mark.parametrize(
    "path",
    [
        NOTEBOOKS[-1],
        *(pytest.param(path, marks=pytest.mark.long) for path in NOTEBOOKS[:-1]),
    ],
    ids=lambda path: path.stem,
)
def test_a_notebook_runs_and_prints_what_it_shows(path: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of Jupyter's own
        import nbformat

        stored = nbformat.read(path, as_version=4)
        shown = printed(stored)
        fresh = printed(refresh().run(stored))
    assert all(shown), "a cell has no stored output; run scripts/refresh_lessons.py"
    assert fresh == shown


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_small_and_knows_no_machine(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert len(text) < LARGEST
    assert not PATHS.search(re.sub(r'"image/png": "[^"]*"', "", text))
    assert '"traceback"' not in text


def test_the_page_lists_every_notebook_and_the_studio_has_the_same_lessons() -> None:
    from rovernav.studio._lesson_texts import LESSONS

    page = (ROOT / "docs" / "lessons" / "index.md").read_text(encoding="utf-8")
    assert {path.stem for path in NOTEBOOKS} == {lesson.key for lesson in LESSONS}
    for lesson in LESSONS:
        assert f"({lesson.key}.ipynb)" in page
        assert lesson.title in page
        assert lesson.question in page
