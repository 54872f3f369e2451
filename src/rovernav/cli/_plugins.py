"""`rovernav plugins`: parts of drives that installed packages offer, and whether they are sound."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from ._console import print_json, print_table, say
from ._options import Json

if TYPE_CHECKING:
    from ..core import Plugin


def plugins(
    *,
    check: Annotated[
        bool, Parameter(negative="", help="Load each, and check that it keeps its contract.")
    ] = False,
    json: Json = False,
) -> int:
    """List the controllers, sensors and metrics that installed packages offer.

    With --check each is loaded and tried: the same seed must give the same result, a rover alone
    the same as in a batch, and so on. The exit code is 1 if one fails.

    Example: rovernav plugins --check
    """
    from ..core import plugins as offered
    from ..core.plugins import GROUPS

    found = [one for kind in GROUPS for one in offered(kind)]
    rows = [_row(one, _fault(one) if check else None) for one in found]
    if json:
        print_json({"plugins": rows})
    elif not rows:
        say("No installed package offers controllers, sensors or metrics.")
    else:
        _print(rows, check=check)
    return 1 if any(row["fault"] for row in rows) else 0


def _row(one: Plugin, fault: str | None) -> dict[str, Any]:
    return {
        "kind": one.kind, "name": one.name, "from": one.distribution, "target": one.target,
        "fault": fault,
    }  # fmt: skip


def _fault(one: Plugin) -> str:
    """What is wrong with a plug-in, in a sentence; nothing where it is sound."""
    from ..control import check_controller
    from ..core import PluginError, RovernavError
    from ..sim import check_metric, check_sensor

    checks = {"controller": check_controller, "sensor": check_sensor, "metric": check_metric}
    try:
        checks[one.kind](one.make())
    except PluginError as error:
        return " ".join(str(error).split())
    except RovernavError as error:
        return f"{one.called}: {error}"
    except Exception as error:  # whatever the plug-in raises
        return f"{one.called} failed: {type(error).__name__}: {error}"
    return ""


def _print(rows: list[dict[str, Any]], *, check: bool) -> None:
    columns = ["kind", "name", "from", "target"]
    cells = [[row[column] for column in columns] for row in rows]
    if check:
        cells = [
            [*row, "fails" if of["fault"] else "ok"] for row, of in zip(cells, rows, strict=True)
        ]
    print_table("Plug-ins", [*columns, *(["contract"] if check else [])], cells)
    for row in rows:
        if row["fault"]:
            say(f"{row['name']}: {row['fault']}")
