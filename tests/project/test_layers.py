from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from pathlib import Path

ALLOWED = {"llvmlite", "numba", "numpy", "platformdirs", *sys.stdlib_module_names}


def imports(path: Path) -> Iterator[str]:
    """The first part of each absolute import in a file."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name.split(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            yield str(node.module).split(".")[0]


def test_kernels_import_only_arrays_and_numba(root: Path) -> None:
    # The layer rule forbids known packages; this forbids all but a few.
    kernels = root / "src" / "rovernav" / "kernels"
    found = {(path.name, name) for path in kernels.rglob("*.py") for name in imports(path)}
    assert found
    assert {item for item in found if item[1] not in ALLOWED} == set()
