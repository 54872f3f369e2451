"""Training: pattern tables, online and mini-batch back-propagation, checkpoints, traces."""

from ._checkpoint import checkpointer, load_training, save_training
from ._describe import describe
from ._drivers import find_controller
from ._online import (
    ORDERS,
    RULES,
    OnlineSettings,
    Recorder,
    Training,
    advance,
    check_fit,
    progress,
    train,
)
from ._paper import (
    W1,
    W2,
    WorkedExample,
    literal_pass,
    paper_network,
    paper_training,
    trained_paper_network,
    worked_example,
)
from ._patterns import Patterns, read_patterns, shipped_patterns, shipped_tables, write_patterns
from ._progress import Listener, Progress, StopReason
from ._trace import trace_csv, trace_text, weight_names

__all__ = [
    "ORDERS",
    "RULES",
    "W1",
    "W2",
    "Listener",
    "OnlineSettings",
    "Patterns",
    "Progress",
    "Recorder",
    "StopReason",
    "Training",
    "WorkedExample",
    "advance",
    "check_fit",
    "checkpointer",
    "describe",
    "find_controller",
    "literal_pass",
    "load_training",
    "paper_network",
    "paper_training",
    "progress",
    "read_patterns",
    "save_training",
    "shipped_patterns",
    "shipped_tables",
    "trace_csv",
    "trace_text",
    "train",
    "trained_paper_network",
    "weight_names",
    "worked_example",
    "write_patterns",
]
