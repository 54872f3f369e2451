"""One rover alone: what every step costs beside the work."""

import math

from harness.model import Peer, Target, Workload
from simulate import ours

OURS = "rovernav, one rover"

WORKLOAD = Workload(
    name="onerover",
    title=(
        "One rover at 1 m/s and 5 Hz with 64 beams on open ground, 5,000 steps or 1 km, its whole "
        "trace kept."
    ),
    unit="s",
    peers=(Peer(name=OURS, build=ours.lone),),
    targets=(Target(row=OURS, limit=0.75),),
    anchors={OURS: "rovernav"},
    size=5000,
    quick=500,
    scale=1.0,
    check="way driven",
    expected=lambda _group, size: 0.2 * size * math.sin(0.05) / 0.05,  # chords of its arcs
    tolerance=1e-6,
)
