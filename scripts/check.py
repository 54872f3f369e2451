"""Run all checks side by side, and show the words of those that fail.

With no argument: format, lint, layer rule, types and spelling of the source.
With `docs`: the pages, built strictly. With `all`: both, and the kernels that tests call most are
compiled, which fills the processors that the slowest check leaves idle.
"""

import os
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BIN = Path(sys.executable).parent
SPELLED = (
    *("src", "tests", "scripts", "benchmarks", "docs", "examples"),
    *("README.md", "CHANGELOG.md", "CONTRIBUTING.md", "Makefile", "pyproject.toml"),
)

CHECKS = {  # the longest first
    "types": ("basedpyright", "--pythonpath", sys.executable, "--level", "error"),
    "layers": ("lint-imports", "--no-logo"),
    "spelling": ("codespell", *SPELLED),
    "lint": ("ruff", "check", "--quiet", "--output-format", "concise"),
    "kernel arguments": (
        *("ruff", "check", "--quiet", "--isolated", "--select", "PLR0913"),
        *("--config", "lint.pylint.max-args=8", "src/rovernav/kernels"),
    ),
    "format": ("ruff", "format", "--check", "--quiet"),
}
DOCS = {"pages": ("python", "scripts/docs.py")}
KERNELS = {"kernels compile": ("python", "scripts/kernels.py")}


def main() -> None:
    """Run what was asked for; exit with 1 if anything failed."""
    asked = sys.argv[1] if len(sys.argv) > 1 else "source"
    jobs = {"source": CHECKS, "docs": DOCS, "all": {**KERNELS, **CHECKS, **DOCS}}[asked]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        passed = list(pool.map(run, jobs, jobs.values()))
    if not all(passed):
        sys.exit(1)


def run(name: str, command: tuple[str, ...]) -> bool:
    """Run one check; print a line if it passed and all that it said if it failed."""
    begun = time.monotonic()
    done = subprocess.run(
        [str(BIN / command[0]), *command[1:]],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    passed = done.returncode == 0
    verdict = "ok" if passed else "FAILED"
    line = f"check: {name} {verdict} ({time.monotonic() - begun:.1f} s)\n"
    sys.stdout.write(line if passed else f"{line}{done.stdout}\n")
    sys.stdout.flush()
    return passed


if __name__ == "__main__":
    main()
