from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rovernav.control import NeuralController
from rovernav.core import InputError, Outcome
from rovernav.learn import Progress, paper_training, train
from rovernav.nets import Network
from rovernav.scenes import Scene, bassil_scene, random_rectangles
from rovernav.show import draw_paper_figure, draw_training, draw_worlds
from rovernav.sim import Drive, Trace, Worlds, simulate

from .pictures import drive, pixels, share

OBSTACLE, PATH, CROSS = "#BBBBBB", "#0072B2", "#D55E00"
SKY, GREEN = "#56B4E9", "#009E73"


@pytest.fixture(scope="module")
def trained() -> tuple[Network, list[Progress]]:
    curve: list[Progress] = []
    net, patterns, settings = paper_training()
    return train(net, patterns, settings, on_event=curve.append).network, curve


def driven(scene: Scene, net: Network, record: str = "all") -> Trace:
    setup = Drive(
        worlds=scene.worlds,
        mission=scene.mission,
        sensors=scene.sensors,
        controller=NeuralController(net),
        motion=scene.motion,
    )
    return simulate(setup, record=record)


def test_the_figure_shows_obstacle_and_what_was_sensed(
    tmp_path: Path, trained: tuple[Network, list[Progress]]
) -> None:
    scene = bassil_scene()
    path = draw_paper_figure(driven(scene, trained[0]), scene, tmp_path / "new" / "figure3.png")
    assert path == tmp_path / "new" / "figure3.png"
    assert path.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    assert b"rovernav" in path.read_bytes()[:200]
    image = pixels(path)
    assert image.shape == (988, 1300, 3)
    assert share(image, OBSTACLE) > 0.03
    assert share(image, SKY) > 2e-4  # up, sight blocked
    assert share(image, GREEN) > 2e-4  # down, goal in sight
    without = bassil_scene(obstacle="none")
    draw_paper_figure(driven(without, trained[0]), without, path)
    assert share(pixels(path), OBSTACLE) < 3e-3


def test_the_same_drive_gives_the_same_bytes(
    tmp_path: Path, trained: tuple[Network, list[Progress]]
) -> None:
    scene = bassil_scene("bassil-replay-v1", obstacle="mirrored")
    trace = driven(scene, trained[0], record="path")
    first = draw_paper_figure(trace, scene, tmp_path / "a.png").read_bytes()
    import matplotlib

    with matplotlib.rc_context({"font.size": 30.0, "text.usetex": True}):
        again = draw_paper_figure(trace, scene, tmp_path / "b.png").read_bytes()
    assert first == again


def test_training_curve(tmp_path: Path, trained: tuple[Network, list[Progress]]) -> None:
    curve = trained[1]
    path = draw_training(curve, tmp_path / "t.png", tolerance=0.01, outputs=2, title="paper")
    image = pixels(path)
    assert share(image, PATH) > 1e-3
    blue = (np.abs(image[70:540] - [0, 0x72, 0xB2]).max(axis=-1) < 6).nonzero()
    assert blue[0][blue[1] < 200].mean() < blue[0][blue[1] > 800].mean() - 100  # it falls
    draw_training(curve[:20], path, tolerance=0.01)  # ended before the tolerance was met
    draw_training(curve[:1], path)
    with pytest.raises(InputError, match="nothing to draw"):
        draw_training([], path)


def test_training_without_known_errors(tmp_path: Path) -> None:
    curve = [
        Progress(epoch=i, updates=i, worst=np.nan, loss=loss, seconds=0.0, parameters=np.zeros(1))
        for i, loss in enumerate((1.0, 0.5, 0.0))
    ]
    assert draw_training(curve, tmp_path / "t.png").stat().st_size > 5000


def test_worlds_side_by_side(tmp_path: Path, trained: tuple[Network, list[Progress]]) -> None:
    scene = random_rectangles(8, np.random.default_rng(0))
    trace = driven(scene, trained[0], record="path")
    assert set(trace.outcome) >= {Outcome.REACHED, Outcome.COLLIDED}
    wide = pixels(draw_worlds(trace, scene.worlds, tmp_path / "w.png", rovers=(2, 3, 0)))
    assert share(wide, OBSTACLE) > 0.02
    assert share(wide, PATH) > 0.002
    assert share(wide[:, : 2 * wide.shape[1] // 3], CROSS) < share(wide, CROSS)
    tall = pixels(draw_worlds(trace, scene.worlds, tmp_path / "w.png", columns=2, title="eight"))
    assert tall.shape[0] > 2 * wide.shape[0]


@pytest.mark.parametrize(
    ("rovers", "message"), [((), "holds 1 to 60 worlds, got 0"), ((1,), "has 0 to 0")]
)
def test_worlds_that_cannot_be_drawn(tmp_path: Path, rovers: tuple[int, ...], message: str) -> None:
    trace = drive([(0, 0), (1, 1)], Outcome.REACHED)
    with pytest.raises(InputError, match=message):
        draw_worlds(trace, Worlds.single(), tmp_path / "w.png", rovers=rovers)


def test_a_trace_without_a_path_says_so(
    tmp_path: Path, trained: tuple[Network, list[Progress]]
) -> None:
    scene = bassil_scene()
    trace = driven(scene, trained[0], record="none")
    with pytest.raises(InputError, match="record='path' or 'all' keeps it"):
        draw_paper_figure(trace, scene, tmp_path / "f.png")
    assert list(tmp_path.iterdir()) == []
