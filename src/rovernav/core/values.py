"""What all values share: frozen, slotted, keyword-only, with read-only arrays."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, TypeVar, dataclass_transform

import numpy as np

T = TypeVar("T")


@dataclass_transform(frozen_default=True, kw_only_default=True, eq_default=False)
def value(cls: type[T]) -> type[T]:
    """Make `cls` a value: a frozen, slotted, keyword-only dataclass with read-only arrays.

    Equality is identity, because arrays have no single truth value. Array fields are replaced by
    read-only views, so the caller's own array stays writable. A method ``_check`` is called last.
    A value that travels to another process is made anew there: read-only and checked.
    """
    arrays_frozen = _post_init(getattr(cls, "_check", None))
    cls.__post_init__ = arrays_frozen  # type: ignore[attr-defined]
    cls.__reduce__ = _reduce
    return dataclasses.dataclass(
        frozen=True, slots=True, kw_only=True, eq=False, weakref_slot=True
    )(cls)


def _post_init(check: Callable[[Any], None] | None) -> Callable[[Any], None]:
    def __post_init__(self: Any) -> None:
        for name in self.__dataclass_fields__:
            item = getattr(self, name)
            if isinstance(item, np.ndarray) and item.flags.writeable:
                view = item.view()
                view.flags.writeable = False
                object.__setattr__(self, name, view)
        if check is not None:
            check(self)

    return __post_init__


def _reduce(self: Any) -> tuple[Any, ...]:
    """How a value is pickled; a read-only mapping travels as a dictionary."""
    fields: dict[str, Any] = {}
    for name in self.__dataclass_fields__:
        item = getattr(self, name)
        fields[name] = dict(item) if isinstance(item, MappingProxyType) else item
    return _made, (type(self), fields)


def _made(cls: type[T], fields: dict[str, Any]) -> T:
    return cls(**fields)


def map_arrays(item: Any, change: Callable[[np.ndarray[Any, Any]], Any]) -> Any:
    """`item` with `change` made to each array in it, as deep as values, mappings and lists go.

    Rows 0 and 2 of everything about n rovers: ``map_arrays(state, lambda array: array[[0, 2]])``.
    """
    if isinstance(item, np.ndarray):
        return change(item)
    if isinstance(item, Mapping):
        return {name: map_arrays(part, change) for name, part in item.items()}
    if isinstance(item, list | tuple):
        return type(item)(map_arrays(part, change) for part in item)
    if dataclasses.is_dataclass(item) and not isinstance(item, type):
        names = [field.name for field in dataclasses.fields(item)]
        return dataclasses.replace(
            item, **{name: map_arrays(getattr(item, name), change) for name in names}
        )
    return item


def read_only(array: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """A read-only view of `array`."""
    view = array.view()
    view.flags.writeable = False
    return view
