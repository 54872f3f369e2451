"""The network as a driver, and the paper's codec."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from rovernav.control import BassilCodec, NeuralController, build_codec
from rovernav.core import Codec, Command, Controller, Observation, SettingError, ShapeError
from rovernav.learn import trained_paper_network
from rovernav.nets import Card, Network
from tests.bits import assert_same_bits
from tests.control import observations

CODEC = {"name": "bassil", "step": 0.8287, "period": 1.0, "stop_at_goal": True}


def network(codec: Any, topology: tuple[int, ...] = (2, 3, 2), dtype: Any = np.float64) -> Network:
    rng = np.random.default_rng(0)
    activations = ("sigmoid",) * (len(topology) - 2) + ("linear",)
    return Network.seeded(topology, activations, rng, dtype=dtype).with_card(Card(codec=codec))


def by_hand(net: Network, seen: Observation, codec: BassilCodec) -> np.ndarray:
    """Twists written with NumPy alone."""
    sight, off_line = seen.channel("clear_sight")[:, 0], seen.channel("off_line")[:, 0]
    move = codec.step * net.forward(np.stack([sight, off_line], axis=1)).astype(float)
    near = (seen.goal**2).sum(1) <= (move**2).sum(1)
    cut = codec.stop_at_goal & near & (sight == 1)
    move = np.where(cut[:, None], seen.goal, move)
    return np.concatenate([move / codec.period, np.zeros((len(move), 1))], axis=1)


def act(driver: NeuralController, seen: Observation) -> np.ndarray:
    command, memory = driver.act(seen, None)
    assert memory is None
    return command.twist


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("stop", [True, False])
def test_commands_are_the_networks_outputs_in_metres_per_second(stop: bool, dtype: Any) -> None:
    codec = BassilCodec(step=0.6, period=0.5, stop_at_goal=stop)
    driver = NeuralController(network(codec.settings(), dtype=dtype))
    seen = observations.bassil(500, np.random.default_rng(1))
    assert_same_bits(act(driver, seen), by_hand(driver.network, seen, codec))


def test_the_trained_network_answers_the_four_patterns() -> None:
    driver = NeuralController(trained_paper_network())
    wanted = {(0, 0): (1, 1), (0, 1): (1, 1), (1, 1): (1, -1), (1, 0): (1, 0)}
    for (sight, off_line), motors in wanted.items():
        twist = act(driver, observations.one(sight, off_line))[0]
        assert_allclose(twist[:2] / 0.8287, motors, rtol=0, atol=0.01)
        assert twist[2] == 0.0


@pytest.mark.parametrize(
    ("sight", "goal", "stops"),
    [(1.0, (0.5, 0.1), True), (0.0, (0.5, 0.1), False), (1.0, (0.9, 0.1), False)],
)
def test_a_step_ends_at_a_goal_in_sight(sight: float, goal: Any, stops: bool) -> None:
    twist = act(NeuralController(trained_paper_network()), observations.one(sight, 0.0, goal))
    assert (twist[0, :2].tolist() == list(goal)) == stops


def test_a_network_without_a_codec_cannot_drive() -> None:
    with pytest.raises(SettingError) as refused:
        NeuralController(network(None))
    assert str(refused.value) == (
        "this network names no codec, so nothing says what its outputs mean to motors; "
        "drive with a network trained for driving"
    )


@pytest.mark.parametrize(
    ("codec", "message"),
    [
        ({"name": "basil"}, "unknown codec 'basil'; did you mean 'bassil'? Allowed: "),
        ({}, "unknown codec None; Allowed: bassil"),
        ({"name": ["bassil"]}, "unknown codec ['bassil']; "),
        (
            {**CODEC, "stepp": 1},
            "codec bassil: unknown parameter 'stepp'; did you mean 'step'? "
            "Allowed: period, step, stop_at_goal.",
        ),
        ({**CODEC, "step": 0}, "codec bassil: step must be above 0, got 0"),
        ({**CODEC, "step": "1"}, "codec bassil: step must be above 0, got '1'"),
        ({**CODEC, "period": float("nan")}, "codec bassil: period must be above 0, got nan"),
        ({**CODEC, "period": None}, "codec bassil: period must be above 0, got None"),
        (
            {**CODEC, "stop_at_goal": "no"},
            "codec bassil: stop_at_goal must be true or false, got 'no'",
        ),
    ],
)
def test_a_codec_that_cannot_be_built_is_explained(codec: Any, message: str) -> None:
    for build in (build_codec, lambda codec: NeuralController(network(codec))):
        with pytest.raises(SettingError) as refused:
            build(codec)
        assert str(refused.value).startswith(message)


@pytest.mark.parametrize("topology", [(3, 3, 2), (2, 3, 3), (1, 2)])
def test_a_network_that_does_not_fit_its_codec_is_refused(topology: tuple[int, ...]) -> None:
    with pytest.raises(SettingError) as refused:
        NeuralController(network(CODEC, topology))
    assert str(refused.value) == (
        "codec bassil needs a network with 2 inputs and 2 outputs, got "
        + "-".join(map(str, topology))
    )


def test_a_missing_channel_is_named() -> None:
    driver = NeuralController(network(CODEC))
    seen = observations.one(1.0, 0.0)
    for channels, have in ((["clear_sight"], "clear_sight"), ([], "none")):
        fewer = {name: seen.channel(name) for name in channels}
        with pytest.raises(ShapeError) as missing:
            driver.act(dataclasses.replace(seen, channels=fewer), None)
        wanted = "off_line" if channels else "clear_sight"
        assert str(missing.value) == (
            f"the controller needs the sensor {wanted!r}, which this rover does not carry; "
            f"it carries: {have}"
        )


def test_a_codec_gives_itself_back_from_its_settings() -> None:
    codec = BassilCodec(step=0.5, period=2.0, stop_at_goal=False)
    again = build_codec(codec.settings())
    assert again.settings() == codec.settings()
    assert build_codec(CODEC).settings() == CODEC
    assert isinstance(again, Codec)
    assert isinstance(NeuralController(network(CODEC)), Controller)


def test_no_rovers_get_no_commands() -> None:
    seen = observations.bassil(0, np.random.default_rng(0))
    command: Command = NeuralController(network(CODEC)).act(seen, None)[0]
    assert command.twist.shape == (0, 3)
    assert_array_equal(BassilCodec().encode(seen), np.empty((0, 2)))
