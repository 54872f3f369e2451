"""Pages as programs: their blocks are run in one empty folder, from top to bottom.

======================  ========================================================================
block                   what is done with it
======================  ========================================================================
```` ```bash ````       run, line by line; a ```` ```text ```` block right after it is its output
```` ```python ````     run; a ```` ```text ```` block right after it is its output
```` ```yaml title ```` written to the file that the title names; the same for csv
```` ```sh ````         only shown: what cannot or should not be run here
======================  ========================================================================

In an output block ``…`` stands for anything within a line, and a line of its own for any lines.
"""

from __future__ import annotations

import contextlib
import io
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

FENCE = re.compile(
    r'^```(?P<kind>[a-z]+)(?: title="(?P<title>[^"]+)")?\n(?P<text>.*?)^```$', re.M | re.S
)
RUN = ("bash", "python")
FILES = ("yaml", "csv")


@dataclass(frozen=True)
class Step:
    """A block of a page: what it is, and the output block that follows it, if one does."""

    kind: str
    title: str | None
    text: str
    output: re.Match[str] | None


def steps(page: str) -> list[Step]:
    """The blocks of a page that do something."""
    found = list(FENCE.finditer(page))
    out: list[Step] = []
    for block, after in zip(found, [*found[1:], None], strict=False):
        kind, title = block["kind"], block["title"]
        if kind in RUN or (kind in FILES and title):
            follows = after is not None and after["kind"] == "text" and not after["title"]
            close = after is not None and not page[block.end() : after.start()].strip()
            out.append(Step(kind, title, block["text"], after if follows and close else None))
    return out


def run(page: str, folder: Path) -> Iterator[tuple[Step, str]]:
    """Do every step of a page in `folder`; yields each with what it printed."""
    names: dict[str, object] = {"__name__": "__main__"}
    with contextlib.chdir(folder):
        for step in steps(page):
            printed = io.StringIO()
            with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed):
                if step.kind == "python":
                    exec(compile(step.text, "page", "exec"), names)
                elif step.kind == "bash":
                    _shell(
                        step.text, expect_error="error:" in (step.output or {"text": ""})["text"]
                    )
                else:
                    Path(step.title or "").write_text(step.text, encoding="utf-8")
            yield step, printed.getvalue()


def _shell(text: str, *, expect_error: bool) -> None:
    """Run lines of a shell; `rovernav` itself in this process, which saves its start-up."""
    from rovernav.cli import main

    for line in text.replace("\\\n", " ").splitlines():
        words = shlex.split(line, comments=True)
        if not words:
            continue
        if words[0] == "rovernav" and not {"|", ">", "&&", ";"} & set(words):
            code = main(words[1:])
        else:
            done = subprocess.run(line, shell=True, capture_output=True, text=True, check=False)
            sys.stdout.write(done.stdout + done.stderr)
            code = done.returncode
        if (code != 0) != expect_error:
            raise AssertionError(f"{line!r} ended with exit code {code}")


def plain(text: str) -> list[str]:
    """Lines without spaces at their ends, and without empty lines around."""
    return "\n".join(line.rstrip() for line in text.splitlines()).strip("\n").split("\n")


def fits(shown: str, printed: str) -> bool:
    """Whether an output block shows what was printed."""
    parts = [
        r"(?:[^\n]*\n)*?" if line.strip() == "…" else re.escape(line).replace("…", ".*") + r"\n"
        for line in plain(shown)
    ]
    return re.fullmatch("".join(parts), "\n".join(plain(printed)) + "\n") is not None
