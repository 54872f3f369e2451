from __future__ import annotations

import dataclasses
import inspect
import pickle
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rovernav import core
from rovernav.core import (
    Frame,
    InputError,
    Mission,
    Observation,
    Outcome,
    RovernavError,
    RoverState,
    ShapeError,
    suggest,
)
from rovernav.core import errors as tree


def mission(**changes: Any) -> Mission:
    plain: dict[str, Any] = {"start": np.zeros((2, 3)), "goal": np.ones((2, 2))}
    plain |= {"goal_radius": 1.0, "time_limit": 60.0, **changes}
    return Mission(**plain)


def test_values_cannot_be_changed() -> None:
    value = mission()
    with pytest.raises(dataclasses.FrozenInstanceError):
        value.goal_radius = 2.0  # type: ignore[misc]
    with pytest.raises((AttributeError, TypeError)):
        value.other = 2.0  # type: ignore[attr-defined]
    with pytest.raises(ValueError, match="read-only"):
        value.start[0, 0] = 1.0
    with pytest.raises(TypeError, match="positional"):
        Frame(1.0, (2, 2))  # type: ignore[misc]


def test_the_callers_array_stays_writable() -> None:
    start = np.zeros((2, 3))
    value = mission(start=start)
    start[0, 0] = 5.0
    assert start.flags.writeable
    assert not value.start.flags.writeable


def test_equality_is_identity() -> None:
    value = mission()
    assert value == value
    assert value != mission()
    assert len({value, value, mission()}) == 2


def test_values_travel_between_processes() -> None:
    copy = pickle.loads(pickle.dumps(mission()))
    assert copy.start.tolist() == mission().start.tolist()


def test_values_arrive_read_only_and_with_their_mappings() -> None:
    seen = Observation(
        goal=np.ones((2, 2)), twist=np.zeros((2, 3)), channels={"a": np.ones((2, 1))}
    )
    for protocol in (2, 5):
        back = pickle.loads(pickle.dumps(seen, protocol=protocol))
        assert not back.goal.flags.writeable
        assert not back.channels["a"].flags.writeable
        assert type(back.channels) is type(seen.channels)
        np.testing.assert_array_equal(back.channel("a"), seen.channel("a"))


def test_readings_of_an_observation_are_frozen() -> None:
    reading = np.zeros((2, 4))
    observation = Observation(
        goal=np.zeros((2, 2)), twist=np.zeros((2, 3)), channels={"beams": reading}
    )
    with pytest.raises(ValueError, match="read-only"):
        observation.channels["beams"][0, 0] = 1.0
    with pytest.raises(TypeError):
        observation.channels["beams"] = reading  # type: ignore[index]
    assert reading.flags.writeable
    with pytest.raises(ShapeError, match=r"needs the sensor 'odometer', .* it carries: beams"):
        observation.channel("odometer")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"start": np.zeros(3)}, r"mission start must have shape \(n, 3\), got \(3,\)"),
        ({"start": np.zeros((2, 2))}, r"mission start must have shape \(n, 3\), got \(2, 2\)"),
        ({"goal": np.zeros((2, 3))}, r"mission goal must have shape \(n, 2\), got \(2, 3\)"),
        ({"goal": np.zeros((1, 2))}, "one goal for each start, got 2 starts and 1 goals"),
        ({"goal": np.full((2, 2), np.nan)}, "mission goal has a coordinate that is not a finite"),
    ],
)
def test_missions_that_cannot_be(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ShapeError, match=message):
        mission(**changes)


def test_a_mission_begins_at_rest_facing_its_goal() -> None:
    one = Mission.between((1.0, 1.0), (1.0, 5.0), goal_radius=0.5, time_limit=9.0)
    np.testing.assert_allclose(one.start, [[1.0, 1.0, np.pi / 2]], rtol=0, atol=1e-15)
    state = RoverState.at_start(one)
    assert state.driving.tolist() == [True]
    assert not state.twist.any()
    assert state.pose.tolist() == one.start.tolist()


def test_outcomes_are_read_by_name() -> None:
    assert [o.label for o in Outcome][-1] == "astray"
    assert np.array([Outcome.REACHED], np.int8).tolist() == [1]


coordinate = st.floats(-1e6, 1e6)


@given(x=coordinate, y=coordinate, dx=coordinate)
def test_frames_go_to_the_map_and_back(x: float, y: float, dx: float) -> None:
    frame = Frame(cell=0.5, shape=(4, 8), origin=(dx, -dx))
    assert frame.to_local(*frame.to_map(x, y)) == pytest.approx((x, y), abs=1e-9)


@given(row=st.integers(0, 3), column=st.integers(0, 7), cell=st.sampled_from([0.1, 0.5, 30.0]))
def test_the_centre_of_a_cell_lies_in_it(row: int, column: int, cell: float) -> None:
    frame = Frame(cell=cell, shape=(4, 8))
    centre = frame.centre_of(row, column)
    assert frame.contains(*centre)
    assert frame.cell_of(*centre) == (row, column)


def test_the_edges_of_a_frame() -> None:
    frame = Frame(cell=0.5, shape=(4, 8))
    assert frame.extent == (4.0, 2.0)
    assert frame.cell_of(0.0, 0.0) == (0, 0)
    assert frame.cell_of(4.0, 2.0) == (3, 7)
    assert frame.contains(4.0, 2.0)
    assert not frame.contains(4.0, 2.1)
    assert not frame.contains(float("nan"), 1.0)


@pytest.mark.parametrize("cell", [0.0, -1.0, np.nan, np.inf])
def test_frames_need_cells(cell: float) -> None:
    with pytest.raises(InputError, match="a cell must be a positive number of metres, got"):
        Frame(cell=cell, shape=(2, 2))


def test_frames_need_a_row_and_a_column() -> None:
    with pytest.raises(InputError, match=r"at least one row and column, got shape \(0, 3\)"):
        Frame(cell=1.0, shape=(0, 3))


def test_the_error_tree_is_the_one_drawn() -> None:
    drawn = (tree.__doc__ or "").split("::")[1].split("A message")[0]
    errors = [
        e for e in inspect.getmembers(tree, inspect.isclass) if e[1].__module__ == tree.__name__
    ]
    assert errors
    for name, error in errors:
        assert issubclass(error, RovernavError)
        assert name in drawn
        assert getattr(core, name) is error
    assert issubclass(InputError, ValueError)
    assert issubclass(core.MissingExtraError, ImportError)
    assert {e.__name__ for e in InputError.__subclasses__()} == {
        "SettingError", "ShapeError", "PatternError", "FileError",
    }  # fmt: skip


def test_suggestions() -> None:
    assert suggest("sigmiod", {"tanh", "sigmoid"}) == (
        "did you mean 'sigmoid'? Allowed: sigmoid, tanh."
    )
    assert suggest("x", ["b", "a"]) == "Allowed: a, b."
