"""What was sensed, kept: the local map."""

from ._local import LocalMap, LocalMapper, bearing

__all__ = ["LocalMap", "LocalMapper", "bearing"]
