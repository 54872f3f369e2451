from __future__ import annotations

import importlib
import inspect
import pkgutil
from types import ModuleType

import pytest

import rovernav

FOUND = pkgutil.iter_modules(rovernav.__path__, "rovernav.")
ROOMS = [module.name for module in FOUND if module.ispkg]


def public_names(room: ModuleType) -> set[str]:
    """What a person finds in `room`, other than its own files."""
    names = {name for name in dir(room) if not name.startswith("_")} - {"annotations"}
    return {name for name in names if not inspect.ismodule(getattr(room, name))}


@pytest.mark.parametrize("name", ROOMS)
def test_each_name_exists(name: str) -> None:
    room = importlib.import_module(name)
    assert [entry for entry in room.__all__ if not hasattr(room, entry)] == []


@pytest.mark.parametrize("name", ROOMS)
def test_all_lists_what_is_public(name: str) -> None:
    # That the list is in order, ruff checks (RUF022).
    room = importlib.import_module(name)
    assert len(set(room.__all__)) == len(room.__all__)
    assert public_names(room) == set(room.__all__)


def test_the_package_names_its_rooms() -> None:
    for name in rovernav.__all__:
        assert getattr(rovernav, name) is not None
    assert set(rovernav.__all__) <= set(dir(rovernav))
    with pytest.raises(AttributeError, match="no_such_room"):
        _ = rovernav.no_such_room
