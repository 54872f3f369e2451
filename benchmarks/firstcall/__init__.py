"""The wait before anything is trained: a fresh process, up to its first epoch of the 2-3-2."""

from harness.model import Peer, Target, Workload
from online import jax_scan, numpy_loop, ours, sklearn_steps, task, torch_eager

WARM, EMPTY = "rovernav, kernels cached", "rovernav, empty cache"

WORKLOAD = Workload(
    name="firstcall",
    title="From the start of a fresh Python process to the first trained epoch of the 2-3-2.",
    unit="s",
    peers=(
        Peer(name=WARM, build=ours.generic_paper, group="paper", cache="warm"),
        Peer(name=EMPTY, build=ours.generic_paper, group="paper", cache="empty"),
        Peer(name="NumPy", build=numpy_loop.build, group="textbook"),
        Peer(name="scikit-learn", build=sklearn_steps.build, group="textbook"),
        Peer(name="PyTorch", build=torch_eager.build, group="textbook"),
        Peer(name="JAX", build=jax_scan.plain, group="textbook"),
    ),
    targets=(Target(row=WARM, limit=2.0),),
    anchors={WARM: "cached"},
    size=1,
    quick=1,
    scale=1.0,
    check="RMSE after it",
    expected=task.expected,
    tolerance=1e-9,
    fresh=True,
)
