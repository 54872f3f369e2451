from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import pytest
from pydantic import BaseModel, ConfigDict, Field, model_validator

from rovernav.core import FileError, SettingError, build, read_yaml
from rovernav.core.settings import MAX_YAML_BYTES


def read(folder: Path, text: str | bytes) -> dict[str, Any]:
    path = folder / "a.yaml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_yaml(path, what="scenario file")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("1e-3", 0.001),
        ("-2E+5", -2e5),
        (".5e1", 5.0),
        ("1.", 1.0),
        ("+.25", 0.25),
        ("-0.0", -0.0),
        (".inf", float("inf")),
        ("1e400", float("inf")),
        ("17", 17),
        ("-3", -3),
        ("0", 0),
        ("true", True),
        ("false", False),
        ("null", None),
        ("~", None),
        ("", None),
        ("no", "no"),
        ("yes", "yes"),
        ("on", "on"),
        ("True", "True"),
        ("010", "010"),
        ("0x10", "0x10"),
        ("1_000", "1_000"),
        ("12:30:45", "12:30:45"),
        ("2012-11-26", "2012-11-26"),
        ("1e", "1e"),
        ("e5", "e5"),
        ("'1'", "1"),
        ("<<", "<<"),
        ("=", "="),
        ("[1, 2.5, no]", [1, 2.5, "no"]),
        ("{a: {b: 1e1}}", {"a": {"b": 10.0}}),
    ],
)
def test_what_a_word_means(tmp_path: Path, text: str, expected: Any) -> None:
    got = read(tmp_path, f"key: {text}\n")["key"]
    assert got == expected
    assert type(got) is type(expected)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: 1\nb: 2\na: 3\n", "line 3: the key 'a' stands here twice"),
        ("a: 1\nb:\n  c: 1\n  c: 2\n", "line 4: the key 'c' stands here twice"),
        ("a: {b: 1, b: 2}", "line 1: the key 'b' stands here twice"),
        ("a: 1\n'a': 2", "line 2: the key 'a' stands here twice"),
        ("a: &x 1\nb: *x\n", "line 2: aliases are not allowed"),
        ("a: !!python/object:os.system 1", "line 1: tags are not allowed"),
        ("a: !!int ''", "line 1: tags are not allowed"),
        ("? !!set {a}\n: 1", "line 1: tags are not allowed"),
        ("? {a: 1}\n: 2", "line 1: a key must be a single word"),
        ("? [a]\n: 2", "line 1: a key must be a single word"),
        ("a: 1\n\tb: 2\n", "line 2: found character .* that cannot start any token"),
        ("a: [1, 2\nb: 3\n", "line 2: "),
        ("a: 'x\n", "line 2: found unexpected end of stream"),
        ("a: 1\n---\nb: 2\n", "line 2: but found another document"),
        ("a: b: c\n", "line 1: mapping values are not allowed here"),
        ("", "must hold 'key: value' lines, got nothing"),
        ("# only a comment\n", "must hold 'key: value' lines, got nothing"),
        ("- 1\n- 2\n", "must hold 'key: value' lines, got a list"),
        ("just text", "must hold 'key: value' lines, got text"),
        ("42", "must hold 'key: value' lines, got a number"),
        ("a: " + "[" * 20_000, "is not YAML: nested too deeply"),
        ("a: " + "9" * 5000, "is not YAML: Exceeds the limit"),
        ("a: \x01", "is not YAML: unacceptable character"),
        (b"a: \xff", r"is not UTF-8 text \(byte 3\); save the scenario file as UTF-8"),
        ("a: b\n" * 200_001, "more than a scenario file may have"),
    ],
)
def test_what_is_refused(tmp_path: Path, text: str | bytes, message: str) -> None:
    with pytest.raises(FileError, match=message) as caught:
        read(tmp_path, text)
    assert "a.yaml" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_byte_order_mark_and_windows_lines(tmp_path: Path) -> None:
    assert read(tmp_path, b"\xef\xbb\xbfa: 1\r\nb: no\r\n") == {"a": 1, "b": "no"}


def test_the_largest_file_is_read(tmp_path: Path) -> None:
    text = "a: 1\n#"
    assert read(tmp_path, text + "x" * (MAX_YAML_BYTES - len(text))) == {"a": 1}


def test_a_missing_file_and_a_folder(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"^there is no rover file at .*b\.yaml; check the path$"):
        read_yaml(tmp_path / "b.yaml", what="rover file")
    with pytest.raises(FileError, match=r"^.* is a folder; give the rover file itself$"):
        read_yaml(tmp_path, what="rover file")


class Strict(BaseModel):
    model_config = ConfigDict(extra="forbid")


class Wheel(Strict):
    radius: float = Field(gt=0)


class Rover(Strict):
    name: str = "x"
    drive: Literal["skid", "point"] = "skid"
    wheel: Wheel | None = None
    wheels: list[Wheel] | None = None
    by_name: dict[str, Wheel] = {}

    @model_validator(mode="after")
    def _one_kind(self) -> Rover:
        if self.wheel and self.wheels:
            raise ValueError("Give either wheel or wheels")
        return self


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ({"names": 1}, "r.yaml: unknown key 'names'; did you mean 'name'? Allowed: by_name, drive, "
                     "name, wheel, wheels."),
        ({"q": 1}, "r.yaml: unknown key 'q'; Allowed: by_name, drive, name, wheel, wheels."),
        ({"wheel": {"radius": 1, "radios": 2}},
         "r.yaml: unknown key 'wheel.radios'; did you mean 'radius'? Allowed: radius."),
        ({"wheels": [{"radius": 1}, {"radius": 1, "x": 2}]},
         "r.yaml: unknown key 'wheels.1.x'; Allowed: radius."),
        ({"by_name": {"left": {"radius": 1, "x": 2}}},
         "r.yaml: unknown key 'by_name.left.x'; Allowed: radius."),
        ({"wheel": {}}, "r.yaml: the key 'wheel.radius' is missing; add it"),
        ({"wheel": {"radius": 0}},
         "r.yaml: wheel.radius = 0: input should be greater than 0"),
        ({"drive": "hover"}, "r.yaml: drive = 'hover': input should be 'skid' or 'point'"),
        ({"name": 3}, "r.yaml: name = 3: input should be a valid string"),
        ({"name": ["x" * 100]},
         "r.yaml: name = ['" + "x" * 55 + "...: input should be a valid string"),
        ({"wheel": {"radius": 1}, "wheels": [{"radius": 1}]},
         "r.yaml: the whole = {'wheel': {'radius': 1}, 'wheels': [{'radius': 1}]}: "
         "give either wheel or wheels"),
        ({1: 2}, "r.yaml: the key 1 must be text; put it in quotes"),
    ],
)  # fmt: skip
def test_the_first_mistake_is_one_sentence(data: dict[str, Any], message: str) -> None:
    with pytest.raises(SettingError) as caught:
        build(Rover, data, source="r.yaml")
    assert str(caught.value) == message


def test_settings_that_are_right() -> None:
    rover = build(Rover, {"wheels": [{"radius": 0.25}]}, source="r.yaml")
    assert rover.wheels == [Wheel(radius=0.25)]
