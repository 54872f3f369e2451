from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rovernav.control import HeadingCodec, NeuralController, build_codec
from rovernav.core import FileError, Outcome, SettingError
from rovernav.learn import (
    Recipe,
    find_controller,
    fresh_network,
    mirrored,
    read_recipe,
    recipes,
    teach,
)
from rovernav.nets import weights_sha256
from rovernav.rover import read_rover
from rovernav.scenes import Scene, equip, free_pairs, pair_mission, practice_grid
from rovernav.sim import RangeFan, Worlds, simulate

TINY = Recipe(
    seed=3, hidden=(8,), rounds=2, worlds=2, rovers=3, side_m=16.0, steps=12, every=2, epochs=2
)


def test_the_same_recipe_gives_the_same_bits(tmp_path: Path) -> None:
    a, b = (teach(TINY, tmp_path / name) for name in "ab")
    assert weights_sha256(a) == weights_sha256(b)
    other = teach(TINY.model_copy(update={"seed": 4}), tmp_path / "c")
    assert weights_sha256(other) != weights_sha256(a)


def test_a_teaching_goes_on_where_it_was_stopped(tmp_path: Path) -> None:
    whole = weights_sha256(teach(TINY, tmp_path))
    (tmp_path / "network-2.safetensors").unlink()
    assert weights_sha256(teach(TINY, tmp_path)) == whole
    for name in ("network-1.safetensors", "network-2.safetensors", "round-2.npz"):
        (tmp_path / name).unlink()
    assert weights_sha256(teach(TINY, tmp_path)) == whole


def test_a_folder_belongs_to_one_recipe(tmp_path: Path) -> None:
    teach(TINY, tmp_path)
    with pytest.raises(SettingError, match="holds rounds of another recipe; name another folder"):
        teach(TINY.model_copy(update={"eta": 0.5}), tmp_path)


def test_a_damaged_round_is_not_learnt_from(tmp_path: Path) -> None:
    teach(TINY, tmp_path)
    kept = tmp_path / "round-1.npz"
    data = bytearray(kept.read_bytes())
    data[len(data) // 2] ^= 1
    kept.write_bytes(data)
    with pytest.raises(FileError, match=r"round-1.npz is damaged; delete it"):
        teach(TINY, tmp_path)


def test_a_rover_without_differential_drive_cannot_be_taught(tmp_path: Path) -> None:
    with pytest.raises(SettingError, match="paper-point has no differential drive"):
        teach(TINY.model_copy(update={"rover": "paper-point"}), tmp_path)


def test_the_network_says_what_it_is() -> None:
    network = fresh_network(TINY, HeadingCodec())
    assert network.topology == (67, 8, 32)
    assert network.card.training is not None
    assert network.card.training["recipe"] == TINY.model_dump(mode="json")
    assert build_codec(network.card.codec or {}).settings() == HeadingCodec().settings()


def test_a_mirror_image_swaps_left_and_right(rng: np.random.Generator) -> None:
    table = rng.random((5, 64 + 3 + 32))
    image = mirrored(table, 64)
    np.testing.assert_array_equal(mirrored(image, 64), table)
    np.testing.assert_array_equal(image[:, 0], table[:, 0])  # towards the goal
    np.testing.assert_array_equal(image[:, 1], table[:, 63])
    np.testing.assert_array_equal(image[:, 65], -table[:, 65])
    np.testing.assert_array_equal(image[:, 67], table[:, 67])
    np.testing.assert_array_equal(image[:, 68], table[:, 98])


def test_shipped_recipes_can_be_read_and_unknown_ones_are_named() -> None:
    for name in recipes():
        assert read_recipe(name).rounds >= 1
    with pytest.raises(FileError, match="no recipe 'heading-v1' and no such file; did you mean"):
        read_recipe("heading-v1")


class Blinded:
    """A fan that always says: nothing there."""

    name = "beams"

    def __init__(self, fan: RangeFan) -> None:
        self.fan = fan

    def start(self, mission: Any, rng: Any) -> None:
        return

    def read(self, world: Any, state: Any, memory: None) -> tuple[np.ndarray, None]:
        return np.full((len(state.pose), len(self.fan.angles)), self.fan.reach), None


def practice(seed: int, count: int = 12) -> Scene:
    """A generated world that no lesson used."""
    rover, rng = read_rover("research"), np.random.default_rng([99, seed])
    grid = practice_grid(rng, rover, side=30.0, cell=0.2)
    starts, goals = free_pairs(grid, count, rng, nearest=6.0, farthest=30.0)
    sensors, mapper, motion, pace = equip(rover, 0.2)
    return Scene(
        name="test",
        worlds=Worlds.single(grid=grid, rovers=count),
        mission=pair_mission(starts, goals, goal_radius=0.5, pace=pace),
        sensors=sensors,
        motion=motion,
        mapper=mapper,
    )


def reached(scene: Scene, driver: Any) -> float:
    trace = simulate(scene.drive(driver), record="none")
    return float(np.mean(trace.outcome == Outcome.REACHED))


def test_the_shipped_driver_drives_ground_it_was_not_taught_on_and_needs_its_eyes() -> None:
    neural, seeker = find_controller("neural"), find_controller("goal-seeker")
    scenes = [practice(seed) for seed in range(3)]
    blind = [
        Scene(
            name=s.name, worlds=s.worlds, mission=s.mission, motion=s.motion, mapper=s.mapper,
            sensors=(Blinded(s.sensors[0]),),  # pyright: ignore[reportArgumentType]
        )
        for s in scenes
    ]  # fmt: skip
    seeing = np.mean([reached(scene, neural) for scene in scenes])
    blinded = np.mean([reached(scene, neural) for scene in blind])
    assert seeing >= 0.6
    assert blinded <= 0.1
    assert np.mean([reached(scene, seeker) for scene in scenes]) <= 0.1


def test_a_taught_network_gets_there_far_more_often_than_an_untaught_one() -> None:
    untaught = NeuralController(fresh_network(read_recipe("headings-v1"), HeadingCodec()))
    scene = practice(0)
    assert reached(scene, find_controller("neural")) >= reached(scene, untaught) + 0.4


@pytest.mark.data
def test_the_shipped_driver_crosses_the_mars_yard(data_dir: Path) -> None:
    from rovernav.bench import draw_pairs, score
    from rovernav.terrain import read_terrain

    yard = read_terrain(data_dir / "dem/earth_marsyard2021_9cm/marsyard_terrain_hm.tif")
    pairs = draw_pairs(yard, read_rover("research"), 40, seed=0)
    neural = score(pairs, "neural", find_controller("neural"))
    assert neural.reached >= 0.7
    assert "collided" not in neural.counts
    assert score(pairs, "seeker", find_controller("goal-seeker")).reached <= 0.1
