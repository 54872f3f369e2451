"""ONNX Runtime on the same network, in double precision and one thread."""

from __future__ import annotations

from typing import Any

from harness.model import Trial

from . import task


def build(size: int) -> Trial:
    """`InferenceSession.run` on one row."""
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    session = onnxruntime.InferenceSession(
        _model().SerializeToString(), options, providers=["CPUExecutionProvider"]
    )
    feed = {"x": task.X[None]}
    return task.calls(size, lambda: session.run(None, feed), lambda answer: answer[0])


def _model() -> Any:
    """Two Gemm nodes with a Sigmoid between them."""
    from onnx import TensorProto, helper, numpy_helper

    node, info = helper.make_node, helper.make_tensor_value_info
    names = ("w1", "b1", "w2", "b2")
    graph = helper.make_graph(
        [
            node("Gemm", ["x", "w1", "b1"], ["s"], transB=1),
            node("Sigmoid", ["s"], ["h"]),
            node("Gemm", ["h", "w2", "b2"], ["y"], transB=1),
        ],
        "decision",
        [info("x", TensorProto.DOUBLE, [1, 2])],
        [info("y", TensorProto.DOUBLE, [1, 2])],
        [numpy_helper.from_array(a, n) for a, n in zip(task.parts(), names, strict=True)],
    )
    return helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
