"""Ground judged for a rover: planes, steps, where it can stand, distance, slip, energy."""

from harness.model import Peer, Target, Workload

from . import ours, richdem_slope, scipy_filters, xarray_spatial

OURS = "rovernav, hazards"


def _forbidden(group: str, size: int) -> float | None:
    return {4096: 5191671.0, 512: 34362.0}.get(size) if group == "judged" else None


WORKLOAD = Workload(
    name="hazards",
    title=(
        "A 4096 x 4096 elevation model with 1 m posts judged for a rover of 3 m: plane fit over "
        "5 x 5 posts, roughness, steps, forbidden ground grown by the rover, distance to it, slip "
        "and energy uphill; one core."
    ),
    unit="s",
    peers=(
        Peer(name=OURS, build=ours.whole, group="judged"),
        Peer(name="rovernav, standing alone", build=ours.standing_alone, group="judged"),
        Peer(name="SciPy and NumPy, the same layers", build=scipy_filters.build, group="judged"),
        Peer(name="xarray-spatial, slope alone", build=xarray_spatial.build),
        Peer(name="RichDEM, slope alone", build=richdem_slope.build),
    ),
    targets=(Target(row=OURS, limit=1.5),),
    anchors={OURS: "rovernav"},
    size=4096,
    quick=512,
    scale=1.0,
    check="forbidden cells",
    expected=_forbidden,
    tolerance=1e-12,
    one_core=True,
    memory=True,
)
