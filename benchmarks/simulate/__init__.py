"""Thousands of rovers at once, with 64 range beams each, among obstacles on a grid."""

from harness.model import Peer, Target, Workload

from . import ours, peers, task

OURS, TWO = "rovernav, one thread", "rovernav, two threads"
GROUP = "one grid"


MEAN = {4096: 26.718932188, 256: 26.336278168}
"""Mean reading of the first fans [cells], from the C walk."""


def _expected(group: str, size: int) -> float | None:
    return MEAN.get(size) if group == GROUP else None


WORKLOAD = Workload(
    name="simulate",
    title=(
        f"{task.ROVERS:,} rovers with {task.BEAMS} beams of {task.REACH:g} cells on a "
        f"{task.SIDE} x {task.SIDE} grid of {task.DISCS:,} discs: sense, decide, move, collide."
    ),
    unit="thousand rover-steps per second",
    peers=(
        Peer(name=OURS, build=ours.ONE, group=GROUP),
        Peer(name=TWO, build=ours.TWO, group=GROUP),
        Peer(name="rovernav, 64 grids, one thread", build=ours.MANY, group="64 grids"),
        Peer(name="C, plain walk", build=peers.c_walk, group=GROUP),
        Peer(name="navground", build=peers.navground, group="discs"),
        Peer(name="MuJoCo, beams alone", build=peers.mujoco, group="height field"),
        Peer(name="ir-sim", build=peers.ir_sim, group="discs"),
    ),
    targets=(
        Target(row=OURS, limit=400.0, at_least=True),
        Target(row=TWO, against=OURS, limit=1 / 1.8),
    ),
    anchors={OURS: "rovernav"},
    size=task.ROVERS,
    quick=256,
    scale=1e-3,
    rate=True,
    check="mean reading",
    expected=_expected,
    tolerance=1e-6,
)
