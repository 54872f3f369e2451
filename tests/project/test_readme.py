from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path


def test_the_example_runs(root: Path, tmp_path: Path) -> None:
    readme = (root / "README.md").read_text(encoding="utf-8")
    example = re.search(r"^```python\n(.+?)^```", readme, flags=re.MULTILINE | re.DOTALL)
    assert example is not None, "README.md has no ```python block"
    done = subprocess.run(
        [sys.executable, "-W", "error::UserWarning", "-c", example.group(1)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
