"""Training: pattern tables, online and mini-batch back-propagation, checkpoints, traces."""

from ._batch_settings import OPTIMIZERS, SCHEDULES, BatchSettings
from ._checkpoint import checkpointer, load_training, save_training
from ._describe import describe, seeded_network
from ._drivers import controller_names, find_controller, rover_of, usual_rover
from ._imitate import Lesson, fresh_network, mirrored, teach
from ._minibatch import BatchTraining, advance_batches, train_batches
from ._online import (
    ORDERS,
    RULES,
    OnlineSettings,
    Recorder,
    Training,
    advance,
    check_fit,
    progress,
    step_patterns,
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
from ._patterns import (
    Patterns,
    parse_number,
    parse_patterns,
    patterns_csv,
    read_patterns,
    shipped_patterns,
    shipped_tables,
    write_patterns,
)
from ._progress import Listener, Progress, StopReason
from ._recipe import Recipe, read_recipe, recipes
from ._routes import PLANNED, guarded, routed
from ._sweep import SweepListener, SweepProgress, SweepResult, sweep
from ._sweep_block import train_members
from ._sweep_scores import MemberScore, SettingScore
from ._sweep_settings import SweepSettings
from ._sweep_store import SweepStore
from ._sweep_tables import write_members_csv, write_settings_csv
from ._trace import trace_csv, trace_length, trace_text, weight_names
from ._worked import PRINTED, WorkedRow, WorkedStep, worked_steps

__all__ = [
    "OPTIMIZERS",
    "ORDERS",
    "PLANNED",
    "PRINTED",
    "RULES",
    "SCHEDULES",
    "W1",
    "W2",
    "BatchSettings",
    "BatchTraining",
    "Lesson",
    "Listener",
    "MemberScore",
    "OnlineSettings",
    "Patterns",
    "Progress",
    "Recipe",
    "Recorder",
    "SettingScore",
    "StopReason",
    "SweepListener",
    "SweepProgress",
    "SweepResult",
    "SweepSettings",
    "SweepStore",
    "Training",
    "WorkedExample",
    "WorkedRow",
    "WorkedStep",
    "advance",
    "advance_batches",
    "check_fit",
    "checkpointer",
    "controller_names",
    "describe",
    "find_controller",
    "fresh_network",
    "guarded",
    "literal_pass",
    "load_training",
    "mirrored",
    "paper_network",
    "paper_training",
    "parse_number",
    "parse_patterns",
    "patterns_csv",
    "progress",
    "read_patterns",
    "read_recipe",
    "recipes",
    "routed",
    "rover_of",
    "save_training",
    "seeded_network",
    "shipped_patterns",
    "shipped_tables",
    "step_patterns",
    "sweep",
    "teach",
    "trace_csv",
    "trace_length",
    "trace_text",
    "train",
    "train_batches",
    "train_members",
    "trained_paper_network",
    "usual_rover",
    "weight_names",
    "worked_example",
    "worked_steps",
    "write_members_csv",
    "write_patterns",
    "write_settings_csv",
]
