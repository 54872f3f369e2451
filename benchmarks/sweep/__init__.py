"""Thousands of independent online trainings at once."""

from harness.model import Peer, Target, Workload

from . import c_loops, jax_vmap, numpy_batched, ours, task, torch_batched

ONE, TWO = "rovernav, sweep, one thread", "rovernav, sweep, two threads"
COMPILED, FANN, JAX = "PyTorch, compiled", "FANN 2.2, one at a time", "JAX, vmap over a scan"

WORKLOAD = Workload(
    name="sweep",
    title=(
        f"{task.NETWORKS:,} networks 2-3-2 from as many seeds, sigmoid hidden, linear out, "
        f"float64, four patterns, rate {task.ETA}, momentum {task.MOMENTUM}, pattern by pattern, "
        "1,000 epochs."
    ),
    unit="ns per update of a network",
    peers=(
        Peer(name=ONE, build=ours.one_thread),
        Peer(name=TWO, build=ours.two_threads),
        Peer(name="C, eight networks side by side", build=c_loops.lanes),
        Peer(name="C, one at a time", build=c_loops.one_by_one),
        Peer(name=COMPILED, build=torch_batched.compiled),
        Peer(name="NumPy, batched", build=numpy_batched.build),
        Peer(name=FANN, build=c_loops.fann),
        Peer(name="PyTorch, eager, batched", build=torch_batched.eager),
        Peer(name=JAX, build=jax_vmap.build),
        Peer(name="PyTorch, torch.func.vmap", build=torch_batched.func_vmap),
    ),
    targets=(
        Target(row=ONE, limit=6.1),
        Target(row=ONE, against=FANN, limit=1 / 15),
        Target(row=ONE, against=JAX, limit=1 / 15),
        Target(row=ONE, against=COMPILED, limit=1 / 5),
        Target(row=TWO, against=ONE, limit=1 / 1.7),
    ),
    anchors={ONE: "one thread"},
    size=1000,
    quick=20,
    scale=1e9,
    check="RMSE of all networks",
    expected=task.expected,
    tolerance=1e-9,
)
