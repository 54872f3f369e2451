"""Run every block of the pages and write its real output below it, where the two differ.

With names: only those pages. A block whose output fits, wildcards included, stays as it is.
"""

import os
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from tests.docs.pages import fits, plain, run, steps  # noqa: E402


def main() -> None:
    """Refresh the pages."""
    os.environ.update(COLUMNS="80", NO_COLOR="1")
    pages = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
    for path in [Path(name).absolute() for name in sys.argv[1:]] or pages:
        page = path.read_text(encoding="utf-8")
        if not steps(page):
            continue
        with tempfile.TemporaryDirectory() as folder:
            done = list(run(page, Path(folder)))
        fresh = page
        for step, printed in reversed(done):  # from the end, so that places stay
            if step.output is not None and not fits(step.output["text"], printed):
                start, end = step.output.span("text")
                fresh = fresh[:start] + "\n".join(plain(printed)) + "\n" + fresh[end:]
                print(f"{path.relative_to(ROOT)}: refreshed the output of {step.text.strip()!r}")
        if fresh != page:
            path.write_text(fresh, encoding="utf-8")


if __name__ == "__main__":
    main()
