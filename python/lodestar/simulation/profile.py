# SPDX-License-Identifier: Apache-2.0
"""The profile language: a flight as a text file, one manoeuvre per line.

    # Everything after a hash is a comment.
    start            lat 57.8 deg  lon 16.4 deg  altitude 2500 m  heading 40 deg  speed 190 m/s
    straight         120 s
    horizontal_turn  right 90 deg  bank 35 deg
    climb            to 3200 m  angle 4 deg
    speed_change     to 210 m/s  in 40 s

A line is the name of a manoeuvre followed by ``key value unit`` groups in any order; the first key
of a manoeuvre may be left out (``straight 120 s``). Units: deg, rad; s, min; m, km, ft; m/s, km/h,
kt; g; deg/s, rad/s; a count has none. The first manoeuvre is ``start``. Altitude is height above
the WGS84 ellipsoid, heading is true, speed is through the air, times are whole tenths of a second.

The manoeuvres and their keys are the table MANOEUVRES below; ``docs/profiles.md`` explains each.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

from lodestar.errors import InputError
from lodestar.simulation.flight_path import FlightError, FlightPath, PathBuilder, Start

_UNITS: dict[str, dict[str, float]] = {
    "angle": {"deg": math.pi / 180, "rad": 1.0},
    "time": {"s": 1.0, "min": 60.0},
    "length": {"m": 1.0, "km": 1000.0, "ft": 0.3048},
    "speed": {"m/s": 1.0, "km/h": 1 / 3.6, "kt": 1852 / 3600},
    "load": {"g": 1.0},
    "rate": {"deg/s": math.pi / 180, "rad/s": 1.0},
    "count": {},
}


@dataclass(frozen=True)
class Key:
    """One key of a manoeuvre: dimension, range in the first unit of that dimension, default.

    A key without a default must be given, unless it is an alternative of others.
    """

    dimension: str
    low: float
    high: float
    default: float | None = None  # in the first unit

    def scale(self) -> float:
        """SI per first unit."""
        return next(iter(_UNITS[self.dimension].values()), 1.0)

    def unit(self) -> str:
        """The first unit of the dimension."""
        return next(iter(_UNITS[self.dimension]), "")

    def allowed(self) -> str:
        """The range as a person reads it."""
        return f"{self.low:g} to {self.high:g} {self.unit()}".rstrip()


@dataclass(frozen=True)
class Manoeuvre:
    """Keys of a manoeuvre; of each group in ``one_of`` exactly one must be given.

    ``at_most_one_of`` likewise, but none will do.
    """

    keys: dict[str, Key]
    one_of: tuple[tuple[str, ...], ...] = ()
    at_most_one_of: tuple[tuple[str, ...], ...] = ()

    def optional(self) -> set[str]:
        """Keys that may be left out."""
        grouped = {key for group in (*self.one_of, *self.at_most_one_of) for key in group}
        return grouped | {name for name, key in self.keys.items() if key.default is not None}


_DURATION = Key("time", 0.1, 36000.0)
_SPEED = Key("speed", 5.0, 700.0)
_LOAD = Key("load", -3.0, 9.0)
_PULL = Key("load", 1.5, 9.0)

MANOEUVRES: dict[str, Manoeuvre] = {
    "start": Manoeuvre(
        {
            "lat": Key("angle", -85.0, 85.0),
            "lon": Key("angle", -180.0, 360.0),
            "altitude": Key("length", -400.0, 20e3),
            "heading": Key("angle", -180.0, 360.0),
            "speed": _SPEED,
        }
    ),
    "straight": Manoeuvre({"for": _DURATION}),
    "speed_change": Manoeuvre({"to": _SPEED, "in": _DURATION}),
    "horizontal_turn": Manoeuvre(
        {
            "left": Key("angle", 0.1, 3600.0),
            "right": Key("angle", 0.1, 3600.0),
            "bank": Key("angle", 1.0, 85.0),
            "load": Key("load", 1.001, 9.0),
            "in": _DURATION,
            "roll_rate": Key("rate", 1.0, 360.0, 25.0),
            "speed": _SPEED,
        },
        one_of=(("left", "right"), ("bank", "load", "in")),
        at_most_one_of=(("speed",),),
    ),
    "vertical_turn": Manoeuvre(
        {"to": Key("angle", -75.0, 75.0), "load": _LOAD, "in": _DURATION, "speed": _SPEED},
        at_most_one_of=(("load", "in"), ("speed",)),
    ),
    "climb": Manoeuvre(
        {
            "to": Key("length", -400.0, 20e3),
            "angle": Key("angle", 0.5, 60.0, 4.0),
            "load": Key("load", 0.05, 3.0, 0.3),
        }
    ),
    "heading_oscillation": Manoeuvre(
        {
            "amplitude": Key("angle", 0.1, 90.0),
            "period": Key("time", 4.0, 600.0),
            "cycles": Key("count", 1, 1000),
        }
    ),
    "loop": Manoeuvre({"load": _PULL}),
    "aileron_roll": Manoeuvre(
        {
            "left": Key("count", 1, 10),
            "right": Key("count", 1, 10),
            "rate": Key("rate", 20.0, 400.0, 120.0),
            "load": Key("load", 0.0, 2.0, 1.0),
        },
        one_of=(("left", "right"),),
    ),
    "split_s": Manoeuvre({"load": Key("load", 2.5, 9.0), "rate": Key("rate", 20.0, 400.0, 120.0)}),
}


@dataclass(frozen=True)
class Line:
    """One manoeuvre of a profile: values in SI (load in g), keys left out are absent."""

    number: int
    name: str
    values: dict[str, float]


@dataclass(frozen=True)
class Profile:
    """A profile that has been read: the file it came from and its lines, ``start`` first."""

    source: str
    lines: tuple[Line, ...] = field(default=())


def read_profile(path: Path) -> Profile:
    """Read a profile file. Raises InputError naming file, line and key."""
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read ({error})") from error
    return parse_profile(text, str(path))


def parse_profile(text: str, source: str = "profile") -> Profile:
    """Read a profile from a text; ``source`` is what errors call it. Raises InputError."""
    lines: list[Line] = []
    for number, row in enumerate(text.splitlines(), start=1):
        words = row.partition("#")[0].split()
        if not words:
            continue
        try:
            lines.append(_parse_line(number, words, first=not lines))
        except FlightError as error:
            raise InputError(f"{source}:{number}: {error}") from None
    if not lines:
        raise InputError(f"{source}: empty; the first manoeuvre must be start")
    return Profile(source, tuple(lines))


def _parse_line(number: int, words: list[str], *, first: bool) -> Line:
    name, rest = words[0], words[1:]
    if first != (name == "start"):
        raise FlightError(f"{name}: the first manoeuvre, and only the first, must be start")
    if name not in MANOEUVRES:
        raise FlightError(f"{name}: no such manoeuvre; allowed are {', '.join(MANOEUVRES)}")
    manoeuvre = MANOEUVRES[name]
    values: dict[str, float] = {}
    while rest:
        key = next(iter(manoeuvre.keys)) if not values and _is_number(rest[0]) else rest.pop(0)
        if key not in manoeuvre.keys:
            raise FlightError(f"{name}: unknown key {key}; allowed are {', '.join(manoeuvre.keys)}")
        if key in values:
            raise FlightError(f"{name}: {key} is given twice")
        values[key] = _parse_value(f"{name}: {key}", manoeuvre.keys[key], rest)
    _check_complete(name, manoeuvre, values)
    for key, described in manoeuvre.keys.items():
        if described.default is not None:
            values.setdefault(key, described.default * described.scale())
    return Line(number, name, values)


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _parse_value(what: str, key: Key, rest: list[str]) -> float:
    """Take a number and its unit off ``rest``; the value in SI."""
    if not rest or not _is_number(rest[0]):
        found = rest[0] if rest else "nothing"
        raise FlightError(f"{what}: a number must follow, not {found}")
    number = float(rest.pop(0))
    units = _UNITS[key.dimension]
    scale = 1.0
    if units:
        if not rest or rest[0] not in units:
            found = rest[0] if rest else "nothing"
            raise FlightError(f"{what}: unit {found}; allowed are {', '.join(units)}")
        scale = units[rest.pop(0)]
    value = number * scale
    low, high = key.low * key.scale(), key.high * key.scale()
    tolerance = 1e-12 * max(abs(low), abs(high))
    if not low - tolerance <= value <= high + tolerance:
        raise FlightError(f"{what} {number:g}: allowed is {key.allowed()}")
    if key.dimension == "count" and value != int(value):
        raise FlightError(f"{what} {number:g}: must be a whole number")
    return value


def _check_complete(name: str, manoeuvre: Manoeuvre, values: dict[str, float]) -> None:
    missing = [k for k in manoeuvre.keys if k not in values and k not in manoeuvre.optional()]
    if missing:
        raise FlightError(f"{name}: {', '.join(missing)} missing")
    for group in manoeuvre.one_of:
        if sum(key in values for key in group) != 1:
            raise FlightError(f"{name}: exactly one of {', '.join(group)} must be given")
    for group in manoeuvre.at_most_one_of:
        if sum(key in values for key in group) > 1:
            raise FlightError(f"{name}: only one of {', '.join(group)} may be given")


def turned(profile: Profile, angle: float) -> Profile:
    """The profile, its whole route turned to the right by ``angle`` (rad) about its start."""
    begin, *rest = profile.lines
    heading = begin.values["heading"] + angle
    return replace(
        profile, lines=(replace(begin, values=begin.values | {"heading": heading}), *rest)
    )


def flight_path(profile: Profile, rate_hz: int) -> FlightPath:
    """Fly the manoeuvres of a profile, sampled at ``rate_hz`` (a multiple of 10, 30 at least).

    Raises InputError, naming file and line, for a manoeuvre that cannot be flown.
    """
    begin, *lines = profile.lines
    v = begin.values
    start = Start(v["lat"], v["lon"], v["altitude"], v["heading"], v["speed"])
    line = begin
    try:
        builder = PathBuilder(start, rate_hz)
        for line in lines:
            _FLOWN_BY[line.name](builder, line.values)
    except FlightError as error:
        raise InputError(f"{profile.source}:{line.number}: {line.name}: {error}") from None
    return builder.path()


def _signed(v: dict[str, float]) -> float:
    return v["right"] if "right" in v else -v["left"]


def _horizontal_turn(builder: PathBuilder, v: dict[str, float]) -> None:
    bank = math.acos(1 / v["load"]) if "load" in v else v.get("bank")
    builder.horizontal_turn(
        _signed(v),
        bank=bank,
        duration=v.get("in"),
        roll_rate=v["roll_rate"],
        airspeed=v.get("speed"),
    )


_FLOWN_BY: dict[str, Callable[[PathBuilder, dict[str, float]], None]] = {
    "straight": lambda b, v: b.straight(v["for"]),
    "speed_change": lambda b, v: b.straight(v["in"], airspeed=v["to"]),
    "horizontal_turn": _horizontal_turn,
    "vertical_turn": lambda b, v: b.vertical_turn(
        v["to"], load=v.get("load"), duration=v.get("in"), airspeed=v.get("speed")
    ),
    "climb": lambda b, v: b.climb(v["to"], angle=v["angle"], load=v["load"]),
    "heading_oscillation": lambda b, v: b.heading_oscillation(
        v["amplitude"], v["period"], int(v["cycles"])
    ),
    "loop": lambda b, v: b.loop(v["load"]),
    "aileron_roll": lambda b, v: b.aileron_roll(
        2 * math.pi * _signed(v), rate=v["rate"], load=v["load"]
    ),
    "split_s": lambda b, v: b.split_s(rate=v["rate"], load=v["load"]),
}
