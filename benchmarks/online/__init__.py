"""Online back-propagation of the 2-3-2 network: one pattern, one update."""

from harness.model import Peer, Target, Workload

from . import c_loops, jax_scan, numpy_loop, ours, sklearn_steps, task, torch_eager

GENERIC, FROZEN = "rovernav, generic kernel", "rovernav, frozen kernel"
C = "C, generic loops"

WORKLOAD = Workload(
    name="online",
    title=(
        "Online back-propagation, 2-3-2, sigmoid hidden, linear out, float64, four patterns, "
        "rate 0.25, momentum 0.9, 1,000 epochs from the same weights, over and over."
    ),
    unit="ns per pattern",
    peers=(
        Peer(name=GENERIC, build=ours.generic, group="textbook"),
        Peer(name=FROZEN, build=ours.frozen, group="textbook"),
        Peer(
            name="rovernav, generic kernel, paper's rule", build=ours.generic_paper, group="paper"
        ),
        Peer(name="rovernav, frozen kernel, paper's rule", build=ours.frozen_paper, group="paper"),
        Peer(name=C, build=c_loops.generic, group="textbook"),
        Peer(name="C, generic loops, paper's rule", build=c_loops.generic_paper, group="paper"),
        Peer(name="C, sizes frozen", build=c_loops.frozen, group="textbook"),
        Peer(name="FANN 2.2, from C", build=c_loops.fann, group="textbook"),
        Peer(name="JAX, lax.scan", build=jax_scan.plain, group="textbook"),
        Peer(name="JAX, lax.scan, unroll 16", build=jax_scan.unrolled, group="textbook"),
        Peer(name="NumPy, a pattern at a time", build=numpy_loop.build, group="textbook"),
        Peer(name="PyTorch, eager, SGD", build=torch_eager.build, group="textbook"),
        Peer(name="scikit-learn, partial_fit", build=sklearn_steps.build, group="textbook"),
    ),
    targets=(
        Target(row=GENERIC, against=C, limit=0.65),
        Target(row=FROZEN, against=C, limit=0.65),
        Target(
            row="rovernav, generic kernel, paper's rule",
            against="C, generic loops, paper's rule",
            limit=0.65,
        ),
        Target(
            row="rovernav, frozen kernel, paper's rule",
            against="C, generic loops, paper's rule",
            limit=0.65,
        ),
    ),
    anchors={GENERIC: "generic", FROZEN: "frozen"},
    size=1000,
    quick=1000,
    scale=1e9,
    check="final RMSE",
    expected=task.expected,
    tolerance=1e-9,
)
