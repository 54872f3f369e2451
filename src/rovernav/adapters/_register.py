"""Telling Gymnasium of our environment."""

from __future__ import annotations

from ..core import MissingExtraError

NAME = "RovernavRover-v1"


def register_envs() -> None:
    """Register ``RovernavRover-v1``, alone and as a batch; once is enough.

    Where Gymnasium is imported before rovernav, as ``make("rovernav:RovernavRover-v1")`` does it,
    this happens by itself.

    Raises:
        MissingExtraError: The extra ``gym`` is not installed.
    """
    try:
        from gymnasium.envs.registration import register, registry
    except ImportError:
        raise MissingExtraError(
            "the environment needs the extra 'gym'; install it with: pip install 'rovernav[gym]'"
        ) from None
    if NAME not in registry:
        register(
            id=NAME,
            entry_point="rovernav.adapters._environment:RoverEnv",
            vector_entry_point="rovernav.adapters._environment:RoverVectorEnv",
        )
