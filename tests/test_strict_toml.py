# SPDX-License-Identifier: Apache-2.0
from dataclasses import dataclass
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lodestar.errors import InputError
from lodestar.strict_toml import build, check, option, parse, read, required_keys


@dataclass(frozen=True)
class Wheel:
    radius_m: float = option(low=0.1, high=2.0, doc="radius")
    spare: bool = option(False, doc="not mounted")


@dataclass(frozen=True)
class Engine:
    kind: str = option("petrol", choices=("petrol", "steam"), doc="what burns")
    cylinders: int = option(4, low=1, high=16, doc="how many")


@dataclass(frozen=True)
class Car:
    name: str = option(doc="what it is called")
    engine: Engine = option(factory=Engine, doc="engine")
    wheels: tuple[Wheel, ...] = option((), doc="wheels")
    extra: dict[str, Any] = option(factory=dict, doc="anything")


GOOD = """
name = "T"
[engine]
kind = "steam"
[[wheels]]
radius_m = 1
[[wheels]]
radius_m = 0.5
spare = true
[extra.deep]
anything = [1, "two"]
"""


def test_good_file_becomes_the_dataclass():
    document = parse(GOOD, "car.toml")
    check(document, Car)
    car = build(document.values, Car)
    assert car == Car(
        "T",
        Engine("steam", 4),
        (Wheel(1.0), Wheel(0.5, True)),
        {"deep": {"anything": [1, "two"]}},
    )
    assert isinstance(car.wheels[0].radius_m, float)
    assert required_keys(Car) == ["name"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("nam = 1", "car.toml:1: nam: unknown key; allowed are name, engine, wheels, extra"),
        ("\nname = 3", "car.toml:2: name: 3 is not a text"),
        ("[engine]\n\ncylinders = 2.5", "car.toml:3: engine.cylinders: 2.5 is not a whole number"),
        ("[engine]\ncylinders = true", "car.toml:2: engine.cylinders: True is not a whole number"),
        (
            "engine.cylinders = 20",
            "car.toml:1: engine.cylinders: 20 is out of range; allowed is 1 to 16",
        ),
        ("[engine]\nkind='coal'", "car.toml:2: engine.kind: 'coal'; allowed are petrol, steam"),
        ("engine = 3", "car.toml:1: engine: must be a table"),
        ("[[engine]]", "car.toml:1: engine: must be a table"),
        ("[wheels]", "car.toml:1: wheels: must be a list of tables, [[wheels]]"),
        ("[[wheels]]\nradius_m=1\n[[wheels]]", "car.toml:3: wheels: radius_m missing"),
        (
            "[[wheels]]\nradius_m=1\n[[wheels]]\nradius_m=9",
            "car.toml:4: wheels.radius_m: 9 is out of range; allowed is 0.1 to 2",
        ),
        ("wheels = [\n{ radius_m = nan }]", "car.toml:1: wheels.radius_m: nan is out of range"),
        ("[[wheels]]\nradius_m=1\nspare=1", "car.toml:3: wheels.spare: 1 is not true or false"),
        ("extra = 1", "car.toml:1: extra: must be a table"),
        ("name = 'a'\nname = 'b'", "car.toml:2: not TOML"),
        ("name = ", "car.toml:1: not TOML"),
        (
            "[extra]\nrows = [\n  [1, 2],\n  [3, 4]\n]\ntext = 'a = ['\n[engine]\nkind = 3",
            "car.toml:8: engine.kind: 3 is not a text",
        ),
    ],
)
def test_errors_name_file_line_key_and_what_is_allowed(text, message):
    with pytest.raises(InputError) as error:
        check(parse(text, "car.toml"), Car)
    assert str(error.value).startswith(message)


def test_unreadable_file_is_named(tmp_path):
    with pytest.raises(InputError, match=r"none\.toml: cannot be read"):
        read(tmp_path / "none.toml")
    (tmp_path / "latin.toml").write_bytes(b'name = "\xe5"')
    with pytest.raises(InputError, match=r"latin\.toml: cannot be read"):
        read(tmp_path / "latin.toml")


def refusal(text):
    try:
        check(parse(text, "car.toml"), Car)
    except InputError as error:
        return str(error)
    return None


@settings(deadline=None)
@given(st.text(alphabet="[]{}=.\"'#\n abname0123kwheels", max_size=60))
def test_any_text_is_read_or_refused_in_one_line(text):
    message = refusal(text)
    assert message is None or (message.startswith("car.toml:") and "\n" not in message)
