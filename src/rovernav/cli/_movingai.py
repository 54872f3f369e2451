"""`rovernav route MAP.map --scen MAP.scen`: all ways of a MovingAI file."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ._console import progress_bar, say

if TYPE_CHECKING:
    from ..plan import Scenarios

MAP = ".map"


def movingai(ground: Path, scen: Path | None, given: dict[str, Any]) -> dict[str, Any]:
    """Solve every scenario of a file; what goes for elevation models only is refused."""
    from ..core import SettingError
    from ..plan import read_map, read_scenarios, solve_scenarios

    for name, item in given.items():
        if item is not None:
            raise SettingError(f"--{name} does not go with a MovingAI map; give --scen FILE alone")
    if scen is None:
        raise SettingError(f"{ground} is a MovingAI map; give its scenarios too: --scen FILE.scen")
    with progress_bar("solving") as update:
        costs = read_map(ground)
        scenarios = read_scenarios(scen, costs)
        begun = time.perf_counter()
        lengths = solve_scenarios(costs, scenarios, on_event=update)
        seconds = time.perf_counter() - begun
    return {
        "map": ground,
        "scen": scen,
        "scenarios": len(scenarios),
        "lengths": lengths,
        **_errors(lengths, scenarios),
        "seconds": seconds,
    }


def _errors(lengths: Any, scenarios: Scenarios) -> dict[str, Any]:
    import numpy as np

    off = np.abs(lengths - scenarios.optimal)
    relative = np.divide(
        off, scenarios.optimal, out=np.where(off > 0.0, np.inf, 0.0), where=scenarios.optimal > 0.0
    )
    return {
        "max_rel_error": float(relative.max()),
        "beyond_printed_digits": int((off > scenarios.tolerance).sum()),
    }


def print_solved(report: dict[str, Any]) -> None:
    """How many were solved, how fast, and whether the lengths are the published ones."""
    count, seconds, off = report["scenarios"], report["seconds"], report["beyond_printed_digits"]
    say(f"{report['map']}: {count:,} scenarios in {seconds:.2f} s, "
        f"{1e3 * seconds / count:.3g} ms each.")  # fmt: skip
    agree = "All lengths equal" if not off else f"{off:,} lengths differ from"
    say(f"{agree} the published ones to the digits printed; the largest relative difference is "
        f"{report['max_rel_error']:.2g}.")  # fmt: skip
