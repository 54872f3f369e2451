"""Controllers: they see observations alone, and answer with commands."""

from ._check import check_controller
from ._classical import GoalSeeker, SensedPlanner
from ._codecs import BassilCodec, build_codec
from ._guarded import Guarded
from ._headings import HeadingCodec
from ._neural import NeuralController
from ._replan import shy
from ._routed import Followed, RouteFollower
from ._why import Explains, Headings, Reading, ReadsOutputs, Why, explain

__all__ = [
    "BassilCodec",
    "Explains",
    "Followed",
    "GoalSeeker",
    "Guarded",
    "HeadingCodec",
    "Headings",
    "NeuralController",
    "Reading",
    "ReadsOutputs",
    "RouteFollower",
    "SensedPlanner",
    "Why",
    "build_codec",
    "check_controller",
    "explain",
    "shy",
]
