"""Build the pages strictly into `site/`, and make sure that they load nothing from elsewhere."""

import os
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SITE = ROOT / "site"
LOADED = re.compile(
    r"<(?:script|img|iframe|source)\b[^>]*\ssrc=[\"']?(?:https?:)?//[^>]*>"
    r"|<link\b(?=[^>]*\srel=[\"']?(?:stylesheet|preconnect|preload|icon))[^>]*\shref=[\"']?(?:https?:)?//[^>]*>"
)


def main() -> None:
    """Exit with 1 and the reason if a page cannot be built or would load something foreign."""
    built = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--clean"],
        cwd=ROOT,
        env={**os.environ, "NO_MKDOCS_2_WARNING": "1"},
        check=False,
    )
    if built.returncode != 0:
        sys.exit(built.returncode)
    foreign = [
        f"{page.relative_to(SITE)}: {match.group()}"
        for page in sorted(SITE.rglob("*.html"))
        for match in LOADED.finditer(page.read_text(encoding="utf-8"))
    ]
    if foreign:
        sys.exit("these pages load something from elsewhere:\n" + "\n".join(foreign))


if __name__ == "__main__":
    main()
