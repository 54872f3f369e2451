"""Noise: the same bits as in plain Python, and the shares and spreads that it claims."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from rovernav.core import Frame, Mission, RoverState, Sensor, SettingError
from rovernav.kernels import noise as kernels
from rovernav.sim import (
    CURVES,
    Grid,
    InfraRed,
    NoisyFan,
    RangeFan,
    RangeNoise,
    Tilt,
    Worlds,
    check_sensor,
    ranger,
)
from tests.naive import noise as naive
from tests.sim.test_sensors import place

ROUGH = RangeNoise(
    core=0.02, relative=0.01, stray=0.05, spread=0.8, back=0.5, lose=0.06, find=0.3, least=0.2,
    grain=0.001,
)  # fmt: skip


def rovers(seed: int, numbers: list[int]) -> np.ndarray:
    out = np.empty(len(numbers), np.uint64)
    kernels.keys(seed, np.array(numbers, np.int64), out)
    return out


def spoil(
    true: np.ndarray, seed: int, noise: RangeNoise, steps: int, reach: float = 5.0
) -> np.ndarray:
    """Readings (steps, n, b) of rovers that stand still."""
    who = rovers(seed, list(range(len(true))))
    before, out = np.zeros(true.shape, np.int64), np.empty((steps, *true.shape))
    for step in range(steps):
        now = np.empty_like(before)
        kernels.spoil(true, who, step + 1, before, reach, noise.numbers(), now, out[step])
        before = now
    return out


@pytest.mark.kernels
def test_keys_and_draws_are_those_of_plain_python() -> None:
    with np.errstate(over="ignore"):  # whole numbers that wrap around, without the compiler
        for seed, number in ((0, 0), (1, 7), (2**63 - 1, 2**62), (5, -3)):
            key = rovers(seed, [number])[0]
            assert int(key) == naive.key_of(seed, number)
            for i, j in ((0, 0), (9, 4), (2**40, 1023)):
                assert kernels.share(key, i, j) == naive.share(int(key), i, j)


@pytest.mark.kernels
def test_ranges_are_spoilt_as_in_plain_python(rng: np.random.Generator) -> None:
    true = rng.uniform(0.1, 6.0, (3, 5)).clip(max=5.0)
    with np.errstate(over="ignore"):
        read = spoil(true, 11, ROUGH, 12)
    p = dataclasses.asdict(ROUGH)
    for k in range(3):
        before = [0] * 5
        for step in range(12):
            key = naive.key_of(11, k)
            before, expected = naive.spoilt(true[k].tolist(), key, step + 1, before, 5.0, p)
            assert_allclose(read[step, k], expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    "sensor",
    [
        NoisyFan(RangeFan(reach=4.0, beams=9), ROUGH),
        NoisyFan(RangeFan(reach=4.0, beams=9), ROUGH, cone=3),
        InfraRed("GP2D120", beams=3),
        Tilt(),
        *(ranger(name) for name in ("lidar", "sonar", "sonar-ring", "infrared-far")),
    ],
    ids=lambda s: type(s).__name__,
)
def test_noisy_sensors_keep_their_contract(sensor: Sensor) -> None:
    check_sensor(sensor, place, rovers=3, steps=3)


def test_the_core_has_its_spread_and_heavy_tails() -> None:
    noise = RangeNoise(core=0.02, relative=0.01)
    error = spoil(np.full((40, 50), 3.0), 1, noise, 50) - 3.0
    assert abs(error.mean()) < 5e-4
    assert error.std() == pytest.approx(0.05, rel=0.02)
    kurtosis = float((error**4).mean() / error.var() ** 2)
    assert 5.0 < kurtosis < 10.0  # 3 for a Gaussian; (2.7)^2 for a product of our deviates


def test_echoes_are_lost_in_bursts_of_the_length_asked_for() -> None:
    noise = RangeNoise(lose=0.02, find=0.25)
    lost = spoil(np.full((40, 50), 2.0), 2, noise, 200)[50:] == 5.0
    begins = (lost[1:] & ~lost[:-1]).sum() / (~lost[:-1]).sum()
    ends = (~lost[1:] & lost[:-1]).sum() / lost[:-1].sum()
    assert begins == pytest.approx(0.04, rel=0.05)
    assert ends == pytest.approx(0.25, rel=0.05)
    assert lost.mean() == pytest.approx(0.04 / 0.29, rel=0.05)


def test_strays_hold_their_error_until_they_are_back() -> None:
    read = spoil(np.full((40, 50), 2.5), 3, RangeNoise(stray=0.02, spread=0.5, back=0.4), 120)
    off = read != 2.5
    held = off[1:] & off[:-1]
    assert (read[1:] == read[:-1])[held].mean() > 0.9  # the others have come back and gone again
    assert off[40:].mean() == pytest.approx(0.05 / 0.45, rel=0.06)
    assert (read - 2.5)[off].std() == pytest.approx(0.5, rel=0.05)


def test_without_noise_a_noisy_fan_is_the_fan_and_never_beyond_its_reach() -> None:
    worlds, mission, state = place(6, np.random.default_rng(4))
    fan = RangeFan(reach=4.0, beams=9)
    true = fan.read(worlds, state, None)[0]
    for noise, same in ((RangeNoise(), True), (ROUGH, False)):
        sensor = NoisyFan(fan, noise)
        memory = sensor.start(mission, np.random.default_rng(0))
        for _ in range(5):
            read, memory = sensor.read(worlds, state, memory)
            assert (read <= 4.0).all()
            assert (read >= noise.least).all()
            assert np.array_equal(read, true) == same


def test_a_cone_reads_its_nearest_beam() -> None:
    worlds, mission, state = place(6, np.random.default_rng(4))
    fan = RangeFan(reach=4.0, beams=9)
    sensor = NoisyFan(fan, RangeNoise(), cone=3)
    read, _ = sensor.read(worlds, state, sensor.start(mission, np.random.default_rng(0)))
    true = fan.read(worlds, state, None)[0]
    assert_array_equal(read, true.reshape(6, 3, 3).min(axis=2))
    assert_allclose(sensor.angles, fan.angles[1::3], atol=1e-12)


def before_a_wall(distance: float, n: int) -> tuple[Worlds, Mission, RoverState]:
    grid = Grid(frame=Frame(cell=1.0, shape=(3, 8)), blocked=np.zeros((3, 8), np.uint8))
    worlds = Worlds.single([(5.0, 0.0, 8.0, 3.0)], grid=grid, rovers=n)
    start = np.tile([5.0 - distance, 1.5, 0.0], (n, 1))
    mission = Mission(start=start, goal=start[:, :2], goal_radius=0.0, time_limit=1.0)
    return worlds, mission, RoverState.at_start(mission)


@pytest.mark.parametrize("name", sorted(CURVES))
def test_infra_red_reads_what_its_table_says(name: str) -> None:
    curve = CURVES[name]
    sensor = InfraRed(name, beams=3, view=0.01)
    for distance, volts in curve.rows[1:]:
        worlds, mission, state = before_a_wall(float(distance), 400)
        read, _ = sensor.read(worlds, state, sensor.start(mission, np.random.default_rng(1)))
        a, b, c = curve.fit
        fitted = float(np.clip(a * volts**b + c, curve.nearest, curve.reach))
        step = abs(a * b * volts ** (b - 1)) * (curve.volt / 1023)  # of one count
        slope = abs(a * b * volts**b) * curve.noise
        assert abs(np.median(read[:, 1]) - fitted) < step + 0.3 * slope + 1e-6
        if curve.nearest < fitted < 0.8 * curve.reach:
            assert read[:, 1].std() == pytest.approx(math.hypot(slope, 0.3 * step), rel=0.35)


def test_infra_red_nearer_than_its_peak_reads_farther() -> None:
    curve, sensor = CURVES["GP2D120"], InfraRed("GP2D120", beams=3, view=0.01)
    worlds, mission, state = before_a_wall(0.01, 50)
    read, _ = sensor.read(worlds, state, sensor.start(mission, np.random.default_rng(1)))
    assert (read[:, 1] > 0.04).all()
    assert curve.voltage(np.array([0.01]))[0] < curve.voltage(np.array([0.03]))[0]


@pytest.mark.kernels
def test_voltages_are_those_of_plain_python(rng: np.random.Generator) -> None:
    for curve in CURVES.values():
        rows = [(float(d), float(v)) for d, v in curve.rows]
        for d in [0.0, curve.nearest, curve.reach, 9.0, *rng.uniform(0, 2 * curve.reach, 50)]:
            got = kernels.voltage(float(d), curve.rows, len(rows) - 1)
            assert got == pytest.approx(naive.volts(float(d), rows), rel=1e-14)


@pytest.mark.data
def test_the_shipped_tables_are_those_of_the_data(data_dir: Path) -> None:
    for file, name in (("gp2d120", "GP2D120"), ("gp2y0a02yk0f", "GP2Y0A02YK0F")):
        table = np.genfromtxt(
            data_dir / "range" / f"sharp_{file}_lookup.csv", delimiter=",", skip_header=1
        )
        assert_array_equal(CURVES[name].rows[1:], table[:, :2])
        assert (table[:, 2] == CURVES[name].noise).all()


def test_tilt_has_a_constant_error_for_each_rover_and_one_for_each_reading() -> None:
    n = 2000
    worlds, mission, state = before_a_wall(2.0, n)
    state = dataclasses.replace(state, attitude=np.tile([0.0, 0.2, -0.1], (n, 1)))
    sensor = Tilt(bias=0.01, noise=0.002)
    memory, reads = sensor.start(mission, np.random.default_rng(0)), []
    for _ in range(20):
        read, memory = sensor.read(worlds, state, memory)
        reads.append(read)
    error = np.array(reads) - (0.2, -0.1)
    assert error.mean(axis=0).std() == pytest.approx(0.01, rel=0.05)
    assert (error - error.mean(axis=0)).std() == pytest.approx(0.002 * math.sqrt(19 / 20), rel=0.05)


BAD: list[tuple[Any, str]] = [
    (lambda: RangeNoise(core=-1.0), "core must be 0 or more, got -1.0"),
    (lambda: RangeNoise(spread=math.nan), "spread must be 0 or more"),
    (lambda: RangeNoise(find=0.0), "find must lie above 0 and up to 1, got 0.0"),
    (lambda: NoisyFan(RangeFan(reach=1.0, beams=9), ROUGH, cone=2), "a whole part of the fan's 9"),
    (lambda: InfraRed("GP2D12"), "did you mean 'GP2D120'"),
    (lambda: Tilt(bias=-1.0), "the bias of a tilt must be 0 rad or more"),
    (lambda: ranger("lidars"), "did you mean 'lidar'"),
]


@pytest.mark.parametrize(("make", "message"), BAD)
def test_absurd_noise_is_refused(make: Any, message: str) -> None:
    with pytest.raises(SettingError, match=message):
        make()
