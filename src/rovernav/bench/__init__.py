"""Controllers measured side by side, with confidence intervals."""

from ._pairs import Pairs, Score, draw_pairs, score, wilson

__all__ = ["Pairs", "Score", "draw_pairs", "score", "wilson"]
