"""Controllers measured side by side, with confidence intervals."""

from ..core import wilson
from ._pairs import Pairs, Score, carrying, draw_pairs, score

__all__ = ["Pairs", "Score", "carrying", "draw_pairs", "score", "wilson"]
