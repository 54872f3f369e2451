"""The noise of 24 sonars: fitted to the first half of a real log, judged on the second.

    ROVERNAV_DATA=FOLDER python benchmarks/experiments/range_noise.py

Nobody knows the true ranges of the log. In their place stands the median of the readings that have
an echo, over 9 samples (1 s), and over 45 where those 9 have none; where none of the 45 has one,
or where the median is beyond 4.5 m, the truth counts as unknown and the reading is left out. What a
model says of a half is found by spoiling that half's true ranges with the kernel that drives use.
A Gaussian of the residuals' standard deviation, clipped to the reach, is judged beside it.
"""

from __future__ import annotations

import itertools
import math
import os
import sys
from pathlib import Path

import numpy as np

from rovernav.core import F64, Bool
from rovernav.kernels import noise as kernels
from rovernav.sim import RangeNoise

LOG = Path("range/scitos_g5_24sonar_part1.csv")
REACH, KNOWN = 5.0, 4.5
"""Where the log saturates, and up to where its truth is guessed [m]."""
NEAR, FAR = 9, 45
"""Samples of the two medians."""
STRAY, JUMP = 0.1, 0.5
"""A reading so far off is a stray one; two so far apart are a jump [m]."""


def main() -> None:
    """Fit, judge, print."""
    named = os.environ.get("ROVERNAV_DATA")
    if not named:
        sys.exit("set ROVERNAV_DATA to the folder of the development data")
    log = np.genfromtxt(Path(named) / LOG, delimiter=",", skip_header=1, usecols=range(24))
    half = len(log) // 2
    first, second = log[:half], log[half:]
    noise = fit(first)
    for name in ("core", "relative", "stray", "spread", "back", "lose", "find", "least", "grain"):
        print(f"{name:9} {getattr(noise, name):.4g}")
    truth = guess(second)
    known = usable(truth)
    plain = np.std((np.minimum(second, REACH) - truth)[known])
    gauss = np.clip(
        np.nan_to_num(truth) + np.random.default_rng(1).normal(0, plain, truth.shape), 0, REACH
    )
    table = {
        "log, second half": judge(second, truth, known),
        "this model": judge(spoilt(truth, noise, seed=1), truth, known),
        f"a Gaussian of {plain:.2f} m": judge(gauss, truth, known),
    }
    print("\n| second half | " + " | ".join(next(iter(table.values()))) + " |")
    for name, row in table.items():
        print(f"| {name} | " + " | ".join(f"{got:.3g}" for got in row.values()) + " |")


def guess(log: F64) -> F64:
    """What the true ranges may have been; NaN where nobody can say."""
    echo = np.where(log < REACH - 1e-9, log, np.nan)
    truth = rolling(echo, NEAR)
    return np.where(np.isnan(truth), rolling(echo, FAR), truth)


def rolling(table: F64, width: int) -> F64:
    """Medians over `width` rows around each row, what is missing left out."""
    padded = np.pad(table, ((width // 2, width // 2), (0, 0)), constant_values=np.nan)
    windows = np.lib.stride_tricks.sliding_window_view(padded, width, axis=0)
    out = np.full(table.shape, np.nan)
    some = ~np.isnan(windows).all(axis=-1)
    out[some] = np.nanmedian(windows[some], axis=-1)
    return out


def usable(truth: F64) -> Bool:
    """Where the truth is known well enough."""
    return np.isfinite(truth) & (truth < KNOWN)


def fit(log: F64) -> RangeNoise:
    """The noise that has the log's shares and spreads."""
    truth = guess(log)
    known, lost = usable(truth), log >= REACH - 1e-9
    echo = known & ~lost
    error, r = (log - truth)[echo], truth[echo]
    far = np.abs(error) > STRAY
    core, relative = steady(error[~far], r[~far])
    both = known[1:] & known[:-1]
    astray = echo & (np.abs(log - np.nan_to_num(truth)) > STRAY)
    sees = both & ~lost[:-1] & ~astray[:-1]
    metres = truth[:-1][sees].sum()
    spread = float(np.sqrt(np.mean(error[far] ** 2)))
    shown = math.erfc(STRAY / spread / math.sqrt(2.0))
    return RangeNoise(
        core=core,
        relative=relative,
        # some strays lie within STRAY of the truth, and do not show
        stray=(sees & astray[1:]).sum() / metres / shown,
        spread=spread,
        back=(both & astray[:-1] & ~astray[1:]).sum() / (both & astray[:-1]).sum(),
        lose=(sees & lost[1:]).sum() / metres,
        find=(both & lost[:-1] & ~lost[1:]).sum() / (both & lost[:-1]).sum(),
        least=0.3,
        grain=0.001,
    )


def steady(error: F64, r: F64) -> tuple[float, float]:
    """Standard deviation at range 0 and its growth per metre, by least squares over bins."""
    edges = np.quantile(r, np.linspace(0.0, 1.0, 13))
    at, spread = [], []
    for low, high in itertools.pairwise(edges):
        inside = (r >= low) & (r < high)
        at.append(r[inside].mean())
        spread.append(error[inside].std())
    slope, start = np.polyfit(at, spread, 1)
    return max(float(start), 0.001), max(float(slope), 0.0)


def spoilt(truth: F64, noise: RangeNoise, *, seed: int) -> F64:
    """True ranges as a rover would read them; where they are not known, nothing is met."""
    true = np.where(np.isfinite(truth), truth, REACH)
    rovers = np.empty(1, np.uint64)
    kernels.keys(seed, np.zeros(1, np.int64), rovers)
    lost, out = np.zeros((1, true.shape[1]), np.int64), np.empty_like(true)
    for step, row in enumerate(true):
        now = np.empty_like(lost)
        kernels.spoil(
            row[None], rovers, step + 1, lost, REACH, noise.numbers(), now, out[step : step + 1]
        )
        lost = now
    return out


def judge(log: F64, truth: F64, known: Bool) -> dict[str, float]:
    """What describes how readings differ from the truth and from each other."""
    lost = (log >= REACH - 1e-9) & known
    error = np.abs(np.minimum(log, REACH) - truth)[known]
    steps = known[1:] & known[:-1]
    jumps = np.abs(np.diff(np.minimum(log, REACH), axis=0))[steps]
    ends = (lost[:-1] & ~lost[1:]).sum()
    return {
        "no echo [%]": 100.0 * lost.sum() / known.sum(),
        "burst [samples]": lost.sum() / max(ends, 1),
        "median error [mm]": 1000.0 * float(np.quantile(error, 0.5)),
        "p75 [mm]": 1000.0 * float(np.quantile(error, 0.75)),
        "p90 [mm]": 1000.0 * float(np.quantile(error, 0.9)),
        "p95 [mm]": 1000.0 * float(np.quantile(error, 0.95)),
        "p99 [mm]": 1000.0 * float(np.quantile(error, 0.99)),
        "jumps > 0.5 m [%]": 100.0 * float((jumps > JUMP).mean()),
    }


if __name__ == "__main__":
    main()
