"""xarray-spatial's slope (Horn, 3 x 3): one of the eight layers."""

from __future__ import annotations

from harness.model import Trial

from . import task


def build(size: int) -> Trial:
    """`xrspatial.slope` on a NumPy-backed array."""
    import xarray
    from xrspatial import slope

    z = xarray.DataArray(task.heights(size), dims=("y", "x"), attrs={"res": (1.0, 1.0)})
    return task.calls(lambda: float(slope(z).data[1:-1, 1:-1].mean()))
