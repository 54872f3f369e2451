"""RichDEM's slope (Horn, 3 x 3): one of the eight layers."""

from __future__ import annotations

from harness.model import Trial

from . import task


def build(size: int) -> Trial:
    """`TerrainAttribute` with slope in degrees."""
    import richdem

    z = richdem.rdarray(task.heights(size), no_data=-9999.0)
    z.geotransform = [0.0, 1.0, 0.0, 0.0, 0.0, -1.0]
    return task.calls(
        lambda: float(richdem.TerrainAttribute(z, attrib="slope_degrees")[1:-1].mean())
    )
