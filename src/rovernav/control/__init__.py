"""Controllers: they see observations alone, and answer with commands."""

from ._codecs import BassilCodec, build_codec
from ._neural import NeuralController

__all__ = ["BassilCodec", "NeuralController", "build_codec"]
