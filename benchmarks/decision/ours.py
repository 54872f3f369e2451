"""rovernav: the whole controller, and the network alone."""

from __future__ import annotations

from typing import Any

import numpy as np
from harness.model import Trial

from . import task


def act(size: int) -> Trial:
    """`NeuralController.act`: channels in, body twist out, for a goal that is far away."""
    from rovernav.control import NeuralController
    from rovernav.core import Observation
    from rovernav.learn import paper_network

    controller: Any = NeuralController(paper_network())
    observation = Observation(
        goal=np.array([[100.0, 0.0]]),
        twist=np.zeros((1, 3)),
        channels={"clear_sight": task.X[None, :1], "off_line": task.X[None, 1:]},
    )
    metres_per_second = controller.codec.step / controller.codec.period
    return task.calls(
        size,
        lambda: controller.act(observation, None),
        lambda answer: answer[0].twist[0, :2] / metres_per_second,
    )


def forward(size: int) -> Trial:
    """`Network.forward` on one row."""
    from rovernav.learn import paper_network

    network, row = paper_network(), task.X[None]
    return task.calls(size, lambda: network.forward(row), lambda answer: answer)
