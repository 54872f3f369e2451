"""Mini-batch back-propagation of a policy network on one core."""

from harness.model import Peer, Target, Workload

from . import jax_scan, keras_fit, numpy_batches, ours, sklearn_fit, torch_eager

OURS = "rovernav, train_batches"
EXPECTED = {3906: 0.00374383731, 400: 0.0246277806}
"""Error after an epoch of so many batches, from the same steps in float64."""


def _expected(_group: str, size: int) -> float | None:
    return EXPECTED.get(size)


WORKLOAD = Workload(
    name="minibatch",
    title=(
        "One epoch of 999,936 rows in order, 48-64-64-2, tanh hidden, linear out, half squared "
        "error, batch 256, rate 0.05, momentum 0.9, float32, one core."
    ),
    unit="thousand patterns per second",
    peers=(
        Peer(name=OURS, build=ours.epoch),
        Peer(name="rovernav, train_batches, whole call", build=ours.whole_call),
        Peer(name="NumPy, arrays made beforehand", build=numpy_batches.build),
        Peer(name="JAX, lax.scan over batches", build=jax_scan.build),
        Peer(name="PyTorch, eager, SGD", build=torch_eager.build),
        Peer(name="scikit-learn, partial_fit", build=sklearn_fit.build),
        Peer(name="Keras on JAX, fit", build=keras_fit.build),
    ),
    targets=(Target(row=OURS, limit=2070.0, at_least=True),),
    anchors={OURS: "rovernav"},
    size=3906,
    quick=400,
    scale=1e-3,
    rate=True,
    check="MSE after the epoch",
    expected=_expected,
    tolerance=1e-4,
    one_core=True,
)
