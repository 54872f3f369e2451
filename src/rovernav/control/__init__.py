"""Controllers: they see observations alone, and answer with commands."""

from ._check import check_controller
from ._classical import GoalSeeker, SensedPlanner
from ._codecs import BassilCodec, build_codec
from ._headings import HeadingCodec
from ._neural import NeuralController

__all__ = [
    "BassilCodec",
    "GoalSeeker",
    "HeadingCodec",
    "NeuralController",
    "SensedPlanner",
    "build_codec",
    "check_controller",
]
