"""The ground that all peers judge, and the rover."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from harness.ccode import BUILD
from harness.model import Result, Stopwatch, Trial

CELL = 1.0
REACH = 2
"""The plane is fitted to 5 x 5 posts: about the 3 m that Perseverance measures."""


def heights(size: int) -> Any:
    """Hills with a spectrum like nature's, 400 m from lowest to highest at 4096 posts; float32."""
    path = BUILD / f"ground-{size}.npy"
    if not path.exists():
        rng = np.random.default_rng(7)
        u = np.fft.rfftfreq(size)[None, :]
        v = np.fft.fftfreq(size)[:, None]
        wave = np.hypot(u, v)
        wave[0, 0] = 1.0
        phase = rng.uniform(0.0, 2.0 * np.pi, wave.shape)
        spectrum = wave**-2.0 * np.exp(1j * phase)
        spectrum[0, 0] = 0.0
        z = np.fft.irfft2(spectrum, (size, size))
        z *= 400.0 * size / 4096 / (z.max() - z.min())
        BUILD.mkdir(exist_ok=True)
        np.save(path, (z - z.min()).astype(np.float32))
    return np.load(path)


def calls(work: Callable[[], float]) -> Trial:
    """`work` once in each repetition; it returns the check."""

    def trial(repeats: int) -> Result:
        watch, check = Stopwatch(), 0.0
        with watch:
            for _ in range(repeats):
                check = work()
        return watch.result(repeats, check)

    return trial
