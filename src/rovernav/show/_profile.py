"""A route from the side: elevation, slope, slip and energy along the way."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..plan import Going, Profile
from ._canvas import INK, footer, heading, picture
from ._words import BLUE, ORANGE, SKY, VERMILION

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def draw_profile(told: Profile, path: Path, *, ground: Going, title: str = "Profile") -> Path:
    """Draw the profile of a route, with the rover's limits.

    Args:
        told: From `plan.profile`.
        path: The PNG file.
        ground: What the route was planned on.
        title: Over the picture.

    Returns:
        `path`.
    """
    moving = ground.table is not None

    def draw(figure: Figure) -> None:
        panels = figure.subplots(4 if moving else 2, 1, sharex=True)
        along, unit = told.distance, "m"
        if along[-1] > 5000.0:
            along, unit = along / 1000.0, "km"
        _elevation(panels[0], along, told)
        _slopes(panels[1], along, told, ground)
        if moving:
            _slip(panels[2], along, told, ground)
            _energy(panels[3], along, told)
        panels[-1].set_xlabel(f"distance along the route [{unit}]")
        for axes in panels:
            axes.margins(x=0.0)
            axes.grid(alpha=0.3, lw=0.6)
        heading(figure, title)
        soil = f", on {ground.hazards.soil}" if ground.hazards.soil else ""
        footer(figure, f"{ground.rover.name}{soil}; slopes are those of planes over its footing.")
        figure.subplots_adjust(0.085, 0.085, 0.81, 0.93, hspace=0.16)

    return picture(path, (11.0, 8.6 if moving else 5.2), draw)


def _legend(axes: Axes) -> None:
    axes.legend(loc="center left", bbox_to_anchor=(1.005, 0.5), frameon=False, fontsize=8.5)


def _elevation(axes: Axes, along: Any, told: Profile) -> None:
    axes.plot(along, told.elevation, color=INK, lw=1.4)
    low = float(np.nanmin(told.elevation)) if np.isfinite(told.elevation).any() else 0.0
    axes.fill_between(along, low, told.elevation, color="#c9b79c", alpha=0.6, lw=0)
    axes.set_ylabel("elevation [m]")


def _slopes(axes: Axes, along: Any, told: Profile, ground: Going) -> None:
    limit = math.degrees(ground.rover.max_slope)
    axes.plot(along, np.degrees(told.slope), color=INK, lw=1.0, label="ground")
    axes.plot(along, np.degrees(told.pitch), color=BLUE, lw=1.2, label="pitch, nose up")
    axes.plot(along, np.degrees(told.roll), color=ORANGE, lw=1.0, label="roll, left up")
    top = max(float(np.nanmax(np.degrees(told.slope), initial=1.0)), 1.0)
    if limit <= 2.5 * top:
        axes.axhline(limit, color=VERMILION, lw=1.2, ls="--", label=f"limit {limit:g} deg")
    else:
        axes.plot([], [], " ", label=f"limit {limit:g} deg,\nbeyond the scale")
    axes.set_ylabel("slope [deg]")
    _legend(axes)


def _slip(axes: Axes, along: Any, told: Profile, ground: Going) -> None:
    axes.fill_between(
        along, 100 * told.slip_low, 100 * told.slip_high, color=SKY, alpha=0.45, lw=0,
        label="likely band",
    )  # fmt: skip
    axes.plot(along, 100 * told.slip, color=BLUE, lw=1.3, label="expected")
    mobility = ground.rover.mobility
    if mobility is not None:
        limit = 100 * mobility.max_slip
        axes.axhline(limit, color=VERMILION, lw=1.2, ls="--", label=f"limit {limit:g} %")
    unsure = np.where(told.measured, np.nan, 0.0)
    if np.isfinite(unsure).any():
        axes.plot(along, unsure, color=INK, lw=4, solid_capstyle="butt", label="not measured")
    axes.set_ylabel("slip [%]")
    axes.set_ylim(bottom=-1.0)
    _legend(axes)


def _energy(axes: Axes, along: Any, told: Profile) -> None:
    axes.plot(along, told.energy, color=BLUE, lw=1.3)
    axes.set_ylabel("energy [J per m]")
    axes.set_ylim(bottom=0.0)
