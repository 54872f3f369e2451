"""Strict YAML: no repeated keys, no aliases, no surprises about numbers, a bounded size."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn, TypeVar

from .errors import FileError, SettingError, suggest
from .files import read_text

if TYPE_CHECKING:
    from pydantic import BaseModel

    Model = TypeVar("Model", bound=BaseModel)

MAX_YAML_BYTES = 1_000_000
_PLAIN = {
    "null": (r"(?:~|null)?", ["~", "n", ""]),
    "bool": ("true|false", ["t", "f"]),
    "int": (r"[-+]?(?:0|[1-9]\d*)", list("-+0123456789")),
    "float": (
        r"[-+]?(?:\d+\.\d*|\.\d+|\d+(?=[eE]))(?:[eE][-+]?\d+)?|[-+]?\.inf|\.nan",
        list("-+.0123456789"),
    ),
}
"""What an unquoted word can be besides text: its pattern and its first letters."""


_KINDS: dict[type, str] = {type(None): "nothing", list: "a list", str: "text"}


def read_yaml(path: Path, *, what: str) -> dict[str, Any]:
    """The mapping in a YAML file.

    ``1e-3`` is a number; ``no``, ``010`` and ``2012-11-26`` are text; repeated keys, aliases and
    tags are refused.

    Raises:
        FileError: The file cannot be read or is not YAML; the sentence names the line.
    """
    import yaml

    text = read_text(path, limit=MAX_YAML_BYTES, what=what)
    try:
        data = yaml.load(text, Loader=_strict_loader())  # a SafeLoader
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        where = f", line {mark.line + 1}" if mark else ""
        raise FileError(f"{path}{where}: {error.problem or 'is not YAML'}") from None
    except RecursionError:
        raise FileError(f"{path} is not YAML: nested too deeply") from None
    except (yaml.YAMLError, ValueError) as error:
        raise FileError(f"{path} is not YAML: {str(error).splitlines()[0]}") from None
    if not isinstance(data, dict):
        got = _KINDS.get(type(data), "a number")
        raise FileError(f"{path} must hold 'key: value' lines, got {got}")
    return data


def build(model: type[Model], data: dict[str, Any], *, source: str) -> Model:
    """A pydantic model from plain data; the first mistake becomes one clear sentence.

    Raises:
        SettingError: An unknown key (with the nearest valid one) or a value that is not allowed.
    """
    from pydantic import ValidationError

    try:
        return model.model_validate(data)
    except ValidationError as error:
        found = error.errors()
        unknown = [one for one in found if one["type"] == "extra_forbidden"]
        # A key that is spelt wrongly is also missing; that it is unknown says more.
        raise SettingError(_sentence(model, (unknown or found)[0], source)) from None


def _sentence(model: type[Any], first: Any, source: str) -> str:
    key = ".".join(str(part) for part in first["loc"]) or "the whole"
    if first["type"] == "extra_forbidden":
        fields = _fields_at(model, first["loc"][:-1])
        return f"{source}: unknown key {key!r}; {suggest(str(first['loc'][-1]), fields)}"
    if first["type"] == "invalid_key":
        return f"{source}: the key {key} must be text; put it in quotes"
    if first["type"] == "missing":
        return f"{source}: the key {key!r} is missing; add it"
    message = first["msg"].removeprefix("Value error, ")
    return f"{source}: {key} = {_short(first['input'])}: {message[0].lower()}{message[1:]}"


def _short(item: Any) -> str:
    text = repr(item)
    return text if len(text) <= 60 else text[:57] + "..."


def _fields_at(model: type[Any], path: tuple[Any, ...]) -> list[str]:
    """Names of the keys allowed at `path` inside `model`."""
    for part in path:
        if part in model.model_fields:  # otherwise the number or name of an item inside a field
            model = next(_models_in(model.model_fields[part].annotation), model)
    return list(model.model_fields)


def _models_in(annotation: Any) -> Iterator[Any]:
    if hasattr(annotation, "model_fields"):
        yield annotation
    for inner in getattr(annotation, "__args__", ()):
        yield from _models_in(inner)


def _strict_loader() -> Any:
    import yaml

    class Strict(yaml.SafeLoader):
        """SafeLoader without repeated keys, aliases, tags, dates, octals or yes/no booleans."""

        def compose_node(self, parent: Any, index: Any) -> Any:
            event = self.peek_event()
            if isinstance(event, yaml.AliasEvent):
                _refuse("aliases are not allowed", event)
            if event.tag is not None:
                _refuse("tags are not allowed", event)
            return super().compose_node(parent, index)

        def construct_mapping(self, node: Any, deep: bool = False) -> Any:
            seen: set[Any] = set()
            for key_node, _ in node.value:
                key = self.construct_object(key_node, deep=True)
                if isinstance(key, (dict, list)):
                    _refuse("a key must be a single word", key_node)
                if key in seen:
                    _refuse(f"the key {key!r} stands here twice", key_node)
                seen.add(key)
            return super().construct_mapping(node, deep)

    def _refuse(problem: str, at: Any) -> NoReturn:
        raise yaml.constructor.ConstructorError(None, None, problem, at.start_mark)

    Strict.yaml_implicit_resolvers = {}
    for kind, (pattern, first) in _PLAIN.items():
        Strict.add_implicit_resolver(
            f"tag:yaml.org,2002:{kind}", re.compile(f"^(?:{pattern})$", re.ASCII), first
        )
    return Strict
