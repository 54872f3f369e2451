"""Names of plug-ins and metrics on the command line."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..core import Metric
    from ..scenes import Ground, Scene
    from ..sim import Trace


def names_in(text: str | None) -> list[str] | None:
    """Names joined by commas; None where nothing was given.

    Raises:
        SettingError: No name, or one twice.
    """
    from ..core import SettingError

    if text is None:
        return None
    names = [name.strip() for name in text.split(",") if name.strip()]
    if not names or len(set(names)) < len(names):
        raise SettingError(f"give one or more names, each once, joined by commas, got {text!r}")
    return names


def measures_of(names: Sequence[str]) -> list[Metric]:
    """The metrics of these names.

    Raises:
        PluginError: There is none of that name, or it cannot be used.
    """
    from ..sim import find_metric

    return [find_metric(name) for name in names]


def measured(metrics: Sequence[Metric], trace: Trace, scene: Scene | Ground) -> dict[str, Any]:
    """What each metric says of the first rover: its value, or None, and the unit."""
    from ..scenes import Ground

    worlds = scene.scene.worlds if isinstance(scene, Ground) else scene.worlds
    found: dict[str, Any] = {}
    for metric in metrics:
        values, valid = metric.compute(trace, worlds)
        found[metric.name] = (float(values[0]) if valid[0] else None, metric.unit)
    return found
