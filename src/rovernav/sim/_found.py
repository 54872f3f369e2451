"""Sensors and metrics by name: ours, and those of installed distributions."""

from __future__ import annotations

from collections.abc import Callable

from ..core import Metric, PluginError, Sensor, make_plugin, plugins
from ._measures import Closest, Detour, Energy, Length

_METRICS: dict[str, Callable[[], Metric]] = {
    "closest": Closest,
    "detour": Detour,
    "energy": Energy,
    "length": Length,
}


def metric_names() -> list[str]:
    """Names of all metrics, those of installed distributions too."""
    return sorted({*_METRICS, *(one.name for one in plugins("metric"))})


def find_metric(name: str) -> Metric:
    """The metric of that name: ``closest``, ``detour``, ``energy``, ``length`` or an installed one.

    Raises:
        PluginError: There is none, or it cannot be used.
    """
    if name in _METRICS:
        return _METRICS[name]()
    made = make_plugin("metric", name, also=_METRICS)
    if not isinstance(made, Metric):
        raise PluginError(f"the metric {name!r} is none: it needs a name, a unit and compute")
    return made


def find_sensor(name: str) -> Sensor:
    """The sensor of that name that an installed distribution offers.

    Raises:
        PluginError: There is none, or it cannot be used.
    """
    made = make_plugin("sensor", name)
    if not isinstance(made, Sensor):
        raise PluginError(f"the sensor {name!r} is none: it needs a name, start and read")
    return made
