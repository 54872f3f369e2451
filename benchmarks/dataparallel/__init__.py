"""Mini-batch back-propagation by one thread and by two, in small batches and in large ones."""

import functools

from harness.model import Peer, Target, Workload
from minibatch import ours, task, torch_eager

SIZES = (task.BATCH, 4096)
EXPECTED = {
    ("256", 3906): 0.00374383731,
    ("256", 400): 0.0246277806,
    ("4096", 3906): 0.02395113,
    ("4096", 400): 0.0423552043,
}
"""Error after the epoch, from the same steps in float64."""


def _name(who: str, batch: int, threads: int) -> str:
    return f"{who}, batches of {batch:,}, {'one thread' if threads == 1 else 'two threads'}"


def _peers(batch: int) -> tuple[Peer, ...]:
    group = str(batch)
    return (
        *(
            Peer(
                name=_name("rovernav", batch, threads),
                build=functools.partial(ours.epoch, batch=batch, shards=2, workers=threads),
                group=group,
            )
            for threads in (1, 2)
        ),
        *(
            Peer(
                name=_name("PyTorch", batch, threads),
                build=functools.partial(torch_eager.build, batch=batch, threads=threads),
                group=group,
            )
            for threads in (1, 2)
        ),
    )


def _targets(batch: int) -> tuple[Target, ...]:
    one, two = (_name("rovernav", batch, threads) for threads in (1, 2))
    return (
        Target(row=one, against=_name("PyTorch", batch, 1), limit=1.0),
        Target(row=two, against=_name("PyTorch", batch, 2), limit=1.0),
        Target(row=two, against=one, limit=1 / 1.7),
    )


def _expected(group: str, size: int) -> float | None:
    return EXPECTED.get((group, size))


WORKLOAD = Workload(
    name="dataparallel",
    title=(
        "One epoch of 999,936 rows in order, 48-64-64-2, tanh hidden, linear out, half squared "
        "error, batches of 256 and of 4,096 rows, rate 0.05, momentum 0.9, float32; rovernav in "
        "two shards."
    ),
    unit="thousand patterns per second",
    peers=tuple(peer for batch in SIZES for peer in _peers(batch)),
    targets=tuple(target for batch in SIZES for target in _targets(batch)),
    anchors={_name("rovernav", batch, 2): f"two threads, {batch:,}" for batch in SIZES},
    size=3906,
    quick=400,
    scale=1e-3,
    rate=True,
    check="MSE after the epoch",
    expected=_expected,
    tolerance=1e-4,
)
