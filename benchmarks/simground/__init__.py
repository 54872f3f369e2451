"""Thousands of rovers with bodies at once, with 64 range beams each over the ground."""

from harness.model import Peer, Target, Workload

from . import ours, peers, task

FOUR, FOUR_TWO = "rovernav, four wheels, one thread", "rovernav, four wheels, two threads"
SIX, SIX_TWO = "rovernav, six wheels, one thread", "rovernav, six wheels, two threads"


def _expected(_group: str, _size: int) -> float | None:
    return None


WORKLOAD = Workload(
    name="simground",
    title=(
        f"{task.ROVERS:,} rovers with bodies on {task.SIDE} x {task.SIDE} posts of relief "
        f"({task.SLOPE:g} deg) and rocks ({100 * task.ROCKS:g} %): {task.BEAMS} beams of "
        f"{task.REACH} cells over the ground, decide, slip, settle, end."
    ),
    unit="thousand rover-steps per second",
    peers=(
        Peer(name=FOUR, build=ours.FOUR, group="four"),
        Peer(name=FOUR_TWO, build=ours.FOUR_TWO, group="four"),
        Peer(name=SIX, build=ours.SIX, group="six"),
        Peer(name=SIX_TWO, build=ours.SIX_TWO, group="six"),
        Peer(name="rovernav, four wheels, no beams", build=ours.FOUR_BLIND),
        Peer(name="rovernav, six wheels, no beams", build=ours.SIX_BLIND),
        Peer(name="rovernav, beams alone", build=ours.LOOKING, group="four"),
        Peer(name="rovernav, beams alone, plain walk", build=ours.WALKING, group="four"),
        Peer(name="C, plain walk, beams alone", build=peers.c_march, group="four"),
        Peer(name="MuJoCo, beams alone", build=peers.mujoco),
        Peer(name="MuJoCo, body alone", build=peers.mujoco_body),
    ),
    targets=(
        Target(row=FOUR, limit=150.0, at_least=True),
        Target(row=SIX, limit=150.0, at_least=True),
        Target(row=FOUR_TWO, against=FOUR, limit=1 / 1.8),
    ),
    anchors={FOUR: "rovernav"},
    size=task.ROVERS,
    quick=256,
    scale=1e-3,
    rate=True,
    check="mean reading",
    expected=_expected,
    tolerance=1e-6,
)
