"""One decision: from what one rover senses to what its motors shall do, called from Python."""

from harness.model import Peer, Target, Workload

from . import numpy_call, onnx_call, ours, torch_call

ACT = "rovernav, NeuralController.act"


def _no_difference(_group: str, _size: int) -> float:
    return 0.0


WORKLOAD = Workload(
    name="decision",
    title=(
        "One decision of the paper's 2-3-2 network, called from Python for one rover; the "
        "controller also encodes the observation and decodes the command, the peers run the bare "
        "network."
    ),
    unit="us per call",
    peers=(
        Peer(name=ACT, build=ours.act),
        Peer(name="rovernav, Network.forward", build=ours.forward),
        Peer(name="NumPy", build=numpy_call.build),
        Peer(name="ONNX Runtime", build=onnx_call.build),
        Peer(name="PyTorch, inference mode", build=torch_call.build),
    ),
    targets=(Target(row=ACT, limit=20.0),),
    anchors={ACT: "act"},
    size=200,
    quick=200,
    scale=1e6,
    check="largest difference",
    expected=_no_difference,
    tolerance=1e-12,
)
