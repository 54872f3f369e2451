from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from rovernav.core import InputError
from rovernav.learn import SweepResult, SweepSettings, shipped_patterns, sweep
from rovernav.show import draw_sweep
from tests.show.pictures import pixels

TABLE = shipped_patterns("bassil-v1")


def result_of(**changes: object) -> SweepResult:
    return sweep(TABLE, SweepSettings(**{"seeds": 4, "epochs": 60, "tolerance": 0.3} | changes))  # type: ignore[arg-type]


@pytest.mark.parametrize("tolerance", [0.0, 0.3])
@pytest.mark.parametrize(
    "rates",
    [
        {"etas": (0.1, 0.3, 5.0), "momenta": (0.0, 0.9)},
        {"etas": (0.1, 0.3, 5.0)},
        {"momenta": (0.0, 0.5, 0.9)},
        {},
        {"etas": (5.0,)},
        {"etas": (5.0, 6.0), "momenta": (0.0, 0.9)},
        {"etas": tuple(k / 60 for k in range(1, 41)), "momenta": tuple(k / 20 for k in range(20))},
    ],
)
def test_every_shape_of_sweep_is_drawn(
    rates: dict[str, tuple[float, ...]], tolerance: float, tmp_path: Path
) -> None:
    result = result_of(tolerance=tolerance, **rates)
    path = draw_sweep(result, tmp_path / "a.png", tolerance=tolerance, title="50 $ networks")
    image = pixels(path)
    assert image.shape[1] == 1378
    assert image.std() > 10.0


def test_another_result_is_another_picture(tmp_path: Path) -> None:
    paths = [
        draw_sweep(result_of(etas=(0.1, eta), momenta=(0.0, 0.9)), tmp_path / f"{eta}.png",
                   tolerance=0.3)
        for eta in (0.3, 0.5)
    ]  # fmt: skip
    assert paths[0].read_bytes() != paths[1].read_bytes()


def test_nothing_to_draw(tmp_path: Path) -> None:
    nothing = dataclasses.replace(result_of(), settings=())
    with pytest.raises(InputError, match="nothing to draw"):
        draw_sweep(nothing, tmp_path / "a.png", tolerance=0.3)
